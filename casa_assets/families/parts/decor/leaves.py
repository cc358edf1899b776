"""Leaves: thin curved solids on a stem."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.solid import Solid

LEAF_THICKNESS = 0.0012  # metres; a succulent's is thicker
GOLDEN_ANGLE = 2.399963  # rad from one leaf to the next. Ref: phyllotaxis.


def leaf(
    length: float,
    width: float,
    *,
    droop: float = 0.6,
    fold: float = 0.25,
    tip: float = 1.0,
    thickness: float = LEAF_THICKNESS,
    steps: int = 7,
) -> Solid:
    """A leaf that starts at the origin along +y and bends down towards its end; without collider.

    Args:
        length, width: metres. droop: rad that it bends over its length. fold: rise of its sides over half the width.
        tip: how pointed it is; 0.5 is round, 2 is a lance. thickness: in its middle.
    """
    s = np.linspace(0.0, 1.0, steps + 1)
    half = width / 2 * np.maximum(np.sin(np.pi * s**0.8) ** (0.5 + 0.25 * tip), 0.04)
    half[-1] = 0.02 * width
    angle = droop * s
    step = length / steps
    y = np.concatenate([[0.0], np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2))]) * step
    z = -np.concatenate([[0.0], np.cumsum(np.sin((angle[1:] + angle[:-1]) / 2))]) * step
    across = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    top = np.array(
        [[(a * h, yy, zz + fold * abs(a) * h) for a in across] for h, yy, zz in zip(half, y, z, strict=True)]
    )
    body = thickness * (1 - 0.7 * np.abs(across))[None, :] * np.sin(np.pi * np.clip(s, 0.06, 0.94))[:, None]
    underside = top.copy()
    underside[..., 2] -= body + 0.0003
    return _sheet(top, underside)


def _sheet(top: Floats, underside: Floats) -> Solid:
    """A closed solid between two (N, M, 3) grids."""
    n, m = top.shape[:2]
    points = np.concatenate([top.reshape(-1, 3), underside.reshape(-1, 3)])
    faces = []
    offset = n * m
    for i in range(n - 1):
        for j in range(m - 1):
            a, b, c, d = i * m + j, i * m + j + 1, (i + 1) * m + j + 1, (i + 1) * m + j
            faces += [(a, b, c), (a, c, d), (offset + a, offset + c, offset + b), (offset + a, offset + d, offset + c)]
    rim = [(0, j) for j in range(m)] + [(i, m - 1) for i in range(1, n)]
    rim += [(n - 1, j) for j in range(m - 2, -1, -1)] + [(i, 0) for i in range(n - 2, 0, -1)]
    for (i, j), (k, q) in zip(rim, [*rim[1:], rim[0]], strict=True):
        a, b = i * m + j, k * m + q
        faces += [(a, offset + a, offset + b), (a, offset + b, b)]
    return Solid(points, np.array(faces, dtype=np.int64), crease_deg=70.0).oriented_outwards()


def golden_angles(count: int) -> list[float]:
    """Angles at which leaves are arranged around a stem, rad."""
    return [k * GOLDEN_ANGLE % (2 * math.pi) for k in range(count)]
