"""VRML 2.0 and X3D -> RawModel: two spellings of one tree of nodes."""
