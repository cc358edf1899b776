"""Panels that are one leaf: stiles and rails with what they hold, which a file may keep as single boards."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from casa_assets.articulate.panels import Panel
from casa_assets.articulate.pieces import Pieces, face_on
from casa_assets.articulate.soup import Floats

# Boards of one leaf begin at the same depth, and touch; diagonals.
FLUSH, TOUCH = 0.006, 0.006
# A stile or rail is at most this part of the leaf wide.
NARROW = 0.26
# A strip that lies upon a leaf is no thicker than this, diagonals.
THIN = 0.05
# The boards cover at least this part of the leaf.
FULL = 0.93


def joined(panels: list[Panel], gripped: list[Floats]) -> list[Panel]:
    """Panels with the boards of one leaf made one panel.

    Args:
        gripped: (2,) middles in (u, v) of things that look like handles.
    """
    left = list(panels)
    while True:
        found = _best(left, gripped)
        if found is None:
            return sorted(left, key=lambda p: (-p.width * p.height, p.members[0]))
        left = [p for p in left if not any(p is q for q in found)] + [_merged(found)]


def _merged(found: list[Panel]) -> Panel:
    """One leaf of some panels."""
    return Panel(
        members=[f for p in found for f in p.members],
        low=np.min([p.low for p in found], axis=0),
        high=np.max([p.high for p in found], axis=0),
        shown=sum(p.shown for p in found),
        boards=sum(p.boards for p in found),
        far=any(p.far for p in found),
    )


def bridged(pieces: Pieces, side: int, panels: list[Panel]) -> list[Panel]:
    """Panels with those made one on which a stile lies that runs over the border between them."""
    low, high = face_on(pieces, side)
    size = high - low
    slim = (size[:, :2].max(axis=1) > 4 * size[:, :2].min(axis=1)) & (size[:, 2] < THIN) & (pieces.seen[:, side] > 0)
    slim[[f for p in panels for f in p.members]] = False
    stiles = np.flatnonzero(slim).tolist()
    left = list(panels)
    while True:
        pair = next(
            ((a, b) for a, b in combinations(left, 2) if any(_bridges(low[i], high[i], a, b) for i in stiles)), None
        )
        if pair is None:
            return left
        left = [p for p in left if p is not pair[0] and p is not pair[1]] + [_merged(list(pair))]


def _bridges(low: Floats, high: Floats, a: Panel, b: Panel) -> bool:
    """Whether a strip lies upon two flush panels, along most of both."""
    along = int(np.argmax((high - low)[:2]))
    across = 1 - along
    flush = abs(float(a.low[2] - b.low[2])) < FLUSH and abs(float(a.low[across] - b.low[across])) < TOUCH
    flush &= abs(float(a.high[across] - b.high[across])) < TOUCH
    apart = max(float(a.low[along]), float(b.low[along])) - min(float(a.high[along]), float(b.high[along]))
    if not flush or abs(apart) > TOUCH:
        return False
    for p in (a, b):
        upon = low[2] < p.low[2] - 0.002 and high[2] >= p.low[2] - 0.001
        inner = low[across] >= p.low[across] - TOUCH and high[across] <= p.high[across] + TOUCH
        length = float(min(high[along], p.high[along]) - max(low[along], p.low[along]))
        if not (upon and inner and length >= 0.6 * float(p.high[along] - p.low[along])):
            return False
    return True


def _best(panels: list[Panel], gripped: list[Floats]) -> list[Panel] | None:
    """The boards of the smallest leaf that two of the panels frame, or None."""
    best: tuple[float, list[Panel]] | None = None
    for a, b in combinations(panels, 2):
        for along in (0, 1):
            if not _frame(a, b, along):
                continue
            low, high = np.minimum(a.low, b.low), np.maximum(a.high, b.high)
            area = float(np.prod((high - low)[:2]))
            if best is not None and area >= best[0]:
                continue
            inner = [p for p in panels if _within(p, low, high)]
            if len(inner) >= 3 and _is_leaf(inner, low, high, area, gripped, (a, b)):
                best = (area, inner)
    return best[1] if best else None


def _frame(a: Panel, b: Panel, along: int) -> bool:
    """Whether two panels are parallel boards of equal length at two sides of something; `along` is their long side."""
    across = 1 - along
    long_a, long_b = float(a.high[along] - a.low[along]), float(b.high[along] - b.low[along])
    wide_a, wide_b = float(a.high[across] - a.low[across]), float(b.high[across] - b.low[across])
    flush = abs(float(a.low[along] - b.low[along])) < TOUCH and abs(float(a.high[along] - b.high[along])) < TOUCH
    whole = max(float(a.high[across]), float(b.high[across])) - min(float(a.low[across]), float(b.low[across]))
    slim = max(wide_a, wide_b) < NARROW * whole and max(wide_a, wide_b) < 0.8 * min(long_a, long_b)
    return flush and slim and abs(float(a.low[2] - b.low[2])) < FLUSH


def _within(panel: Panel, low: Floats, high: Floats) -> bool:
    inside = (panel.low[:2] >= low[:2] - TOUCH).all() and (panel.high[:2] <= high[:2] + TOUCH).all()
    return (
        bool(inside) and float(panel.low[2]) >= float(low[2]) - FLUSH and float(panel.low[2]) <= float(high[2]) + 0.02
    )


def _is_leaf(
    inner: list[Panel], low: Floats, high: Floats, area: float, gripped: list[Floats], frame: tuple[Panel, Panel]
) -> bool:
    """Whether boards fill a rectangle, and what they frame has no handle of its own."""
    covered = sum(p.width * p.height for p in inner)
    if covered < FULL * area:
        return False
    for p in inner:
        slim = min(p.width, p.height) < NARROW * float(min((high - low)[:2]))
        if p is frame[0] or p is frame[1] or slim or p.boards > 1:
            continue
        if any(((g >= p.low[:2]) & (g <= p.high[:2])).all() for g in gripped):
            return False
    held = sum(any(((g >= p.low[:2]) & (g <= p.high[:2])).all() for g in gripped) for p in inner)
    return held <= 1
