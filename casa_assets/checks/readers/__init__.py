"""Each format, and the asset itself, read back into the table of facts."""
