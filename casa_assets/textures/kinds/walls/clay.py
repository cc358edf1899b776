"""Fired clay: bricks and terracotta, bare, limewashed, painted, reclaimed."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, rgb_table, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.walls.ceramic import ColorAssignment, colors_of, read_per_piece
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, lay
from casa_assets.textures.laying.pieces import PieceMap


class FiredClay(Record):
    """Bricks or unglazed tiles.

    Attributes:
        laying, joint: how they lie and what is between them.
        colors: of the fired clay; `color_order` says which piece gets which.
        variety: 0..1, how much pieces of one colour differ.
        mottle: 0..1, clouds of stronger and weaker fire within a piece.
        kiln_marks: 0..1, dark ends and patches of the kiln.
        relief_m: relief of the face, metres; protrusion_m: how far pieces protrude, standard deviation, metres.
        coat_color, coat_share: a coat of lime over all, 0..1 how much of the wall it still hides.
        paint_share: 0..1, how much the coat is paint, which covers the joints too.
        roughness: 0..1.
    """

    laying: Laying
    joint: Joint = Joint(width_m=0.01, depth_m=0.004, rim_noise_m=0.002)
    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=12)]
    color_order: ColorAssignment = ColorAssignment.LOT
    variety: Share = 0.4
    mottle: Share = 0.4
    kiln_marks: Share = 0.0
    relief_m: Annotated[float, Field(ge=0, le=0.005)] = 0.0005
    protrusion_m: Annotated[float, Field(ge=0, le=0.005)] = 0.0006
    coat_color: HexColor = "#eeeae1"
    coat_share: Share = 0.0
    paint_share: Share = 0.0
    roughness: Annotated[float, Field(ge=0.1, le=0.98)] = 0.85


def paint(params: FiredClay, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of bricks."""
    pieces = lay(params.laying, canvas, rng)
    rim_m = rim(params.joint, pieces, canvas, rng)
    number, tone = colors_of(params.color_order, len(params.colors), pieces, rng), stratified(pieces.count, rng)
    cloud = read_per_piece(canvas.noise(0.06, 0.06, rng, 5), canvas, pieces, rng)
    grit = canvas.resolved(0.004, 0.004) * canvas.noise(0.004, 0.004, rng) + 0.6 * canvas.noise(0.011, 0.011, rng, 2)
    shade = 1.0 + params.variety * 0.17 * tone.astype(np.float32)[pieces.owner]
    shade = shade + params.mottle * 0.10 * cloud + 0.018 * grit
    albedo = rgb_table(params.colors)[number][pieces.owner] * shade[..., None]
    if params.kiln_marks > 0:
        dark = _burnt(pieces, cloud, rng) * params.kiln_marks
        albedo = albedo * (1.0 - np.array([0.55, 0.5, 0.42], dtype=np.float32) * dark[..., None])
    proud = (rng.normal(0.0, 1.0, pieces.count).clip(-2, 2) * params.protrusion_m).astype(np.float32)[pieces.owner]
    lumps = 0.5 * grit + 0.6 * cloud - 1.2 * smoothstep(1.6, 2.3, cloud + 0.5 * grit)
    height = (proud + params.relief_m * 0.4 * lumps).astype(np.float32)
    gloss = np.broadcast_to(np.float32(params.roughness), canvas.size_px) + np.float32(0.03) * cloud
    laid = fill(Layers.of(albedo, height, gloss), params.joint, rim_m, canvas, rng)
    return _coated(params, laid, rim_m, grit, canvas, rng) if params.coat_share > 0 else laid


def _burnt(pieces: PieceMap, cloud: Map, rng: np.random.Generator) -> Map:
    """Mask 0..1: dark toward one end of some bricks, as they lay in the kiln."""
    lean = rng.normal(0.0, 1.0, pieces.count).astype(np.float32)[pieces.owner]
    share = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
    along = pieces.v_m / pieces.half_m[:, 1].astype(np.float32)[pieces.owner]
    return smoothstep(0.6, 2.2, along * lean + 1.3 * share + 0.4 * cloud)


def _coated(params: FiredClay, laid: Layers, rim_m: Map, grit: Map, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """A coat of lime or paint; it wears off the faces first and stays in the joints."""
    worn = 0.8 * canvas.noise(0.12, 0.16, rng, 4) + 0.7 * canvas.noise(0.02, 0.02, rng, 3) + 0.3 * grit
    low = smoothstep(0.004, -0.001, rim_m) * (1.0 - params.paint_share) if params.paint_share < 1 else 0.0 * rim_m
    edge = 2.4 - 4.8 * params.coat_share
    share = smoothstep(edge - 0.7, edge + 0.7, worn + 0.8 * low)
    share = np.maximum(share, params.paint_share) * (0.9 + 0.1 * params.paint_share)
    coat = rgb(params.coat_color) * (1.0 + 0.018 * canvas.noise(0.2, 0.2, rng, 3) + 0.006 * grit)[..., None]
    # Mortar lies in its own shade: a coat of one colour still shows the bond a little.
    coat = coat * (1.0 - 0.05 * smoothstep(0.001, -0.002, rim_m))[..., None]
    return Layers.of(
        blend(laid.albedo, coat, share),
        laid.height_m + 0.0002 * share,
        np.clip(laid.roughness + (params.roughness - 0.35 * params.paint_share - laid.roughness) * share, 0.1, 1),
    )


CLAY = TextureKind("fired_clay", FiredClay, paint)
"""Kind of brick."""
