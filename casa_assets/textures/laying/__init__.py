"""Laying patterns: bonds of bricks, tiles, planks and stones that repeat without a seam."""
