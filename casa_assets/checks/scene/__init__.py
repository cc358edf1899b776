"""Checks of a whole scene: it is loaded, left alone, opened, pushed and measured."""
