"""Geometry on numpy arrays: topology, measures, hulls, primitives, voxels, normals. Knows nothing of assets."""
