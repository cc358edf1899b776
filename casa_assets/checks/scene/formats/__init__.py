"""Checks of a scene's files: MJCF, light form and USD agree and are valid."""
