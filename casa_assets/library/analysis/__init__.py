"""Duplicates in a library: shape signatures, CLIP embeddings, search."""
