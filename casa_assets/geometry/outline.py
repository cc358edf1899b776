"""Whether a point lies in an outline. Without scipy: a plan is checked in less time than it takes to load."""

from __future__ import annotations

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
