"""Metres per unit of an ingested mesh: from the file, from words, from the usual size of its category."""
