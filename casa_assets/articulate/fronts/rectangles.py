"""Split the relief of a front into rectangles along gaps and steps, then between handles and controls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import find_objects, label

from casa_assets.articulate.segment.creases import BACKGROUND_DEPTH, MIN_DEPTH_STEP, Protrusion, SideRelief, edge_lines
from casa_assets.articulate.segment.welded_mesh import Bools
from casa_assets.core.typing import Floats

# Narrowest rectangle, diagonals.
MIN_SIDE = 0.012
# How far a line may deviate from straight, diagonals.
LINE_TOLERANCE = 0.0022
# A line is divided into stretches; each, and the whole line, has to be visible to these shares.
LINE_STRETCHES, MIN_STRETCH_VISIBILITY, MIN_LINE_VISIBILITY = 12, 0.5, 0.75
# A line is visible to so much more than edges elsewhere in its rectangle: rough surfaces have edges everywhere.
MIN_LINE_CONTRAST = 0.45
# A stretch counts if this share of it is not hidden by protrusions; so many stretches have to count.
MIN_FREE_SHARE, MIN_USABLE_STRETCHES = 0.3, 5
# Length to width and least protrusion of a handle, diagonals. Ref: as MIN_HANDLE_PROTRUSION in fronts.py.
MIN_BAR_RATIO, MIN_BAR_PROTRUSION = 2.5, 0.012
# A region that protrudes farther is the ragged border of the object before what lies behind it, diagonals.
MAX_PROTRUSION = 0.13
# From this protrusion on a handle keeps HANDLE_MARGIN from the border of the object, else FLAT_MARGIN, since flaps of
# cartons end there; diagonals. MIN_SURROUNDED_SHARE of its surroundings is surface.
SURE_HANDLE_PROTRUSION, HANDLE_MARGIN, FLAT_MARGIN, MIN_SURROUNDED_SHARE = 0.024, 0.012, 0.03, 0.97
# Handles whose middles differ by less lie in one row or column, diagonals.
SAME_ROW = 0.04
# Most pulls, width of their rectangle as a share of the side, tolerance of their sizes, and how many in a row are
# controls instead.
MAX_PULLS, MIN_WIDTH_SHARE, SIZE_TOLERANCE, MIN_CONTROLS_IN_ROW = 10, 0.45, 0.3, 3
# Distance of a pull from a side of its front, or from its middle, by the width of the front.
MAX_SIDE_OFFSET, MAX_CENTRE_OFFSET = 0.25, 0.12
# The frame around a recess is this quantile of depth; least size and greatest depth of a recess, diagonals, and the
# share of its rectangle that it fills.
FRAME_DEPTH_QUANTILE, MIN_SUNK_SIDE, MAX_SUNK_DEPTH, MIN_SUNK_FILL = 0.15, 0.04, 0.05, 0.85


@dataclass(frozen=True)
class FrontRectangle:
    """A rectangle of the front, as half-open pixel ranges.

    Attributes:
        plane: median depth of its ground. blobs: numbers of the things whose middle lies in it.
    """

    rows: tuple[int, int]
    columns: tuple[int, int]
    plane: float = 0.0
    blobs: tuple[int, ...] = ()


def find_front_rectangles(side: SideRelief) -> list[FrontRectangle]:
    """Return the rectangles of a side, top down and left to right; together they cover it."""
    seen = side.depth < BACKGROUND_DEPTH / 2
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if not len(rows):
        return []
    whole = FrontRectangle((int(rows[0]), int(rows[-1]) + 1), (int(columns[0]), int(columns[-1]) + 1))
    waver = max(1, round(LINE_TOLERANCE / side.image.pixel))
    lines = edge_lines(side, False, waver), edge_lines(side, True, waver)
    parted = [
        m
        for rectangle in _parted(whole, lines, max(4, round(MIN_SIDE / side.image.pixel)))
        for m in _held(side, rectangle)
    ]
    return sorted((measure_rectangle(side, m) for m in parted), key=lambda m: (m.rows, m.columns))


def _parted(
    rectangle: FrontRectangle, lines: tuple[tuple[Bools, Bools], tuple[Bools, Bools]], min_size: int
) -> list[FrontRectangle]:
    """Split a rectangle along its best line, and the halves likewise, until no line is left."""
    level = _best(lines[0], rectangle.rows, rectangle.columns, min_size)
    upright = _best(lines[1], rectangle.columns, rectangle.rows, min_size)
    if max(level[0], upright[0]) < MIN_LINE_VISIBILITY:
        return [rectangle]
    halves = _at_row(rectangle, level[1]) if level[0] >= upright[0] else _at_column(rectangle, upright[1])
    return [m for half in halves for m in _parted(half, lines, min_size)]


def _best(
    line: tuple[Bools, Bools], across: tuple[int, int], along: tuple[int, int], min_size: int
) -> tuple[float, int]:
    """Return the visibility 0..1 of the best line across a rectangle from end to end, and its place."""
    lower, upper = across[0] + min_size, across[1] - min_size
    if upper <= lower or along[1] - along[0] < 2 * LINE_STRETCHES:
        return 0.0, 0
    window = slice(lower, upper), slice(*along)
    edges, free = line[0][window], line[1][window]
    cuts = np.linspace(0, edges.shape[1], LINE_STRETCHES + 1).astype(np.int64)[:-1]
    hit = np.add.reduceat(edges.astype(np.int64), cuts, axis=1)
    can = np.add.reduceat(free.astype(np.int64), cuts, axis=1)
    width = np.diff(np.append(cuts, edges.shape[1]))
    speaks = can >= MIN_FREE_SHARE * width
    share = np.where(speaks, hit / np.maximum(can, 1), 1.0)
    mean = np.where(speaks, hit, 0).sum(axis=1) / np.maximum(np.where(speaks, can, 0).sum(axis=1), 1)
    good = (share >= MIN_STRETCH_VISIBILITY).all(axis=1) & (speaks.sum(axis=1) >= MIN_USABLE_STRETCHES)
    mean = np.where(good & (mean - float(edges.mean()) >= MIN_LINE_CONTRAST), mean, 0.0)
    best = float(mean.max())
    # Of equal neighbours the middle one.
    at = np.flatnonzero(mean >= best - 0.02)
    run = at[(at - at[0]) <= np.arange(len(at)) + 1]
    return best, lower + int(run[len(run) // 2])


def _at_row(rectangle: FrontRectangle, row: int) -> list[FrontRectangle]:
    """Split a rectangle at a row."""
    return [replace(rectangle, rows=(rectangle.rows[0], row)), replace(rectangle, rows=(row, rectangle.rows[1]))]


def _at_column(rectangle: FrontRectangle, column: int) -> list[FrontRectangle]:
    """Split a rectangle at a column."""
    return [
        replace(rectangle, columns=(rectangle.columns[0], column)),
        replace(rectangle, columns=(column, rectangle.columns[1])),
    ]


def _inside(side: SideRelief, rectangle: FrontRectangle) -> list[Protrusion]:
    """Return the protrusions whose middle is in a rectangle."""
    return [
        b
        for b in side.blobs
        if rectangle.rows[0] <= sum(b.rows) / 2 < rectangle.rows[1]
        and rectangle.columns[0] <= sum(b.columns) / 2 < rectangle.columns[1]
    ]


def is_bar(blob: Protrusion) -> bool:
    """Return whether a protrusion has the shape of a handle."""
    return blob.long >= MIN_BAR_RATIO and MIN_BAR_PROTRUSION <= blob.protrusion <= MAX_PROTRUSION


def is_handle(side: SideRelief, blob: Protrusion) -> bool:
    """Return whether a protrusion is a handle: a bar that is no stretch of the object's border, nor a flap near it."""
    return is_bar(blob) and is_surrounded(
        side, blob, HANDLE_MARGIN if blob.protrusion >= SURE_HANDLE_PROTRUSION else FLAT_MARGIN
    )


