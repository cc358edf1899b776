"""Small things that every package above the records shares: array types, colour, rotation, hands. Knows nothing of assets."""
