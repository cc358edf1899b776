"""Hardware: handles, knobs, buttons, faucets, legs, displays."""
