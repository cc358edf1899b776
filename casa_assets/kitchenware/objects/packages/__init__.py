"""Food packages, and blocks of food and other materials, wrapped and bare."""
