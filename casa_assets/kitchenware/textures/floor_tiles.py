"""Floor tiles: pressed cement in patterns, and tiles sawn from stone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
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
    Share,
    Slab,
    TextureKind,
    blend,
    fill,
    inlay,
    lay,
    rgb,
    rim,
    slab_canvas,
    smoothstep,
    stratified,
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

# Encaustic ------------------------------------------------------------------------------------------------------------
# Cement tiles: coloured cement pressed into a pattern, dull, a little worn.


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
        share = ink(np.asarray(depth), soft)[..., None]
        albedo = albedo + (colors[number % len(colors)] - albedo) * share
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

# Stone ----------------------------------------------------------------------------------------------------------------
# Marble, travertine, limestone, slate, granite, terrazzo, each piece from its own place.


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