def is_surrounded(side: SideRelief, blob: Protrusion, away: float) -> bool:
    """Return whether a protrusion stands on a surface that goes on all around it, as far as `away`, diagonals."""
    (a, b), (c, d) = blob.rows, blob.columns
    near = max(1, round(away / side.image.pixel))
    ring = np.zeros((b - a + 2 * near, d - c + 2 * near), dtype=bool)
    height, width = side.depth.shape
    top, left = max(a - near, 0), max(c - near, 0)
    part = side.depth[top : min(b + near, height), left : min(d + near, width)] < BACKGROUND_DEPTH / 2
    ring[top - a + near : top - a + near + part.shape[0], left - c + near : left - c + near + part.shape[1]] = part
    return float(ring.mean()) >= MIN_SURROUNDED_SHARE


def _held(side: SideRelief, rectangle: FrontRectangle, drawn: bool = False) -> list[FrontRectangle]:
    """Split a rectangle without seams so that each part has one handle, and none shares a part with controls.

    Args:
        drawn: it is part of one that had pulls.
    """
    inside = _inside(side, rectangle)
    bars = [b for b in inside if is_bar(b)]
    others = [b for b in inside if not is_bar(b)]
    if bars and others:
        parts = _band(rectangle, bars, others)
        if parts:
            return [m for part in parts for m in _held(side, part)]
    if len(bars) >= 2:
        parts = _between(rectangle, bars, max(2, round(SAME_ROW / side.image.pixel)))
        if parts:
            return [m for part in parts for m in _held(side, part)]
    if not bars and len(inside) >= 2 and (drawn or _are_pulls(side, rectangle, inside)):
        parts = _apart(rectangle, inside, _sunk(side, rectangle))
        rectangles = [m for part in parts for m in _held(side, part, True)]
        if rectangles and (drawn or all(_is_drawn(side, m, rectangles) for m in rectangles)):
            return rectangles
    return [rectangle]


