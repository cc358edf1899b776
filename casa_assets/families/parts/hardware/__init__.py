"""Parts that are bought ready made: handles, knobs, buttons, faucets, legs, displays."""
