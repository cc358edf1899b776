"""Small shelf of what many modules need: colour, rotation, random lanes, the force of a hand, rounding, array types."""
