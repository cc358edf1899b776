"""Path-traced stills of kitchens and assets: Blender's Cycles, in a process of its own, draws their USD."""
