"""Parametric families of assets: each has its `Params` and a function that builds a member of them."""
