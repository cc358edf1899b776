"""Checks of a scene in motion: at rest, joints through their ranges, pulled by a hand, load and speed."""
