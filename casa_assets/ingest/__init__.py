"""One raw mesh into an Asset: load, clean, orient, scale, simplify, texture, collide, mass, assemble."""
