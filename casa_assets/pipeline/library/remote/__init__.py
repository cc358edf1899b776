"""Libraries on object stores: push, pull, and runs that keep their library there, entry by entry."""
