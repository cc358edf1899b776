"""Tell drawer boxes, cavities and racks apart by looking down on some fragments alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.segment.fragment_measures import SIDES, TOP, MeasuredFragments
from casa_assets.articulate.segment.raster import render_depth
from casa_assets.core.typing import Floats

PIXELS = 96
# A cavity is at least so deep, diagonals.
MIN_CAVITY_DEPTH = 0.05
# Walls of a tub stand within this part of the plan from its border, and rise by this part of its height.
WALL_BORDER_SHARE, MIN_WALL_RISE = 0.12, 0.15


@dataclass(frozen=True)
class PlanView:
    """Shares of the plan of some fragments, seen from above.

    Attributes:
        covered: where anything is. low: where the first thing is in the lower half of their height, of all.
        lid: where it is in the upper quarter.
        walls: (3,) of the left, the right and the far border, where something rises above the floor.
    """

    covered: float
    low: float
    lid: float
    walls: tuple[float, float, float]

    @property
    def is_box(self) -> bool:
        """Return whether it is open at the top, with a floor: a drawer."""
        return self.low >= 0.45 and self.lid <= 0.5

    @property
    def is_tub(self) -> bool:
        """Return whether it is a box with walls on three sides: only a drawer or a bin looks like this."""
        return self.is_box and self.low >= 0.5 and min(self.walls) >= 0.6


def view_from_above(pieces: MeasuredFragments, fragments: Sequence[int]) -> PlanView:
    """Look down on some fragments alone."""
    faces = pieces.soup.faces[pieces.faces_of(fragments)]
    low, high = pieces.box(fragments)
    used, local = np.unique(faces, return_inverse=True)
    picture = render_depth(pieces.soup.points[used], local.reshape(-1, 3), SIDES[TOP], PIXELS)
    height = max(float(high[2] - low[2]), 1e-9)
    share = picture.depth / height
    seen = np.isfinite(share)
    total = float(share.size)
    deep, shallow = seen & (share > 0.5), seen & (share < 0.25)
    return PlanView(float(seen.sum()) / total, float(deep.sum()) / total, float(shallow.sum()) / total, _walls(share))


def free_share_behind(
    pieces: MeasuredFragments, side: int, fragments: Sequence[int], low: Floats, high: Floats
) -> float:
    """Return the share of a rectangle behind which there is free space, once some fragments are removed.

    Args:
        low, high: (3,) corners in (u, v, w) of what those fragments are; room is what lies deeper than `high`.
    """
    gone = np.zeros(len(pieces.label), dtype=bool)
    gone[pieces.faces_of(fragments)] = True
    faces = pieces.soup.faces[~gone]
    if not len(faces):
        return 0.0
    picture = render_depth(pieces.soup.points, faces, SIDES[side], 2 * PIXELS)
    nearest = float((pieces.soup.points[faces] @ SIDES[side][2]).min())
    row, column = picture.rows_columns(np.array([low[:2], high[:2]]))
    depth = picture.depth[row[1] : row[0] + 1, column[0] : column[1] + 1] + nearest
    return float((np.isfinite(depth) & (depth > float(high[2]) + MIN_CAVITY_DEPTH)).mean())


def roofed_share(pieces: MeasuredFragments, side: int, low: Floats, high: Floats) -> float:
    """Return the share of the strip right behind a front that something covers at the height of its top or above.

    Args:
        low, high: (3,) corners of the front in (u, v, w) of an upright side.
    """
    strip = np.array([[low[0], low[1], high[2]], [high[0], high[1], high[2] + MIN_CAVITY_DEPTH]]) @ SIDES[side]
    flat = np.sort(strip @ SIDES[TOP].T, axis=0)
    picture = pieces.depth_images[TOP]
    row, column = picture.rows_columns(flat[:, :2])
    depth = picture.depth[row[1] : row[0] + 1, column[0] : column[1] + 1]
    height = float(pieces.high[:, 2].max()) - np.where(np.isfinite(depth), depth, np.inf)
    return float((height >= float(high[1]) - 0.25 * float(high[1] - low[1])).mean())


def _walls(share: Floats) -> tuple[float, float, float]:
    """Return the shares of the left, right and far border of a plan that have a wall rising above the floor."""
    rows, columns = (max(1, round(WALL_BORDER_SHARE * n)) for n in share.shape)
    seen = np.isfinite(share)
    floor = float(np.median(share[seen])) if seen.any() else 0.0
    high = share < floor - MIN_WALL_RISE
    return (
        float(high[:, :columns].any(axis=1).mean()),
        float(high[:, -columns:].any(axis=1).mean()),
        float(high[:rows].any(axis=0).mean()),
    )
