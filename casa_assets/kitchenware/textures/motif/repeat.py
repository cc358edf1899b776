"""Wallpaper figures that repeat in a rectangle: coordinates -0.5 to 0.5 each way about its middle, inks in order."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum

import numpy as np

from casa_assets.kitchenware.textures.motif.figures import Array, diamond, disc, flower, lens, polar, ring, star

# (depth of the figure in units of the width, number of its ink from 1)
Figures = list[tuple[Array, int]]


class PaperRepeat(StrEnum):
    """Design of one repeat."""

    DAMASK = "damask"
    STRIPE = "stripe"
    TICKING = "ticking"
    TRELLIS = "trellis"
    OGEE = "ogee"
    FANS = "fans"
    HEXLINES = "hexlines"
    GINGHAM = "gingham"
    SCALLOP = "scallop"
    DOTS = "dots"
    CHEVRON = "chevron"
    SPRIG = "sprig"
    SUNBURST = "sunburst"
    KEY = "key"
    ARCHES = "arches"


def _half_drop(u: Array, v: Array, draw: Callable[[Array, Array], Figures]) -> Figures:
    """One figure in the middle and one at each corner of the repeat."""
    found = draw(u, v)
    corner = draw(np.mod(u + 1.0, 1.0) - 0.5, np.mod(v + 1.0, 1.0) - 0.5)
    return [(np.maximum(a, b), n) for (a, n), (b, _) in zip(found, corner, strict=True)]


def _damask(u: Array, v: Array) -> Figures:
    """A symmetric bouquet in a frame of leaves, half dropped."""

    def bouquet(x: Array, y: Array) -> Figures:
        a, b = np.abs(x) * 0.66, y * 0.9
        body = lens(a, b, 0.0, -0.05, np.pi / 2, 0.42, 0.17)
        slit = lens(a, b, 0.0, -0.05, np.pi / 2, 0.32, 0.09)
        places = [(0.11, 0.17, -0.9, 0.26, 0.085), (0.14, 0.02, -0.5, 0.24, 0.075), (0.12, -0.15, -1.1, 0.24, 0.07)]
        places += [(0.05, -0.30, -1.3, 0.20, 0.06), (0.055, 0.30, 1.1, 0.18, 0.05)]
        leaves = np.maximum.reduce([lens(a, b, *place) for place in places])
        curl = np.minimum(ring(a, b, 0.155, 0.265, 0.045, 0.022), a - 0.12)
        dots = np.maximum(disc(a, b, 0.24, 0.13, 0.016), disc(a, b, 0.21, -0.24, 0.016))
        crown = flower(a, b + 0.36, 8, 0.055, 0.35)
        outer = np.maximum.reduce([body, leaves, curl, dots, crown])
        inner = np.maximum(np.minimum(slit, 1.0), disc(a, b, 0.0, -0.36, 0.016))
        return [(outer, 1), (inner, 0), (slit - 0.022, 1)]

    return _half_drop(u, v, bouquet)


def _stripe(u: Array, v: Array) -> Figures:
    flat = 0.0 * v
    lines = np.maximum(0.012 - np.abs(np.abs(u) - 0.30), 0.012 - np.abs(np.abs(u) - 0.36))
    return [(0.20 - np.abs(u) + flat, 1), (lines + flat, 2)]


def _ticking(u: Array, v: Array) -> Figures:
    """Narrow lines in a group, as on mattress cloth."""
    a, flat = np.abs(u), 0.0 * v
    lines = np.maximum.reduce([0.030 - a, 0.013 - np.abs(a - 0.085), 0.013 - np.abs(a - 0.135)])
    return [(lines + flat, 1), (0.010 - np.abs(a - 0.42) + flat, 2)]


def _trellis(u: Array, v: Array) -> Figures:
    """Double lines on the slant with a knot where they cross."""
    slant = np.abs(np.abs(u) + np.abs(v) - 0.5) / np.sqrt(2.0)
    lines = np.maximum(0.010 - np.abs(slant - 0.028), -1.0)
    a, b = np.abs(u), np.abs(v)
    knot = np.maximum(flower(a - 0.5, b, 4, 0.085, 0.4), flower(a, b - 0.5, 4, 0.085, 0.4))
    pip = np.maximum(disc(a, b, 0.5, 0.0, 0.025), disc(a, b, 0.0, 0.5, 0.025))
    heart = np.maximum(flower(u, v, 8, 0.075, 0.45), flower(a - 0.5, b - 0.5, 8, 0.075, 0.45))
    return [(lines, 1), (knot, 1), (pip, 0), (heart, 2)]


def _ogee(u: Array, v: Array) -> Figures:
    """Bands that swing together and apart, a seed in each eye."""

    def eye(x: Array, y: Array) -> Figures:
        t = 1.0 - 4.0 * np.minimum(np.abs(y), 0.5) / 2.0
        edge = 0.25 * (1.0 + t + 0.2 * np.sin(np.pi * t)) - np.abs(x)
        band = 0.020 - np.abs(edge - 0.045)
        fine = 0.007 - np.abs(edge - 0.095)
        seed = lens(x, y, 0.0, 0.0, np.pi / 2, 0.34, 0.15)
        return [(band, 1), (fine, 2), (seed, 1), (seed - 0.028, 0), (seed - 0.045, 2)]

    return _half_drop(u, v, eye)


def _fans(u: Array, v: Array) -> Figures:
    """Art deco fans in rows: arcs and ribs."""
    found: Figures = []
    for row in range(-1, 4):
        x = np.mod(u + 0.5 * (row % 2) + 0.5, 1.0) - 0.5
        y = v + 0.5 - 0.5 * row
        far, bearing = np.hypot(x, y), np.arctan2(-y, x)
        body = 0.5 - far
        ribs = np.minimum(0.009 - far * np.abs(np.mod(bearing + np.pi / 16, np.pi / 8) - np.pi / 16), 0.40 - far)
        rims = np.maximum(0.012 - np.abs(far - 0.487), 0.009 - np.abs(far - 0.41))
        found += [(body, 0), (np.maximum(np.minimum(ribs, far - 0.13), rims), 1), (0.13 - far, 2)]
    return found


def _hexlines(u: Array, v: Array) -> Figures:
    """Lines of a honeycomb, and a smaller one in every cell; the repeat is sqrt(3) as high as wide."""

    def cell(x: Array, y: Array) -> Figures:
        y = y * np.sqrt(3.0)
        edge = 0.5 - np.maximum(np.abs(x), np.abs(x) / 2 + np.abs(y) * np.sqrt(3.0) / 2)
        spokes = np.minimum(0.011 - np.minimum(np.abs(x), np.abs(np.abs(x) / 2 * np.sqrt(3.0) - np.abs(y) / 2)), edge)
        return [(np.where(edge > -0.01, 0.018 - np.abs(edge - 0.018), -1.0), 1), (0.010 - np.abs(edge - 0.16), 2),
                (np.minimum(spokes, 0.16 - edge), 2), (edge - 0.38, 1)]  # fmt: skip

    return _half_drop(u, v, cell)


def _gingham(u: Array, v: Array) -> Figures:
    return [(0.25 - np.abs(u) + 0.0 * v, 1), (0.25 - np.abs(v) + 0.0 * u, 1)]


def _scallop(u: Array, v: Array) -> Figures:
    found: Figures = []
    for row in range(-1, 4):
        x = np.mod(u + 0.5 * (row % 2) + 0.5, 1.0) - 0.5
        far = np.hypot(x, v + 0.5 - 0.5 * row)
        found += [(0.5 - far, 0), (0.020 - np.abs(far - 0.47), 1), (0.30 - far, 2)]
    return found


def _dots(u: Array, v: Array) -> Figures:
    a, b = np.abs(u), np.abs(v)
    return [(np.maximum(disc(u, v, 0, 0, 0.14), disc(a, b, 0.5, 0.5, 0.14)), 1)]


def _chevron(u: Array, v: Array) -> Figures:
    rise = np.mod(v + 0.5 * np.abs(u) + 0.5, 0.5) - 0.25
    return [((0.13 - np.abs(rise)) * 0.9, 1), (0.012 - np.abs(np.abs(rise) - 0.19), 2)]


def _sprig(u: Array, v: Array) -> Figures:
    """A small flower on a stem, half dropped."""

    def sprig(x: Array, y: Array) -> Figures:
        stem = np.minimum(0.008 - np.abs(x - 0.05 * np.sin(6.0 * y)), np.minimum(0.30 - y, y + 0.05))
        places = ((0.08, 0.17, -0.7, 0.17, 0.06), (-0.06, 0.24, -2.3, 0.15, 0.055), (-0.07, 0.11, -2.5, 0.12, 0.045))
        leaves = np.maximum.reduce([lens(x, y, *place) for place in places])
        bud = np.maximum(disc(x, y, 0.15, -0.02, 0.03), disc(x, y, -0.14, 0.03, 0.024))
        bloom = flower(x, y + 0.13, 5, 0.12, 0.42, np.pi / 2)
        return [(np.maximum(stem, leaves), 1), (np.maximum(bloom, bud), 2), (disc(x, y, 0.0, -0.13, 0.032), 3)]

    return _half_drop(u, v, sprig)


def _sunburst(u: Array, v: Array) -> Figures:
    """Rays from the middle of every square."""
    far, bearing = polar(u, v, 24)
    ray = np.minimum(0.030 * far / 0.5 - np.abs(far * np.sin(bearing)), np.minimum(far - 0.13, 0.44 - far))
    short = star(u, v, 12, 0.16, 0.09)
    corner = diamond(np.abs(u) - 0.5, np.abs(v) - 0.5, 0.09)
    return [(ray, 1), (short, 2), (corner, 2)]


def _key(u: Array, v: Array) -> Figures:
    """A meander: one line that turns in and out, between two straight ones."""
    half = 0.045

    def bar(x0: float, y0: float, x1: float, y1: float) -> Array:
        dx = np.maximum(np.maximum(x0 - u, u - x1), 0.0)
        dy = np.maximum(np.maximum(y0 - v, v - y1), 0.0)
        return np.asarray(half - np.maximum(dx, dy))

    bars = [(-0.5, 0.27, -0.36, 0.27), (-0.36, -0.27, -0.36, 0.27), (-0.36, -0.27, 0.27, -0.27)]
    bars += [(0.27, -0.27, 0.27, 0.09), (-0.09, 0.09, 0.27, 0.09), (-0.09, -0.09, -0.09, 0.09)]
    bars += [(-0.18, 0.27, 0.5, 0.27), (-0.18, -0.09, -0.18, 0.27)]
    return [(np.maximum.reduce([bar(*ends) for ends in bars]), 1), (0.02 - np.abs(np.abs(v) - 0.45) + 0.0 * u, 2)]


def _arches(u: Array, v: Array) -> Figures:
    """Rainbows side by side, every other row half an arch on."""
    found: Figures = []
    for row in range(-1, 3):
        x = np.mod(u + 0.5 * (row % 2) + 0.5, 1.0) - 0.5
        y = v + 0.5 - 0.5 * row
        far = np.where(y < 0.0, np.hypot(x, y), np.abs(x))
        inside = np.minimum(0.47 - far, 0.5 - y)
        rings = 0.042 - np.abs(np.mod(far + 0.02, 0.15) - 0.075)
        found += [(inside, 0), (np.minimum(rings, inside), 1 + row % 2)]
    return found


REPEATS: dict[PaperRepeat, Callable[[Array, Array], Figures]] = {
    PaperRepeat(maker.__name__.removeprefix("_")): maker
    for maker in (
        *(_damask, _stripe, _ticking, _trellis, _ogee, _fans, _hexlines, _gingham, _scallop, _dots, _chevron),
        *(_sprig, _sunburst, _key, _arches),
    )
}
