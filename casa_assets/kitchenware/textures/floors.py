"""Floors: linoleum, rubber, cork, vinyl, wood; tiles of pressed cement and of stone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Canvas,
    Joint,
    Layers,
    Laying,
    LayingPattern,
    Map,
    SawCut,
    Share,
    Slab,
    TextureKind,
    TileEdge,
    WoodPalette,
    WoodSpecies,
    blend,
    fill,
    inlay,
    lay,
    rgb,
    rgb_table,
    rim,
    slab_canvas,
    smoothstep,
    stratified,
    whole,
    wood,
    worley,
)
from casa_assets.kitchenware.textures.motif import DESIGNS, TileDesign, ink
from casa_assets.kitchenware.textures.stone import (
    BandedStone,
    Granite,
    MadeStone,
    VeinedStone,
    paint_flow,
    paint_granite,
    paint_speckled,
    paint_veined,
)

# Material of the sheet: MARBLED linoleum, streaks of several colours, drawn along v; FLECKED crumbs of other colours in
# rubber; STUDDED round studs; WOVEN vinyl yarns over and under; TREAD raised bars in pairs, as on plate.
ResilientSort = StrEnum("ResilientSort", "MARBLED FLECKED STUDDED CORK WOVEN TREAD")


class ResilientFloor(Record):
    """A soft floor."""

    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=8, description="the ground, then the rest")
    material: ResilientSort = Field(description="of the sheet")
    laying: Laying | None = Field(None, description="of tiles; marbled ones alternate in direction; None: a sheet")
    joint: Joint = Joint(color="#4c4a46", width_m=0.001, depth_m=0.0004)
    grain_m: float = Field(0.02, gt=0.001, le=0.2, description="size of streaks, crumbs, studs or yarns")
    strength: Share = Field(0.6, description="how clearly the other colours show")
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.55


def paint_resilient(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one floor."""
    albedo, height, gloss = _SORTS[params.material](params, canvas, rng)
    face = Layers.of(albedo, height, params.roughness + gloss)
    if params.laying is None:
        return face
    pieces = lay(params.laying, canvas, rng)
    if params.material is not ResilientSort.STUDDED:
        jump = rng.random((2, pieces.count)).astype(np.float32)
        dx, dy = (jump * np.array(canvas.tile_m, dtype=np.float32)[:, None])[:, pieces.owner]
        at_x, at_y = pieces.u_m + dx - canvas.axes()[0], pieces.v_m + dy - canvas.axes()[1]
        tone = pieces.read(stratified(pieces.count, rng))
        planes = [canvas.shifted(face.albedo[..., n], at_x, at_y) * (1.0 + 0.04 * tone) for n in range(3)]
        relief, gloss = (canvas.shifted(plane, at_x, at_y) for plane in (face.height_m, face.roughness))
        face = Layers.of(np.stack(planes, axis=2), relief, gloss)
    return fill(face, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


_Parts = tuple[Map, Map, Map]


def _marbled(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    size = params.grain_m
    albedo: Map = np.broadcast_to(rgb(params.colors[0]), (*canvas.size_px, 3))
    bend = 0.7 * size * canvas.noise(6 * size, 3 * size, rng, 2)
    for color in params.colors[1:]:
        streak = canvas.noise(4.0 * size, 0.45 * size, rng, 3) + 0.6 * canvas.noise(1.2 * size, 0.3 * size, rng, 2)
        albedo = blend(albedo, rgb(color), params.strength * smoothstep(0.1, 1.9, canvas.shifted(streak, bend)))
    crumb = canvas.noise(0.004, 0.003, rng, 2)
    return albedo * (1.0 + 0.015 * crumb)[..., None], 0.000005 * crumb, 0.02 * crumb


def _flecked(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    albedo: Map = rgb(params.colors[0]) * (1.0 + 0.015 * canvas.noise(0.3, 0.3, rng, 3))[..., None]
    for n, color in enumerate(params.colors[1:]):
        size = params.grain_m * (1.0 - 0.18 * n)
        first, second, owner = worley(canvas.size_px, canvas.cells(size, size), rng, 0.95)
        lot = rng.random((2, int(owner.max()) + 1)).astype(np.float32)
        reach = 0.14 + 0.28 * lot[0][owner]
        crumb = smoothstep(reach, reach - 0.10, first) * (lot[1][owner] < 0.55) * smoothstep(0.0, 0.12, second - first)
        albedo = blend(albedo, rgb(color), params.strength * crumb)
    peel = canvas.noise(0.005, 0.005, rng, 2)
    return albedo, 0.00003 * peel, 0.02 * peel


def _studded(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Round studs with flat tops in a square net."""
    x, y = canvas.axes()
    pixel = canvas.pixel_width_m
    _, wide = whole(canvas.tile_m[0], params.grain_m)
    _, tall = whole(canvas.tile_m[1], params.grain_m)
    far = np.hypot((np.mod(x / wide, 1.0) - 0.5) * wide, (np.mod(y / tall, 1.0) - 0.5) * tall)
    radius = 0.40 * params.grain_m
    rise = np.clip((radius - far) / max(0.0015, pixel) + 0.5, 0.0, 1.0)
    scuff = canvas.noise(0.12, 0.12, rng, 5)
    top, ground = rgb(params.colors[-1]), rgb(params.colors[0])
    albedo = blend(ground, top, rise)
    foot = np.exp(-((far - radius - 0.0012) ** 2) / (2.0 * max(0.0014, 0.7 * pixel) ** 2))
    albedo = albedo * (1.0 - 0.30 * foot + 0.02 * scuff)[..., None]
    return albedo, np.asarray(0.0011 * rise + 0.00001 * canvas.noise(0.004, 0.004, rng)), -0.06 * rise + 0.03 * scuff


def _cork(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Granules of bark pressed together, with dark crumbs between."""
    size = params.grain_m
    albedo: Map = np.broadcast_to(rgb(params.colors[0]), (*canvas.size_px, 3))
    colors = rgb_table(params.colors)
    height = np.zeros(canvas.size_px, dtype=np.float32)
    for scale in (1.0, 0.5):
        first, second, owner = worley(canvas.size_px, canvas.cells(scale * size, scale * size), rng, 0.95)
        count = int(owner.max()) + 1
        pick = rng.integers(0, len(colors), count)
        tone = rng.normal(0.0, 1.0, count).clip(-2, 2).astype(np.float32)
        bend = 0.25 * scale * size
        granule = colors[pick][owner] * (1.0 + 0.10 * tone[owner])[..., None]
        edge = smoothstep(0.02, 0.14, second - first)
        share = (edge if scale < 1 else np.ones_like(edge)) * (1.0 if scale == 1 else (rng.random(count) < 0.45)[owner])
        dx, dy = bend * canvas.noise(size, size, rng), bend * canvas.noise(size, size, rng)
        share = canvas.shifted(np.asarray(share, dtype=np.float32), dx, dy)
        granule = np.stack([canvas.shifted(granule[..., n], dx, dy) for n in range(3)], axis=2)
        albedo = blend(albedo, granule, params.strength * share)
        height = height + np.float32(0.00008 * scale) * canvas.shifted(edge, dx, dy)
    lenticel = smoothstep(2.0, 2.5, canvas.noise(0.5 * size, 0.16 * size, rng) + 0.5 * canvas.noise(0.2, 0.2, rng))
    albedo = albedo * (1.0 - 0.45 * lenticel + 0.02 * canvas.noise(0.003, 0.003, rng))[..., None]
    return albedo, height - 0.0003 * lenticel, 0.1 * lenticel


def _woven(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Round yarns, two over and two under, so that slanting ribs appear."""
    x, y = canvas.axes()
    columns, wide = whole(canvas.tile_m[0], params.grain_m)
    rows, tall = whole(canvas.tile_m[1], params.grain_m)
    column, row = (x / wide).astype(np.intp) % columns, (y / tall).astype(np.intp) % rows
    upright = (column + row) % 4 < 2
    across = np.where(upright, np.mod(x / wide, 1.0) - 0.5 + 0 * y, np.mod(y / tall, 1.0) - 0.5 + 0 * x)
    yarn = np.sqrt(np.clip(1.0 - (2.0 * across) ** 2, 0.0, 1.0)) * canvas.resolved(params.grain_m, params.grain_m)
    colors = rgb_table(params.colors)
    warp, weft = colors[rng.integers(0, len(colors), columns)][column], colors[rng.integers(0, len(colors), rows)][row]
    albedo = np.where(upright[..., None], warp, weft) * (0.78 + 0.22 * yarn)[..., None]
    return np.asarray(albedo), np.asarray(0.2 * params.grain_m * yarn), np.asarray(-0.05 * yarn)


def _tread(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Raised lozenges, each at right angles to its neighbours."""
    x, y = canvas.axes()
    columns, wide = whole(canvas.tile_m[0], params.grain_m, even=True)
    rows, tall = whole(canvas.tile_m[1], params.grain_m, even=True)
    turned = ((x / wide).astype(np.intp) % columns + (y / tall).astype(np.intp) % rows) % 2 == 0
    a, b = np.mod(x / wide, 1.0) - 0.5, np.mod(y / tall, 1.0) - 0.5
    s, t = (a + b) / np.sqrt(2.0), (a - b) / np.sqrt(2.0)
    long, short = np.where(turned, s, t), np.where(turned, t, s)
    rise = np.clip((0.11 * (1.0 - (long / 0.5) ** 2) - np.abs(short)) / 0.05, 0.0, 1.0)
    scuff = canvas.noise(0.1, 0.1, rng, 5)
    ground, top = rgb(params.colors[0]), rgb(params.colors[-1])
    albedo = (blend(ground, top, params.strength * rise)) * (1.0 + 0.025 * scuff)[..., None]
    return albedo, np.asarray(0.0016 * rise), -0.08 * rise + 0.04 * scuff


_SORTS: dict[ResilientSort, Callable[[ResilientFloor, Canvas, np.random.Generator], _Parts]] = {
    ResilientSort(maker.__name__.removeprefix("_")): maker
    for maker in (_marbled, _flecked, _studded, _cork, _woven, _tread)
}

RESILIENT = TextureKind("resilient_floor", ResilientFloor, paint_resilient)


_SLAB_LONG_M = 1.6
_SHORTEST_SLAB_M = 0.12


class TimberFloor(Record):
    """A wooden floor."""

    laying: Laying
    joint: Joint = Joint(
        color="#2a2019", width_m=0.001, depth_m=0.0012, edge=TileEdge.BEVEL, edge_width_m=0.0015, rim_drop_m=0.0006
    )
    species: WoodSpecies
    palette: WoodPalette
    saw_cuts: tuple[SawCut, ...] = Field(
        (SawCut.FLAT, SawCut.FLAT, SawCut.RIFT), min_length=1, max_length=4, description="in equal parts"
    )
    variety: Share = Field(0.4, description="how much boards differ in tone")
    warmth: Share = Field(0.3, description="how much boards differ in hue")
    scraping_m: float = Field(0.0, ge=0, le=0.003, description="depth of the hollows that a scraper left")
    saw_marks: Share = Field(0.0, description="strength of marks of the saw across the boards")
    wear: Share = Field(0.0, description="how much dirt and light have marked it")


def paint_timber(params: TimberFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of boards."""
    pieces = lay(params.laying, canvas, rng)
    # Boards cut from a few sawn faces, each at a different place of its face.
    wide = 2.0 * float(pieces.half_m[:, 0].max())
    slabs, roots = [], []
    for n, cut in enumerate(params.saw_cuts):
        # A flat-cut face has its heart in the middle and a joint at its border: boards keep clear of it.
        room = max(_SHORTEST_SLAB_M, 1.35 * wide if cut is SawCut.FLAT else 2.5 * wide)
        tile_m = (room, _SLAB_LONG_M * (1.0 + 0.11 * n))
        slabs.append(Slab(wood.board(slab_canvas(canvas, tile_m), params.species, cut, params.palette, rng), tile_m))
        roots.append(0.5 * room if cut is SawCut.FLAT else 0.0)
    pick = rng.permutation(np.arange(pieces.count) % len(slabs))
    rooms = np.array([s.tile_m[0] for s in slabs])[pick]
    free = np.maximum(rooms - 2.0 * pieces.half_m[:, 0], 0.0) / 2.0
    flat = np.array(roots)[pick]
    stray = np.where(flat > 0, free, rooms / 2.0) * rng.uniform(-1.0, 1.0, pieces.count)
    down = rng.permutation(np.arange(pieces.count)) * 0.6180339887 % 1.0 * _SLAB_LONG_M  # places that keep apart
    mirrored = rng.permutation(np.arange(pieces.count) % 2) * 2.0 - 1.0
    face = inlay(pieces, tuple(slabs), pick, flat + stray, down, mirrored)
    tone = pieces.read(stratified(pieces.count, rng))
    warm = pieces.read(stratified(pieces.count, rng))
    hue = np.stack([1.0 + 0.03 * params.warmth * warm, np.ones_like(warm), 1.0 - 0.07 * params.warmth * warm], axis=2)
    albedo = face.albedo * hue * (1.0 + 0.26 * params.variety * tone)[..., None]
    height: Map = face.height_m
    roughness: Map = face.roughness
    if params.scraping_m > 0:
        hollow = canvas.noise(0.22, 0.22, rng) + 0.6 * pieces.u_m / pieces.read(pieces.half_m[:, 0])
        height = height + np.float32(0.4 * params.scraping_m) * hollow
    if params.saw_marks > 0:
        phase = pieces.read(rng.uniform(0.0, 1.0, pieces.count))
        lines = np.sin(2 * np.pi * (pieces.v_m + 0.6 * pieces.u_m**2 / 0.1) / 0.006 + 20.0 * phase)
        lines = lines * canvas.resolved(0.003, 1.0) * smoothstep(-0.2, 1.6, canvas.noise(0.2, 0.1, rng, 2) + 1.5 * tone)
        albedo = albedo * (1.0 - 0.09 * params.saw_marks * np.maximum(lines, -0.4))[..., None]
        height = height - np.float32(0.00015 * params.saw_marks) * lines
    if params.wear > 0:
        dirt = smoothstep(-0.4, 2.2, canvas.noise(0.25, 0.25, rng, 5))
        rims = np.exp(-np.maximum(pieces.inside_m, 0.0) / 0.006)
        albedo = albedo * (1.0 - params.wear * (0.22 * dirt + 0.3 * rims))[..., None]
        roughness = roughness + 0.12 * params.wear * dirt
    return fill(Layers.of(albedo, height, roughness), params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


class EndGrainFloor(Record):
    """Blocks that show the end of the trunk."""

    laying: Laying
    joint: Joint = Joint(color="#3a2a1c", width_m=0.0015, depth_m=0.001)
    species: WoodSpecies = Field(description="pores are dots here")
    palette: WoodPalette
    variety: Share = Field(0.5, description="how much blocks differ")


def paint_ends(params: EndGrainFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of blocks: arcs of rings, about a different pith in each block."""
    pieces = lay(params.laying, canvas, rng)
    wide = float(pieces.half_m.max())
    angle = rng.uniform(0.0, 2 * np.pi, pieces.count)
    far = wide * rng.uniform(0.3, 3.2, pieces.count)
    pu, pv = (far * np.cos(angle)).astype(np.float32), (far * np.sin(angle)).astype(np.float32)
    radius = np.hypot(pieces.u_m - pu[pieces.owner], pieces.v_m - pv[pieces.owner])
    radius = radius + 0.0012 * canvas.noise(0.03, 0.03, rng, 3)
    part = np.mod(radius / params.species.ring_m + pieces.read(rng.random(pieces.count)), 1.0)
    seen = np.float32(min(1.0, 0.5 * params.species.ring_m / canvas.pixel_m))
    ring = 0.4 + (smoothstep(0.2, 0.9, part) * (1.0 - smoothstep(0.94, 1.0, part)) - 0.4) * seen
    tone = pieces.read(stratified(pieces.count, rng))
    # Mask 0..1: cracks that run out from the pith of some blocks.
    bearing = np.arctan2(pieces.v_m - pv[pieces.owner], pieces.u_m - pu[pieces.owner])
    crack = pieces.read(rng.uniform(-np.pi, np.pi, pieces.count))
    has = pieces.read(rng.random(pieces.count) < 0.35)
    off = np.abs(np.mod(bearing - crack + np.pi, 2 * np.pi) - np.pi + 0.02 * canvas.noise(0.03, 0.03, rng, 2))
    check = np.asarray(has * np.clip(1.2 - off / 0.03, 0.0, 1.0), dtype=np.float32)
    light, dark = rgb(params.palette.light), rgb(params.palette.dark)
    fibre = canvas.resolved(0.002, 0.002) * canvas.noise(0.002, 0.002, rng)
    mix = np.clip(params.species.contrast * ring + 0.35 * params.variety * tone + 0.045 * fibre + 0.2, 0.0, 1.0)
    face = Layers(
        (blend(light, dark, mix) * (1.0 - 0.5 * check)[..., None]).astype(np.float32),
        np.asarray(0.00006 * ring - 0.0008 * check, dtype=np.float32),
        np.asarray(params.palette.roughness + 0.1 * ring + 0.2 * check, dtype=np.float32),
    )
    return fill(face, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


TIMBER = TextureKind("timber", TimberFloor, paint_timber)
END_GRAIN = TextureKind("end_grain_block", EndGrainFloor, paint_ends)


class Encaustic(Record):
    """Patterned tiles, all laid the same way."""

    design: TileDesign = Field(description="what is on a tile")
    colors: tuple[HexColor, ...] = Field(
        min_length=2, max_length=6, description="the ground, then the inks by their numbers"
    )
    side_m: float = Field(0.2, gt=0.05, le=0.6, description="of a tile")
    joint: Joint = Joint(width_m=0.0015, depth_m=0.0004, color="#b9b4aa", rim_drop_m=0.0002)
    bleed: Share = Field(0.3, description="how far colours run into each other")
    wear: Share = Field(0.3, description="how far feet have paled the colours")
    variety: Share = Field(0.25, description="how much tiles differ")
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.55


def paint_encaustic(params: Encaustic, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of tiles."""
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=params.side_m, length_m=params.side_m, upright=True)
    pieces = lay(laying, canvas, rng)
    side = np.float32(2.0 * pieces.half_m[0, 0])
    shake = np.float32(0.0007 * params.bleed)  # the divider is pulled out by hand
    u = (pieces.u_m + shake * canvas.noise(0.012, 0.012, rng, 2)) / side
    v = (pieces.v_m + shake * canvas.noise(0.012, 0.012, rng, 2)) / side
    soft = (canvas.pixel_m + 0.0008 * params.bleed) / float(side)
    colors = [rgb(c) for c in params.colors]
    albedo: Map = np.broadcast_to(colors[0], (*canvas.size_px, 3))
    mottle = canvas.noise(0.05, 0.05, rng, 5)
    for depth, number in DESIGNS[params.design](u, v):
        albedo = albedo + (colors[number % len(colors)] - albedo) * ink(np.asarray(depth), soft)[..., None]
    tone = pieces.read(stratified(pieces.count, rng))
    grain = canvas.noise(0.004, 0.004, rng, 2)
    shade = 1.0 + 0.12 * params.variety * tone + 0.035 * mottle + 0.012 * grain
    pale = albedo.mean(axis=2, keepdims=True) * 0.5 + 0.36
    feet = params.wear * 0.35 * smoothstep(-0.6, 2.0, canvas.noise(0.3, 0.3, rng, 4) + 0.4 * mottle)
    albedo = (blend(albedo, pale, feet)) * shade[..., None]
    face = Layers(
        np.clip(albedo, 0, 1).astype(np.float32),
        (0.00002 * grain + 0.00003 * mottle).astype(np.float32),
        (params.roughness + 0.05 * mottle + 0.1 * feet).astype(np.float32),
    )
    return fill(face, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


ENCAUSTIC = TextureKind("cement_tile", Encaustic, paint_encaustic)


class StoneTile(Record):
    """Parameters common to tiles of any stone."""

    laying: Laying
    joint: Joint = Joint(width_m=0.002, depth_m=0.0006)
    variety: Share = Field(0.3, description="how much pieces differ in tone")
    warmth: Share = Field(0.2, description="how much they differ in hue")
    turned: bool = Field(True, description="pieces are laid with their grain in all directions")
    cleft_m: float = Field(0.0, ge=0, le=0.01, description="relief of a split face")
    protrusion_m: float = Field(0.0, ge=0, le=0.02, description="standard deviation of how far pieces protrude")
    slab_m: float = Field(1.6, ge=0.4, le=3, description="side of the slab that pieces are cut from")


class MarbleTile(StoneTile):
    """Marble and its like; `stone` is its slab, `accent` that of every other sort of piece where there is one."""

    stone: VeinedStone
    accent: VeinedStone | None = None


class LayeredTile(StoneTile):
    """Travertine, limestone, slate."""

    stone: BandedStone
    accent: BandedStone | None = None


class GraniteTile(StoneTile):
    """Granite."""

    stone: Granite
    accent: Granite | None = None


class ChipTile(StoneTile):
    """Terrazzo and quartz in pieces."""

    stone: MadeStone
    accent: MadeStone | None = None


_PAINT_SLAB: dict[type[Record], Callable[[Any, Canvas, np.random.Generator], Layers]] = {
    VeinedStone: paint_veined,
    BandedStone: paint_flow,
    Granite: paint_granite,
    MadeStone: paint_speckled,
}


def paint_stone(
    params: MarbleTile | LayeredTile | GraniteTile | ChipTile, canvas: Canvas, rng: np.random.Generator
) -> Layers:
    """Paint one field of stone tiles."""
    size = (params.slab_m, params.slab_m)
    on = slab_canvas(canvas, size)
    stones = [stone for stone in (params.stone, params.accent) if stone is not None]
    slabs = tuple(Slab(_PAINT_SLAB[type(stone)](stone, on, rng), size) for stone in stones)
    pieces = lay(params.laying, canvas, rng)
    if isinstance(params, LayeredTile):  # the layers of the slab lie along the pieces
        pieces = replace(pieces, u_m=pieces.v_m, v_m=-pieces.u_m)
    pick = pieces.sort % len(slabs)
    at = rng.uniform(0.0, params.slab_m, (2, pieces.count))
    mirrored = rng.permutation(np.arange(pieces.count) % 2) * 2.0 - 1.0
    face = inlay(pieces, slabs, pick, at[0], at[1], mirrored if params.turned else np.ones(pieces.count))
    tone = pieces.read(stratified(pieces.count, rng))
    warm = pieces.read(stratified(pieces.count, rng)) * np.float32(params.warmth)
    hue = np.stack([1.0 + 0.035 * warm, 1.0 + 0.008 * warm, 1.0 - 0.06 * warm], axis=2)
    albedo = face.albedo * hue * (1.0 + 0.16 * params.variety * tone)[..., None]
    height: Map = face.height_m
    if params.protrusion_m > 0:
        out = rng.normal(0.0, 1.0, pieces.count).clip(-2, 2).astype(np.float32) * np.float32(params.protrusion_m)
        height = height + out[pieces.owner]
    if params.cleft_m > 0:
        height = height + np.float32(params.cleft_m) * _cleft(canvas, rng)
    laid = Layers.of(albedo, height, face.roughness)
    return fill(laid, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


def _cleft(canvas: Canvas, rng: np.random.Generator) -> Map:
    """Terraces of a split face: flat ground and short steps, about -1..1."""
    ground = canvas.noise(0.12, 0.16, rng, 5)
    steps = np.round(2.0 * ground) / 2.0
    soft = steps + 0.5 * np.tanh(6.0 * (ground - steps) * 2.0) / 2.0
    return np.asarray(0.45 * soft + 0.08 * canvas.noise(0.015, 0.015, rng, 3), dtype=np.float32)


MARBLE = TextureKind("marble_tile", MarbleTile, paint_stone)
LAYERED = TextureKind("layered_stone_tile", LayeredTile, paint_stone)
GRANITE = TextureKind("granite_tile", GraniteTile, paint_stone)
CHIPS = TextureKind("chip_tile", ChipTile, paint_stone)
