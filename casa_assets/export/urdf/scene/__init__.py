"""Scene -> URDF: the kitchen as one tree of links, its assets one by one, and the list of placements."""
