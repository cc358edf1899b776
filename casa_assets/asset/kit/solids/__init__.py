"""Solids of families: blocks, sweeps, lofts, slabs and mouldings, with their skins and colliders."""
