"""Parametric families of assets: each has its `Params` and `build(params, supplies) -> Asset`."""
