"""Wall coverings: plaster, printed and woven paper, foliage, and the repeats that are printed."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Canvas,
    Layers,
    Map,
    Share,
    TextureKind,
    blend,
    rgb,
    rgb_table,
    ridged,
    smoothstep,
    standardize,
    whole,
    worley,
)
from casa_assets.kitchenware.textures import motif
from casa_assets.kitchenware.textures.motif import Array, FoliageKind

# (depth of the figure in units of the width, number of its ink from 1)
Figures = list[tuple[Array, int]]


# Design of one repeat.
PaperRepeat = Literal["damask", "stripe", "trellis", "ogee", "fans", "gingham", "scallop", "dots", "sprig", "arches"]


def _half_drop(u: Array, v: Array, draw: Callable[[Array, Array], Figures]) -> Figures:
    """One figure in the middle and one at each corner of the repeat."""
    found = draw(u, v)
    corner = draw(np.mod(u + 1.0, 1.0) - 0.5, np.mod(v + 1.0, 1.0) - 0.5)
    return [(np.maximum(a, b), n) for (a, n), (b, _) in zip(found, corner, strict=True)]


def _damask(u: Array, v: Array) -> Figures:
    """A symmetric bouquet in a frame of leaves, half dropped."""

    def bouquet(x: Array, y: Array) -> Figures:
        a, b = np.abs(x) * 0.66, y * 0.9
        body = motif.lens(a, b, 0.0, -0.05, np.pi / 2, 0.42, 0.17)
        slit = motif.lens(a, b, 0.0, -0.05, np.pi / 2, 0.32, 0.09)
        places = [(0.11, 0.17, -0.9, 0.26, 0.085), (0.14, 0.02, -0.5, 0.24, 0.075), (0.12, -0.15, -1.1, 0.24, 0.07)]
        places += [(0.05, -0.30, -1.3, 0.20, 0.06), (0.055, 0.30, 1.1, 0.18, 0.05)]
        leaves = np.maximum.reduce([motif.lens(a, b, *place) for place in places])
        curl = np.minimum(motif.ring(a, b, 0.155, 0.265, 0.045, 0.022), a - 0.12)
        dots = np.maximum(motif.disc(a, b, 0.24, 0.13, 0.016), motif.disc(a, b, 0.21, -0.24, 0.016))
        outer = np.maximum.reduce([body, leaves, curl, dots, motif.flower(a, b + 0.36, 8, 0.055, 0.35)])
        inner = np.maximum(np.minimum(slit, 1.0), motif.disc(a, b, 0.0, -0.36, 0.016))
        return [(outer, 1), (inner, 0), (slit - 0.022, 1)]

    return _half_drop(u, v, bouquet)


def _stripe(u: Array, v: Array) -> Figures:
    flat = 0.0 * v
    lines = np.maximum(0.012 - np.abs(np.abs(u) - 0.30), 0.012 - np.abs(np.abs(u) - 0.36))
    return [(0.20 - np.abs(u) + flat, 1), (lines + flat, 2)]


def _trellis(u: Array, v: Array) -> Figures:
    """Double lines on the slant with a knot where they cross."""
    slant = np.abs(np.abs(u) + np.abs(v) - 0.5) / np.sqrt(2.0)
    lines = np.maximum(0.010 - np.abs(slant - 0.028), -1.0)
    a, b = np.abs(u), np.abs(v)
    knot = np.maximum(motif.flower(a - 0.5, b, 4, 0.085, 0.4), motif.flower(a, b - 0.5, 4, 0.085, 0.4))
    pip = np.maximum(motif.disc(a, b, 0.5, 0.0, 0.025), motif.disc(a, b, 0.0, 0.5, 0.025))
    heart = np.maximum(motif.flower(u, v, 8, 0.075, 0.45), motif.flower(a - 0.5, b - 0.5, 8, 0.075, 0.45))
    return [(lines, 1), (knot, 1), (pip, 0), (heart, 2)]


def _ogee(u: Array, v: Array) -> Figures:
    """Bands that swing together and apart, a seed in each eye."""

    def eye(x: Array, y: Array) -> Figures:
        t = 1.0 - 4.0 * np.minimum(np.abs(y), 0.5) / 2.0
        edge = 0.25 * (1.0 + t + 0.2 * np.sin(np.pi * t)) - np.abs(x)
        band, fine = 0.020 - np.abs(edge - 0.045), 0.007 - np.abs(edge - 0.095)
        seed = motif.lens(x, y, 0.0, 0.0, np.pi / 2, 0.34, 0.15)
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


def _gingham(u: Array, v: Array) -> Figures:
    return [(0.25 - np.abs(u) + 0.0 * v, 1), (0.25 - np.abs(v) + 0.0 * u, 1)]


def _scallop(u: Array, v: Array) -> Figures:
    found: Figures = []
    for row in range(-1, 4):
        far = np.hypot(np.mod(u + 0.5 * (row % 2) + 0.5, 1.0) - 0.5, v + 0.5 - 0.5 * row)
        found += [(0.5 - far, 0), (0.020 - np.abs(far - 0.47), 1), (0.30 - far, 2)]
    return found


def _dots(u: Array, v: Array) -> Figures:
    a, b = np.abs(u), np.abs(v)
    return [(np.maximum(motif.disc(u, v, 0, 0, 0.14), motif.disc(a, b, 0.5, 0.5, 0.14)), 1)]


def _sprig(u: Array, v: Array) -> Figures:
    """A small flower on a stem, half dropped."""

    def sprig(x: Array, y: Array) -> Figures:
        stem = np.minimum(0.008 - np.abs(x - 0.05 * np.sin(6.0 * y)), np.minimum(0.30 - y, y + 0.05))
        places = ((0.08, 0.17, -0.7, 0.17, 0.06), (-0.06, 0.24, -2.3, 0.15, 0.055), (-0.07, 0.11, -2.5, 0.12, 0.045))
        leaves = np.maximum.reduce([motif.lens(x, y, *place) for place in places])
        bud = np.maximum(motif.disc(x, y, 0.15, -0.02, 0.03), motif.disc(x, y, -0.14, 0.03, 0.024))
        bloom = motif.flower(x, y + 0.13, 5, 0.12, 0.42, np.pi / 2)
        return [(np.maximum(stem, leaves), 1), (np.maximum(bloom, bud), 2), (motif.disc(x, y, 0.0, -0.13, 0.032), 3)]

    return _half_drop(u, v, sprig)


def _arches(u: Array, v: Array) -> Figures:
    """Rainbows side by side, every other row half an arch on."""
    found: Figures = []
    for row in range(-1, 3):
        x = np.mod(u + 0.5 * (row % 2) + 0.5, 1.0) - 0.5
        y = v + 0.5 - 0.5 * row
        far = np.where(y < 0.0, np.hypot(x, y), np.abs(x))
        inside = np.minimum(0.47 - far, 0.5 - y)
        found += [(inside, 0), (np.minimum(0.042 - np.abs(np.mod(far + 0.02, 0.15) - 0.075), inside), 1 + row % 2)]
    return found


REPEATS: dict[str, Callable[[Array, Array], Figures]] = {
    maker.__name__.removeprefix("_"): maker
    for maker in (_damask, _stripe, _trellis, _ogee, _fans, _gingham, _scallop, _dots, _sprig, _arches)
}


Inks = Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=8)]


EMBOSS_M = 0.00006  # how far inks are raised


class PrintedPaper(Record):
    """Paper with a printed repeat."""

    ground: HexColor = Field(description="of the paper")
    inks: Inks = Field(description="numbered by the repeat from 1")
    repeat: PaperRepeat = Field(description="what is on it")
    width_m: float = Field(0.2, gt=0.01, le=1, description="of one repeat")
    height_m: float = Field(0.2, gt=0.01, le=1, description="of one repeat")
    opacity: Share = Field(0.95, description="how opaque the inks are")
    sheen: Share = Field(0.1, description="how much glossier inks are")
    roughness: float = Field(0.8, ge=0.05, le=0.98, description="of the paper")


class FoliagePaper(Record):
    """Paper with plants all over."""

    ground: HexColor = Field(description="of the paper")
    inks: Inks = Field(description="of the plants")
    growth: FoliageKind = Field(description="what grows on it")
    size_m: float = Field(0.2, gt=0.02, le=1, description="length of a leaf or twig")
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.8


# On the paper: GRASS level blades, uneven, on fine upright threads; RAFFIA a basket weave of flat strips.
PaperWeave = StrEnum("PaperWeave", "GRASS LINEN RAFFIA")


class WovenPaper(Record):
    """A woven wall covering."""

    colors: Inks = Field(description="of the blades or threads")
    ground: HexColor = Field(description="what is seen between them")
    weave: PaperWeave
    thread_m: float = Field(0.003, gt=0.001, le=0.03, description="width of a blade or thread")
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.85


def paint_printed(params: PrintedPaper, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one stretch of paper."""
    x, y = canvas.axes()
    _, wide = whole(canvas.tile_m[0], params.width_m)
    _, tall = whole(canvas.tile_m[1], params.height_m)
    u, v = np.mod(x / wide, 1.0) - 0.5 + 0.0 * y, np.mod(y / tall, 1.0) - 0.5 + 0.0 * x
    colors = [rgb(params.ground), *(rgb(c) for c in params.inks)]
    albedo: Map = np.broadcast_to(colors[0], (*canvas.size_px, 3))
    inked = np.zeros(canvas.size_px, dtype=np.float32)
    cover = 0.5 if params.repeat == "gingham" else params.opacity
    dry = np.clip(1.0 - 0.12 * np.maximum(canvas.noise(0.005, 0.005, rng, 2), 0.0), 0.0, 1.0)
    for depth, number in REPEATS[params.repeat](u, v):
        share = motif.ink(depth, canvas.pixel_m / wide)
        if number:
            share = share * cover * dry
            albedo = blend(albedo, colors[1 + (number - 1) % len(params.inks)], share)
            inked = np.maximum(inked, share)
        else:
            albedo = blend(albedo, colors[0], share)
            inked = inked * (1.0 - share)
    height, gloss = inked * np.float32(EMBOSS_M), params.roughness - 0.4 * params.sheen * inked
    return _paper(albedo, height, gloss, canvas, rng)


