"""Whether a point lies in an outline, and how deep convex outlines overlap.

Without scipy: a plan is checked in less time than it takes to load.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.numeric import Floats

Outline = Sequence[tuple[float, float]] | Floats


def contains_point(outline: Outline, point: tuple[float, float]) -> bool:
    """True where a point lies in an outline, which need not be convex."""
    x, y = point
    odd = False
    corners = [(float(a), float(b)) for a, b in outline]
    for (ax, ay), (bx, by) in zip(corners, (*corners[1:], corners[0]), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            odd = not odd
    return odd


def penetration_depth(one: Outline, other: Outline) -> float:
    """Least translation that parts two convex outlines, metres; negative for a gap between them."""
    a, b = np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64)
    normals = np.concatenate([edge_normals(a), edge_normals(b)])
    p, q = normals @ a.T, normals @ b.T
    return float(np.minimum(p.max(axis=1) - q.min(axis=1), q.max(axis=1) - p.min(axis=1)).min())


def edge_normals(outline: Floats) -> Floats:
    """(M, 2) outward unit normals of the edges of a counter-clockwise outline."""
    edge = np.roll(outline, -1, axis=0) - outline
    normals = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))
