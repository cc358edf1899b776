"""Articulated objects of other people, from public repositories: built from their sources, and scored against."""
