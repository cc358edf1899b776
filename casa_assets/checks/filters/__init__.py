"""Filters of strangers' meshes: holes, cards, grounds, odd shapes, poor pictures, no rest, nothing to hold."""
