"""Parametric families of assets: each has its `Params`, `sample(rng, stock)` and `build(params, supplies) -> Asset`."""
