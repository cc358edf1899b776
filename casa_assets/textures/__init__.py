"""Textures of walls, floors, counters and cabinets: procedural recipes and packs of pictures become finishes."""
