"""Lay pieces in patterns (bonds of bricks, tiles, planks and stones) that repeat without a seam."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from itertools import product

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures.canvas import Canvas, blur
from casa_assets.textures.pieces import Array, Outline, PieceMap, PlacedOutline, box, disc, polygon, raster, whole

# Shapes and bonds.
LayingPattern = StrEnum(
    "LayingPattern",
    "RUNNING PLANKS BASKET HERRINGBONE CHEVRON ASHLAR PANEL HEXAGON PENNY PICKET DIAMOND SCALE LANTERN OCTAGON STAR "
    "CUBE FIELDSTONE LEDGE",
)


class Laying(Record):
    """A pattern and its sizes. The picture has to hold whole repeats: another size is an error, not a stretch."""

    pattern: LayingPattern = Field(description="shape and bond")
    width_m: float = Field(gt=0.005, le=2, description="of a piece across its length, joint included")
    length_m: float = Field(0.1, gt=0.005, le=3, description="of a piece along its length, joint included")
    bond: float = Field(0.0, ge=0, lt=1, description="running bond: shift of each row by a length; 0: stacked")
    upright: bool = Field(False, description="the length of pieces is vertical (running bond, planks)")
    diagonal: bool = Field(False, description="the whole pattern is turned by 45 degrees (herringbone)")
    width_count: int = Field(1, ge=1, le=8, description="planks: number of widths that are mixed")
    ends_m: float = Field(0.0, ge=0, le=0.03, description="planks: by how much joints at ends are narrower")


def lay(laying: Laying, canvas: Canvas, rng: np.random.Generator) -> PieceMap:
    """The piece of every pixel and its position on it. Raises ValueError: no whole number of repeats fits."""
    width, length = laying.width_m, laying.length_m
    if laying.pattern is LayingPattern.FIELDSTONE:
        return fieldstone(canvas, length, width, rng)
    if laying.pattern is LayingPattern.LEDGE:
        return ledges(canvas, width, length, rng)
    return raster(_PLACES[laying.pattern](canvas.tile_m, laying, rng), canvas)


Size = tuple[float, float]
_LEVEL = np.pi / 2  # a piece whose length runs along x


def running(tile_m: Size, width: float, length: float, bond: float, upright: bool) -> list[PlacedOutline]:
    """Rows of bricks; every row is moved along by `bond` of a length. `upright` rows are columns."""
    along, across = (tile_m[1], tile_m[0]) if upright else tile_m
    columns, true_length = whole(along, length)
    rows, true_width = whole(across, width)
    if bond > 0 and abs(rows * bond - round(rows * bond)) > 1e-3:
        raise ValueError(f"{rows} rows moved by {bond:g} of a length do not close over the border")
    shape = box(true_width / 2, true_length / 2)
    found = []
    for row, column in product(range(rows), range(columns)):
        a, b = (column + 0.5 + bond * row) * true_length % along, (row + 0.5) * true_width
        x, y = (b, a) if upright else (a, b)
        turn = 0.0 if upright else _LEVEL
        found.append(PlacedOutline(x, y, turn, true_width / 2, true_length / 2, shape, (row + column) % 2))
    return found


def planks(
    tile_m: Size, width: float, length: float, widths: int, upright: bool, ends_m: float, rng: np.random.Generator
) -> list[PlacedOutline]:
    """Boards end to end in courses, their ends staggered at random.

    `widths`: mixed, 0.7 to 1.3 of `width`. `upright`: along v. `ends_m`: how far ends of boards reach into joints.
    """
    along, across = (tile_m[1], tile_m[0]) if upright else tile_m
    courses = max(2, round(across / width))
    sizes = rng.permutation(np.resize(np.linspace(0.7, 1.3, widths), courses)) if widths > 1 else np.ones(courses)
    edges = np.concatenate([[0.0], np.cumsum(sizes / sizes.sum())]) * across
    # One board to a course would make the picture repeat as an endless stripe.
    count = max(2, round(along / length))
    found, last = [], 0.0
    for course in range(courses):
        # Ends of neighbours keep apart: each course starts a good way off the one before.
        last = (last + rng.uniform(0.3, 0.7) / count) % 1.0
        parts = rng.uniform(0.75, 1.25, count)
        ends = (last + np.concatenate([[0.0], np.cumsum(parts / parts.sum())])) * along
        for n in range(count):
            half_v, half_u = (ends[n + 1] - ends[n]) / 2, (edges[course + 1] - edges[course]) / 2
            a, b = (ends[n] + half_v) % along, edges[course] + half_u
            x, y = (b, a) if upright else (a, b)
            turn = 0.0 if upright else _LEVEL
            found.append(PlacedOutline(x, y, turn, half_u, half_v, box(half_u, half_v + ends_m / 2), course % 2))
    return found


def basket(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Squares of parallel pieces, level and upright in turn."""
    columns, side_x = whole(tile_m[0], length, even=True)
    rows, side_y = whole(tile_m[1], length, even=True)
    fingers = max(1, round(length / width))
    found = []
    for row, column, n in product(range(rows), range(columns), range(fingers)):
        upright = (row + column) % 2 == 0
        off = (n + 0.5) / fingers
        x = (column + (off if upright else 0.5)) * side_x
        y = (row + (0.5 if upright else off)) * side_y
        half_u, half_v = (side_x if upright else side_y) / fingers / 2, (side_y if upright else side_x) / 2
        turn = 0.0 if upright else _LEVEL
        found.append(PlacedOutline(x, y, turn, half_u, half_v, box(half_u, half_v), int(upright)))
    return found


