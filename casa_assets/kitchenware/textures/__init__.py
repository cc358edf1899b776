"""Kinds of procedural texture: code that paints colour, relief and gloss in metres."""
