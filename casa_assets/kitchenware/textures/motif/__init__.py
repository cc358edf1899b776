"""Drawn figures: masks of inks in a square or rectangle that repeats."""
