"""Cache of results by content key, and the keys themselves."""
