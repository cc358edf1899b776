"""Tiles sawn from stone: marble, travertine, limestone, slate, granite, terrazzo, each piece from its own place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters import flow, granite, speckled, veined
from casa_assets.textures.laying.inlay import Slab, inlay, slab_canvas
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, lay


class StoneTile(Record):
    """Parameters common to tiles of any stone.

    Attributes:
        laying, joint: how they lie and what is between them.
        variety: 0..1, how much pieces differ in tone; warmth: in hue.
        turned: whether pieces are laid with their grain in all directions.
        cleft_m: relief of a split face, metres; protrusion_m: how far pieces protrude, standard deviation, metres.
        slab_m: side of the slab that pieces are cut from, metres.
    """

    laying: Laying
    joint: Joint = Joint(width_m=0.002, depth_m=0.0006)
    variety: Share = 0.3
    warmth: Share = 0.2
    turned: bool = True
    cleft_m: Annotated[float, Field(ge=0, le=0.01)] = 0.0
    protrusion_m: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    slab_m: Annotated[float, Field(ge=0.4, le=3)] = 1.6


class MarbleTile(StoneTile):
    """Marble and its like; `stone` is its slab, `accent` that of every other sort of piece where there is one."""

    stone: veined.VeinedStone
    accent: veined.VeinedStone | None = None


class LayeredTile(StoneTile):
    """Travertine, limestone, slate."""

    stone: flow.BandedStone
    accent: flow.BandedStone | None = None


class GraniteTile(StoneTile):
    """Granite."""

    stone: granite.Granite
    accent: granite.Granite | None = None


class ChipTile(StoneTile):
    """Terrazzo and quartz in pieces."""

    stone: speckled.MadeStone
    accent: speckled.MadeStone | None = None


_PAINT_SLAB: dict[type[Record], Callable[[Any, Canvas, np.random.Generator], Layers]] = {
    veined.VeinedStone: veined.paint,
    flow.BandedStone: flow.paint,
    granite.Granite: granite.paint,
    speckled.MadeStone: speckled.paint,
}


def paint(
    params: MarbleTile | LayeredTile | GraniteTile | ChipTile, canvas: Canvas, rng: np.random.Generator
) -> Layers:
    """Paint one field of stone tiles."""
    slab = slab_canvas(canvas, (params.slab_m, params.slab_m))
    stones = [stone for stone in (params.stone, params.accent) if stone is not None]
    faces = [_PAINT_SLAB[type(stone)](stone, slab, rng) for stone in stones]
    return _cut_and_lay(params, faces, canvas, rng, along=isinstance(params, LayeredTile))


def _cut_and_lay(
    params: StoneTile, faces: list[Layers], canvas: Canvas, rng: np.random.Generator, along: bool = False
) -> Layers:
    """Pieces cut from slabs; `along`: the layers of the slab lie along the pieces."""
    pieces = lay(params.laying, canvas, rng)
    if along:
        pieces = replace(pieces, u_m=pieces.v_m, v_m=-pieces.u_m)
    slabs = tuple(Slab(face, (params.slab_m, params.slab_m)) for face in faces)
    pick = pieces.sort % len(slabs)
    at = rng.uniform(0.0, params.slab_m, (2, pieces.count))
    mirrored = rng.permutation(np.arange(pieces.count) % 2) * 2.0 - 1.0
    face = inlay(pieces, slabs, pick, at[0], at[1], mirrored if params.turned else np.ones(pieces.count))
    tone = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
    warm = stratified(pieces.count, rng).astype(np.float32)[pieces.owner] * np.float32(params.warmth)
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


MARBLE = TextureKind("marble_tile", MarbleTile, paint)
LAYERED = TextureKind("layered_stone_tile", LayeredTile, paint)
GRANITE = TextureKind("granite_tile", GraniteTile, paint)
CHIPS = TextureKind("chip_tile", ChipTile, paint)
