"""Whether a point lies in an outline, and how far outlines are apart.

Without scipy: a plan is checked in less time than it takes to load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from casa_assets.core.typing import Floats

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


def separation(one: Outline, other: Outline) -> float:
    """Distance of two convex outlines along the side that parts them best; less than 0: how deep they overlap."""
    return max(_apart(one, other), _apart(other, one))


def _apart(one: Outline, other: Outline) -> float:
    """Greatest distance of an outline beyond a side of another one; less than 0 where it is within all of them."""
    corners = [(float(a), float(b)) for a, b in one]
    points = [(float(a), float(b)) for a, b in other]
    ends = [*corners[1:], corners[0]]
    turn = sum(ax * by - bx * ay for (ax, ay), (bx, by) in zip(corners, ends, strict=True))
    best = -math.inf
    for (ax, ay), (bx, by) in zip(corners, ends, strict=True):
        length = math.hypot(bx - ax, by - ay)
        if length > 0.0:
            # Outwards is to the right of a side that goes round to the left.
            nx, ny = (by - ay) / length, (ax - bx) / length
            if turn < 0.0:
                nx, ny = -nx, -ny
            best = max(best, min((x - ax) * nx + (y - ay) * ny for x, y in points))
    return best
