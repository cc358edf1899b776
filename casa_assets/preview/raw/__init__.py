"""Pictures of raw models, of which no MJCF exists: by MuJoCo, or as points where that refuses them."""