def herringbone(tile_m: Size, width: float, length: float, slant: bool) -> list[PlacedOutline]:
    """Pieces of `length` = n `width` at right angles; `slant` turns the whole by 45 degrees.

    The picture holds multiples of 2 n width each way; with `slant` n sqrt(2) width across, sqrt(2) width down.
    """
    n = max(2, round(length / width))
    half_u, half_v = width / 2, n * width / 2
    shape = box(half_u, half_v)
    # Middles of a level and an upright piece that touch, in widths.
    pair = (((n / 2, 0.5), _LEVEL, 0), ((n + 0.5, 1 - n / 2), 0.0, 1))
    if slant:
        root = np.sqrt(2.0)
        columns, wide = whole(tile_m[0], n * root * width)
        rows, tall = whole(tile_m[1], root * width)
        spots = [(c * wide, r * tall) for r in range(rows) for c in range(columns)]
    else:
        columns, wide = whole(tile_m[0], 2 * n * width)
        rows, tall = whole(tile_m[1], 2 * n * width)
        wide, tall = wide / (2 * n), tall / (2 * n)
        spots = [((j + 2 * n * c) * wide, j * tall) for j in range(2 * n * rows) for c in range(columns)]
    turn = np.pi / 4 if slant else 0.0
    cos, sin = np.cos(turn), np.sin(turn)
    found = []
    for x, y in spots:
        for (a, b), angle, sort in pair:
            px, py = x + (cos * a - sin * b) * width, y + (sin * a + cos * b) * width
            found.append(PlacedOutline(px % tile_m[0], py % tile_m[1], angle + turn, half_u, half_v, shape, sort))
    return found


