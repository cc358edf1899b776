"""Segmentation of a static mesh into fragments, and exact cuts along their borders."""
