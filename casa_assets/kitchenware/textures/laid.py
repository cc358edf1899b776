"""Worktops of other matter: wooden staves, glazed tiles and lava, printed laminates, sheet metal."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Canvas,
    GrainMaps,
    Layers,
    Map,
    SawCut,
    Share,
    TextureKind,
    WoodPalette,
    WoodSpecies,
    blend,
    line_coverage,
    rgb,
    rgb_table,
    ring_maps,
    smoothstep,
    stratified,
    wood,
)
from casa_assets.kitchenware.textures.stone import voronoi_cells

Ids = npt.NDArray[np.intp]
_GLUE_M = 0.001  # as wide as a joint looks from arm's length


class ButcherBlock(Record):
    """Staves along u."""

    species: WoodSpecies
    palette: WoodPalette = Field(description="its `variety` is how much staves differ")
    cut: SawCut = SawCut.RIFT
    stave_m: float = Field(0.04, gt=0.01, lt=0.4, description="width of a stave")
    length_m: float = Field(0.5, gt=0.05, lt=4, description="of the pieces that a stave is joined from")


class EndGrain(Record):
    """Blocks standing on end."""

    species: WoodSpecies
    palette: WoodPalette
    block_m: float = Field(0.045, gt=0.01, lt=0.2, description="side of a block")
    second: WoodPalette | None = Field(None, description="palette of every other block, None if all are of one wood")
    bond: float = Field(0.5, ge=0, le=1, description="how far every other row is shifted, as a share of a block")


def paint_staves(params: ButcherBlock, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one worktop, grain along u."""
    return _glued(params, canvas.transposed, rng).transposed


