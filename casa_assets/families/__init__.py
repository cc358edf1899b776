"""Numbers into assets: every family is `Params`, `sample(rng) -> Params` and `build(Params) -> Asset`."""
