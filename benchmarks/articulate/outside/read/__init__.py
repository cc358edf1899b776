"""Readers of files that state joints: URDF, SDF, MJCF and USD."""
