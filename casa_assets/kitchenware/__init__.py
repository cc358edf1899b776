"""Content: fixtures, objects, parts and kinds of textures."""