def chevron(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Pieces cut at 45 degrees that meet in straight upright seams."""
    columns, wide = whole(tile_m[0], length / np.sqrt(2.0), even=True)
    rows, tall = whole(tile_m[1], width * np.sqrt(2.0))
    found = []
    for column in range(columns):
        rise = 1.0 if column % 2 == 0 else -1.0
        flat = [(s * wide / 2, s * rise * wide / 2 + t * tall / 2) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        angle = _LEVEL + rise * np.pi / 4
        cos, sin = np.cos(angle), np.sin(angle)
        corners = [(cos * x + sin * y, cos * y - sin * x) for x, y in flat]
        half = np.abs(np.array(corners)).max(axis=0)
        shape = polygon(corners)
        for row in range(rows):
            x, y = (column + 0.5) * wide, (row + 0.5) * tall
            found.append(PlacedOutline(x, y, angle, float(half[0]), float(half[1]), shape, column % 2))
    return found


def ashlar(tile_m: Size, unit: float, rng: np.random.Generator) -> list[PlacedOutline]:
    """Rectangles of one to three units each way that fill the picture without order."""
    columns, wide = whole(tile_m[0], unit)
    rows, tall = whole(tile_m[1], unit)
    taken: npt.NDArray[np.bool_] = np.zeros((rows, columns), dtype=bool)
    choices = ((3, 2), (2, 3), (2, 2), (2, 1), (1, 2), (1, 1))
    odds = np.array([0.26, 0.2, 0.26, 0.12, 0.1, 0.06])
    found = []
    for row, column in product(range(rows), range(columns)):
        if taken[row, column]:
            continue
        for pick in rng.choice(len(choices), len(choices), replace=False, p=odds):
            across, down = choices[int(pick)]
            at = np.ix_(np.arange(row, row + down) % rows, np.arange(column, column + across) % columns)
            if not taken[at].any():
                break
        else:
            across, down, at = 1, 1, np.ix_([row], [column])
        taken[at] = True
        half_x, half_y = across * wide / 2, down * tall / 2
        level = across >= down
        half_u, half_v = (half_y, half_x) if level else (half_x, half_y)
        x, y = (column * wide + half_x) % tile_m[0], (row * tall + half_y) % tile_m[1]
        turn = _LEVEL if level else 0.0
        found.append(PlacedOutline(x, y, turn, half_u, half_v, box(half_u, half_v), across * down))
    return found


def panel(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Square parquet panels, `length` a side: a mitred frame, and in it a basket weave on the slant."""
    columns, side = whole(tile_m[0], length)
    rows, _ = whole(tile_m[1], length)
    inner = side / 2 - width
    block = 2.0 * inner / np.sqrt(2.0) / 3.0  # three blocks fit along each half diagonal
    found = []
    for row, column in product(range(rows), range(columns)):
        x, y = (column + 0.5) * side, (row + 0.5) * side
        found += [_frame(x, y, k, side / 2, width) for k in range(4)]
        found += _weave(x, y, inner, block)
    return found


def _frame(x: float, y: float, quarter: int, half: float, width: float) -> PlacedOutline:
    """One strip of a mitred frame."""
    corners = [(-width / 2, -half), (width / 2, -half + width), (width / 2, half - width), (-width / 2, half)]
    turn, reach = quarter * np.pi / 2, half - width / 2
    # Its outer edge is at u = -width/2, away from the middle of the panel.
    x, y = x - np.cos(turn) * reach, y - np.sin(turn) * reach
    return PlacedOutline(x, y, turn, width / 2, half, polygon(corners), 2 + quarter % 2)


def _weave(x: float, y: float, inner: float, block: float) -> list[PlacedOutline]:
    """Slanting blocks of three strips each, cut off by the frame."""
    found = []
    turn = np.pi / 4
    cos, sin = np.cos(turn), np.sin(turn)
    for i, j, n in product(range(-3, 4), range(-3, 4), (-1, 0, 1)):
        upright = (i + j) % 2 == 0
        a, b = (i + n / 3, float(j)) if upright else (float(i), j + n / 3)
        dx, dy = (cos * a - sin * b) * block, (sin * a + cos * b) * block
        if max(abs(dx), abs(dy)) <= inner + block:
            angle = turn + (0.0 if upright else np.pi / 2)
            shape = _clipped(box(block / 6, block / 2), dx, dy, angle, inner)
            found.append(PlacedOutline(x + dx, y + dy, angle, block / 6, block / 2, shape, int(upright)))
    return found


def _clipped(outline: Outline, dx: float, dy: float, angle: float, inner: float) -> Outline:
    """The part of an outline inside a square around the middle of the panel, (dx, dy) away."""
    cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))

    def inside(u: Array, v: Array) -> Array:
        px, py = np.float32(dx) + cos * u - sin * v, np.float32(dy) + sin * u + cos * v
        fence = np.float32(inner) - np.maximum(np.abs(px), np.abs(py))
        return np.asarray(np.minimum(outline(u, v), fence))

    return inside


