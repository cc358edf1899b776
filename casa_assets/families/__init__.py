"""Build members of families, fixtures and objects, check them, and publish them into a library."""
