"""Edges of worktops: profiles from the underside to the top."""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.families.kit.solids.slab import arc
from casa_assets.model.record import Vec2


class CounterEdge(StrEnum):
    """Profile of the front edge of a worktop."""

    SQUARE = "square"
    EASED = "eased"
    BEVEL = "bevel"
    HALF_BULLNOSE = "half_bullnose"
    BULLNOSE = "bullnose"
    OGEE = "ogee"
    DUPONT = "dupont"


def profile(edge: CounterEdge, thickness: float) -> list[Vec2]:
    """(inset, z) points from z = -thickness up to z = 0, metres; the edge reaches inset 0."""
    t = thickness
    e = 0.0015
    lower_edge: list[Vec2] = [(e, -t), (0.0, -t + e)]
    if edge is CounterEdge.SQUARE:
        return [(0.0008, -t), (0.0, -t + 0.0008), (0.0, -0.0008), (0.0008, 0.0)]
    if edge is CounterEdge.EASED:
        return [*lower_edge, *arc(0.004, -0.004, 0.004, 180, 90, 3)]
    if edge is CounterEdge.BEVEL:
        b = min(0.012, 0.4 * t)
        return [*lower_edge, (0.0, -b), (b, 0.0)]
    if edge is CounterEdge.HALF_BULLNOSE:
        r = min(0.018, 0.6 * t)
        return [*lower_edge, *arc(r, -r, r, 180, 90, 7)]
    if edge is CounterEdge.BULLNOSE:
        return arc(t / 2, -t / 2, t / 2, 270, 90, 14)
    if edge is CounterEdge.OGEE:
        w, z0, z1 = min(0.012, 0.45 * t), -0.72 * t, -0.0025
        wave = [(w / 2 * (1 - math.cos(math.pi * k / 8)), z0 + (z1 - z0) * k / 8) for k in range(9)]
        return [*lower_edge, *wave, (w + 0.0012, -0.0005), (w + 0.002, 0.0)]
    r = min(0.01, 0.35 * t)
    return [*lower_edge, (0.0, -r - 0.004), (0.003, -r - 0.004 + 1e-4), *arc(0.003 + r, -r, r, 180, 90, 6)]
