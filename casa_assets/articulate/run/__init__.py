"""Articulate run: one static mesh to an asset with joints, its decisions and its review page."""
