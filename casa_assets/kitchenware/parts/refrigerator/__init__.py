"""Parts of refrigerators: case, doors, gaskets, shelves, drawers, the lower freezer."""
