"""Built assets -> Scene: props, cameras, light, swept areas and floor facts."""
