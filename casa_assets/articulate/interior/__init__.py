"""Cavities behind fronts: those that the mesh has, and those that have to be built."""
