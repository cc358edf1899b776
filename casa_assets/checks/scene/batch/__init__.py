"""Checks of the batch form of a kitchen: its size for GPU engines, and what it may not lose of the light form."""
