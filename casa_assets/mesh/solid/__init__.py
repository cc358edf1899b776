"""Functions on solids and convex shapes: booleans, cuts, hulls, primitives, bounds, deviation."""
