"""Find what slides or turns behind a front: inner drawers, racks and turntables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.interior.hollow_parts import view_from_above
from casa_assets.articulate.plan import HingeEdge
from casa_assets.articulate.segment.fragment_measures import (
    BOTTOM,
    FRONT,
    LEFT,
    RIGHT,
    SIDES,
    MeasuredFragments,
    corners_from_side,
)
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats

# Least width of a rack and of a turntable as shares of their door, and their greatest height.
MIN_RACK_WIDTH_SHARE, MIN_TURNTABLE_WIDTH_SHARE, MAX_HEIGHT_SHARE = 0.45, 0.2, 0.5
# Least width of a tub as a share of its door, since tubs stand side by side, and the gaps over which fragments are
# grouped, the narrower first; diagonals.
MIN_TUB_WIDTH_SHARE, GROUPING_GAPS = 0.3, (0.0008, 0.004)
# Greatest share of the surface of an inner part that is visible from outside, and of a tub.
MAX_VISIBLE_SHARE, MAX_TUB_VISIBLE_SHARE = 0.02, 0.05
# A plate this near to a wall rests on it, diagonals.
TOUCH_TOLERANCE = 0.001


@dataclass(frozen=True)
class InnerPart:
    """Something behind a door that moves: a turntable (`turns`), a drawer (`is_drawer`), or else a rack."""

    fragments: tuple[int, ...]
    turns: bool
    is_drawer: bool
    confidence: float
    reason: str


def find_inner_parts(
    measured: MeasuredFragments, side: int, door: Panel, edge: HingeEdge | None, taken: Sequence[int]
) -> list[InnerPart]:
    """Return the drawers and turntables behind a front, and the racks behind one that folds down."""
    lower, upper = corners_from_side(measured, side)
    free = np.ones(measured.count, dtype=bool)
    free[list(taken)] = False
    within = (lower[:, :2] >= door.lower[:2] - 0.03).all(axis=1) & (upper[:, :2] <= door.upper[:2] + 0.03).all(axis=1)
    small = (upper - lower)[:, 1] <= MAX_HEIGHT_SHARE * door.height
    rows = free & within & small & (lower[:, 2] >= door.upper[2] - 0.12)
    surface = MAX_VISIBLE_SHARE * np.maximum(measured.area, 1e-12)
    # A thing without a top or back shows what is in it; what shows elsewhere is a wall.
    covered = (
        measured.visible_area[:, [s for s in (FRONT, LEFT, RIGHT, BOTTOM) if s != side]].sum(axis=1)
        <= MAX_TUB_VISIBLE_SHARE / MAX_VISIBLE_SHARE * surface
    )
    found = []
    gone: set[int] = set()
    for gap in GROUPING_GAPS:
        for group in group_touching(
            lower, upper, [i for i in np.flatnonzero(rows & covered).tolist() if i not in gone], gap
        ):
            if _fills(lower, upper, group, door, MIN_TUB_WIDTH_SHARE) and _is_tub(measured, lower, upper, group, door):
                found.append(InnerPart(tuple(group), False, True, 0.7, "a tub behind a front"))
                gone |= set(group)
    rows &= measured.visible_area.sum(axis=1) <= surface
    rows[sorted(gone)] = False
    for heap in group_touching(lower, upper, np.flatnonzero(rows).tolist()):
        if not _fills(lower, upper, heap, door, MIN_TURNTABLE_WIDTH_SHARE):
            continue
        group = _with_what_it_holds(lower, upper, heap, rows)
        tray = _rack(measured, side, group, edge, door)
        if tray is not None:
            found.append(tray)
            rows[group] = False
    return found


def _with_what_it_holds(lower: Floats, upper: Floats, group: list[int], free: Bools) -> list[int]:
    """Return a group with all that lies within its box: tines of a basket need not touch its wires."""
    a, b = lower[group].min(axis=0) - TOUCH_TOLERANCE, upper[group].max(axis=0) + TOUCH_TOLERANCE
    within = free & (lower >= a).all(axis=1) & (upper <= b).all(axis=1)
    return sorted({*group, *np.flatnonzero(within).tolist()})


def _fills(lower: Floats, upper: Floats, group: list[int], door: Panel, share: float) -> bool:
    """Return whether a group is wide enough, by a share of its door, and deep enough to be its content."""
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    return bool(across[0] >= share * door.width and across[2] >= min(0.25, share) * door.width)


def _is_tub(measured: MeasuredFragments, lower: Floats, upper: Floats, group: list[int], door: Panel) -> bool:
    """Return whether a group is a drawer: of solid walls, and starting not far behind the front."""
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    near = float(lower[group, 2].min() - door.upper[2]) <= 0.35 * float(across[2])
    tall = 0.08 * min(across[0], across[2]) <= across[1] <= MAX_HEIGHT_SHARE * door.height
    return bool(near and tall) and view_from_above(measured, group).is_tub


def _rack(
    measured: MeasuredFragments, side: int, group: list[int], edge: HingeEdge | None, door: Panel
) -> InnerPart | None:
    """Return a rack or a turntable, or None for neither: boards between the walls do not move."""
    lower, upper = corners_from_side(measured, side)
    across = upper[group].max(axis=0) - lower[group].min(axis=0)
    if across[1] > 0.6 * min(across[0], across[2]):
        return None
    disc = abs(float(across[0] - across[2])) < 0.03 * float(across[0]) and _is_disc(measured, side, group)
    if disc:
        return InnerPart(tuple(group), True, False, 0.7, "a disc behind a door")
    if (
        edge is not HingeEdge.BOTTOM
        or not _fills(lower, upper, group, door, MIN_RACK_WIDTH_SHARE)
        or _is_board(lower, upper, group, measured.count)
    ):
        return None
    return InnerPart(tuple(group), False, False, 0.6, "a level rack behind a door that folds down")


def _is_board(lower: Floats, upper: Floats, group: list[int], count: int) -> bool:
    """Return whether a group is one plate that stands between two walls."""
    a, b = lower[group].min(axis=0), upper[group].max(axis=0)
    plates = [i for i in group if np.prod((upper[i] - lower[i])[[0, 2]]) >= 0.9 * np.prod((b - a)[[0, 2]])]
    others = np.ones(count, dtype=bool)
    others[group] = False
    return len(plates) == 1 and is_shelf(lower, upper, plates[0], others)


def is_shelf(lower: Floats, upper: Floats, plate: int, others: Bools) -> bool:
    """Return whether a level plate stands between two walls among `others`, as shelves, floors and tops do."""
    thick = float((upper - lower)[plate, 1])
    near = (
        others
        & (lower <= upper[plate] + TOUCH_TOLERANCE).all(axis=1)
        & (upper >= lower[plate] - TOUCH_TOLERANCE).all(axis=1)
    )
    walls = near & (upper[:, 1] - lower[:, 1] > 3 * thick)
    left = walls & (upper[:, 0] <= lower[plate, 0] + 2 * TOUCH_TOLERANCE)
    right = walls & (lower[:, 0] >= upper[plate, 0] - 2 * TOUCH_TOLERANCE)
    return bool(left.any() and right.any())


def group_touching(lower: Floats, upper: Floats, rows: list[int], gap: float = 0.004) -> list[list[int]]:
    """Group fragments whose boxes touch, each group ascending; `gap` in diagonals."""
    if not rows:
        return []
    a, b = lower[rows], upper[rows]
    meet = ((a[:, None] <= b[None] + gap) & (a[None] <= b[:, None] + gap)).all(axis=2)
    _, label = connected_components(coo_matrix(meet), directed=False)
    return [[r for r, k in zip(rows, label.tolist(), strict=True) if k == n] for n in range(int(label.max()) + 1)]


def _is_disc(measured: MeasuredFragments, side: int, group: Sequence[int]) -> bool:
    """Return whether the outline seen from above is a circle, because its corners are empty."""
    points = measured.points_of(group) @ SIDES[side][[0, 2]].T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.ptp(points, axis=0).max()) / 2
    return bool(np.linalg.norm(points - middle, axis=1).max() <= 1.06 * radius)
