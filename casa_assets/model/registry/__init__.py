"""Records of the files under registry/: categories, contracts, limits, finishes, texture recipes."""
