"""Tilings of other shapes: hexagons, pickets, diamonds, pennies, scales, lanterns, octagons, stars, cubes."""

from __future__ import annotations

import numpy as np

from casa_assets.textures.laying.pieces import Array, Outline, PlacedOutline, box, disc, polygon, whole

Size = tuple[float, float]
_ROOT3 = float(np.sqrt(3.0))


def hexagons(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Regular hexagons with a corner up, `width` from flat to flat. Rows are width * sqrt(3) / 2 apart."""
    return _honeycomb(tile_m, width, polygon(_hexagon(width, width / _ROOT3)), width * _ROOT3 / 2, width / _ROOT3)


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
    columns, wide = whole(tile_m[0], width)
    rows, tall = whole(tile_m[1], width)
    half, cut = width / 2, width * 0.22
    corners = [(-half, -half + cut), (-half + cut, -half), (half - cut, -half), (half, -half + cut)]
    corners += [(-u, -v) for u, v in corners]
    big, dot = polygon(corners), box(cut / np.sqrt(2.0), cut / np.sqrt(2.0))
    found = []
    for row in range(rows):
        for column in range(columns):
            found.append(PlacedOutline((column + 0.5) * wide, (row + 0.5) * tall, 0.0, half, half, big))
            found.append(PlacedOutline(column * wide, row * tall, np.pi / 4, cut, cut, dot, 1))
    return found


def stars(tile_m: Size, width: float) -> list[PlacedOutline]:
    """Eight-pointed stars that touch, `width` apart, and crosses between them (sort 1)."""
    columns, wide = whole(tile_m[0], width)
    rows, tall = whole(tile_m[1], width)
    half = width / 2
    star = _star(half)

    def cross(u: Array, v: Array) -> Array:
        # A cross is what its four stars leave; by symmetry the nearest one decides.
        return -star(np.abs(u) - np.float32(half), np.abs(v) - np.float32(half))

    found = []
    for row in range(rows):
        for column in range(columns):
            found.append(PlacedOutline((column + 0.5) * wide, (row + 0.5) * tall, 0.0, half, half, star))
            found.append(PlacedOutline(column * wide, row * tall, 0.0, half, half, cross, 1))
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


def _star(half: float) -> Outline:
    side = np.float32(half / np.sqrt(2.0))

    def outline(u: Array, v: Array) -> Array:
        straight = side - np.maximum(np.abs(u), np.abs(v))
        slant = side - (np.abs(u) + np.abs(v)) / np.float32(np.sqrt(2.0))
        return np.maximum(straight, slant)

    return outline


def _hexagon(width: float, radius: float) -> list[tuple[float, float]]:
    half = [(-width / 2, -radius / 2), (0.0, -radius), (width / 2, -radius / 2)]
    return half + [(-u, -v) for u, v in half]


def _honeycomb(tile_m: Size, width: float, outline: Outline, pitch: float, half_v: float) -> list[PlacedOutline]:
    """One shape in rows `pitch` apart, every other row moved by half a width. `sort` takes turns by three."""
    columns, wide = whole(tile_m[0], width)
    rows, tall = whole(tile_m[1], pitch, even=True)
    return [
        PlacedOutline(
            ((column + 0.5 * (row % 2) + 0.5) * wide) % tile_m[0],
            (row + 0.5) * tall,
            0.0,
            width / 2,
            half_v,
            outline,
            (column - row // 2 - row) % 3,  # no two neighbours alike where columns come in threes
        )
        for row in range(rows)
        for column in range(columns)
    ]
