"""Checks of where things stand in a scene: inside the room, supported, not overlapping."""
