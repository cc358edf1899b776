"""Read the relief of a side: evidence of seams around fronts, the rectangles that they bound, bulging ones too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy.ndimage import find_objects, label, maximum_filter1d, uniform_filter1d

from casa_assets.articulate.fronts.pull_partition import Item, part_between_pulls
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import (
    BACKGROUND_DEPTH,
    MIN_DEPTH_STEP,
    SIDES,
    Protrusion,
    SideRelief,
    dilate,
    edge_lines,
)
from casa_assets.core.numeric import Floats, Ints, Mask

# A seam of a closed shell may be shallower than a cell of the grid that the shell was made on. It is long and
# straight, so its mean over the whole line is distinct even if no single pixel of it is.
# Pixels on each side of a line over which its depth and its normals are averaged, and those left out next to it.
BAND, GAP = 5, 3
# Noise below which a line is compared with these instead: depth, diagonals, and the sine of a bend.
MIN_GROOVE_NOISE, MIN_BEND_NOISE = 0.00015, 0.01
# A signal of this many times the noise speaks as loud as can be.
LOUD = 6.0
# Depth beyond which what lies behind a line is not the same side of the object, diagonals.
OUTLINE_STEP = 0.02
# Greatest difference of depth that is told apart, diagonals.
MAX_STEP = 0.05
# Lengths over which the loudest stretch of a line is looked for, shares of the longer side of the picture.
STRETCHES = (0.1, 0.25, 0.6)
# Lines nearer to each other than this are one, diagonals.
SAME_LINE = 0.006
# Lines that are quieter than this are not looked at, and how many are at most, in each direction.
MIN_LOUDNESS, MAX_LINES = 0.35, 24
_T = TypeVar("_T", bound=np.generic)
# What is known of a line between two others, the last axis of `LineTable.values`.
LINE_MEASURES = ("edge", "groove", "bend", "outline_before", "outline_after", "step", "visible")
# (7, H + 1, W) by LINE_MEASURES, of the border above each row of a picture; zero where nothing is visible.
SeamMaps = npt.NDArray[np.float32]
# Narrowest rectangle, diagonals.
MIN_SIDE = 0.012
# How far a line may deviate from straight, diagonals.
LINE_TOLERANCE = 0.0022
# A line is divided into stretches; each, and the whole line, has to be visible to these shares.
LINE_STRETCHES, MIN_STRETCH_VISIBILITY, MIN_LINE_VISIBILITY = 12, 0.5, 0.75
# A line is visible to so much more than edges elsewhere in its rectangle: rough surfaces have edges everywhere.
MIN_LINE_CONTRAST = 0.45
# A stretch counts if this share of it is not hidden by protrusions; this many stretches have to count.
MIN_FREE_SHARE, MIN_USABLE_STRETCHES = 0.3, 5
# Length to width and least protrusion of a handle, diagonals. Ref: as MIN_HANDLE_PROTRUSION in opening_panels.py.
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
# Most pulls, width of their rectangle by the side, tolerance of their sizes, and how many in a row are controls.
MAX_PULLS, MIN_WIDTH_SHARE, SIZE_TOLERANCE, MIN_CONTROLS_IN_ROW = 10, 0.45, 0.3, 3
# The frame around a recess is this quantile of depth; least size and greatest depth of a recess, diagonals, and the
# share of its rectangle that it fills.
FRAME_DEPTH_QUANTILE, MIN_SUNK_SIDE, MAX_SUNK_DEPTH, MIN_SUNK_FILL = 0.15, 0.04, 0.05, 0.85
Window = tuple[tuple[int, int], tuple[int, int]]  # half-open ranges of rows and of columns
# Highest stair, and deepest groove between two stairs that is no gap between fronts; diagonals.
MAX_STAIR_HEIGHT, MAX_GROOVE_DEPTH = 0.0095, 0.002
# Distance from a border at which its two sides are sampled.
BESIDE_PIXELS = 4
# Strips are as long as the front within this share of its length, and cover this share of it.
LENGTH_TOLERANCE, MIN_STRIP_FILL = 0.035, 0.9
# Fewest stairs of a bulge on both sides together: a framed panel has one on each side.
MIN_STAIRS = 3


@dataclass(frozen=True)
class LineTable:
    """Evidence for each line of one direction, between every two lines of the other.

    Attributes:
        at: (N,) ascending pixel borders of the lines. values: (N, M, M, 7) of LINE_MEASURES, means over the stretch
            between two of the M lines across; the third index must be greater than the second.
    """

    at: Ints
    values: Floats


def seam_maps(mesh: WeldedMesh, relief: SideRelief, side: int, upright: bool) -> SeamMaps:
    """Measure the evidence for level lines, or for upright ones in the transposed picture."""
    image = relief.image
    seen = relief.depth < BACKGROUND_DEPTH / 2
    free = seen & ~dilate(relief.blob >= 0, 2)
    tilt = mesh.normals[np.maximum(image.face, 0)] @ (SIDES[side][0] if upright else -SIDES[side][1])
    edges = relief.across if upright else relief.along
    depth = relief.base
    if upright:
        seen, free, tilt, edges, depth = seen.T, free.T, tilt.T, edges.T, depth.T
    return _maps(depth, tilt, edges, seen, free)


def _maps(depth: Floats, tilt: Floats, edges: Mask, seen: Mask, free: Mask) -> SeamMaps:
    """Return the maps of a picture; `tilt` is the component of the normals down the picture."""
    height = depth.shape[0]
    pad = BAND + GAP + 1
    far = np.pad(np.where(seen, depth, BACKGROUND_DEPTH), ((pad, pad), (0, 0)), constant_values=BACKGROUND_DEPTH)
    is_free = np.pad(free, ((pad, pad), (0, 0)))
    is_seen = np.pad(seen, ((pad, pad), (0, 0)))
    normal = np.pad(np.where(free, tilt, 0.0), ((pad, pad), (0, 0)))

    def rows(values: npt.NDArray[_T], first: int) -> npt.NDArray[_T]:
        """Return (H + 1, W): for each border the row that is `first` below it (-1 is the one above)."""
        return values[pad + first : pad + first + height + 1]

    above, below = -GAP - BAND // 2, GAP + BAND // 2 - 1
    a, b = rows(far, above), rows(far, below)
    middle = np.maximum(rows(far, -1), rows(far, 0))
    speaks = rows(is_free, above) & rows(is_free, below) & rows(is_free, -1) & rows(is_free, 0)
    groove = np.where(speaks, middle - np.maximum(a, b), 0.0)
    sums = np.cumsum(np.pad(normal, ((1, 0), (0, 0))), axis=0)
    mean_above = (sums[pad : pad + height + 1] - sums[pad - BAND : pad - BAND + height + 1]) / BAND
    mean_below = (sums[pad + BAND : pad + BAND + height + 1] - sums[pad : pad + height + 1]) / BAND
    # Down the picture, the normals of a groove turn from downwards to upwards.
    bend = np.where(speaks, mean_above - mean_below, 0.0)
    first, last = rows(is_seen, above), rows(is_seen, below)
    before = last & ~(first & (a < b + OUTLINE_STEP))
    after = first & ~(last & (b < a + OUTLINE_STEP))
    step = np.where(speaks, np.clip(a - b, -MAX_STEP, MAX_STEP) / MAX_STEP, 0.0)
    step = np.where(before, 1.0, np.where(after, -1.0, step))
    visible = speaks | before | after
    quiet = speaks & (np.abs(groove) < OUTLINE_STEP)
    layers = [
        np.pad(edges, ((1, 0), (0, 0))) & visible,
        np.where(speaks, np.clip(groove / _loud(groove[quiet], MIN_GROOVE_NOISE), -1.0, 1.0), 0.0),
        np.where(speaks, np.clip(bend / _loud(bend[quiet], MIN_BEND_NOISE), -1.0, 1.0), 0.0),
        before,
        after,
        step,
        visible,
    ]
    return np.stack([m.astype(np.float32) for m in layers])


def _loud(values: Floats, least: float) -> float:
    """Return the signal that counts in full, by the noise of a sample of it."""
    noise = float(np.median(np.abs(values - np.median(values)))) if len(values) else 0.0
    return LOUD * max(noise * 1.5, least)


def find_lines(maps: SeamMaps, pixel: float, more: list[int]) -> Ints:
    """Return the pixel borders of lines that any stretch speaks for, and of those that are given, ascending."""
    edge, groove, bend, before, after = maps[:5]
    loud = np.maximum.reduce([edge, groove, bend, before, after])
    longest = max(loud.shape)
    heard = maximum_filter1d(loud, 3, axis=0)
    score = np.zeros(len(loud))
    for share in STRETCHES:
        size = max(8, round(share * longest))
        if size <= loud.shape[1]:
            score = np.maximum(score, uniform_filter1d(heard, size, axis=1, mode="constant").max(axis=1) * share**0.25)
    near = max(2, round(SAME_LINE / pixel))
    kept = sorted(set(more))
    for at in np.argsort(-score, kind="stable").tolist():
        if score[at] >= MIN_LOUDNESS and len(kept) < MAX_LINES and all(abs(at - k) > near for k in kept):
            kept.append(int(at))
    return np.array(sorted(kept), dtype=np.int64)


def line_table(maps: SeamMaps, at: Ints, across: Ints, pixel: float) -> LineTable:
    """Measure each line between every two lines across it; a line may lie slightly off its place.

    Args:
        at: (N,) borders of the lines. across: (M,) borders of those across.
    """
    waver = max(1, round(SAME_LINE / pixel / 3))
    height = maps.shape[1]
    best: Floats | None = None
    for shift in range(-waver, waver + 1):
        rows = np.clip(at + shift, 0, height - 1)
        sums = np.cumsum(np.pad(maps[:, rows].astype(np.float64), ((0, 0), (0, 0), (1, 0))), axis=2)[:, :, across]
        total = sums[:, :, None, :] - sums[:, :, :, None]
        visible = np.maximum(total[6], 1.0)
        length = np.maximum((across[None, :] - across[:, None]).astype(np.float64), 1.0)
        means = np.moveaxis(np.concatenate([total[:6] / visible, total[6:] / length]), 0, -1)
        if best is None:
            best = means
        else:
            best[..., :5] = np.maximum(best[..., :5], means[..., :5])
            louder = np.abs(means[..., 5]) > np.abs(best[..., 5])
            best[..., 5] = np.where(louder, means[..., 5], best[..., 5])
            best[..., 6] = np.maximum(best[..., 6], means[..., 6])
    assert best is not None
    return LineTable(at, best)


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
    parted = _parted(whole, lines, max(4, round(MIN_SIDE / side.image.pixel)))
    found = [measure_rectangle(side, m) for rectangle in parted for m in _held(side, rectangle)]
    return sorted(found, key=lambda m: (m.rows, m.columns))


def _parted(
    rectangle: FrontRectangle, lines: tuple[tuple[Mask, Mask], tuple[Mask, Mask]], min_size: int
) -> list[FrontRectangle]:
    """Split a rectangle along its best line, and the halves likewise, until no line is left."""
    level = _best(lines[0], rectangle.rows, rectangle.columns, min_size)
    upright = _best(lines[1], rectangle.columns, rectangle.rows, min_size)
    if max(level[0], upright[0]) < MIN_LINE_VISIBILITY:
        return [rectangle]
    is_level = level[0] >= upright[0]
    halves = _split_at(rectangle, *("rows", level[1]) if is_level else ("columns", upright[1]))
    return [m for half in halves for m in _parted(half, lines, min_size)]


def _best(line: tuple[Mask, Mask], across: tuple[int, int], along: tuple[int, int], min_size: int) -> tuple[float, int]:
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


def _split_at(rectangle: FrontRectangle, axis: str, at: int) -> list[FrontRectangle]:
    """Split a rectangle at a row or a column; `axis` is the name of its field."""
    (a, b), (c, d) = rectangle.rows, rectangle.columns
    if axis == "rows":
        return [replace(rectangle, rows=(a, at)), replace(rectangle, rows=(at, b))]
    return [replace(rectangle, columns=(c, at)), replace(rectangle, columns=(at, d))]


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
    inside = [b for b in side.blobs if _lies_in(b, (rectangle.rows, rectangle.columns))]
    pulls = _pulls(side, rectangle, inside)
    others = [b for b in inside if not any(b is p for p in pulls)]
    if others and any(is_bar(b) for b in pulls):
        parts = _band(rectangle, pulls, others)
        if parts:
            return [m for part in parts for m in _held(side, part)]
    if len(pulls) < 2:
        return [rectangle]
    recesses, rooms = _recesses(side, rectangle)
    sunk = [s for s in recesses if sum(_lies_in(b, s) for b in pulls) == 1]
    items = []
    for pull in pulls:
        # No cut may cross the sunk panel that it is on.
        reach = next((s for s in sunk if _lies_in(pull, s)), (pull.rows, pull.columns))
        items.append(Item(pull.rows, pull.columns, *reach))
    items += [Item(*span, *span, is_room=True) for span in rooms]
    cells = part_between_pulls(rectangle.rows, rectangle.columns, items)
    return [replace(rectangle, rows=c.rows, columns=c.columns, fit=math.exp(-c.cost)) for c in cells] or [rectangle]


def _lies_in(blob: Protrusion, window: Window) -> bool:
    """Return whether the middle of a protrusion is in a range of rows and columns."""
    return all(a <= sum(span) / 2 < b for span, (a, b) in zip((blob.rows, blob.columns), window, strict=True))


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


def _recesses(side: SideRelief, rectangle: FrontRectangle) -> tuple[list[Window], list[Window]]:
    """Return what lies deeper than the frame around it, each of one front, and open rooms, far deeper or not there."""
    window = slice(*rectangle.rows), slice(*rectangle.columns)
    depth, free = side.depth[window], side.blob[window] < 0
    if not free.any():
        return [], []
    frame = float(np.quantile(depth[free], FRAME_DEPTH_QUANTILE))
    sunk = (depth > frame + MIN_DEPTH_STEP) & (depth < frame + MAX_SUNK_DEPTH) | ~free
    is_room = (depth > frame + MAX_SUNK_DEPTH) & free
    return _filled(side, rectangle, sunk), _filled(side, rectangle, is_room)


def _filled(side: SideRelief, rectangle: FrontRectangle, deep: Mask) -> list[Window]:
    """Return the large connected regions of a mask of the pixels of a rectangle that fill their own rectangles."""
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
        found.append((max(far) / span, order, _split_at(rectangle, name, at)))
    return min(found, key=lambda f: f[:2])[2] if found else []


def measure_rectangle(side: SideRelief, rectangle: FrontRectangle) -> FrontRectangle:
    """Return a rectangle with its median depth and its protrusions."""
    span = rectangle.rows, rectangle.columns
    numbers = tuple(i for i, b in enumerate(side.blobs) if _lies_in(b, span))
    return replace(rectangle, plane=_plane(side, span, BACKGROUND_DEPTH), blobs=numbers)


def _plane(side: SideRelief, span: Window, none: float) -> float:
    """Return the median depth of the ground in a range of rows and columns; `none` if all of it is hidden."""
    window = slice(*span[0]), slice(*span[1])
    ground = side.depth[window][side.blob[window] < 0]
    return float(np.median(ground)) if len(ground) else none


def rectangle_corners(side: SideRelief, rectangle: FrontRectangle) -> tuple[Floats, Floats]:
    """Return the (2,) lower and upper corner of a rectangle in (u, v)."""
    height = side.depth.shape[0]
    image = side.image
    lower = image.lower + image.pixel * np.array([rectangle.columns[0], height - rectangle.rows[1]])
    upper = image.lower + image.pixel * np.array([rectangle.columns[1], height - rectangle.rows[0]])
    return lower, upper


def merge_stairs(side: SideRelief, rectangles: list[FrontRectangle]) -> list[FrontRectangle]:
    """Merge rectangles of `find_front_rectangles` that lie next to each other like the stairs of a bulging front."""
    left = list(rectangles)
    for core in sorted(rectangles, key=lambda m: (round(m.plane, 6), m.rows, m.columns)):
        if not any(m is core for m in left):
            continue
        before, after = _stairs(side, left, core, 0), _stairs(side, left, core, 1)
        if before and after and len(before) + len(after) >= MIN_STAIRS:
            strips = [core, *(m for stair in (*before, *after) for m in stair)]
            left = [m for m in left if not any(m is s for s in strips)]
            columns = min(m.columns[0] for m in strips), max(m.columns[1] for m in strips)
            plane, blobs = _plane(side, (core.rows, columns), core.plane), {b for m in strips for b in m.blobs}
            left.append(replace(core, columns=columns, plane=plane, blobs=tuple(sorted(blobs))))
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
