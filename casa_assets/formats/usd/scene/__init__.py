"""Scene -> USD: the kitchen, its lights and cameras, and references to asset layers."""
