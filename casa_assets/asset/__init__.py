"""What assets are made of: the builder with its solids, scaled and light forms."""
