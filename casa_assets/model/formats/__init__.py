"""Records of JSON files that other programs read: their JSON Schemas are made of these."""
