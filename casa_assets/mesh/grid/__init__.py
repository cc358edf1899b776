"""Functions on voxel grids: occupancy, implicit fields, isosurfaces, the volume that a vessel holds."""
