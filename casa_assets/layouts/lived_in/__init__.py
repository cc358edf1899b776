"""Put objects into a kitchen where people keep them: on worktops and shelves, in drawers and refrigerators."""
