"""A relief -> rectangles that its front is made of: split along gaps and steps, then between handles and controls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from casa_assets.articulate.creases import FAR, Blob, Relief, thick_lines
from casa_assets.articulate.soup import Bools, Floats

# No rectangle is narrower than this, diagonals.
LEAST = 0.012
# A line may waver by so much, diagonals.
WAVER = 0.0022
# A line is looked at in so many stretches: each must show it, and all together even more.
STRETCHES, EACH, ALL = 12, 0.5, 0.75
# It shows so much more than the rest of the rectangle does: a rough surface has edges everywhere.
CONTRAST = 0.45
# A stretch of which less lies open says nothing; so many must speak.
OPEN, SPEAK = 0.3, 5
# What stands out and is so long is a handle, from so far on. Ref: as for whole fragments, fronts.HANDLE_STANDS.
BAR_LONG, BAR_STANDS = 2.5, 0.012
# What stands out farther is the ragged border of the thing, before what lies behind it.
FARTHEST = 0.13
# Handles whose middles differ by less lie in one row or column.
ROW = 0.04


@dataclass(frozen=True)
class Leaf:
    """A rectangle of the front, half-open ranges of pixels.

    Attributes:
        plane: median depth of its ground. blobs: numbers of the things whose middle lies in it.
    """

    rows: tuple[int, int]
    columns: tuple[int, int]
    plane: float = 0.0
    blobs: tuple[int, ...] = ()


def find_leaves(side: Relief) -> list[Leaf]:
    """Rectangles of a side, top down and left to right; together they cover it."""
    seen = side.depth < FAR / 2
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if not len(rows):
        return []
    whole = Leaf((int(rows[0]), int(rows[-1]) + 1), (int(columns[0]), int(columns[-1]) + 1))
    waver = max(1, round(WAVER / side.picture.pixel))
    lines = thick_lines(side, False, waver), thick_lines(side, True, waver)
    parted = [m for leaf in _parted(whole, lines, max(4, round(LEAST / side.picture.pixel))) for m in _held(side, leaf)]
    return sorted((_measured(side, m) for m in parted), key=lambda m: (m.rows, m.columns))


def _parted(leaf: Leaf, lines: tuple[tuple[Bools, Bools], tuple[Bools, Bools]], least: int) -> list[Leaf]:
    """A rectangle split along its best line, and the parts likewise, until none is left."""
    level = _best(lines[0], leaf.rows, leaf.columns, least)
    upright = _best(lines[1], leaf.columns, leaf.rows, least)
    if max(level[0], upright[0]) < ALL:
        return [leaf]
    halves = _at_row(leaf, level[1]) if level[0] >= upright[0] else _at_column(leaf, upright[1])
    return [m for half in halves for m in _parted(half, lines, least)]


def _best(line: tuple[Bools, Bools], across: tuple[int, int], along: tuple[int, int], least: int) -> tuple[float, int]:
    """How well the best line that crosses a rectangle from end to end is seen, 0..1, and where it lies."""
    low, high = across[0] + least, across[1] - least
    if high <= low or along[1] - along[0] < 2 * STRETCHES:
        return 0.0, 0
    window = slice(low, high), slice(*along)
    edges, free = line[0][window], line[1][window]
    cuts = np.linspace(0, edges.shape[1], STRETCHES + 1).astype(np.int64)[:-1]
    hit = np.add.reduceat(edges.astype(np.int64), cuts, axis=1)
    can = np.add.reduceat(free.astype(np.int64), cuts, axis=1)
    width = np.diff(np.append(cuts, edges.shape[1]))
    speaks = can >= OPEN * width
    share = np.where(speaks, hit / np.maximum(can, 1), 1.0)
    mean = np.where(speaks, hit, 0).sum(axis=1) / np.maximum(np.where(speaks, can, 0).sum(axis=1), 1)
    good = (share >= EACH).all(axis=1) & (speaks.sum(axis=1) >= SPEAK)
    mean = np.where(good & (mean - float(edges.mean()) >= CONTRAST), mean, 0.0)
    best = float(mean.max())
    # Of equal neighbours the middle one.
    at = np.flatnonzero(mean >= best - 0.02)
    run = at[(at - at[0]) <= np.arange(len(at)) + 1]
    return best, low + int(run[len(run) // 2])


def _at_row(leaf: Leaf, row: int) -> list[Leaf]:
    return [replace(leaf, rows=(leaf.rows[0], row)), replace(leaf, rows=(row, leaf.rows[1]))]


def _at_column(leaf: Leaf, column: int) -> list[Leaf]:
    return [replace(leaf, columns=(leaf.columns[0], column)), replace(leaf, columns=(column, leaf.columns[1]))]


def _inside(side: Relief, leaf: Leaf) -> list[Blob]:
    """What stands out with its middle in a rectangle."""
    return [
        b
        for b in side.blobs
        if leaf.rows[0] <= sum(b.rows) / 2 < leaf.rows[1] and leaf.columns[0] <= sum(b.columns) / 2 < leaf.columns[1]
    ]


def is_bar(blob: Blob) -> bool:
    """Whether something is a handle by its shape."""
    return blob.long >= BAR_LONG and BAR_STANDS <= blob.stands <= FARTHEST


def _held(side: Relief, leaf: Leaf) -> list[Leaf]:
    """A rectangle without seams, split so that a part has one handle, and no handle shares one with controls."""
    inside = _inside(side, leaf)
    bars = [b for b in inside if is_bar(b)]
    others = [b for b in inside if not is_bar(b)]
    if bars and others:
        parts = _band(leaf, bars, others)
        if parts:
            return [m for part in parts for m in _held(side, part)]
    if len(bars) >= 2:
        parts = _between(leaf, bars, max(2, round(ROW / side.picture.pixel)))
        if parts:
            return [m for part in parts for m in _held(side, part)]
    return [leaf]


def _band(leaf: Leaf, bars: list[Blob], others: list[Blob]) -> list[Leaf]:
    """The strip along a side that holds the controls, and the rest; controls lie in the middle of their strip."""
    found: list[tuple[float, int, list[Leaf]]] = []
    for order, (name, first, step) in enumerate(
        (("rows", 0, 1), ("rows", 1, -1), ("columns", 1, -1), ("columns", 0, 1))
    ):
        ends = getattr(leaf, name)
        span = ends[1] - ends[0]
        near = [abs(getattr(b, name)[first] - ends[first]) for b in others]
        far = [abs(getattr(b, name)[1 - first] - ends[first]) for b in others]
        hand = min(abs(getattr(b, name)[first] - ends[first]) for b in bars)
        if max(far) >= hand or max(far) > 0.45 * span:
            continue
        at = ends[first] + step * min(max(far) + min(near), (max(far) + hand) // 2)
        halves = _at_row(leaf, at) if name == "rows" else _at_column(leaf, at)
        found.append((max(far) / span, order, halves))
    return min(found, key=lambda f: f[:2])[2] if found else []


def _between(leaf: Leaf, bars: list[Blob], row: int) -> list[Leaf]:
    """A rectangle with several handles, split between the first and the others."""
    lie = sum((b.columns[1] - b.columns[0]) > (b.rows[1] - b.rows[0]) for b in bars) * 2 >= len(bars)
    by_row = _gap([b.rows for b in bars], row)
    by_column = _gap([b.columns for b in bars], row)
    if by_row is not None and (lie or by_column is None):
        top = min(b.rows[0] for b in bars) - leaf.rows[0]
        at = by_row[1] - top if lie and top < 0.9 * (by_row[1] - by_row[0]) else sum(by_row) // 2
        return _at_row(leaf, at)
    return _at_column(leaf, sum(by_column) // 2) if by_column is not None else []


def _gap(spans: list[tuple[int, int]], least: int) -> tuple[int, int] | None:
    """The first stretch between spans that none of them covers, where it is long enough."""
    ordered = sorted(spans)
    reach = ordered[0][1]
    for low, high in ordered[1:]:
        if low - reach >= least // 2:
            return reach, low
        reach = max(reach, high)
    return None


def _measured(side: Relief, leaf: Leaf) -> Leaf:
    """A rectangle with its plane and what stands on it."""
    window = slice(*leaf.rows), slice(*leaf.columns)
    ground = side.depth[window][side.blob[window] < 0]
    inside = _inside(side, leaf)
    numbers = tuple(i for i, b in enumerate(side.blobs) if any(b is o for o in inside))
    return replace(leaf, plane=float(np.median(ground)) if len(ground) else FAR, blobs=numbers)


def corners(side: Relief, leaf: Leaf) -> tuple[Floats, Floats]:
    """(2,) lower and upper corner of a rectangle in (u, v)."""
    height = side.depth.shape[0]
    picture = side.picture
    low = picture.low + picture.pixel * np.array([leaf.columns[0], height - leaf.rows[1]])
    high = picture.low + picture.pixel * np.array([leaf.columns[1], height - leaf.rows[0]])
    return low, high
