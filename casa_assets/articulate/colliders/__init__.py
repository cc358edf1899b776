"""Collision shapes of the links, clear of each other over the whole range of every joint."""
