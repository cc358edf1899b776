"""Split the relief of a front into rectangles along gaps and steps, then between handles and controls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import find_objects, label

from casa_assets.articulate.fronts.pull_partition import Item, part_between_pulls
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
# A handle that is too short for a bar is at least so much longer than thick, beside bars as thick as it is.
MIN_STUB_RATIO = 1.6
# Most pulls, width of their rectangle as a share of the side, tolerance of their sizes, and how many in a row are
# controls instead.
MAX_PULLS, MIN_WIDTH_SHARE, SIZE_TOLERANCE, MIN_CONTROLS_IN_ROW = 10, 0.45, 0.3, 3
# The frame around a recess is this quantile of depth; least size and greatest depth of a recess, diagonals, and the
# share of its rectangle that it fills.
FRAME_DEPTH_QUANTILE, MIN_SUNK_SIDE, MAX_SUNK_DEPTH, MIN_SUNK_FILL = 0.15, 0.04, 0.05, 0.85


@dataclass(frozen=True)
class FrontRectangle:
    """A rectangle of the front, as half-open pixel ranges.

    Attributes:
        plane: median depth of its ground. blobs: numbers of the things whose middle lies in it.
        fit: how well its pull is placed on it, 0 to 1, where it was parted from others by their pulls; else 0.
    """

    rows: tuple[int, int]
    columns: tuple[int, int]
    plane: float = 0.0
    blobs: tuple[int, ...] = ()
    fit: float = 0.0


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
    return [b for b in side.blobs if _lies_in(b, (rectangle.rows, rectangle.columns))]


def is_bar(blob: Protrusion) -> bool:
    """Return whether a protrusion has the shape of a handle."""
    return blob.long >= MIN_BAR_RATIO and MIN_BAR_PROTRUSION <= blob.protrusion <= MAX_PROTRUSION


def is_handle(side: SideRelief, blob: Protrusion) -> bool:
    """Return whether a protrusion is a handle: a bar that is no stretch of the object's border, nor a flap near it."""
    return is_bar(blob) and is_surrounded(
        side, blob, HANDLE_MARGIN if blob.protrusion >= SURE_HANDLE_PROTRUSION else FLAT_MARGIN
    )


def is_surrounded(side: SideRelief, blob: Protrusion, away: float) -> bool:
    """Return whether the surface under a protrusion continues on all sides of it, as far as `away`, diagonals."""
    (a, b), (c, d) = blob.rows, blob.columns
    near = max(1, round(away / side.image.pixel))
    ring = np.zeros((b - a + 2 * near, d - c + 2 * near), dtype=bool)
    height, width = side.depth.shape
    top, left = max(a - near, 0), max(c - near, 0)
    part = side.depth[top : min(b + near, height), left : min(d + near, width)] < BACKGROUND_DEPTH / 2
    ring[top - a + near : top - a + near + part.shape[0], left - c + near : left - c + near + part.shape[1]] = part
    return float(ring.mean()) >= MIN_SURROUNDED_SHARE


def _held(side: SideRelief, rectangle: FrontRectangle) -> list[FrontRectangle]:
    """Split a rectangle without seams so that each part has one handle, and none shares a part with controls."""
    inside = _inside(side, rectangle)
    pulls = _pulls(side, rectangle, inside)
    others = [b for b in inside if not any(b is p for p in pulls)]
    if others and any(is_bar(b) for b in pulls):
        parts = _band(rectangle, pulls, others)
        if parts:
            return [m for part in parts for m in _held(side, part)]
    if len(pulls) < 2:
        return [rectangle]
    sunk = [s for s in _sunk(side, rectangle) if sum(_lies_in(b, s) for b in pulls) == 1]
    items = [_item(b, sunk) for b in pulls] + _rooms(side, rectangle)
    cells = part_between_pulls(rectangle.rows, rectangle.columns, items)
    return [replace(rectangle, rows=c.rows, columns=c.columns, fit=math.exp(-c.cost)) for c in cells] or [rectangle]


def _item(pull: Protrusion, sunk: Sequence[tuple[tuple[int, int], tuple[int, int]]]) -> Item:
    """Return a pull with what no cut may cross: the sunk panel that it is on."""
    reach = next((s for s in sunk if _lies_in(pull, s)), (pull.rows, pull.columns))
    return Item(pull.rows, pull.columns, *reach)


