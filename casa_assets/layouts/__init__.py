"""Plan x Style -> Scene: rooms, rows of units, what stands on them, and where it all is. Pure functions, no disk."""
