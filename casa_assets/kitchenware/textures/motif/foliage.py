"""Leaves, twigs and birds scattered over a picture that repeats, painted one over the other."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from casa_assets.ext.textures import Canvas, PlacedOutline, window
from casa_assets.kitchenware.textures.motif.figures import Array, disc, flower, ink, lens


class FoliageKind(StrEnum):
    """Kind of plant."""

    FERN = "fern"
    BANANA = "banana"
    GINKGO = "ginkgo"
    WILLOW = "willow"
    BLOSSOM = "blossom"
    MEADOW = "meadow"


def scatter(
    canvas: Canvas, growth: FoliageKind, size_m: float, inks: Array, ground: Array, rng: np.random.Generator
) -> Array:
    """(H, W, 3) sRGB picture of a ground with plants on it.

    Args:
        canvas: pixels and metres. growth: what grows. size_m: length of a leaf or twig, metres.
        inks: (N, 3) colours of the plants, the darkest first. ground: (3,) behind them.
        rng: all of the randomness.
    """
    picture = np.broadcast_to(ground, (*canvas.size_px, 3)).astype(np.float32)
    soft = canvas.pixel_m / size_m * 1.2
    for x, y, turn, size, number in _spots(canvas, growth, size_m, rng):
        half = 0.62 * size
        place = PlacedOutline(x, y, turn, half, half, lambda u, v: u)
        rows, columns, dx, dy = window(place, canvas)
        cos, sin = np.float32(np.cos(turn)), np.float32(np.sin(turn))
        u, v = (cos * dx + sin * dy) / np.float32(size), (cos * dy - sin * dx) / np.float32(size)
        at = np.ix_(rows, columns)
        patch = picture[at]
        for depth, hue in _DRAW[growth](u, v):
            share = ink(depth, soft * size_m / size)[..., None]
            patch = patch + (inks[(number + hue) % len(inks)] - patch) * share
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
    leaf = np.where(edge > 0, edge - np.abs(u), -1.0)
    blade = np.minimum(leaf, -slits)
    stem = np.minimum(0.010 - np.abs(u), np.minimum(0.55 - v, v + 0.46))
    light = np.minimum(blade - 0.01, u)
    lines = np.minimum(blade - 0.012, 0.004 - np.abs(vein) / 17.0)
    return [(blade, 0), (light, 1), (lines, 2), (stem, 2)]


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
    bend = u - 0.16 * (0.5 - v) ** 2
    stem = np.minimum(0.006 - np.abs(bend), np.minimum(0.5 - v, v + 0.34))
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


_MIXED = (FoliageKind.FERN, FoliageKind.BANANA, FoliageKind.WILLOW)  # inks are shades of one colour: any may come first
_ANY_WAY = (FoliageKind.FERN, FoliageKind.GINKGO, FoliageKind.BANANA)
_DENSE = {
    FoliageKind.FERN: 2.0,
    FoliageKind.BANANA: 2.1,
    FoliageKind.GINKGO: 1.15,
    FoliageKind.WILLOW: 1.9,
    FoliageKind.BLOSSOM: 1.35,
    FoliageKind.MEADOW: 1.9,
}
_DRAW = {
    FoliageKind(maker.__name__.removeprefix("_")): maker
    for maker in (_fern, _banana, _ginkgo, _willow, _blossom, _meadow)
}