def _are_pulls(side: SideRelief, rectangle: FrontRectangle, inside: list[Protrusion]) -> bool:
    """Return whether small protrusions on a wide rectangle are pulls: far out, alike, and no row of controls."""
    pixel = side.image.pixel
    wide = (rectangle.columns[1] - rectangle.columns[0]) >= MIN_WIDTH_SHARE * side.depth.shape[1]
    if not wide or len(inside) > MAX_PULLS:
        return False
    size = np.array([b.upper - b.lower for b in inside])
    middle = np.array([b.middle for b in inside])
    alike = bool((np.abs(size - np.median(size, axis=0)) <= SIZE_TOLERANCE * np.median(size) + 2 * pixel).all())
    out = all(b.long < MIN_BAR_RATIO and MIN_BAR_PROTRUSION <= b.protrusion <= MAX_PROTRUSION for b in inside)
    row = max(int((np.abs(middle[:, 1] - v) < SAME_ROW / 2).sum()) for v in middle[:, 1])
    return alike and out and row < MIN_CONTROLS_IN_ROW


def _is_drawn(side: SideRelief, rectangle: FrontRectangle, rectangles: list[FrontRectangle]) -> bool:
    """Return whether a rectangle has its pull at one side, or in its middle and is framed, stacked or wide."""
    (pull,) = _inside(side, rectangle)[:1]
    place = (sum(pull.columns) / 2 - rectangle.columns[0]) / (rectangle.columns[1] - rectangle.columns[0])
    if min(place, 1 - place) <= MAX_SIDE_OFFSET:
        return True
    # None beside it: what lies above or below it lies within its columns.
    stacked = all(
        m is rectangle or m.rows[1] <= rectangle.rows[0] or m.rows[0] >= rectangle.rows[1] for m in rectangles
    )
    stacked |= any(m is not rectangle and m.columns == rectangle.columns for m in rectangles)
    return abs(place - 0.5) <= MAX_CENTRE_OFFSET and (stacked or bool(_sunk(side, rectangle)))


