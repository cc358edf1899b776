"""Merge the strips of a bulging front in a voxelised shell, whose surface descends to the edges in stairs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from casa_assets.articulate.fronts.rectangles import FrontRectangle
from casa_assets.articulate.segment.creases import SideRelief
from casa_assets.core.typing import Floats

# Highest stair, and deepest groove between two stairs that is no gap between fronts; diagonals.
MAX_STAIR_HEIGHT, MAX_GROOVE_DEPTH = 0.0095, 0.002
# Distance from a border at which its two sides are sampled.
BESIDE_PIXELS = 4
# Strips are as long as the front within this share of its length, and cover this share of it.
LENGTH_TOLERANCE, MIN_STRIP_FILL = 0.035, 0.9
# Fewest stairs of a bulge on both sides together: a framed panel has one on each side.
MIN_STAIRS = 3


def merge_stairs(side: SideRelief, rectangles: list[FrontRectangle]) -> list[FrontRectangle]:
    """Merge rectangles of a side that lie next to each other like the stairs of a bulging front.

    Args:
        rectangles: as `find_front_rectangles` returns them; the result has the same form.
    """
    left = list(rectangles)
    for core in sorted(rectangles, key=lambda m: (round(m.plane, 6), m.rows, m.columns)):
        if not any(m is core for m in left):
            continue
        before, after = _stairs(side, left, core, 0), _stairs(side, left, core, 1)
        if before and after and len(before) + len(after) >= MIN_STAIRS:
            strips = [core, *(m for stair in (*before, *after) for m in stair)]
            left = [m for m in left if not any(m is s for s in strips)]
            left.append(_one(side, core, strips))
    return sorted(left, key=lambda m: (m.rows, m.columns))


def _stairs(
    side: SideRelief, rectangles: list[FrontRectangle], core: FrontRectangle, end: int
) -> list[list[FrontRectangle]]:
    """Return strips next to a rectangle that descend from it, nearest first; a strip may be several stacked rectangles.

    Args:
        end: 0 for those to its left, 1 to its right.
    """
    out: list[list[FrontRectangle]] = []
    at, plane = core.columns[end], core.plane
    while True:
        strip = _beside(rectangles, core, at, end)
        if not strip or not _goes_down(side, core, at, end):
            return out
        deep = float(np.average([m.plane for m in strip], weights=[m.rows[1] - m.rows[0] for m in strip]))
        if deep <= plane:
            return out
        out.append(strip)
        at, plane = strip[0].columns[end], deep


def _beside(rectangles: list[FrontRectangle], core: FrontRectangle, at: int, end: int) -> list[FrontRectangle]:
    """Return rectangles that end at a column and together are as long as another; empty if there are no such."""
    long = core.rows[1] - core.rows[0]
    slack = max(2, round(LENGTH_TOLERANCE * long))
    found = [
        m
        for m in rectangles
        if m.columns[1 - end] == at and m.rows[0] >= core.rows[0] - slack and m.rows[1] <= core.rows[1] + slack
    ]
    even = len({m.columns for m in found}) == 1
    return found if even and sum(m.rows[1] - m.rows[0] for m in found) >= MIN_STRIP_FILL * long else []


def _goes_down(side: SideRelief, core: FrontRectangle, at: int, end: int) -> bool:
    """Return whether a border is a stair: a little deeper beyond it, and no deeper between."""
    first, last = at - BESIDE_PIXELS - 1, at + BESIDE_PIXELS
    if first < 0 or last >= side.depth.shape[1]:
        return False
    band: Floats = side.base[slice(*core.rows), first : last + 1]
    inner, outer = (band[:, 0], band[:, -1]) if end else (band[:, -1], band[:, 0])
    step = float(np.median(outer - inner))
    groove = float(np.median(band.max(axis=1) - np.maximum(inner, outer)))
    return 0.0 < step <= MAX_STAIR_HEIGHT and groove <= MAX_GROOVE_DEPTH


def _one(side: SideRelief, core: FrontRectangle, strips: list[FrontRectangle]) -> FrontRectangle:
    """Return the rectangle around some strips."""
    columns = min(m.columns[0] for m in strips), max(m.columns[1] for m in strips)
    window = slice(*core.rows), slice(*columns)
    ground = side.depth[window][side.blob[window] < 0]
    plane = float(np.median(ground)) if len(ground) else core.plane
    return replace(core, columns=columns, plane=plane, blobs=tuple(sorted({b for m in strips for b in m.blobs})))
