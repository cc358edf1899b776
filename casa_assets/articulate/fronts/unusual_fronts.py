"""Find fronts without a seam or handle of the usual kind: tiled and round ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.controls.controls import Control, has_round_outline
from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.segment.fragments import FRONT, MeasuredFragments, corners_from_side
from casa_assets.core.numeric import Floats

# Tiled fronts ---------------------------------------------------------------------------------------------------------
# Find fronts without handles: panels that tile a side together, or that have controls next to them.

# Fronts of one thing start at one depth, end in line, and lie this near to each other, diagonals.
SAME_DEPTH, IN_LINE, MAX_GAP = 0.02, 0.012, 0.04
# A front is at least this large by its equal beside it, and this wide by its length: thinner ones are boards and slats.
MIN_SIZE_BY_EQUAL, MIN_SLIMNESS = 0.35, 0.1
# A front shows this share of its rectangle, with what lies on it.
MIN_VISIBLE_SHARE = 0.5
# Controls that make a front beside them a door, its least share of the side, and its greatest.
MIN_CONTROLS_BESIDE, MIN_DOOR_SHARE, MAX_DOOR_SHARE = 2, 0.3, 0.93
# Detergent drawers lie above a round door and are at most this wide by the side.
MAX_DRAWER_WIDTH_SHARE = 0.45


def tiled_fronts(measured: MeasuredFragments, panels: Sequence[Panel], chosen: Sequence[Panel]) -> list[Panel]:
    """Return panels that, with those that surely open, tile a part of the side in rows or columns."""
    rest = [p for p in panels if _is_plain(measured, p) and not any(p is c for c in chosen)]
    found: list[Panel] = []
    while True:
        sure = [*chosen, *found]
        more = [p for p in rest if any(_tile(p, o) for o in (sure or rest) if o is not p)]
        if not more:
            return found
        found += more
        rest = [p for p in rest if not any(p is m for m in more)]


def door_beside_controls(
    measured: MeasuredFragments, panels: Sequence[Panel], controls: Sequence[Control]
) -> Panel | None:
    """Return the one large panel without a handle that lies next to or below controls, as doors of appliances do."""
    lower, upper = corners_from_side(measured, FRONT)
    extent = upper.max(axis=0) - lower.min(axis=0)
    beside = [c.middle for c in controls]
    found = []
    for p in panels:
        outside = sum(bool((m < p.lower[:2]).any() or (m > p.upper[:2]).any()) for m in beside)
        share = p.width * p.height / float(extent[0] * extent[1])
        if (
            _is_plain(measured, p)
            and MIN_DOOR_SHARE <= share <= MAX_DOOR_SHARE
            and outside >= max(MIN_CONTROLS_BESIDE, len(beside))
        ):
            found.append(p)
    return found[0] if len(found) == 1 else None


def detergent_drawers(
    measured: MeasuredFragments, door: Panel, panels: Sequence[Panel], controls: Sequence[Control]
) -> list[Panel]:
    """Return the panel above a round door that is the front of a drawer: small, at one side, without controls."""
    lower, upper = corners_from_side(measured, FRONT)
    low, high = lower.min(axis=0), upper.max(axis=0)
    extent, middle = high - low, float((low + high)[0]) / 2
    found = [
        p
        for p in panels
        if p is not door
        and p.controls == 0
        and float(p.lower[1]) >= float(door.upper[1]) - IN_LINE
        and p.width <= MAX_DRAWER_WIDTH_SHARE * float(extent[0])
        and not p.lower[0] <= middle <= p.upper[0]
        and not any((c.middle >= p.lower[:2]).all() and (c.middle <= p.upper[:2]).all() for c in controls)
    ]
    return found[:1] if len(found) == 1 else []


def _is_plain(measured: MeasuredFragments, panel: Panel) -> bool:
    """Return whether a panel may be a front though it has no handle: seen, no slat, and without controls."""
    visible = float(measured.visible_area[panel.everything, FRONT].sum())
    slim = min(panel.width, panel.height) < MIN_SLIMNESS * max(panel.width, panel.height)
    return (
        not panel.is_recessed
        and panel.controls == 0
        and not slim
        and visible >= MIN_VISIBLE_SHARE * panel.width * panel.height
    )


def _tile(a: Panel, b: Panel) -> bool:
    """Return whether two panels lie in one row or column, flush, near each other, and about as large."""
    if abs(float(a.lower[2] - b.lower[2])) > SAME_DEPTH:
        return False
    areas = sorted((a.width * a.height, b.width * b.height))
    return areas[0] >= MIN_SIZE_BY_EQUAL * areas[1] and any(
        _in_line(a.lower, a.upper, b.lower, b.upper, k) for k in (0, 1)
    )


def _in_line(lower: Floats, upper: Floats, other_lower: Floats, other_upper: Floats, across: int) -> bool:
    """Return whether two rectangles begin and end at the same place on an axis, and are near on the other."""
    along = 1 - across
    away = np.abs([lower[across] - other_lower[across], upper[across] - other_upper[across]]).max()
    gap = max(float(lower[along] - other_upper[along]), float(other_lower[along] - upper[along]))
    return bool(away <= IN_LINE) and -IN_LINE <= gap <= MAX_GAP


# Round doors ----------------------------------------------------------------------------------------------------------
# Find the round door of a washing machine or dryer, which lies on the front as a ring, a disc or a dome.

# Diameter by the width and by the height of the front, distance of its middle from that of the front by the width, and
# height by width of the front. Ref: makers list loading doors of 30 to 50 cm in fronts of 60 by 85 cm.
MIN_DIAMETER_BY_WIDTH, MAX_DIAMETER_BY_WIDTH, MIN_DIAMETER_BY_HEIGHT = 0.35, 0.85, 0.22
MAX_OFFSET, MIN_TALL, MAX_TALL = 0.15, 0.8, 2.4
# Its parts start within this share of the depth of the thing, reach back at most by this share of their diameter, and
# show at least this share of their square.
MAX_START_SHARE, MAX_DEPTH_BY_DIAMETER, ROUND_MIN_VISIBLE_SHARE = 0.2, 0.6, 0.08
# Parts of one door have their middles this near to each other, by its diameter, and stay within its circle so far.
MAX_ECCENTRICITY, CIRCLE_TOLERANCE = 0.1, 1.06
# What lies deeper behind its back is the drum, diagonals.
MAX_BEHIND = 0.02


def find_round_door(measured: MeasuredFragments) -> Panel | None:
    """Return the round door of a side, with all that lies in its circle, or None."""
    lower, upper = corners_from_side(measured, FRONT)
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
    fits &= measured.visible_area[:, FRONT] >= ROUND_MIN_VISIBLE_SHARE * across**2
    rings = [i for i in np.flatnonzero(fits).tolist() if has_round_outline(measured, FRONT, [i], size[i, :2])]
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
    visible = float(measured.visible_area[members, FRONT].sum())
    corners = lower[shared].min(axis=0), upper[shared].max(axis=0)
    return Panel(members, *corners, visible_area=visible, is_round=True)


def fragments_around(measured: MeasuredFragments, door: Panel) -> list[int]:
    """Return the fragments whose rectangles hold a round door: the front of the body, in which it is hung."""
    lower, upper = corners_from_side(measured, FRONT)
    around = (lower[:, :2] <= door.lower[:2]).all(axis=1) & (upper[:, :2] >= door.upper[:2]).all(axis=1)
    return [i for i in np.flatnonzero(around).tolist() if i not in door.members]
