"""Functions on triangle meshes: topology, normals, mass properties, visibility, registration, grasps."""
