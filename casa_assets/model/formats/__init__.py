"""Records of JSON files that other programs read: writers hold their files against them, schemas are made of them."""
