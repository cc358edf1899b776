"""Fronts of cabinets: panels, doors, drawers, glazing and their looks."""
