"""Results kept by content key, and the keys themselves."""
