"""Recipes and packs of pictures into finishes: what walls, floors, counters and cabinets look like."""
