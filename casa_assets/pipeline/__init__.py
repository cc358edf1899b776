"""Runs stages, isolates them, remembers their results, and puts them on disk: all side effects live here."""
