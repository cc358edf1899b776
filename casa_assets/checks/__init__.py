"""Checks of assets, scenes and libraries: pure functions, one table of rows, limits from registry/limits.yaml."""
