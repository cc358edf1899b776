"""Records of JSON files that other programs read and that no other record describes: their JSON Schemas are made of them."""
