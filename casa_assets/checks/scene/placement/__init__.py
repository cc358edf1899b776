"""Checks of the placements of a scene: inside the room, supported, not overlapping."""
