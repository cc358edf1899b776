"""Reader of COLLADA (.dae) files."""
