"""Merge boards that make up one door: stiles and rails with the panels that they hold."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.segment.fragment_measures import MeasuredFragments, corners_from_side
from casa_assets.core.typing import Floats

# Boards of one door begin at the same depth within this, and touch within this; diagonals.
FLUSH_TOLERANCE, TOUCH_TOLERANCE = 0.006, 0.006
# Widest stile or rail, as a share of its door.
MAX_STILE_SHARE = 0.26
# Thickest strip that lies upon a door, diagonals.
MAX_STRIP_THICKNESS = 0.05
# Share of the door that its boards cover.
MIN_LEAF_COVERAGE = 0.93
# Shorter side of equal boards from which they are fronts of their own, diagonals.
MIN_LEAF_SIDE = 0.09
# Widest stile of a narrow door, as a share of it, where so many rails run between the stiles.
MAX_BROAD_STILE_SHARE, MIN_RAILS = 0.36, 2
# Boards that are too slim for panels: least width and length, diagonals, and visible share of their rectangle.
MIN_SLAT_WIDTH, MIN_SLAT_LENGTH, MIN_VISIBLE_SHARE = 0.006, 0.025, 0.5
MAX_SLATS = 80
# Thickness of a slat by its width: flat, or square as rails of thin fronts are.
MAX_THICKNESS_BY_WIDTH = 1.1
# The infill of a framed door lies this much deeper than its stiles and meets them within the gap; a door within a frame
# of the body does neither. Diagonals.
MIN_SUNK_DEPTH, MAX_SUNK_GAP = 0.0004, 0.0012


def merge_framed_panels(panels: list[Panel], handle_spots: list[Floats], slats: list[Panel]) -> list[Panel]:
    """Merge the boards of each framed door into one panel.

    Args:
        handle_spots: (2,) middles in (u, v) of things that look like handles.
        slats: boards that are too slim to be panels: they may be part of one, and are left out otherwise.
    """
    remaining = [*panels, *slats]
    while True:
        boards = _smallest_framed_door(remaining, handle_spots)
        if boards is None:
            slat_ids = {id(p) for p in slats}
            return sorted(
                (p for p in remaining if id(p) not in slat_ids), key=lambda p: (-p.width * p.height, p.members[0])
            )
        remaining = [p for p in remaining if not any(p is q for q in boards)] + [_merge(boards)]


def _merge(panels: list[Panel]) -> Panel:
    """Return one panel around some panels."""
    return Panel(
        members=[f for p in panels for f in p.members],
        lower=np.min([p.lower for p in panels], axis=0),
        upper=np.max([p.upper for p in panels], axis=0),
        visible_area=sum(p.visible_area for p in panels),
        boards=sum(p.boards for p in panels),
        is_recessed=any(p.is_recessed for p in panels),
    )


def find_slats(measured: MeasuredFragments, side: int, panels: list[Panel]) -> list[Panel]:
    """Return flat boards on a side that are too slim to be panels, largest first."""
    lower, upper = corners_from_side(measured, side)
    size = upper - lower
    footprint = size[:, 0] * size[:, 1]
    is_slat = (
        (size[:, :2].min(axis=1) >= MIN_SLAT_WIDTH)
        & (size[:, :2].max(axis=1) >= MIN_SLAT_LENGTH)
        & (size[:, 2] < MAX_STRIP_THICKNESS)
    )
    is_slat &= (size[:, 2] <= MAX_THICKNESS_BY_WIDTH * size[:, :2].min(axis=1)) & (
        measured.visible_area[:, side] >= MIN_VISIBLE_SHARE * footprint
    )
    is_slat[[f for p in panels for f in p.members]] = False
    rows = np.flatnonzero(is_slat)
    order = rows[np.lexsort((rows, -footprint[rows]))][:MAX_SLATS].tolist()
    return [Panel([i], lower[i], upper[i], visible_area=float(measured.visible_area[i, side])) for i in order]


def merge_bridged_panels(measured: MeasuredFragments, side: int, panels: list[Panel]) -> list[Panel]:
    """Merge neighbouring panels where a stile lies across the border between them."""
    lower, upper = corners_from_side(measured, side)
    size = upper - lower
    is_stile = (
        (size[:, :2].max(axis=1) > 4 * size[:, :2].min(axis=1))
        & (size[:, 2] < MAX_STRIP_THICKNESS)
        & (measured.visible_area[:, side] > 0)
    )
    is_stile[[f for p in panels for f in p.members]] = False
    stiles = np.flatnonzero(is_stile).tolist()
    remaining = list(panels)
    while True:
        pair = next(
            ((a, b) for a, b in combinations(remaining, 2) if any(_bridges(lower[i], upper[i], a, b) for i in stiles)),
            None,
        )
        if pair is None:
            return remaining
        remaining = [p for p in remaining if p is not pair[0] and p is not pair[1]] + [_merge(list(pair))]


def _bridges(lower: Floats, upper: Floats, a: Panel, b: Panel) -> bool:
    """Return whether a strip lies upon two flush panels, along most of both."""
    along = int(np.argmax((upper - lower)[:2]))
    across = 1 - along
    is_flush = (
        abs(float(a.lower[2] - b.lower[2])) < FLUSH_TOLERANCE
        and abs(float(a.lower[across] - b.lower[across])) < TOUCH_TOLERANCE
    )
    is_flush &= abs(float(a.upper[across] - b.upper[across])) < TOUCH_TOLERANCE
    gap = max(float(a.lower[along]), float(b.lower[along])) - min(float(a.upper[along]), float(b.upper[along]))
    if not is_flush or abs(gap) > TOUCH_TOLERANCE:
        return False
    for p in (a, b):
        is_upon = lower[2] < p.lower[2] - 0.002 and upper[2] >= p.lower[2] - 0.001
        is_within = (
            lower[across] >= p.lower[across] - TOUCH_TOLERANCE and upper[across] <= p.upper[across] + TOUCH_TOLERANCE
        )
        length = float(min(upper[along], p.upper[along]) - max(lower[along], p.lower[along]))
        if not (is_upon and is_within and length >= 0.6 * float(p.upper[along] - p.lower[along])):
            return False
    return True


def _smallest_framed_door(panels: list[Panel], handle_spots: list[Floats]) -> list[Panel] | None:
    """Return the boards of the smallest door that two of the panels frame, or None."""
    best: tuple[float, list[Panel]] | None = None
    for a, b in combinations(panels, 2):
        for along in (0, 1):
            if not _are_stiles(a, b, along):
                continue
            lower, upper = np.minimum(a.lower, b.lower), np.maximum(a.upper, b.upper)
            area = float(np.prod((upper - lower)[:2]))
            if best is not None and area >= best[0]:
                continue
            inner = [p for p in panels if _within(p, lower, upper)]
            if len(inner) >= 3 and _fills_door(inner, lower, upper, area, handle_spots, (a, b)):
                best = (area, inner)
    return best[1] if best else None


def _are_stiles(a: Panel, b: Panel, along: int) -> bool:
    """Return whether two panels are parallel boards of equal length on two sides; `along` is their long axis."""
    across = 1 - along
    length_a, length_b = float(a.upper[along] - a.lower[along]), float(b.upper[along] - b.lower[along])
    width_a, width_b = float(a.upper[across] - a.lower[across]), float(b.upper[across] - b.lower[across])
    is_flush = (
        abs(float(a.lower[along] - b.lower[along])) < TOUCH_TOLERANCE
        and abs(float(a.upper[along] - b.upper[along])) < TOUCH_TOLERANCE
    )
    span = max(float(a.upper[across]), float(b.upper[across])) - min(float(a.lower[across]), float(b.lower[across]))
    is_slim = max(width_a, width_b) < MAX_BROAD_STILE_SHARE * span and max(width_a, width_b) < 0.8 * min(
        length_a, length_b
    )
    return is_flush and is_slim and abs(float(a.lower[2] - b.lower[2])) < FLUSH_TOLERANCE


def _within(panel: Panel, lower: Floats, upper: Floats) -> bool:
    """Return whether a panel lies in a rectangle and at about its depth."""
    inside = (panel.lower[:2] >= lower[:2] - TOUCH_TOLERANCE).all() and (
        panel.upper[:2] <= upper[:2] + TOUCH_TOLERANCE
    ).all()
    return (
        bool(inside)
        and float(panel.lower[2]) >= float(lower[2]) - FLUSH_TOLERANCE
        and float(panel.lower[2]) <= float(upper[2]) + 0.02
    )


def _fills_door(
    inner: list[Panel],
    lower: Floats,
    upper: Floats,
    area: float,
    handle_spots: list[Floats],
    frame: tuple[Panel, Panel],
) -> bool:
    """Return whether boards fill a rectangle, and the boards inside their frame have no separate handle."""
    covered = sum(p.width * p.height for p in inner)
    if _are_leaves(inner):
        return False
    if covered < MIN_LEAF_COVERAGE * area or not (_is_narrow(frame, lower, upper) or _has_rails(inner, frame)):
        return False
    for p in inner:
        is_slim = min(p.width, p.height) < MAX_STILE_SHARE * float(min((upper - lower)[:2]))
        if p is frame[0] or p is frame[1] or is_slim or p.boards > 1 or _is_recessed_infill(p, frame):
            continue
        if any(((g >= p.lower[:2]) & (g <= p.upper[:2])).all() for g in handle_spots):
            return False
    handles = sum(any(((g >= p.lower[:2]) & (g <= p.upper[:2])).all() for g in handle_spots) for p in inner)
    return handles <= 1


def _are_leaves(panels: list[Panel]) -> bool:
    """Return whether panels are large and equal: fronts in a row, and no stiles with what they hold."""
    size = np.array([[p.width, p.height] for p in panels])
    return bool((np.ptp(size, axis=0) < TOUCH_TOLERANCE).all() and size.min() >= MIN_LEAF_SIDE)


def _is_narrow(frame: tuple[Panel, Panel], lower: Floats, upper: Floats) -> bool:
    """Return whether two stiles are narrow by the door that they frame."""
    across = 1 - _along(frame)
    width = max(float((p.upper - p.lower)[across]) for p in frame)
    return width < MAX_STILE_SHARE * float((upper - lower)[across])


def _has_rails(inner: list[Panel], frame: tuple[Panel, Panel]) -> bool:
    """Return whether boards run between two stiles, from one to the other, at both ends of them."""
    along = _along(frame)
    across = 1 - along
    first, last = sorted(frame, key=lambda p: float(p.lower[across]))
    rails = [
        p
        for p in inner
        if p is not first
        and p is not last
        and abs(float(p.lower[across] - first.upper[across])) < TOUCH_TOLERANCE
        and abs(float(last.lower[across] - p.upper[across])) < TOUCH_TOLERANCE
        and abs(float(p.lower[2] - first.lower[2])) < FLUSH_TOLERANCE
    ]
    lower, upper = float(first.lower[along]), float(first.upper[along])
    has_end = [any(abs(float(p.lower[along]) - lower) < TOUCH_TOLERANCE for p in rails)]
    has_end += [any(abs(float(p.upper[along]) - upper) < TOUCH_TOLERANCE for p in rails)]
    is_plain = all(p.boards == 1 for p in frame)
    return is_plain and sum(p.boards for p in rails) >= MIN_RAILS and all(has_end)


def _along(frame: tuple[Panel, Panel]) -> int:
    """Return the axis along which two stiles run: the one on which they begin at the same place."""
    return int(np.argmin(np.abs(frame[0].lower - frame[1].lower)[:2]))


def _is_recessed_infill(panel: Panel, frame: tuple[Panel, Panel]) -> bool:
    """Return whether a panel lies a little deeper than two stiles and meets both."""
    across = 1 - _along(frame)
    first, last = sorted(frame, key=lambda p: float(p.lower[across]))
    gaps = float(panel.lower[across] - first.upper[across]), float(last.lower[across] - panel.upper[across])
    return max(gaps) <= MAX_SUNK_GAP and float(panel.lower[2]) >= max(float(p.lower[2]) for p in frame) + MIN_SUNK_DEPTH
