"""Checks of a whole library: duplicates and outliers of size."""