def paint_foliage(params: FoliagePaper, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one stretch of paper."""
    albedo = motif.scatter(canvas, params.growth, params.size_m, rgb_table(params.inks), rgb(params.ground), rng)
    wash = 1.0 + 0.012 * canvas.noise(0.03, 0.03, rng, 4)
    flat = np.zeros(canvas.size_px, dtype=np.float32)
    return _paper(albedo * wash[..., None], flat, params.roughness + flat, canvas, rng)


def _paper(albedo: Map, height: Map, gloss: Map, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """The tooth of the paper under the print."""
    tooth = canvas.resolved(0.003, 0.003) * canvas.noise(0.003, 0.003, rng) + 0.4 * canvas.noise(0.012, 0.012, rng, 2)
    albedo = albedo * (1.0 + 0.012 * tooth + 0.01 * canvas.noise(0.4, 0.4, rng, 2))[..., None]
    return Layers.of(albedo, height + 0.00003 * tooth, gloss + 0.01 * tooth)


def paint_woven(params: WovenPaper, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one stretch of cloth."""
    size = params.thread_m
    if params.weave is PaperWeave.RAFFIA:
        pick, height, open_ = _raffia(size, canvas, rng)
    elif params.weave is PaperWeave.GRASS:
        pick = 0.8 * canvas.noise(size, 0.7, rng) + 0.6 * canvas.noise(2.6 * size, 0.9, rng)
        pick = pick + 0.5 * canvas.noise(size, 0.12, rng)
        height = 0.0002 * pick
        upright = canvas.noise(0.5, 1.6 * size, rng) * canvas.resolved(1.0, size)
        open_ = 0.45 * smoothstep(0.9, 2.2, -canvas.noise(0.8 * size, 0.4, rng)) + 0.10 * smoothstep(0.8, 1.6, upright)
    else:
        warp = canvas.noise(0.4, size, rng) + 0.4 * canvas.noise(0.06, 1.3 * size, rng)
        weft = canvas.noise(size, 0.4, rng) + 0.4 * canvas.noise(1.3 * size, 0.06, rng)
        pick, height = 0.7 * (warp + weft), np.asarray(0.00012 * np.maximum(warp, weft))
        open_ = 0.35 * smoothstep(0.4, 1.8, -np.maximum(warp, weft))
    colors = rgb_table(params.colors)
    at = np.clip((0.5 + 0.24 * pick) * (len(colors) - 1), 0.0, len(colors) - 1.0)
    low = np.minimum(at.astype(np.intp), max(0, len(colors) - 2))
    share = (at - low)[..., None]
    albedo = colors[low] * (1.0 - share) + colors[np.minimum(low + 1, len(colors) - 1)] * share
    albedo = albedo * (1.0 + 0.03 * pick)[..., None]
    albedo = blend(albedo, rgb(params.ground), np.clip(open_, 0, 1))
    return Layers.of(albedo, height - 0.0003 * open_, params.roughness + 0.05 * open_)


def _raffia(size: float, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Flat strips over and under: tone, height in metres, and the holes between."""
    x, y = canvas.axes()
    columns, wide = whole(canvas.tile_m[0], size, even=True)
    rows, tall = whole(canvas.tile_m[1], size, even=True)
    column, row = (x / wide).astype(np.intp) % columns, (y / tall).astype(np.intp) % rows
    a, b = np.mod(x / wide, 1.0) - 0.5, np.mod(y / tall, 1.0) - 0.5
    upright = (column + row) % 2 == 0
    across, along = np.where(upright, a + 0 * b, b + 0 * a), np.where(upright, b + 0 * a, a + 0 * b)
    arch = np.cos(np.pi * along)
    tone = rng.normal(0.0, 1.0, columns).astype(np.float32)[column] * upright
    tone = tone + rng.normal(0.0, 1.0, rows).astype(np.float32)[row] * ~upright
    fibre = np.where(upright, canvas.noise(0.2, 0.25 * size, rng), canvas.noise(0.25 * size, 0.2, rng))
    hole = smoothstep(0.40, 0.5, np.abs(across)) * (1.0 - 0.6 * arch)
    height = np.asarray(0.12 * size * arch * (1.0 - np.abs(across)) + 0.00003 * fibre)
    return np.asarray(0.5 * tone + 0.35 * fibre + 0.5 * (arch - 0.6)), height, np.asarray(0.9 * hole)


PRINTED = TextureKind("printed_paper", PrintedPaper, paint_printed)
FOLIAGE = TextureKind("foliage_paper", FoliagePaper, paint_foliage)
WOVEN = TextureKind("woven_paper", WovenPaper, paint_woven)


# Tool or material of the plaster: ROLLER orange peel of a paint roller; SKIP_TROWEL thin patches of mud with smooth
# ground between; VENETIAN many thin coats, polished: strokes that overlap; LIMEWASH brushed crosswise, cloudy; TADELAKT
# soaped lime, burnished with a stone; STUCCO thrown on; COMBED level grooves; CLAY earth with straw.
PlasterFinish = StrEnum("PlasterFinish", "ROLLER SAND SKIP_TROWEL VENETIAN LIMEWASH TADELAKT STUCCO COMBED CLAY")


class Plaster(Record):
    """A plastered wall."""

    color: HexColor = Field(description="in the middle of its range")
    second: HexColor = Field(description="of its clouds or strokes")
    technique: PlasterFinish = Field(PlasterFinish.ROLLER, description="how it was put on")
    strength: Share = Field(0.5, description="how plain the technique is to see in colour")
    relief: Share = Field(0.5, description="the same in depth")
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.8


# Share of the second colour about 0, depth in metres, change of roughness.
_Parts = tuple[Map, Map, Map]


def paint_plaster(params: Plaster, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one wall."""
    share, depth, gloss = _HANDS[params.technique](canvas, rng)
    albedo = blend(rgb(params.color), rgb(params.second), np.clip(params.strength * share, -0.6, 1.0))
    return Layers.of(albedo, params.relief * depth, np.clip(params.roughness + gloss, 0.05, 1))


def _roller(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    peel = canvas.noise(0.006, 0.006, rng) * canvas.resolved(0.004, 0.004) + 0.5 * canvas.noise(0.013, 0.013, rng)
    lap = canvas.noise(0.9, 0.24, rng, 2)
    return 0.35 * lap + 0.14 * peel, np.asarray(0.00022 * peel), 0.012 * lap


def _sand(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    grains = canvas.resolved(0.004, 0.004) * np.maximum(canvas.noise(0.0035, 0.0035, rng), -0.5)
    grains = grains + 0.6 * canvas.noise(0.008, 0.008, rng, 2)
    float_ = canvas.noise(0.25, 0.25, rng, 4)
    return 0.3 * float_ + 0.25 * grains, np.asarray(0.0006 * grains + 0.0006 * float_), 0.02 * grains


def _skip_trowel(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    field = canvas.noise(0.06, 0.15, rng, 5) + 0.5 * canvas.noise(0.16, 0.2, rng, 3)
    mud = smoothstep(0.0, 0.28, field) * (0.75 + 0.25 * smoothstep(-1.5, 1.5, canvas.noise(0.1, 0.1, rng, 3)))
    second = smoothstep(0.5, 0.75, canvas.noise(0.09, 0.12, rng, 5))
    drag = canvas.noise(0.004, 0.09, rng) * mud
    return 0.55 * mud + 0.3 * second - 0.35, np.asarray(0.0016 * mud + 0.0008 * second + 0.0001 * drag), -0.03 * mud


def _venetian(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Coat over coat of short strokes, each with one clean edge."""
    total = np.zeros(canvas.size_px, dtype=np.float32)
    for size in (0.34, 0.24, 0.17, 0.12):
        first, second, owner = worley(canvas.size_px, canvas.cells(0.7 * size, size), rng)
        tone = rng.normal(0.0, 1.0, int(owner.max()) + 1).astype(np.float32)[owner]
        stroke = tone * smoothstep(0.0, 0.5, second - first)
        bend = 0.35 * size
        dx, dy = bend * canvas.noise(size, size, rng), 0.6 * bend * canvas.noise(0.8 * size, size, rng)
        total += canvas.shifted(np.asarray(stroke), dx, dy)
    cloud = standardize(total) + 0.7 * canvas.noise(0.5, 0.5, rng, 4)
    share = 0.55 * cloud + 0.12 * canvas.noise(0.02, 0.2, rng, 3)
    return share, np.asarray(0.00005 * cloud), -0.05 * np.clip(cloud, -1, 1)


def _limewash(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    one = canvas.noise(0.012, 0.22, rng, 2)
    other = canvas.noise(0.22, 0.012, rng, 2)
    bend = 0.009 * canvas.noise(0.3, 0.3, rng, 2)
    one, other = canvas.shifted(one, bend, bend), canvas.shifted(other, bend, -bend)
    cross = other + (one - other) * smoothstep(-0.9, 0.9, canvas.noise(0.22, 0.22, rng, 4))
    cloud = 0.7 * canvas.noise(0.5, 0.5, rng, 6) + 0.6 * canvas.noise(0.2, 0.25, rng, 5)
    return 0.45 * cloud + 0.17 * cross, np.asarray(0.0001 * cross), 0.01 * cloud


def _tadelakt(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = 0.8 * canvas.noise(0.35, 0.35, rng, 6) + 0.5 * canvas.noise(0.07, 0.09, rng, 4)
    stone = canvas.noise(0.035, 0.05, rng, 2)
    pit = smoothstep(2.2, 2.8, canvas.noise(0.007, 0.007, rng) + 0.6 * cloud)
    depth = np.asarray(0.0003 * stone + 0.0005 * cloud - 0.0006 * pit)
    return 0.55 * cloud + 0.1 * stone + 0.7 * pit, depth, 0.06 * cloud


def _stucco(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    blobs = ridged(canvas.size_px, canvas.cells(0.03, 0.035), rng, 2) - 0.5
    lumps = np.abs(canvas.noise(0.022, 0.022, rng)) + 0.6 * np.abs(canvas.noise(0.011, 0.011, rng)) - 1.0
    mask = smoothstep(-0.7, 0.8, canvas.noise(0.08, 0.08, rng, 2))
    return 0.35 * lumps - 0.2, np.asarray(0.0022 * (mask * (lumps + blobs)) + 0.0006 * lumps), 0.02 * lumps


def _combed(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    _, y = canvas.axes()
    count = max(1, round(canvas.tile_m[1] / 0.009))
    wander = 0.0022 * canvas.noise(0.2, 0.5, rng) + 0.0006 * canvas.noise(0.02, 0.06, rng, 2)
    groove = np.cos(2 * np.pi * count / canvas.tile_m[1] * (y + wander)) * canvas.resolved(0.0045, 1.0)
    crumb = canvas.noise(0.006, 0.01, rng, 2)
    return np.asarray(0.35 * groove + 0.16 * crumb), np.asarray(0.0011 * groove + 0.0002 * crumb), 0.02 * crumb


def _clay(canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = canvas.noise(0.4, 0.4, rng, 5)
    grain = canvas.noise(0.005, 0.005, rng, 2)
    straw = np.zeros(canvas.size_px, dtype=np.float32)
    for along, across in ((0.003, 0.028), (0.028, 0.003), (0.010, 0.014)):
        fibre = canvas.noise(along, across, rng)
        bend = 0.012 * canvas.noise(0.05, 0.05, rng)
        fibre = canvas.shifted(fibre, bend, -bend) * canvas.resolved(0.003, 0.003)
        straw = np.maximum(straw, smoothstep(1.5, 2.1, fibre))
    depth = np.asarray(0.0005 * cloud + 0.0002 * grain + 0.0003 * straw)
    return 0.35 * cloud + 0.15 * grain - 1.1 * straw, depth, 0.0 * straw


_HANDS: dict[PlasterFinish, Callable[[Canvas, np.random.Generator], _Parts]] = {
    PlasterFinish(maker.__name__.removeprefix("_")): maker
    for maker in (_roller, _sand, _skip_trowel, _venetian, _limewash, _tadelakt, _stucco, _combed, _clay)
}

PLASTER = TextureKind("plaster", Plaster, paint_plaster)
