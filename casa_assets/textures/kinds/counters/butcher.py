"""Wooden worktops: staves glued edge to edge, and end grain blocks."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures import wood
from casa_assets.textures.canvas import Canvas, Layers, Map, blend, line_coverage, rgb, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.wood import WoodPalette
from casa_assets.textures.wood_grain import GrainMaps, SawCut, WoodSpecies, ring_maps

Ids = npt.NDArray[np.intp]
_GLUE_M = 0.001  # as wide as a joint looks from arm's length


class ButcherBlock(Record):
    """Staves along u.

    Attributes:
        species, palette, cut: of the wood; `palette.variety` is how much staves differ.
        stave_m: width of a stave in metres.
        length_m: of the pieces that a stave is joined from, metres.
    """

    species: WoodSpecies
    palette: WoodPalette
    cut: SawCut = SawCut.RIFT
    stave_m: Annotated[float, Field(gt=0.01, lt=0.4)] = 0.04
    length_m: Annotated[float, Field(gt=0.05, lt=4)] = 0.5


class EndGrain(Record):
    """Blocks standing on end.

    Attributes:
        species, palette: of the wood.
        block_m: side of a block in metres.
        second: palette of every other block, None if all are of one wood.
        bond: 0..1, how far every other row is shifted, as a share of a block.
    """

    species: WoodSpecies
    palette: WoodPalette
    block_m: Annotated[float, Field(gt=0.01, lt=0.2)] = 0.045
    second: WoodPalette | None = None
    bond: Annotated[float, Field(ge=0, le=1)] = 0.5


def paint_staves(params: ButcherBlock, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one worktop, grain along u."""
    return _glued(params, canvas.transposed, rng).transposed


def _glued(params: ButcherBlock, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """The worktop with its grain along v: every piece is read from another place of one sheet of wood."""
    plain = params.palette.replace(variety=0.0)
    face = wood.board(canvas, params.species, params.cut, plain, rng)
    piece, edge_m, count = _pieces(canvas, params.stave_m, params.length_m, rng)
    dx = rng.uniform(0.0, canvas.tile_m[0], count).astype(np.float32)[piece]
    dy = rng.uniform(0.0, canvas.tile_m[1], count).astype(np.float32)[piece]
    moved = [
        canvas.shifted(plane, dx, dy) for plane in (*np.moveaxis(face.albedo, 2, 0), face.height_m, face.roughness)
    ]
    # Most staves are much alike and a few stand out: a cube of the lot keeps it so. Pale ones stand out less.
    lot = stratified(count, rng)
    tones = 0.35 * lot + 0.65 * lot**3
    tones = np.where(tones < 0.0, 0.5 * tones, tones) * params.palette.variety
    tone = tones.astype(np.float32)[piece]
    albedo = np.stack(moved[:3], axis=-1)
    dark, light = rgb(params.palette.dark), rgb(params.palette.light)
    albedo = albedo + 0.9 * (dark - light) * tone[..., None]
    albedo = albedo * (1.0 + 0.04 * tone)[..., None]
    pixel = max(canvas.pixel_width_m, canvas.tile_m[1] / canvas.size_px[0])
    glue = line_coverage(edge_m, _GLUE_M, pixel)
    albedo = blend(albedo, rgb(params.palette.heart), 0.42 * glue)
    return Layers.of(albedo, moved[3] - 0.00004 * glue, moved[4] + 0.04 * glue)


def _pieces(canvas: Canvas, stave_m: float, length_m: float, rng: np.random.Generator) -> tuple[Ids, Map, int]:
    """Number of the piece, metres to its edge, count of pieces. Staves upright, ends at random heights."""
    x, y = canvas.axes()
    columns = max(2, round(canvas.tile_m[0] / stave_m))
    rows = max(1, round(canvas.tile_m[1] / length_m))
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
    return np.mod(row, rows) + column * rows, np.minimum(off, side).astype(np.float32), rows * columns


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
    grain = _end_maps(canvas, params.species, radius.astype(np.float32), np.arctan2(dy, dx), rng)
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


def _end_maps(canvas: Canvas, species: WoodSpecies, radius: Map, angle: Map, rng: np.random.Generator) -> GrainMaps:
    """Maps of wood seen from its end."""
    ring, early, zone = ring_maps(canvas, species, radius, rng)
    dots = canvas.noise(0.0012, 0.0012, rng)
    zero = np.zeros_like(ring)
    rays = np.cos(angle * 160.0).astype(np.float32)
    return GrainMaps(
        ring=ring,
        early=early,
        fibre=0.5 * canvas.noise(0.002, 0.002, rng) + 0.25 * rays,
        zone=zone,
        pore=smoothstep(0.5, 1.6, dots),
        fleck=zero,
        dash=zero,
        sheen=zero,
        knot=zero,
        tone=zero,
        joint=zero,
        edge_m=zero + 1.0,
    )


STAVES = TextureKind("butcher_block", ButcherBlock, paint_staves)
END_GRAIN = TextureKind("end_grain", EndGrain, paint_blocks)
