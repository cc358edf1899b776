"""Packs of pictures: taken in from folders of pictures, and read as recipes of textures and as finishes."""
