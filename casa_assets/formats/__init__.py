"""File formats: readers of meshes, writers of MJCF, USD, URDF and glTF."""
