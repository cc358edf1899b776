"""Records of one asset: links, joints, shapes, meshes, materials, sites, labels, provenance."""
