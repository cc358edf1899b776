"""Checks of the asset record: size, mass, colliders, triangles, normals, textures."""
