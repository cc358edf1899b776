"""Kitchens side by side in one batch: models of one structure, start states, and one module per engine."""
