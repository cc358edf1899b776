"""Write accepted assets, or kitchens, in one format: each a file, listed, and put in place whole."""
