"""Find the round door of a washing machine or dryer, which lies on the front as a ring, a disc or a dome."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.controls.controls import has_round_outline
from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.segment.fragment_measures import MeasuredFragments, corners_from_side

# Diameter by the width and by the height of the front, distance of its middle from that of the front by the width, and
# height by width of the front. Ref: makers list loading doors of 30 to 50 cm in fronts of 60 by 85 cm.
MIN_DIAMETER_BY_WIDTH, MAX_DIAMETER_BY_WIDTH, MIN_DIAMETER_BY_HEIGHT = 0.35, 0.85, 0.22
MAX_OFFSET, MIN_TALL, MAX_TALL = 0.15, 0.8, 2.4
# Its parts start within this share of the depth of the thing, reach back at most by this share of their diameter, and
# show at least this share of their square.
MAX_START_SHARE, MAX_DEPTH_BY_DIAMETER, MIN_VISIBLE_SHARE = 0.2, 0.6, 0.08
# Parts of one door have their middles this near to each other, by its diameter, and stay within its circle so far.
MAX_ECCENTRICITY, CIRCLE_TOLERANCE = 0.1, 1.06
# What lies deeper behind its back is the drum, diagonals.
MAX_BEHIND = 0.02


def find_round_door(measured: MeasuredFragments, side: int) -> Panel | None:
    """Return the round door of a side, with all that lies in its circle, or None."""
    lower, upper = corners_from_side(measured, side)
    size, whole_lower, whole_upper = upper - lower, lower.min(axis=0), upper.max(axis=0)
    extent = whole_upper - whole_lower
    if not MIN_TALL <= extent[1] / max(float(extent[0]), 1e-9) <= MAX_TALL:
        return None
    across = size[:, :2].max(axis=1)
    middle = (lower + upper)[:, :2] / 2
    fits = (across <= 1.2 * size[:, :2].min(axis=1)) & (across <= MAX_DIAMETER_BY_WIDTH * extent[0])
    fits &= (across >= MIN_DIAMETER_BY_WIDTH * extent[0]) & (across >= MIN_DIAMETER_BY_HEIGHT * extent[1])
    fits &= (lower[:, 2] - whole_lower[2] <= MAX_START_SHARE * extent[2]) & (
        size[:, 2] <= MAX_DEPTH_BY_DIAMETER * across
    )
    fits &= np.abs(middle[:, 0] - (whole_lower + whole_upper)[0] / 2) <= MAX_OFFSET * extent[0]
    fits &= measured.visible_area[:, side] >= MIN_VISIBLE_SHARE * across**2
    rings = [i for i in np.flatnonzero(fits).tolist() if has_round_outline(measured, side, [i], size[i, :2])]
    if not rings:
        return None
    first = max(rings, key=lambda i: (round(float(across[i]), 6), -i))
    radius = float(across[first]) / 2
    shared = [i for i in rings if float(np.abs(middle[i] - middle[first]).max()) <= 2 * MAX_ECCENTRICITY * radius]
    back = float(upper[shared, 2].max()) + MAX_BEHIND
    corner = np.maximum(np.abs(lower[:, :2] - middle[first]), np.abs(upper[:, :2] - middle[first]))
    inside = (np.abs(middle - middle[first]).max(axis=1) <= radius) & (upper[:, 2] <= back)
    inside &= corner.max(axis=1) <= CIRCLE_TOLERANCE * radius
    members = [first, *(i for i in np.flatnonzero(inside).tolist() if i != first)]
    visible = float(measured.visible_area[members, side].sum())
    corners = lower[shared].min(axis=0), upper[shared].max(axis=0)
    return Panel(members, *corners, visible_area=visible, is_round=True)


def fragments_around(measured: MeasuredFragments, side: int, door: Panel) -> list[int]:
    """Return the fragments whose rectangles hold a round door: the front of the body, in which it is hung."""
    lower, upper = corners_from_side(measured, side)
    around = (lower[:, :2] <= door.lower[:2]).all(axis=1) & (upper[:, :2] >= door.upper[:2]).all(axis=1)
    return [i for i in np.flatnonzero(around).tolist() if i not in door.members]
