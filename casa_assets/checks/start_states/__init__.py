"""Start states of a kitchen: draw them, let them settle, and see whether they stay as they are."""
