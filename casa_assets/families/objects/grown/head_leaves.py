"""Leaves around a head of cabbage, lettuce or a sprout: sheets along its profile whose rims curl away from it."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.objects.closed_surface import sheet
from casa_assets.families.parts.decor.leaves import golden_angles

# Points across a leaf and from its foot to its tip.
ACROSS, LENGTHWISE = 9, 9


def head_leaves(
    curve: Floats, count: int, curl: float, ruffle: float, reach: float, clear: float, rng: np.random.Generator
) -> list[Solid]:
    """Leaves around a body of revolution, the inner ones first; their picture runs upwards from foot to tip.

    Args:
        curve: (N, 2) radius and height of the body from its lower end to its upper one, m.
        count: number of leaves.
        curl, ruffle: how far the rims curl away, and how far they rise and fall, relative to the largest radius.
        reach: share of the curve from the foot to the tip of the longest leaf.
        clear: distance of the innermost leaf from the curve, relative to the largest radius.
    """
    size = float(curve[:, 0].max())
    forward = np.gradient(curve, axis=0)
    forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    outward = np.column_stack([forward[:, 1], -forward[:, 0]])
    run = np.linspace(0.0, 1.0, len(curve))
    u, v = np.meshgrid(np.linspace(-1, 1, ACROSS), np.linspace(0.0, 1.0, LENGTHWISE), indexing="ij")
    out = []
    for k, turn in enumerate(golden_angles(count)):
        layer = (k + 1) / count
        long = reach * float(rng.uniform(0.82, 1.0)) * (1.0 - 0.18 * layer)
        place = 0.04 + (long - 0.04) * v
        half = float(rng.uniform(0.95, 1.25)) * np.maximum(np.sin(np.pi * (0.12 + 0.78 * v)), 0.25) ** 0.6
        # Where the body is thin the leaf does not reach round it.
        angle = turn + u * half
        edge = (np.abs(u) ** 4 + v**4) ** 0.25
        off = clear + 0.05 * layer + curl * (0.4 + 0.6 * layer) * edge**4
        waves = float(rng.integers(4, 7))
        off = off + ruffle * edge**3 * np.sin(waves * math.pi * (u + 0.8 * v) + float(rng.uniform(0, 6)))
        base = np.stack([np.interp(place, run, curve[:, i]) for i in (0, 1)], axis=2)
        normal = np.stack([np.interp(place, run, outward[:, i]) for i in (0, 1)], axis=2)
        radius, height = np.moveaxis(base + normal * (off * size)[..., None], 2, 0)
        radius = np.maximum(radius, 0.03 * size)
        grid = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=2)
        out.append(sheet(grid, 0.018 * size))
    return out
