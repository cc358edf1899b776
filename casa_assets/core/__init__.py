"""Small things that every package above the records shares: types, colour, rotation, hands. Knows nothing of assets."""
