"""Path-traced stills of kitchens and assets: Blender's Cycles, in a separate process, draws their USD."""
