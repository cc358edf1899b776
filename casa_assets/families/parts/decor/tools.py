"""Upright or hanging kitchen tools: the end of their handle at the origin, the working end up z."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from casa_assets.families.kit.solids.blocks import box, lathe
from casa_assets.families.kit.solids.loft import loft
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import circle, tube
from casa_assets.families.parts.hardware.legs import tapered_leg


class CrockTool(StrEnum):
    """Kind of tool."""

    SPOON = "spoon"
    SPATULA = "spatula"
    FORK = "fork"
    TURNER = "turner"
    LADLE = "ladle"
    WHISK = "whisk"


def crock_tool(kind: CrockTool, size: float) -> list[Solid]:
    """The solids of a tool of a length in metres."""
    if kind in (CrockTool.SPOON, CrockTool.SPATULA, CrockTool.FORK):
        stem = tapered_leg((0, 0, 0), (0, 0, 0.74 * size), 0.0052, 0.0068, 12)
        return [stem, *_wooden_end(kind, size)]
    grip = tapered_leg((0, 0, 0), (0, 0, 0.36 * size), 0.0085, 0.0065, 12)
    rod_ = tapered_leg((0, 0, 0.359 * size), (0, 0, 0.76 * size), 0.0032, 0.0032, 10)
    if kind is CrockTool.TURNER:
        blade = box((0.078, 0.0018, 0.24 * size), (0, 0.006, 0.875 * size), 0.0006)
        return [grip, rod_, blade]
    if kind is CrockTool.LADLE:
        r = 0.042
        bowl = lathe([(0.002, -r), (0.6 * r, -0.8 * r), (r, 0.0), (r - 0.0014, 0.0), (0.58 * r, -0.77 * r)], 24, 60.0)
        return [grip, rod_, bowl.rotated("x", -0.5).translated(0, r * 0.8, 0.82 * size)]
    wires = []
    for k in range(5):
        t = math.pi * k / 5
        path = []
        for s in np.linspace(0, 1, 15):
            a = 2 * math.pi * (s - 0.5)
            w = 0.03 * math.sin(a)
            z = 0.72 * size + 0.28 * size * (0.5 + 0.5 * math.cos(a)) ** 0.8
            path.append((w * math.cos(t), w * math.sin(t), z))
        wires.append(tube(path[1:-1], 0.0011).without_colliders())
    return [grip, rod_, *wires]


def _wooden_end(kind: CrockTool, size: float) -> list[Solid]:
    base, end = 0.73 * size, size
    if kind is CrockTool.SPOON:
        rings = []
        for s in np.linspace(0.0, 1.0, 9):
            w = 0.007 + 0.024 * math.sin(math.pi * min(1.0, 0.08 + 0.88 * s)) ** 0.7
            ring = circle(1.0, 16) * np.array([w, 0.0055])
            dip = 0.006 * math.sin(math.pi * s)
            z = base + (end - base) * s
            rings.append(np.column_stack([ring[:, 0], ring[:, 1] + dip * (1 - (ring[:, 0] / w) ** 2), np.full(16, z)]))
        return [loft(rings, 60.0)]
    flare = [(-0.008, base), (0.008, base), (0.03, end - 0.03), (0.03, end), (-0.03, end), (-0.03, end - 0.03)]
    if kind is CrockTool.SPATULA:
        return [_plate(flare, 0.005)]
    tines = [box((0.011, 0.005, 0.07), (x, 0, end - 0.035), 0.0015) for x in (-0.0205, 0.0, 0.0205)]
    neck = [(-0.008, base), (0.008, base), (0.026, end - 0.065), (-0.026, end - 0.065)]
    return [_plate(neck, 0.005), *tines]


def _plate(outline: list[tuple[float, float]], thickness: float) -> Solid:
    """An outline in x, z pulled through y."""
    points = np.array(outline)
    front = np.column_stack([points[:, 0], np.full(len(points), thickness / 2), points[:, 1]])
    back = front * np.array([1.0, -1.0, 1.0])
    return loft([front, back], 40.0)
