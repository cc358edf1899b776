"""Rows of all checks by subject; `table.py` puts them together."""
