"""Drawn figures: masks of inks in a square or rectangle that repeats, and foliage strewn over it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from casa_assets.ext.textures import Canvas, PlacedOutline, window

Array = npt.NDArray[np.floating[Any]]


def disc(u: Array, v: Array, cu: float, cv: float, radius: float) -> Array:
    """A circle."""
    return np.asarray(radius - np.hypot(u - cu, v - cv))


def ring(u: Array, v: Array, cu: float, cv: float, radius: float, width: float) -> Array:
    """A line around a circle."""
    return np.asarray(width / 2 - np.abs(np.hypot(u - cu, v - cv) - radius))


def square(u: Array, v: Array, half: float) -> Array:
    """An upright square."""
    return np.asarray(half - np.maximum(np.abs(u), np.abs(v)))


def diamond(u: Array, v: Array, half: float) -> Array:
    """A square on a corner; `half` is from its middle to a corner."""
    return np.asarray((half - np.abs(u) - np.abs(v)) / np.sqrt(2.0))


def lens(u: Array, v: Array, cu: float, cv: float, turn: float, length: float, width: float) -> Array:
    """A petal between two arcs, `length` from tip to tip along `turn` (radians)."""
    a = np.cos(turn) * (u - cu) + np.sin(turn) * (v - cv)
    b = np.abs(np.cos(turn) * (v - cv) - np.sin(turn) * (u - cu))
    radius = (length**2 + width**2) / (4.0 * width)
    return np.asarray(radius - np.hypot(a, b + radius - width / 2))


def polar(u: Array, v: Array, folds: int) -> tuple[Array, Array]:
    """Radius, and angle from the middle of the nearest of `folds` equal sectors, radians."""
    bearing, sector = np.arctan2(v, u), 2.0 * np.pi / folds
    return np.hypot(u, v), np.asarray(np.mod(bearing + sector / 2, sector) - sector / 2)


def star(u: Array, v: Array, points: int, outer: float, inner: float, turn: float = 0.0) -> Array:
    """A star of straight edges between an outer and an inner radius."""
    c, s = np.cos(turn), np.sin(turn)
    far, bearing = polar(c * u + s * v, c * v - s * u, points)
    x, y = far * np.cos(bearing), np.abs(far * np.sin(bearing))
    tip = np.array([outer, 0.0])
    notch = inner * np.array([np.cos(np.pi / points), np.sin(np.pi / points)])
    edge = notch - tip
    normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
    return np.asarray((tip[0] - x) * normal[0] + (tip[1] - y) * normal[1])


def flower(u: Array, v: Array, petals: int, radius: float, depth: float, turn: float = 0.0) -> Array:
    """A rosette whose rim swings `petals` times by `depth` of the radius."""
    far, bearing = np.hypot(u, v), np.arctan2(v, u) - turn
    rim = radius * (1.0 - depth + depth * np.abs(np.cos(bearing * petals / 2.0)))
    return np.asarray(0.9 * (rim - far))


def folded(u: Array, v: Array) -> tuple[Array, Array]:
    """Both coordinates folded into one eighth: 0 <= second <= first."""
    a, b = np.abs(u), np.abs(v)
    return np.maximum(a, b), np.minimum(a, b)


def ink(depth: Array, soft: float) -> Array:
    """0..1, what a figure covers, its edge as wide as `soft`."""
    return np.asarray(np.clip(depth / max(soft, 1e-6) + 0.5, 0.0, 1.0))


# (depth of the figure, number of its colour)
Figures = list[tuple[Array, int]]


# Design of a cement tile.
TileDesign = Literal[
    "coastal", "quatrefoil", "star", "moroccan", "circles", "compass", "lace", "diamonds", "rosette", "bordered",
    "cubes", "triangles", "fleur", "crosses", "arcs", "waves", "octagram", "tulip",
]  # fmt: skip


def _coastal(u: Array, v: Array) -> Figures:
    """Four dark petals from the middle, dark arrowheads at the corners, a diamond between."""
    a, b = folded(u, v)
    petals = lens(np.abs(u), np.abs(v), 0.19, 0.19, np.pi / 4, 0.46, 0.17)
    corner = np.minimum(disc(np.abs(u), np.abs(v), 0.5, 0.5, 0.30), -disc(np.abs(u), np.abs(v), 0.36, 0.36, 0.13))
    side = diamond(a - 0.5, b, 0.13)
    return [(petals, 1), (corner, 1), (side, 1), (disc(a, b, 0.30, 0.0, 0.035), 1), (disc(u, v, 0, 0, 0.045), 0)]


def _quatrefoil(u: Array, v: Array) -> Figures:
    a, b = folded(u, v)
    foil = np.maximum(disc(a, b, 0.20, 0.0, 0.21), square(u, v, 0.17))
    inner = np.maximum(disc(a, b, 0.20, 0.0, 0.15), square(u, v, 0.13))
    corner = diamond(np.abs(u) - 0.5, np.abs(v) - 0.5, 0.17)
    return [(foil, 1), (inner, 0), (diamond(u, v, 0.13), 2), (corner, 1), (corner - 0.045, 2)]


def _star(u: Array, v: Array) -> Figures:
    big = star(u, v, 8, 0.47, 0.27)
    corner = star(np.abs(u) - 0.5, np.abs(v) - 0.5, 4, 0.22, 0.10)
    return [(big, 1), (star(u, v, 8, 0.30, 0.17, np.pi / 8), 2), (disc(u, v, 0, 0, 0.07), 0), (corner, 2)]


def _moroccan(u: Array, v: Array) -> Figures:
    """Bands that cross about an eight-pointed star."""
    eight = np.maximum(square(u, v, 0.25), diamond(u, v, 0.25 * np.sqrt(2.0)))
    band = 0.028 - np.abs(eight - 0.0)
    a, b = np.abs(u), np.abs(v)
    rays = np.minimum(0.028 - np.abs(a - b) / np.sqrt(2.0), -eight)
    cross = np.minimum(0.028 - np.abs(np.minimum(0.5 - a, 0.5 - b) - 0.11), np.maximum(0.5 - a, 0.5 - b) - 0.05)
    core, corner = star(u, v, 8, 0.17, 0.085), diamond(a - 0.5, b - 0.5, 0.15)
    return [(eight, 1), (band, 0), (core, 2), (np.minimum(rays, 0.3 - corner), 3), (cross, 3), (corner, 2)]


def _circles(u: Array, v: Array) -> Figures:
    """Circles that overlap: four petals to a tile."""
    a, b = folded(u, v)
    petal = lens(a, b, 0.25, 0.0, 0.0, 0.50, 0.2071)
    side = lens(a - 0.5, b, 0.0, 0.25, np.pi / 2, 0.50, 0.2071)
    return [(np.maximum(petal, side), 1), (star(u, v, 4, 0.12, 0.05, np.pi / 4), 2)]


def _compass(u: Array, v: Array) -> Figures:
    far, bearing = polar(u, v, 4)
    long, short = star(u, v, 4, 0.46, 0.12), star(u, v, 4, 0.34, 0.12, np.pi / 4)
    lit = np.where(bearing > 0, 0.02, -1.0)
    around = ring(u, v, 0, 0, 0.41, 0.025)
    corner = disc(np.abs(u), np.abs(v), 0.5, 0.5, 0.14)
    found = [(around, 2), (short, 2), (long, 1), (np.minimum(long, lit), 3)]
    return [*found, (corner, 1), (corner - 0.05, 0), (0.05 - far, 0)]


def _lace(u: Array, v: Array) -> Figures:
    a, b = np.abs(u), np.abs(v)
    rim = 0.016 - np.abs(flower(a - 0.5, b - 0.5, 16, 0.44, 0.10))
    hearts = flower(u, v, 8, 0.17, 0.45)
    far, bearing = polar(u, v, 8)
    dots = disc(far * np.cos(bearing), far * np.sin(bearing), 0.235, 0.0, 0.024)
    inner = ring(a, b, 0.5, 0.5, 0.29, 0.022)
    return [(rim, 1), (hearts, 1), (disc(u, v, 0, 0, 0.05), 0), (dots, 2), (inner, 2), (disc(a, b, 0.5, 0.5, 0.16), 1)]


def _diamonds(u: Array, v: Array) -> Figures:
    one = diamond(u, v, 0.5)
    corner = diamond(np.abs(u) - 0.5, np.abs(v) - 0.5, 0.25)
    return [(one, 1), (one - 0.10, 0), (one - 0.17, 2), (one - 0.27, 0), (corner, 2), (corner - 0.08, 1)]


def _rosette(u: Array, v: Array) -> Figures:
    far, bearing = polar(u, v, 8)
    x, y = far * np.cos(bearing), far * np.sin(bearing)
    petals = lens(x, y, 0.20, 0.0, 0.0, 0.34, 0.11)
    veins = np.minimum(petals - 0.018, 0.008 - np.abs(y))
    a, b = np.abs(u), np.abs(v)
    leaf = lens(a, b, 0.41, 0.41, np.pi / 4, 0.26, 0.10)
    wing = np.maximum(lens(a, b, 0.47, 0.32, np.pi / 2, 0.2, 0.07), lens(a, b, 0.32, 0.47, 0.0, 0.2, 0.07))
    return [(petals, 1), (veins, 0), (disc(u, v, 0, 0, 0.065), 2), (leaf, 2), (wing, 3)]


def _bordered(u: Array, v: Array) -> Figures:
    frame, line = -square(u, v, 0.43), 0.010 - np.abs(square(u, v, 0.395))
    core = np.maximum(square(u, v, 0.18), diamond(u, v, 0.26))
    corner = square(np.abs(u) - 0.5, np.abs(v) - 0.5, 0.075)
    return [(frame, 1), (line, 1), (core, 2), (core - 0.05, 0), (star(u, v, 4, 0.1, 0.045), 1), (corner, 2)]


def _cubes(u: Array, v: Array) -> Figures:
    """Blocks in perspective: two to a tile, half a tile apart."""
    tops: list[Array] = []
    lefts: list[Array] = []
    for du, dv in ((0.0, 0.0), (0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)):
        x, y = u - du, v - dv + 0.0
        top = 0.25 - np.abs(x) * 0.5 - np.abs(y + 0.25) * 1.0
        tops.append(0.8 * top)
        slanted = y - x * 0.5
        lefts.append(np.minimum(np.minimum(-x, x + 0.5), np.minimum(slanted + 0.0, 0.5 - slanted) * 0.9))
    return [(np.maximum.reduce(lefts), 1), (np.maximum.reduce(tops), 2)]


def _triangles(u: Array, v: Array) -> Figures:
    """Half squares that take turns, four to a tile."""
    x, y = np.mod(u + 0.5, 0.5) - 0.25, np.mod(v + 0.5, 0.5) - 0.25
    half = (x * np.where((u > 0) ^ (v > 0), 1.0, -1.0) + y) / np.sqrt(2.0)
    return [(np.where(v > 0, half, -half), 1), (np.minimum(diamond(u, v, 0.16), 1.0), 2)]


def _fleur(u: Array, v: Array) -> Figures:
    """A cross of lilies."""
    a, b = folded(u, v)
    stem, leaf = np.minimum(0.022 - b, 0.33 - a), lens(a, b, 0.34, 0.0, 0.0, 0.26, 0.12)
    curl = np.minimum(ring(a, b, 0.235, 0.085, 0.06, 0.045), a - 0.17)
    band = np.minimum(0.018 - np.abs(a - 0.21), 0.075 - b)
    corner = disc(np.abs(u), np.abs(v), 0.5, 0.5, 0.2)
    return [(corner, 2), (corner - 0.05, 0), (corner - 0.1, 1), (np.maximum.reduce([stem, leaf, curl, band]), 1)]


def _crosses(u: Array, v: Array) -> Figures:
    """Plus signs with notched ends about small squares."""
    a, b = folded(u, v)
    plus = np.maximum(np.minimum(0.36 - a, 0.12 - b), np.minimum(0.12 - a, 0.36 - b))
    corner = square(np.abs(u) - 0.5, np.abs(v) - 0.5, 0.20)
    return [(plus, 1), (plus - 0.055, 2), (corner, 2), (corner - 0.07, 0), (corner - 0.13, 1)]


def _arcs(u: Array, v: Array) -> Figures:
    """Quarter rings about two corners."""
    far = np.minimum(np.hypot(u + 0.5, v + 0.5), np.hypot(u - 0.5, v - 0.5))
    return [(np.minimum(0.058 - np.abs(np.mod(far, 0.20) - 0.10), 0.5 - far), 1), (far - 0.5, 2)]


def _waves(u: Array, v: Array) -> Figures:
    """Fans in rows, each row half a fan on."""
    found: Figures = []
    for dv in (-0.5, -0.25, 0.0, 0.25, 0.5, 0.75):
        x = np.mod(u + 0.5 + 0.25 * (round(4 * dv) % 2), 0.5) - 0.25
        far = np.hypot(x, v - dv - 0.0)
        found += [(0.25 - far, 0), (0.235 - far, 1), (0.185 - far, 0), (0.135 - far, 2), (0.07 - far, 0)]
    return found


def _octagram(u: Array, v: Array) -> Figures:
    a, b = np.abs(u), np.abs(v)
    outer, corner = star(u, v, 8, 0.5, 0.36), star(a - 0.5, b - 0.5, 8, 0.2, 0.13)
    line = 0.013 - np.abs(star(u, v, 8, 0.42, 0.30))
    return [(outer, 1), (line, 3), (star(u, v, 8, 0.3, 0.2), 2), (star(u, v, 8, 0.16, 0.09), 0), (corner, 2)]


def _tulip(u: Array, v: Array) -> Figures:
    """Buds that grow from the corners to the middle."""
    a, b = np.abs(u), np.abs(v)
    s, t = (1.0 - a - b) / np.sqrt(2.0), np.abs(a - b) / np.sqrt(2.0)  # along and across the diagonal
    bud = lens(s, t, 0.38, 0.0, 0.0, 0.34, 0.22)
    slit = lens(s, t, 0.44, 0.05, 0.25, 0.26, 0.05)
    stem = np.minimum(0.016 - t, 0.28 - s)
    leaf = lens(s, t, 0.20, 0.06, 0.75, 0.24, 0.07)
    return [(bud, 1), (slit, 0), (stem, 2), (leaf, 2), (star(u, v, 4, 0.15, 0.06), 2), (0.09 - s, 1)]


DESIGNS: dict[str, Callable[[Array, Array], Figures]] = {
    maker.__name__.removeprefix("_"): maker
    for maker in (
        *(_coastal, _quatrefoil, _star, _moroccan, _circles, _compass, _lace, _diamonds, _rosette, _bordered),
        *(_cubes, _triangles, _fleur, _crosses, _arcs, _waves, _octagram, _tulip),
    )
}


# Kind of plant.
FoliageKind = Literal["fern", "banana", "ginkgo", "willow", "blossom", "meadow"]


def scatter(
    canvas: Canvas, growth: FoliageKind, size_m: float, inks: Array, ground: Array, rng: np.random.Generator
) -> Array:
    """(H, W, 3) sRGB picture of a ground with plants on it.

    `growth`: what grows. `size_m`: length of a leaf or twig. `inks`: (N, 3), the darkest first. `ground`: (3,).
    """
    picture = np.broadcast_to(ground, (*canvas.size_px, 3)).astype(np.float32)
    soft = canvas.pixel_m / size_m * 1.2
    for x, y, turn, size, number in _spots(canvas, growth, size_m, rng):
        half = 0.62 * size
        rows, columns, dx, dy = window(PlacedOutline(x, y, turn, half, half, lambda u, v: u), canvas)
        cos, sin = np.float32(np.cos(turn)), np.float32(np.sin(turn))
        u, v = (cos * dx + sin * dy) / np.float32(size), (cos * dy - sin * dx) / np.float32(size)
        at = np.ix_(rows, columns)
        patch = picture[at]
        for depth, hue in _DRAW[growth](u, v):
            patch = patch + (inks[(number + hue) % len(inks)] - patch) * ink(depth, soft * size_m / size)[..., None]
        picture[at] = patch
    return picture


def _spots(
    canvas: Canvas, growth: FoliageKind, size_m: float, rng: np.random.Generator
) -> list[tuple[float, float, float, float, int]]:
    """Middles, turns, lengths and first inks: one to a cell of a jittered grid, in an order that hides the grid."""
    wide, tall = canvas.tile_m
    columns, rows = (max(2, round(side / size_m * _DENSE[growth])) for side in (wide, tall))
    rows += rows % 2
    found = []
    for n in range(rows * columns):
        row, column = divmod(n, columns)
        jitter = rng.uniform(-0.28, 0.28, 2)
        x = (column + 0.5 + 0.5 * (row % 2) + jitter[0]) / columns * wide % wide
        y = (row + 0.5 + jitter[1]) / rows * tall % tall
        turn = rng.uniform(-np.pi, np.pi) if growth in _ANY_WAY else rng.normal(0.0, 0.35)
        found.append((x, y, turn, size_m * rng.uniform(0.8, 1.15), int(rng.integers(0, 64)) * (growth in _MIXED)))
    return [found[i] for i in rng.permutation(len(found))]


def _fern(u: Array, v: Array) -> list[tuple[Array, int]]:
    """A rib with pairs of leaflets that shorten to the tip."""
    u = u - 0.10 * (v + 0.2) ** 2
    parts = [np.minimum(0.006 - np.abs(u), 0.47 - np.abs(v))]
    for k in range(11):
        at = 0.36 - 0.078 * k
        length = 0.30 * np.sin(np.pi * min(0.97, 0.25 + 0.07 * k)) ** 0.8
        parts.append(lens(np.abs(u), v, 0.42 * length, at - 0.20 * length, -0.45, length, 0.24 * length))
    return [(np.maximum.reduce(parts), 0)]


def _banana(u: Array, v: Array) -> list[tuple[Array, int]]:
    """A broad leaf, torn along its veins."""
    u = u - 0.22 * (v + 0.1) ** 2
    edge = 0.21 * np.sqrt(np.clip(1.0 - (2.1 * (v + 0.04)) ** 2, 0.0, 1.0))
    vein = np.mod((v + 0.55 * np.abs(u)) * 17.0, 1.0) - 0.5
    tear = np.where(np.abs(np.floor((v + 0.55 * np.abs(u)) * 17.0 / 3.0) % 2) < 0.5, 0.13, 0.17)
    slits = np.minimum(np.abs(u) - tear, 0.006 - np.abs(np.mod((v + 0.55 * np.abs(u)) * 5.7, 1.0) - 0.5) / 5.7)
    blade = np.minimum(np.where(edge > 0, edge - np.abs(u), -1.0), -slits)
    stem = np.minimum(0.010 - np.abs(u), np.minimum(0.55 - v, v + 0.46))
    light = np.minimum(blade - 0.01, u)
    return [(blade, 0), (light, 1), (np.minimum(blade - 0.012, 0.004 - np.abs(vein) / 17.0), 2), (stem, 2)]


def _ginkgo(u: Array, v: Array) -> list[tuple[Array, int]]:
    """A fan on a long stalk with a notch and fine rays."""
    y = v - 0.12
    far, bearing = np.hypot(u, y), np.arctan2(u, -y)
    rim = 0.44 + 0.018 * np.cos(9.0 * bearing) - 0.15 * np.exp(-((bearing / 0.09) ** 2))
    fan = np.minimum(rim - far, (1.02 - np.abs(bearing)) * np.maximum(far, 0.02))
    rays = np.minimum(fan - 0.008, 0.0035 - far * np.abs(np.mod(bearing + 0.05, 0.10) - 0.05))
    rays = np.minimum(rays, far - 0.10)
    stalk = np.minimum(0.009 - np.abs(u - 0.25 * (y - 0.0) ** 2), np.minimum(y + 0.02, 0.34 - y))
    return [(stalk, 1), (fan, 0), (rays, 1)]


def _willow(u: Array, v: Array) -> list[tuple[Array, int]]:
    """A bough with slim leaves in turn, two tones, after the paper of the 1880s."""
    u = u - 0.07 * np.sin(5.0 * v)
    parts: list[tuple[Array, int]] = [(np.minimum(0.007 - np.abs(u), 0.48 - np.abs(v)), 2)]
    for k in range(8):
        side = 1.0 if k % 2 else -1.0
        at = 0.38 - 0.11 * k
        leaf = lens(u, v, side * 0.105, at - 0.075, -np.pi / 2 + side * 0.95, 0.26, 0.068)
        vein = np.minimum(leaf - 0.008, lens(u, v, side * 0.105, at - 0.075, -np.pi / 2 + side * 0.95, 0.22, 0.008))
        parts += [(leaf, k % 2), (vein, 2)]
    return parts


# Of a twig: place, radius and turn of open flowers; place and radius of buds.
_OPEN = ((0.10, -0.20, 0.105, 0.3), (-0.13, 0.05, 0.12, 1.1), (0.24, -0.06, 0.075, 0.7), (-0.02, 0.33, 0.085, 0.1))
_BUDS = ((0.02, -0.40, 0.028), (0.13, 0.19, 0.024), (-0.15, -0.13, 0.022))


def _blossom(u: Array, v: Array) -> list[tuple[Array, int]]:
    """A crooked twig with open flowers and buds, as on painted silk."""
    line = u - 0.11 * np.sin(7.5 * v) - 0.03 * np.sin(19.0 * v)
    twig = np.minimum(0.011 * (1.0 + v) - np.abs(line) * 0.8, 0.5 - np.abs(v))
    side = np.minimum(0.006 - np.abs(v - 0.10 + 0.7 * (u - 0.05)), np.minimum(u - 0.03, 0.26 - u))
    found: list[tuple[Array, int]] = [(np.maximum(twig, side), 0)]
    for x, y, r, turn in _OPEN:
        petals = flower(u - x, v - y, 5, r, 0.35, turn)
        found += [(petals, 1), (petals - 0.55 * r, 2), (disc(u, v, x, y, 0.2 * r), 3)]
    buds = np.maximum.reduce([disc(u, v, *bud) for bud in _BUDS])
    leaves = np.maximum(lens(u, v, -0.09, -0.30, 0.6, 0.17, 0.055), lens(u, v, 0.13, 0.30, -0.5, 0.17, 0.055))
    return [*found[:1], (leaves, 3), *found[1:], (buds, 1)]


def _meadow(u: Array, v: Array) -> list[tuple[Array, int]]:
    """Grasses and umbels on one stem."""
    stem = np.minimum(0.006 - np.abs(u - 0.16 * (0.5 - v) ** 2), np.minimum(0.5 - v, v + 0.34))
    tops: list[Array] = []
    rays: list[Array] = []
    for k in range(7):
        angle = (k - 3) * 0.30
        x, y = 0.115 + 0.17 * np.sin(angle), -0.34 - 0.13 * np.cos(angle) + 0.08
        tops.append(disc(u, v, float(x), float(y), 0.026))
        t = np.clip((v + 0.30) / (float(y) + 0.30 - 1e-6), 0.0, 1.0)
        rays.append(np.where((t > 0) & (t < 1), 0.004 - np.abs(u - (0.105 + t * (float(x) - 0.105))), -1.0))
    blades = np.maximum(lens(u, v, -0.07, 0.22, -1.9, 0.50, 0.034), lens(u, v, 0.10, 0.30, -1.2, 0.36, 0.030))
    return [(blades, 0), (np.maximum(stem, np.maximum.reduce(rays)), 1), (np.maximum.reduce(tops), 2)]


_MIXED = ("fern", "banana", "willow")  # inks are shades of one colour: any may come first
_ANY_WAY = ("fern", "ginkgo", "banana")
_DENSE = {"fern": 2.0, "banana": 2.1, "ginkgo": 1.15, "willow": 1.9, "blossom": 1.35, "meadow": 1.9}
_DRAW = {maker.__name__.removeprefix("_"): maker for maker in (_fern, _banana, _ginkgo, _willow, _blossom, _meadow)}
