"""Texture run: recipes and packs of pictures into finishes."""
