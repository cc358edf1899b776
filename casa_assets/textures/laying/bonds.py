"""Bonds of rectangles: running and stacked, basket weave, herringbone, chevron, planks, ashlar, panels."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.textures.laying.pieces import Array, Outline, PlacedOutline, box, polygon, whole

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
    for row in range(rows):
        for column in range(columns):
            a, b = (column + 0.5 + bond * row) * true_length % along, (row + 0.5) * true_width
            x, y = (b, a) if upright else (a, b)
            turn = 0.0 if upright else _LEVEL
            found.append(PlacedOutline(x, y, turn, true_width / 2, true_length / 2, shape, (row + column) % 2))
    return found


def planks(
    tile_m: Size, width: float, length: float, widths: int, upright: bool, ends_m: float, rng: np.random.Generator
) -> list[PlacedOutline]:
    """Boards end to end in courses, their ends staggered at random.

    Args:
        tile_m: of the picture. width, length: of a board, metres.
        widths: 1 for boards of one width, else how many widths are mixed (0.7 to 1.3 of `width`).
        upright: boards run along v of the picture, else along u.
        ends_m: by how much boards reach into the joints at their ends.
        rng: draws widths and ends.
    """
    along, across = (tile_m[1], tile_m[0]) if upright else tile_m
    courses = max(2, round(across / width))
    sizes = np.ones(courses)
    if widths > 1:
        sizes = rng.permutation(np.resize(np.linspace(0.7, 1.3, widths), courses))
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
    for row in range(rows):
        for column in range(columns):
            upright = (row + column) % 2 == 0
            for n in range(fingers):
                off = (n + 0.5) / fingers
                x = (column + (off if upright else 0.5)) * side_x
                y = (row + (0.5 if upright else off)) * side_y
                half_u, half_v = (side_x if upright else side_y) / fingers / 2, (side_y if upright else side_x) / 2
                turn = 0.0 if upright else _LEVEL
                found.append(PlacedOutline(x, y, turn, half_u, half_v, box(half_u, half_v), int(upright)))
    return found


def herringbone(tile_m: Size, width: float, length: float, slant: bool) -> list[PlacedOutline]:
    """Pieces of `length` = n `width` at right angles; `slant` turns the whole by 45 degrees.

    The picture holds whole repeats: multiples of 2 n width each way, with `slant` of n sqrt(2) width across and
    sqrt(2) width down.
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
    for row in range(rows):
        for column in range(columns):
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
            x, y = column * wide + half_x, row * tall + half_y
            turn = _LEVEL if level else 0.0
            found.append(
                PlacedOutline(x % tile_m[0], y % tile_m[1], turn, half_u, half_v, box(half_u, half_v), across * down)
            )
    return found


def panel(tile_m: Size, width: float, length: float) -> list[PlacedOutline]:
    """Square parquet panels: a mitred frame, and in it a basket weave on the slant.

    Args:
        tile_m: of the picture. width: of a strip. length: side of a panel.
    """
    columns, side = whole(tile_m[0], length)
    rows, _ = whole(tile_m[1], length)
    inner = side / 2 - width
    block = 2.0 * inner / np.sqrt(2.0) / 3.0  # three blocks fit along each half diagonal
    found = []
    for row in range(rows):
        for column in range(columns):
            x, y = (column + 0.5) * side, (row + 0.5) * side
            found += [_frame(x, y, k, side / 2, width) for k in range(4)]
            found += _weave(x, y, inner, block)
    return found


def _frame(x: float, y: float, quarter: int, half: float, width: float) -> PlacedOutline:
    """One strip of a mitred frame."""
    corners = [(-width / 2, -half), (width / 2, -half + width), (width / 2, half - width), (-width / 2, half)]
    turn = quarter * np.pi / 2
    reach = half - width / 2
    # Its outer edge is at u = -width/2, away from the middle of the panel.
    return PlacedOutline(
        x - np.cos(turn) * reach, y - np.sin(turn) * reach, turn, width / 2, half, polygon(corners), 2 + quarter % 2
    )


def _weave(x: float, y: float, inner: float, block: float) -> list[PlacedOutline]:
    """Slanting blocks of three strips each, cut off by the frame."""
    found = []
    turn = np.pi / 4
    cos, sin = np.cos(turn), np.sin(turn)
    for i in range(-3, 4):
        for j in range(-3, 4):
            upright = (i + j) % 2 == 0
            for n in (-1, 0, 1):
                a, b = (i + n / 3, float(j)) if upright else (float(i), j + n / 3)
                dx, dy = (cos * a - sin * b) * block, (sin * a + cos * b) * block
                if max(abs(dx), abs(dy)) > inner + block:
                    continue
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
