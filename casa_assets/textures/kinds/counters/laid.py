"""Counters of glazed tiles, glazed lava, and laminates with a printed pattern."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, rgb_table, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.voronoi import voronoi_cells


class TiledCounter(Record):
    """Tiles with grout.

    Attributes:
        colors: drawn from with equal odds, or in turn where `checker`.
        grout: colour of the grout; `joint_m` is its width in metres.
        width_m, height_m: of a tile.
        bond: 0..1, how far every other row is moved along.
        checker: colours take turns.
        unevenness: 0..1, how much tiles differ, and the glaze within one.
        pillow_m: how much lower the edge of a tile is than its middle, metres.
        roughness: 0..1, of the glaze.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=8)]
    grout: HexColor
    joint_m: Annotated[float, Field(gt=0.0005, lt=0.03)] = 0.004
    width_m: Annotated[float, Field(gt=0.01, lt=1)] = 0.1
    height_m: Annotated[float, Field(gt=0.01, lt=1)] = 0.1
    bond: Annotated[float, Field(ge=0, le=1)] = 0.0
    checker: bool = False
    unevenness: Share = 0.3
    pillow_m: Annotated[float, Field(ge=0, le=0.004)] = 0.0006
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.15


class GlazedLava(Record):
    """Enamelled lava: thick glaze that pools and crackles.

    Attributes:
        color: of the glaze; `pool_color` where it pools.
        crackle: 0..1, how plain its net of fine cracks is; `crackle_m` is the size of its pieces.
        roughness: 0..1.
    """

    color: HexColor
    pool_color: HexColor
    crackle: Share = 0.4
    crackle_m: Annotated[float, Field(gt=0.003, lt=0.2)] = 0.02
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.08


class LaminatePattern(StrEnum):
    """Patterns of printed laminate."""

    BOOMERANG = "boomerang"
    CRACKED_ICE = "cracked_ice"
    FLECKS = "flecks"
    TERRAZZO = "terrazzo"


class PrintedLaminate(Record):
    """A laminate with a pattern of the middle of the last century.

    Attributes:
        ground: colour of the sheet.
        inks: colours of the figures.
        pattern: which.
        size_m: of a figure, metres.
        roughness: 0..1.
    """

    ground: HexColor
    inks: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=6)]
    pattern: LaminatePattern
    size_m: Annotated[float, Field(gt=0.003, lt=0.3)] = 0.05
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
    dome = params.pillow_m * (1.0 - np.exp(-np.maximum(edge, 0.0) / 0.008)) + 0.00002 * params.unevenness * glaze
    return Layers.of(
        albedo, face * (0.0008 + dome) + (1.0 - face) * 0.00004 * sand, 0.85 + (params.roughness - 0.85) * face
    )


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
    return Layers.of(
        albedo, 0.00004 * wave - 0.00002 * crack, params.roughness + 0.1 * params.crackle * crack + 0.02 * pool
    )


def paint_print(params: PrintedLaminate, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of laminate."""
    albedo: Map = np.broadcast_to(rgb(params.ground), (*canvas.size_px, 3))
    for n, ink in enumerate(params.inks):
        mask = _figures(params, n, canvas, rng)
        albedo = blend(albedo, rgb(ink), mask)
    peel = canvas.noise(0.004, 0.004, rng)
    return Layers.of(albedo * (1.0 + 0.004 * peel)[..., None], 0.000004 * peel, params.roughness + 0.01 * peel)


def _figures(params: PrintedLaminate, ink: int, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: what is printed in one ink."""
    size = params.size_m
    if params.pattern is LaminatePattern.CRACKED_ICE:
        shards = voronoi_cells(canvas, size * (1.0 + 0.5 * ink), rng, stretch=1.4)
        lit = shards.random_per_cell(rng) ** 2
        return np.asarray(0.75 * lit * smoothstep(0.0, 0.03, shards.border_m / size), dtype=np.float32)
    places = voronoi_cells(canvas, size * (1.25 if params.pattern is LaminatePattern.BOOMERANG else 1.0), rng)
    turn = 2.0 * np.pi * places.random_per_cell(rng)
    u = (np.cos(turn) * places.dx_m + np.sin(turn) * places.dy_m) / size
    v = (np.cos(turn) * places.dy_m - np.sin(turn) * places.dx_m) / size
    soft = canvas.pixel_width_m / size
    if params.pattern is LaminatePattern.BOOMERANG:
        # A bent bar: distance to a parabola, the bar thins out to its tips; only its outline is inked.
        bar = np.abs(v + 0.10 - 1.6 * u * u) / np.sqrt(1.0 + (3.2 * u) ** 2) - 0.10 * np.sqrt(
            np.clip(1 - 9 * u * u, 0, 1)
        )
        bar = np.where(np.abs(u) < 0.34, bar, 1.0)
        return np.asarray(
            np.clip(1.2 - (np.abs(bar) - 0.012) / max(soft, 0.012), 0.0, 1.0) * (places.random_per_cell(rng) < 0.8)
        )
    if params.pattern is LaminatePattern.FLECKS:
        slim = np.maximum(np.abs(u) / 0.30, np.abs(v) / 0.035)
        return np.asarray(
            np.clip((1.0 - slim) / max(soft / 0.035, 0.2) + 0.5, 0.0, 1.0) * (places.random_per_cell(rng) < 0.55)
        )
    chip = places.border_m / size - 0.05 - 0.15 * places.random_per_cell(rng)
    return np.asarray(np.clip(chip / soft, 0.0, 1.0) * (places.random_per_cell(rng) < 0.3), dtype=np.float32)


TILED = TextureKind("tiled_counter", TiledCounter, paint_tiles)
GLAZED = TextureKind("glazed_lava", GlazedLava, paint_glaze)
PRINTED = TextureKind("printed_laminate", PrintedLaminate, paint_print)
