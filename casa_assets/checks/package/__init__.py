"""Checks of the files of a written asset."""
