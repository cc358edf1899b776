"""Cement tiles: coloured cement pressed into a pattern, dull, a little worn."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, LayingPattern, lay
from casa_assets.textures.motif.encaustic import DESIGNS, TileDesign
from casa_assets.textures.motif.figures import ink


class Encaustic(Record):
    """Patterned tiles, all laid the same way.

    Attributes:
        design: what is on a tile.
        colors: the ground, then the inks in the order in which the design numbers them.
        side_m: of a tile, metres.
        joint: between tiles.
        bleed: 0..1, how far colours run into each other; wear: how far feet have paled them; variety: between tiles.
        roughness: 0..1.
    """

    design: TileDesign
    colors: Annotated[tuple[HexColor, ...], Field(min_length=2, max_length=6)]
    side_m: Annotated[float, Field(gt=0.05, le=0.6)] = 0.2
    joint: Joint = Joint(width_m=0.0015, depth_m=0.0004, color="#b9b4aa", rim_drop_m=0.0002)
    bleed: Share = 0.3
    wear: Share = 0.3
    variety: Share = 0.25
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.55


def paint(params: Encaustic, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
    tone = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
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


ENCAUSTIC = TextureKind("cement_tile", Encaustic, paint)
"""Kind of patterned tiles."""