def _glued(params: ButcherBlock, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """The worktop with its grain along v: every piece is read from another place of one sheet of wood."""
    face = wood.board(canvas, params.species, params.cut, params.palette.replace(variety=0.0), rng)
    # Number of the piece, metres to its edge, count of pieces. Staves upright, ends at random heights.
    x, y = canvas.axes()
    columns = max(2, round(canvas.tile_m[0] / params.stave_m))
    rows = max(1, round(canvas.tile_m[1] / params.length_m))
    pitch = canvas.tile_m[0] / columns
    column = np.minimum((x / pitch).astype(np.intp), columns - 1)
    # Ends may not come to lie beside those of the next stave: golden steps keep them apart.
    start = np.mod(np.arange(columns) * 0.618 + rng.uniform(0.0, 0.12, columns), 1.0) / rows
    ends = np.sort(np.mod(start[:, None] + (np.arange(rows) + rng.uniform(-0.22, 0.22, (columns, rows))) / rows, 1.0))
    at = np.mod(y / np.float32(canvas.tile_m[1]), 1.0)
    row = np.zeros(canvas.size_px, dtype=np.intp)
    off = np.full(canvas.size_px, np.inf, dtype=np.float32)
    for n in range(rows if rows > 1 else 0):  # a stave as long as the picture has no ends
        end = ends[:, n][column]
        row = row + (at >= end)
        off = np.minimum(off, np.abs(np.mod(at - end + 0.5, 1.0) - 0.5) * canvas.tile_m[1])
    side = np.abs(np.mod(x / pitch + 0.5, 1.0) - 0.5) * pitch
    piece, edge_m, count = np.mod(row, rows) + column * rows, np.minimum(off, side).astype(np.float32), rows * columns
    dx = rng.uniform(0.0, canvas.tile_m[0], count).astype(np.float32)[piece]
    dy = rng.uniform(0.0, canvas.tile_m[1], count).astype(np.float32)[piece]
    planes = (*np.moveaxis(face.albedo, 2, 0), face.height_m, face.roughness)
    moved = [canvas.shifted(plane, dx, dy) for plane in planes]
    # Most staves are much alike and a few stand out: a cube of the lot keeps it so. Pale ones stand out less.
    lot = stratified(count, rng)
    tones = 0.35 * lot + 0.65 * lot**3
    tones = np.where(tones < 0.0, 0.5 * tones, tones) * params.palette.variety
    tone = tones.astype(np.float32)[piece]
    albedo = np.stack(moved[:3], axis=-1)
    albedo = albedo + 0.9 * (rgb(params.palette.dark) - rgb(params.palette.light)) * tone[..., None]
    albedo = albedo * (1.0 + 0.04 * tone)[..., None]
    glue = line_coverage(edge_m, _GLUE_M, max(canvas.pixel_width_m, canvas.tile_m[1] / canvas.size_px[0]))
    albedo = blend(albedo, rgb(params.palette.heart), 0.42 * glue)
    return Layers.of(albedo, moved[3] - 0.00004 * glue, moved[4] + 0.04 * glue)


def paint_blocks(params: EndGrain, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one block worktop: years as arcs around piths that lie outside the blocks, pores as dots, rays between."""
    x, y = canvas.axes()
    rows = 2 * max(1, round(canvas.tile_m[1] / params.block_m / 2.0))
    columns = 2 * max(1, round(canvas.tile_m[0] / params.block_m / 2.0))
    tall, wide = canvas.tile_m[1] / rows, canvas.tile_m[0] / columns
    row = np.minimum((y / tall).astype(np.intp), rows - 1)
    along = x / wide + params.bond * np.mod(row, 2)
    column = np.mod(np.floor(along).astype(np.intp), columns)
    block = row * columns + column
    in_x, in_y = (np.mod(along, 1.0) - 0.5) * wide, (np.mod(y / tall, 1.0) - 0.5) * tall
    angle = rng.uniform(0.0, 2.0 * np.pi, rows * columns)
    far = rng.uniform(0.6, 3.5, rows * columns) * params.block_m
    dx = in_x - (far * np.cos(angle)).astype(np.float32)[block]
    dy = in_y - (far * np.sin(angle)).astype(np.float32)[block]
    lot = rng.uniform(0.0, canvas.tile_m[0], rows * columns).astype(np.float32)[block]
    radius = np.hypot(dx, dy) + lot + 0.0006 * canvas.noise(0.015, 0.015, rng)
    # Maps of wood seen from its end.
    ring, early, zone = ring_maps(canvas, params.species, radius.astype(np.float32), rng)
    dots = canvas.noise(0.0012, 0.0012, rng)
    zero = np.zeros_like(ring)
    fibre = 0.5 * canvas.noise(0.002, 0.002, rng) + 0.25 * np.cos(np.arctan2(dy, dx) * 160.0).astype(np.float32)
    none = dict.fromkeys(("fleck", "dash", "sheen", "knot", "tone", "joint"), zero)
    grain = GrainMaps(ring, early, fibre, zone, smoothstep(0.5, 1.6, dots), edge_m=zero + 1.0, **none)
    grain = replace(grain, tone=rng.uniform(-1.0, 1.0, rows * columns).astype(np.float32)[block])
    face = wood.finish_wood(grain, params.species, params.palette, canvas, rng)
    albedo = face.albedo
    if params.second is not None:
        other = wood.finish_wood(grain, params.species, params.second, canvas, rng)
        albedo = np.where((np.mod(row + column, 2) == 1)[..., None], other.albedo, albedo)
    edge = np.minimum(wide / 2.0 - np.abs(in_x), tall / 2.0 - np.abs(in_y))
    glue = line_coverage(edge, _GLUE_M, canvas.pixel_width_m)
    albedo = blend(albedo, rgb(params.palette.heart), 0.5 * glue)
    return Layers.of(albedo, face.height_m - 0.00004 * glue, face.roughness + 0.04 * glue)


STAVES = TextureKind("butcher_block", ButcherBlock, paint_staves)
END_GRAIN = TextureKind("end_grain", EndGrain, paint_blocks)


# How much lower the edge of a tile is than its middle.
PILLOW_M = 0.0006


class TiledCounter(Record):
    """Tiles with grout."""

    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=8, description="drawn, or in turn where `checker`")
    grout: HexColor = Field(description="colour")
    joint_m: float = Field(0.004, gt=0.0005, lt=0.03, description="width of a joint")
    width_m: float = Field(0.1, gt=0.01, lt=1, description="of a tile")
    height_m: float = Field(0.1, gt=0.01, lt=1, description="of a tile")
    bond: float = Field(0.0, ge=0, le=1, description="how far every other row is moved along")
    checker: bool = Field(False, description="colours take turns")
    unevenness: Share = Field(0.3, description="how much tiles differ, and the glaze within one")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.15


class GlazedLava(Record):
    """Enamelled lava: thick glaze that pools and crackles."""

    color: HexColor = Field(description="of the glaze")
    pool_color: HexColor = Field(description="where the glaze pools")
    crackle: Share = Field(0.4, description="how plain its net of fine cracks is")
    crackle_m: float = Field(0.02, gt=0.003, lt=0.2, description="size of a piece between cracks")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.08


# Patterns of printed laminate.
LaminatePattern = Literal["boomerang", "cracked_ice", "flecks"]


class PrintedLaminate(Record):
    """A laminate with a pattern of the middle of the last century."""

    ground: HexColor = Field(description="colour of the sheet")
    inks: tuple[HexColor, ...] = Field(min_length=1, max_length=6, description="colours of the figures")
    pattern: LaminatePattern
    size_m: float = Field(0.05, gt=0.003, lt=0.3, description="of a figure")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.35


def paint_tiles(params: TiledCounter, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of tiles."""
    x, y = canvas.axes()
    rows = max(1, round(canvas.tile_m[1] / params.height_m))
    columns = max(1, round(canvas.tile_m[0] / params.width_m))
    if params.bond > 0 or params.checker:  # two rows that differ have to close over the border
        rows, columns = rows + rows % 2, columns + (columns % 2 if params.checker else 0)
    tall, wide = canvas.tile_m[1] / rows, canvas.tile_m[0] / columns
    row = np.minimum((y / tall).astype(np.intp), rows - 1)
    along = x / wide + params.bond * np.mod(row, 2)
    column = np.mod(np.floor(along).astype(np.intp), columns)
    in_x, in_y = np.mod(along, 1.0) * wide, np.mod(y / tall, 1.0) * tall
    # Joints lie half on this tile and half on the next.
    edge = np.minimum(np.minimum(in_x, wide - in_x), np.minimum(in_y, tall - in_y)) - params.joint_m / 2.0
    tile = row * columns + column
    lot = rng.uniform(0.0, 1.0, (2, rows * columns)).astype(np.float32)
    pick = np.mod(row + column, len(params.colors)) if params.checker else (lot[0][tile] * len(params.colors))
    colors = rgb_table(params.colors)[np.asarray(pick).astype(np.intp)]
    glaze = canvas.noise(0.05, 0.05, rng, 4)
    shade = 1.0 + params.unevenness * (0.16 * (lot[1][tile] - 0.5) + 0.035 * glaze)
    rim = np.exp(-np.maximum(edge, 0.0) / 0.006)  # glaze is thinner at the edge
    albedo = colors * (shade * (1.0 - 0.06 * params.unevenness * rim))[..., None]
    sand = canvas.noise(0.0025, 0.0025, rng)
    grout = rgb(params.grout) * (1.0 + 0.03 * sand + 0.03 * canvas.noise(0.15, 0.15, rng, 2))[..., None]
    face = smoothstep(-0.0004, 0.0008, edge)
    albedo = blend(grout, albedo, face)
    dome = PILLOW_M * (1.0 - np.exp(-np.maximum(edge, 0.0) / 0.008)) + 0.00002 * params.unevenness * glaze
    height = face * (0.0008 + dome) + (1.0 - face) * 0.00004 * sand
    return Layers.of(albedo, height, 0.85 + (params.roughness - 0.85) * face)


def paint_glaze(params: GlazedLava, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one glazed slab."""
    pool = smoothstep(-1.5, 2.0, canvas.noise(0.3, 0.3, rng, 5))
    color, deep = rgb(params.color), rgb(params.pool_color)
    albedo = blend(color, deep, 0.8 * pool)
    net = voronoi_cells(canvas, params.crackle_m, rng, bend_m=0.12 * params.crackle_m)
    pixel = canvas.pixel_width_m
    crack = np.clip(1.3 - net.border_m / max(0.00035, 0.6 * pixel), 0.0, 1.0) * min(1.0, 0.0007 / pixel)
    crack = crack * (0.3 + 0.7 * smoothstep(-1.0, 1.0, canvas.noise(0.15, 0.15, rng)))
    albedo = blend(albedo, deep * 0.45, params.crackle * crack)
    wave = canvas.noise(0.06, 0.06, rng, 2)
    roughness = params.roughness + 0.1 * params.crackle * crack + 0.02 * pool
    return Layers.of(albedo, 0.00004 * wave - 0.00002 * crack, roughness)


def paint_print(params: PrintedLaminate, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of laminate."""
    albedo: Map = np.broadcast_to(rgb(params.ground), (*canvas.size_px, 3))
    for n, ink in enumerate(params.inks):
        albedo = blend(albedo, rgb(ink), _figures(params, n, canvas, rng))
    peel = canvas.noise(0.004, 0.004, rng)
    return Layers.of(albedo * (1.0 + 0.004 * peel)[..., None], 0.000004 * peel, params.roughness + 0.01 * peel)


def _figures(params: PrintedLaminate, ink: int, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: what is printed in one ink."""
    size = params.size_m
    if params.pattern == "cracked_ice":
        shards = voronoi_cells(canvas, size * (1.0 + 0.5 * ink), rng, stretch=1.4)
        lit = shards.random_per_cell(rng) ** 2
        return np.asarray(0.75 * lit * smoothstep(0.0, 0.03, shards.border_m / size), dtype=np.float32)
    places = voronoi_cells(canvas, size * (1.25 if params.pattern == "boomerang" else 1.0), rng)
    turn = 2.0 * np.pi * places.random_per_cell(rng)
    u = (np.cos(turn) * places.dx_m + np.sin(turn) * places.dy_m) / size
    v = (np.cos(turn) * places.dy_m - np.sin(turn) * places.dx_m) / size
    soft = canvas.pixel_width_m / size
    if params.pattern == "boomerang":
        # A bent bar: distance to a parabola, the bar thins out to its tips; only its outline is inked.
        half = 0.10 * np.sqrt(np.clip(1 - 9 * u * u, 0, 1))
        bar = np.abs(v + 0.10 - 1.6 * u * u) / np.sqrt(1.0 + (3.2 * u) ** 2) - half
        bar = np.where(np.abs(u) < 0.34, bar, 1.0)
        line = np.clip(1.2 - (np.abs(bar) - 0.012) / max(soft, 0.012), 0.0, 1.0)
        return np.asarray(line * (places.random_per_cell(rng) < 0.8))
    fleck = np.clip((1.0 - np.maximum(np.abs(u) / 0.30, np.abs(v) / 0.035)) / max(soft / 0.035, 0.2) + 0.5, 0.0, 1.0)
    return np.asarray(fleck * (places.random_per_cell(rng) < 0.55))


TILED = TextureKind("tiled_counter", TiledCounter, paint_tiles)
GLAZED = TextureKind("glazed_lava", GlazedLava, paint_glaze)
PRINTED = TextureKind("printed_laminate", PrintedLaminate, paint_print)


# Marks on the metal: ALONG brushed along u; UPRIGHT along v; ORBITAL small arcs; ROLLED as it left the mill.
MetalTooling = StrEnum("MetalTooling", "ALONG UPRIGHT ORBITAL HAMMERED ROLLED")


class SheetMetal(Record):
    """A metal sheet."""

    color: HexColor = Field(description="of the clean metal")
    patina_color: HexColor
    patina: Share = Field(0.0, description="how much of the face has it")
    spots: Share = Field(0.0, description="drops and rings that a used counter has")
    tooling: MetalTooling = Field(MetalTooling.ALONG, description="marks of the tool")
    mark_m: float = Field(0.02, gt=0.003, lt=0.4, description="size of one mark")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.3
    metallic: Share = Field(1.0, description="a thick patina is hardly metal any more")


def paint_metal(params: SheetMetal, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet."""
    tone, height, gloss = _marks(params, canvas, rng)
    cloud = canvas.noise(0.5, 0.6, rng, 3)
    albedo = rgb(params.color) * (1.0 + 0.05 * tone + 0.012 * cloud)[..., None]
    roughness = params.roughness + 0.04 * gloss + 0.015 * cloud
    if params.patina > 0:
        field = 0.8 * canvas.noise(0.25, 0.3, rng, 6) + 0.5 * canvas.noise(0.05, 0.06, rng, 5)
        edge = 1.6 - 3.0 * params.patina
        share = 0.6 * smoothstep(edge - 2.0, edge + 2.0, field)
        deep = 1.0 + 0.08 * canvas.noise(0.05, 0.05, rng, 4)
        albedo = blend(albedo, rgb(params.patina_color) * deep[..., None], share)
        roughness, height = roughness + 0.25 * share, height + 0.000004 * share
    if params.spots > 0:
        # Mask 0..1: rings of glasses and dried drops.
        drops = voronoi_cells(canvas, 0.11, rng, bend_m=0.004)
        radius = 0.008 + 0.03 * drops.random_per_cell(rng)
        ring = np.exp(-(((drops.near_m - radius) / 0.0018) ** 2)) + 0.3 * (drops.near_m < radius)
        ring = ring * (drops.random_per_cell(rng) < params.spots) * (0.4 + 0.6 * drops.random_per_cell(rng))
        mark = np.asarray(ring, dtype=np.float32)
        albedo = blend(albedo, rgb(params.patina_color), 0.45 * mark)
        roughness = roughness + 0.1 * mark
    return Layers.of(albedo, height, np.clip(roughness, 0.06, 1.0), params.metallic)


def _marks(params: SheetMetal, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Tone and gloss of deviation about 1, height in metres."""
    tooling, mark = params.tooling, params.mark_m
    if tooling in (MetalTooling.ALONG, MetalTooling.UPRIGHT):
        sizes = ((0.0012, 0.35), (0.0025, 0.9), (0.02, 1.2))
        pairs = [s if tooling is MetalTooling.ALONG else s[::-1] for s in sizes]
        lines = sum((w * canvas.noise(*s, rng) for w, s in zip((1.0, 0.7, 0.35), pairs, strict=True)), np.float32(0))
        lines = np.asarray(lines, dtype=np.float32)
        return 0.75 * lines, 0.000002 * lines, 0.8 * lines
    if tooling is MetalTooling.ORBITAL:
        # Scratches around many centres, laid over each other.
        tone = np.zeros(canvas.size_px, dtype=np.float32)
        for scale in (1.0, 0.7, 1.4):
            swirls = voronoi_cells(canvas, mark * scale, rng, bend_m=0.15 * mark)
            off = swirls.near_m + mark * 3.0 * swirls.random_per_cell(rng)
            tone = tone + np.sin(off * 2.0 * np.pi / 0.0023) * (0.4 + 0.6 * swirls.random_per_cell(rng))
            tone = tone + 0.6 * (swirls.random_per_cell(rng) - 0.5)
        tone = 0.55 * tone + 0.4 * canvas.noise(0.0025, 0.0025, rng)
        return tone, 0.0000015 * tone, 0.6 * tone
    if tooling is MetalTooling.HAMMERED:
        dents = voronoi_cells(canvas, mark, rng, bend_m=0.05 * mark)
        bowl = np.minimum(dents.near_m / mark, 0.62) ** 2
        rim = 1.0 - smoothstep(0.0, 0.10, dents.border_m / mark)
        return 3.3 * (bowl - 0.15) + 0.4 * rim, 0.045 * mark * bowl, np.zeros_like(bowl)
    cloud, fine = canvas.noise(0.1, 0.2, rng, 4), canvas.noise(0.004, 0.03, rng)
    return 0.5 * cloud + 0.25 * fine, 0.000001 * fine, 0.6 * cloud


METAL = TextureKind("sheet_metal", SheetMetal, paint_metal)