def _sunk(side: SideRelief, rectangle: FrontRectangle) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return rows and columns of rectangles that lie deeper than the frames around them; each belongs to one front."""
    window = slice(*rectangle.rows), slice(*rectangle.columns)
    depth, free = side.depth[window], side.blob[window] < 0
    if not free.any():
        return []
    frame = float(np.quantile(depth[free], FRAME_DEPTH_QUANTILE))
    number, _ = label((depth > frame + MIN_DEPTH_STEP) & (depth < frame + MAX_SUNK_DEPTH) | ~free)
    min_size = MIN_SUNK_SIDE / side.image.pixel
    out = []
    for i, (rows, columns) in enumerate(find_objects(number), start=1):
        mask = number[rows, columns] == i
        if min(mask.shape) >= min_size and float(mask.mean()) >= MIN_SUNK_FILL:
            top, left = rectangle.rows[0], rectangle.columns[0]
            out.append(((rows.start + top, rows.stop + top), (columns.start + left, columns.stop + left)))
    return out


def _apart(
    rectangle: FrontRectangle, pulls: list[Protrusion], sunk: list[tuple[tuple[int, int], tuple[int, int]]]
) -> list[FrontRectangle]:
    """Split a rectangle between its pulls, in the widest gap from end to end that meets no pull and nothing sunk."""
    best: tuple[int, int, int] | None = None
    for way in (0, 1):
        own = sorted((b.rows, b.columns)[way] for b in pulls)
        spans = sorted([*own, *(s[way] for s in sunk)])
        reach = spans[0][1]
        for lower, upper in spans[1:]:
            parted = any(b <= reach for _, b in own) and any(a >= lower for a, _ in own)
            if lower > reach and parted and (best is None or lower - reach > best[0]):
                best = (lower - reach, way, (lower + reach) // 2)
            reach = max(reach, upper)
    if best is None:
        return []
    return _at_row(rectangle, best[2]) if best[1] == 0 else _at_column(rectangle, best[2])


def _band(rectangle: FrontRectangle, bars: list[Protrusion], others: list[Protrusion]) -> list[FrontRectangle]:
    """Split off the strip along a side that holds the controls, which lie in the middle of their strip."""
    found: list[tuple[float, int, list[FrontRectangle]]] = []
    for order, (name, first, step) in enumerate(
        (("rows", 0, 1), ("rows", 1, -1), ("columns", 1, -1), ("columns", 0, 1))
    ):
        ends = getattr(rectangle, name)
        span = ends[1] - ends[0]
        near = [abs(getattr(b, name)[first] - ends[first]) for b in others]
        far = [abs(getattr(b, name)[1 - first] - ends[first]) for b in others]
        hand = min(abs(getattr(b, name)[first] - ends[first]) for b in bars)
        if max(far) >= hand or max(far) > 0.45 * span:
            continue
        at = ends[first] + step * min(max(far) + min(near), (max(far) + hand) // 2)
        halves = _at_row(rectangle, at) if name == "rows" else _at_column(rectangle, at)
        found.append((max(far) / span, order, halves))
    return min(found, key=lambda f: f[:2])[2] if found else []


def _between(rectangle: FrontRectangle, bars: list[Protrusion], row: int) -> list[FrontRectangle]:
    """Split a rectangle with several handles between the first and the others.

    Fronts with level handles have them all at one distance from their tops; one above doors is drawn by its middle.
    """
    by_row = _gap([b.rows for b in bars], row)
    by_column = _gap([b.columns for b in bars], row)
    over = [] if by_row is None else [b for b in bars if b.rows[1] <= by_row[0]]
    under = [] if by_row is None else [b for b in bars if b.rows[1] > by_row[0]]
    drawn = bool(over and under) and _lie(over) and not _lie(under)
    if by_row is not None and (drawn or _lie(bars) or by_column is None):
        top = min(b.rows[0] for b in bars) - rectangle.rows[0]
        at = sum(by_row) // 2
        if drawn:
            at = min(at, by_row[0] + top)
        elif _lie(bars) and top < 0.9 * (by_row[1] - by_row[0]):
            at = by_row[1] - top
        return _at_row(rectangle, at)
    return _at_column(rectangle, sum(by_column) // 2) if by_column is not None else []


def _lie(bars: list[Protrusion]) -> bool:
    """Return whether at least half of some bars are wider than high."""
    return 2 * sum(b.columns[1] - b.columns[0] > b.rows[1] - b.rows[0] for b in bars) >= len(bars)


def _gap(spans: list[tuple[int, int]], min_size: int) -> tuple[int, int] | None:
    """Return the first stretch between spans that none of them covers, where it is long enough."""
    ordered = sorted(spans)
    reach = ordered[0][1]
    for lower, upper in ordered[1:]:
        if lower - reach >= min_size // 2:
            return reach, lower
        reach = max(reach, upper)
    return None


def measure_rectangle(side: SideRelief, rectangle: FrontRectangle) -> FrontRectangle:
    """Return a rectangle with its median depth and its protrusions."""
    window = slice(*rectangle.rows), slice(*rectangle.columns)
    ground = side.depth[window][side.blob[window] < 0]
    inside = _inside(side, rectangle)
    numbers = tuple(i for i, b in enumerate(side.blobs) if any(b is o for o in inside))
    return replace(rectangle, plane=float(np.median(ground)) if len(ground) else BACKGROUND_DEPTH, blobs=numbers)


def rectangle_corners(side: SideRelief, rectangle: FrontRectangle) -> tuple[Floats, Floats]:
    """Return the (2,) lower and upper corner of a rectangle in (u, v)."""
    height = side.depth.shape[0]
    image = side.image
    lower = image.lower + image.pixel * np.array([rectangle.columns[0], height - rectangle.rows[1]])
    upper = image.lower + image.pixel * np.array([rectangle.columns[1], height - rectangle.rows[0]])
    return lower, upper
