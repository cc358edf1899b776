"""Scene -> MJCF: the kitchen, its lights and cameras, and the files that scenes share."""
