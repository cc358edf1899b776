"""Pictures of assets and kitchens."""
