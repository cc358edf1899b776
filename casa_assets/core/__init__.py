"""Small things that every package above the records shares: array types, colour, rotation. Knows nothing of assets."""