_ROOT3 = float(np.sqrt(3.0))


def hexagons(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Regular hexagons with a corner up, `width` from flat to flat. Rows are width * sqrt(3) / 2 apart."""
    radius = width / _ROOT3
    half = [(-width / 2, -radius / 2), (0.0, -radius), (width / 2, -radius / 2)]
    return _honeycomb(tile_m, width, polygon(half + [(-u, -v) for u, v in half]), width * _ROOT3 / 2, radius)


def pennies(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Discs as close as they lie, `width` from middle to middle."""
    return _honeycomb(tile_m, width, disc(width * 0.475), width * _ROOT3 / 2, width / 2)


def pickets(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Hexagons drawn out to `length` from tip to tip. Rows are length - width / 4 apart, as tips interlock."""
    tip = width / 2
    pitch = length - tip
    corners = [(-width / 2, -pitch / 2 + tip / 2), (0.0, -length / 2), (width / 2, -pitch / 2 + tip / 2)]
    corners += [(-u, -v) for u, v in corners]
    return _honeycomb(tile_m, width, polygon(corners), pitch, length / 2)


def diamonds(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Rhombs standing on a corner."""
    corners = [(0.0, -length / 2), (width / 2, 0.0), (0.0, length / 2), (-width / 2, 0.0)]
    return _honeycomb(tile_m, width, polygon(corners), length / 2, length / 2)


def scales(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Fish scales with the round end up, `width` wide; rows are width / 2 apart."""
    r = np.float32(width / 2)

    def outline(u: Array, v: Array) -> Array:
        below = np.minimum(np.hypot(u - r, v - r), np.hypot(u + r, v - r)) - r
        return np.asarray(np.minimum(r - np.hypot(u, v), below))

    return _honeycomb(tile_m, width, outline, width / 2, width / 2)


def lanterns(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Ogees with a tip above and below; rows are length / 2 apart. Edges swing out, then in."""

    def outline(u: Array, v: Array) -> Array:
        t = 1.0 - 4.0 * np.minimum(np.abs(v), length / 2) / length
        half = width / 4 * (1.0 + t + 0.22 * np.sin(np.pi * t))
        slope = width / length * (1.0 + 0.22 * np.pi * np.cos(np.pi * t))
        return np.asarray((half - np.abs(u)) / np.sqrt(1.0 + slope**2), dtype=np.float32)

    return _honeycomb(tile_m, width, outline, length / 2, length / 2)


def octagons(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Octagons `width` from flat to flat, with small squares on a corner between (sort 1)."""
    half, cut = width / 2, width * 0.22
    corners = [(-half, -half + cut), (-half + cut, -half), (half - cut, -half), (half, -half + cut)]
    corners += [(-u, -v) for u, v in corners]
    dot = box(cut / np.sqrt(2.0), cut / np.sqrt(2.0))
    return _large_and_small(tile_m, width, polygon(corners), (np.pi / 4, cut, cut, dot))


def stars(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Eight-pointed stars that touch, `width` apart, and crosses between them (sort 1)."""
    half = width / 2
    side = np.float32(half / np.sqrt(2.0))

    def star(u: Array, v: Array) -> Array:
        straight = side - np.maximum(np.abs(u), np.abs(v))
        slant = side - (np.abs(u) + np.abs(v)) / np.float32(np.sqrt(2.0))
        return np.maximum(straight, slant)

    def cross(u: Array, v: Array) -> Array:
        # A cross is what its four stars leave; by symmetry the nearest one decides.
        return -star(np.abs(u) - np.float32(half), np.abs(v) - np.float32(half))

    return _large_and_small(tile_m, width, star, (0.0, half, half, cross))


def _large_and_small(
    tile_m: Size, width: float, large: Outline, small: tuple[float, float, float, Outline]
) -> list[PlacedOutline]:
    """One shape in rows and columns `width` apart; at their corners another: its turn, half sizes and outline."""
    columns, wide = whole(tile_m[0], width)
    rows, tall = whole(tile_m[1], width)
    found = []
    for row, column in product(range(rows), range(columns)):
        x, y = (column + 0.5) * wide, (row + 0.5) * tall
        found.append(PlacedOutline(x, y, 0.0, width / 2, width / 2, large))
        found.append(PlacedOutline(column * wide, row * tall, *small, 1))
    return found


def cubes(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Three rhombs per hexagon, so that blocks seem to protrude (sorts 0 to 2)."""
    spoke = width / _ROOT3
    shape = polygon([(0.0, -width / 2), (spoke / 2, 0.0), (0.0, width / 2), (-spoke / 2, 0.0)])
    found = []
    for place in hexagons(tile_m, width):
        for sort in range(3):
            turn = np.pi / 2 + sort * 2 * np.pi / 3
            x, y = place.x + spoke / 2 * np.cos(turn), place.y + spoke / 2 * np.sin(turn)
            found.append(PlacedOutline(x % tile_m[0], y % tile_m[1], turn, spoke / 2, width / 2, shape, sort))
    return found


def _honeycomb(tile_m: Size, width: float, outline: Outline, pitch: float, half_v: float) -> list[PlacedOutline]:
    """One shape in rows `pitch` apart, every other row moved by half a width. `sort` takes turns by three."""
    columns, wide = whole(tile_m[0], width)
    rows, tall = whole(tile_m[1], pitch, even=True)
    found = []
    for row, column in product(range(rows), range(columns)):
        x, y = ((column + 0.5 * (row % 2) + 0.5) * wide) % tile_m[0], (row + 0.5) * tall
        sort = (column - row // 2 - row) % 3  # no two neighbours alike where columns come in threes
        found.append(PlacedOutline(x, y, 0.0, width / 2, half_v, outline, sort))
    return found


def fieldstone(canvas: Canvas, width: float, height: float, rng: np.random.Generator) -> PieceMap:
    """Irregular round stones of about this size, metres; `inside_m` is the distance to the border between two."""
    rows, columns = canvas.cells(height, width)
    rows += rows % 2
    off = 0.78 * (rng.random((2, rows, columns)) - 0.5)
    size = rng.uniform(0.75, 1.25, (rows, columns)).astype(np.float32)
    bend = np.float32(0.05 * min(width, height))
    x, y = canvas.axes()
    x = x + bend * canvas.noise(0.5 * height, 0.5 * width, rng)
    y = y + bend * canvas.noise(0.5 * height, 0.5 * width, rng)
    wide, tall = canvas.tile_m[0] / columns, canvas.tile_m[1] / rows
    row, column = np.floor(y / tall).astype(np.int64), np.floor(x / wide).astype(np.int64)
    first = np.full(canvas.size_px, 9.0, dtype=np.float32)
    second, owner = first.copy(), np.zeros(canvas.size_px, dtype=np.int32)
    us, vs = np.zeros_like(first), np.zeros_like(first)
    for down, right in product(range(-2, 3), range(-2, 3)):
        r, c = row + down, column + right
        at = (r % rows, c % columns)
        dx = x - ((c + 0.5 + off[0][at] + 0.5 * (r % 2)) * wide).astype(np.float32)
        dy = y - ((r + 0.5 + off[1][at]) * tall).astype(np.float32)
        gap = np.sqrt((dx / wide) ** 2 + (dy / tall) ** 2) / size[at]
        closer = gap < first
        second = np.where(closer, first, np.minimum(second, gap))
        owner = np.where(closer, (at[0] * columns + at[1]).astype(np.int32), owner)
        us, vs = np.where(closer, dx, us), np.where(closer, dy, vs)
        first = np.where(closer, gap, first)
    count = rows * columns
    number = np.arange(count)
    inside = 0.5 * (second - first) * np.float32(min(wide, tall))
    return PieceMap(
        owner=owner,
        inside_m=blur(inside.astype(np.float32), 0.0015 / canvas.pixel_m),
        u_m=us.astype(np.float32),
        v_m=vs.astype(np.float32),
        turn=np.zeros(count),
        sort=number % 3,
        half_m=np.broadcast_to(np.array([wide / 2, tall / 2]), (count, 2)),
    )


def ledges(canvas: Canvas, width: float, length: float, rng: np.random.Generator) -> PieceMap:
    """Strips of split stone in courses of a third to one `width`, about `length` long, metres."""
    wide, tall = canvas.tile_m
    units, unit = whole(tall, width / 3)
    heights: list[int] = []
    while sum(heights) < units:
        heights.append(min(int(rng.choice((1, 2, 2, 3))), units - sum(heights)))
    places: list[PlacedOutline] = []
    top = 0.0
    for height in heights:
        count = max(2, round(wide / (length * rng.uniform(0.75, 1.25))))
        parts = rng.uniform(0.45, 1.55, count)
        ends = (rng.random() + np.concatenate([[0.0], np.cumsum(parts / parts.sum())])) * wide
        for n in range(count):
            half_v, half_u = (ends[n + 1] - ends[n]) / 2, height * unit / 2
            x, y = (ends[n] + half_v) % wide, top + half_u
            places.append(PlacedOutline(x, y, np.pi / 2, half_u, half_v, box(half_u, half_v), height))
        top += height * unit
    return raster(places, canvas)


_PLACES: dict[LayingPattern, Callable[[Size, Laying, np.random.Generator], list[PlacedOutline]]] = {
    LayingPattern.RUNNING: lambda tile, p, _: running(tile, p.width_m, p.length_m, p.bond, p.upright),
    LayingPattern.PLANKS: lambda tile, p, rng: planks(
        tile, p.width_m, p.length_m, p.width_count, p.upright, p.ends_m, rng
    ),
    LayingPattern.BASKET: lambda tile, p, _: basket(tile, p.width_m, p.length_m),
    LayingPattern.HERRINGBONE: lambda tile, p, _: herringbone(tile, p.width_m, p.length_m, p.diagonal),
    LayingPattern.CHEVRON: lambda tile, p, _: chevron(tile, p.width_m, p.length_m),
    LayingPattern.ASHLAR: lambda tile, p, rng: ashlar(tile, p.width_m, rng),
    LayingPattern.PANEL: lambda tile, p, _: panel(tile, p.width_m, p.length_m),
    LayingPattern.PICKET: lambda tile, p, _: pickets(tile, p.width_m, p.length_m),
    LayingPattern.DIAMOND: lambda tile, p, _: diamonds(tile, p.width_m, p.length_m),
    LayingPattern.LANTERN: lambda tile, p, _: lanterns(tile, p.width_m, p.length_m),
    LayingPattern.HEXAGON: lambda tile, p, _: hexagons(tile, p.width_m),
    LayingPattern.PENNY: lambda tile, p, _: pennies(tile, p.width_m),
    LayingPattern.SCALE: lambda tile, p, _: scales(tile, p.width_m),
    LayingPattern.OCTAGON: lambda tile, p, _: octagons(tile, p.width_m),
    LayingPattern.STAR: lambda tile, p, _: stars(tile, p.width_m),
    LayingPattern.CUBE: lambda tile, p, _: cubes(tile, p.width_m),
}