def _lies_in(blob: Protrusion, window: tuple[tuple[int, int], tuple[int, int]]) -> bool:
    """Return whether the middle of a protrusion is in a range of rows and columns."""
    return all(a <= sum(span) / 2 < b for span, (a, b) in zip((blob.rows, blob.columns), window, strict=True))


def _rooms(side: SideRelief, rectangle: FrontRectangle) -> list[Item]:
    """Return the open rooms of a rectangle: what lies so deep behind it, or is not there at all, over a rectangle."""
    window = slice(*rectangle.rows), slice(*rectangle.columns)
    depth, free = side.depth[window], side.blob[window] < 0
    if not free.any():
        return []
    plane = float(np.quantile(depth[free], FRAME_DEPTH_QUANTILE))
    spans = _filled(side, rectangle, (depth > plane + MAX_SUNK_DEPTH) & free)
    return [Item(*span, *span, is_room=True) for span in spans]


def _pulls(side: SideRelief, rectangle: FrontRectangle, inside: Sequence[Protrusion]) -> list[Protrusion]:
    """Return the handles among the protrusions of a rectangle: bars, and what is as thick and as far out as a bar."""
    bars = [b for b in inside if is_bar(b)]
    if not bars:
        return list(inside) if len(inside) >= 2 and _are_pulls(side, rectangle, inside) else []
    slack = 2 * side.image.pixel

    def is_alike(blob: Protrusion, bar: Protrusion) -> bool:
        thick = float((bar.upper - bar.lower).min())
        away = abs(float((blob.upper - blob.lower).min()) - thick)
        out = abs(blob.protrusion - bar.protrusion) <= SIZE_TOLERANCE * bar.protrusion
        return out and away <= SIZE_TOLERANCE * thick + slack and blob.long >= MIN_STUB_RATIO

    return [b for b in inside if is_bar(b) or any(is_alike(b, bar) for bar in bars)]


def _are_pulls(side: SideRelief, rectangle: FrontRectangle, inside: Sequence[Protrusion]) -> bool:
    """Return whether small protrusions on a wide rectangle are pulls: far out, alike, and no row of controls."""
    pixel = side.image.pixel
    wide = (rectangle.columns[1] - rectangle.columns[0]) >= MIN_WIDTH_SHARE * side.depth.shape[1]
    if not wide or len(inside) > MAX_PULLS:
        return False
    size = np.sort([b.upper - b.lower for b in inside], axis=1)
    middle = np.array([b.middle for b in inside])
    alike = bool((np.abs(size - np.median(size, axis=0)) <= SIZE_TOLERANCE * np.median(size) + 2 * pixel).all())
    out = all(b.long < MIN_BAR_RATIO and MIN_BAR_PROTRUSION <= b.protrusion <= MAX_PROTRUSION for b in inside)
    row = max(int((np.abs(middle[:, 1] - v) < SAME_ROW / 2).sum()) for v in middle[:, 1])
    return alike and out and row < MIN_CONTROLS_IN_ROW


def _sunk(side: SideRelief, rectangle: FrontRectangle) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return rows and columns of rectangles that lie deeper than the frames around them; each belongs to one front."""
    window = slice(*rectangle.rows), slice(*rectangle.columns)
    depth, free = side.depth[window], side.blob[window] < 0
    if not free.any():
        return []
    frame = float(np.quantile(depth[free], FRAME_DEPTH_QUANTILE))
    return _filled(side, rectangle, (depth > frame + MIN_DEPTH_STEP) & (depth < frame + MAX_SUNK_DEPTH) | ~free)


def _filled(side: SideRelief, rectangle: FrontRectangle, deep: Bools) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return rows and columns of the large connected regions that fill their rectangles.

    Args:
        deep: mask of the pixels of `rectangle`.
    """
    number, _ = label(deep)
    min_size = MIN_SUNK_SIDE / side.image.pixel
    out = []
    for i, (rows, columns) in enumerate(find_objects(number), start=1):
        mask = number[rows, columns] == i
        if min(mask.shape) >= min_size and float(mask.mean()) >= MIN_SUNK_FILL:
            top, left = rectangle.rows[0], rectangle.columns[0]
            out.append(((rows.start + top, rows.stop + top), (columns.start + left, columns.stop + left)))
    return out


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
