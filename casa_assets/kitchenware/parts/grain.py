"""Directions that the grain of wood runs along: across the front, from front to back, and upright."""

from __future__ import annotations

from casa_assets.ext.records import Vec3

ACROSS: Vec3 = (1.0, 0.0, 0.0)
ALONG: Vec3 = (0.0, 1.0, 0.0)
UPRIGHT: Vec3 = (0.0, 0.0, 1.0)
