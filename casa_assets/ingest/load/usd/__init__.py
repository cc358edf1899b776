"""USD, USDA, USDC and USDZ -> RawModel, by usd-core."""
