"""FBX -> RawModel, by ufbx."""
