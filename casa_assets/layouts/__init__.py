"""Plan x Style -> Scene: rooms, rows of units, the objects on them, and all poses. Pure functions, no disk access."""
