"""Walls of rough stone: ledgestone, fieldstone, ashlar."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Share, blend, rgb, rgb_table, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.walls.ceramic import ColorAssignment, colors_of, read_per_piece
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, lay


class Stonework(Record):
    """A wall of stones.

    Attributes:
        laying, joint: how they lie and what is between them.
        colors: of the stones, drawn with equal odds; `stain` gathers on parts of them.
        variety: 0..1, how much stones of one colour differ.
        stain_share: 0..1, share of the face that leans to the stain.
        layered: 0..1, strength of the lines along a stone.
        relief_m: relief of a face, metres; protrusion_m: how far stones protrude, standard deviation, metres.
        rim_rounding_m: how far a face falls off toward its rim, metres.
        roughness: 0..1.
    """

    laying: Laying
    joint: Joint = Joint(width_m=0.012, depth_m=0.006, rim_noise_m=0.004)
    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=12)]
    stain: HexColor = "#8a6a48"
    variety: Share = 0.5
    stain_share: Share = 0.2
    layered: Share = 0.2
    relief_m: Annotated[float, Field(ge=0, le=0.02)] = 0.003
    protrusion_m: Annotated[float, Field(ge=0, le=0.02)] = 0.003
    rim_rounding_m: Annotated[float, Field(ge=0, le=0.02)] = 0.004
    roughness: Annotated[float, Field(ge=0.1, le=0.98)] = 0.85


def paint(params: Stonework, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one wall."""
    pieces = lay(params.laying, canvas, rng)
    rim_m = rim(params.joint, pieces, canvas, rng)
    number, tone = colors_of(ColorAssignment.LOT, len(params.colors), pieces, rng), stratified(pieces.count, rng)
    rock = read_per_piece(canvas.noise(0.10, 0.13, rng, 6), canvas, pieces, rng)
    lines = 0.5 * canvas.noise(0.009, 0.13, rng) + 0.8 * canvas.noise(0.023, 0.3, rng, 3)
    bend = 0.006 * canvas.noise(0.05, 0.12, rng, 2)
    lines = read_per_piece(canvas.shifted(lines, 0.0 * bend, bend), canvas, pieces, rng)
    grit = canvas.noise(0.006, 0.006, rng, 2)
    crack = 1.0 - smoothstep(0.0, 0.16, np.abs(read_per_piece(canvas.noise(0.06, 0.09, rng, 3), canvas, pieces, rng)))
    shade = 1.0 + params.variety * 0.24 * tone.astype(np.float32)[pieces.owner] + 0.07 * rock + 0.024 * grit
    shade = shade + 0.08 * params.layered * lines - 0.10 * crack * (1.0 - params.layered)
    albedo = rgb_table(params.colors)[number][pieces.owner] * shade[..., None]
    if params.stain_share > 0:
        bias = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
        edge = 2.2 - 3.6 * params.stain_share
        share = smoothstep(edge, edge + 1.8, read_per_piece(rock, canvas, pieces, rng) + 0.9 * bias)
        albedo = blend(albedo, rgb(params.stain) * shade[..., None], 0.65 * share)
    dome = 1.0 - np.exp(-np.maximum(rim_m, 0.0) / 0.018)
    out = (rng.normal(0.0, 1.0, pieces.count).clip(-1.6, 2) * params.protrusion_m).astype(np.float32)[pieces.owner]
    # Split faces are flats that meet in edges, not dunes.
    facets = np.abs(rock) * 0.9 - np.abs(read_per_piece(canvas.noise(0.05, 0.05, rng, 2), canvas, pieces, rng)) * 0.6
    height = (
        out
        + params.rim_rounding_m * dome
        + params.relief_m * (0.45 * facets + 0.10 * grit + 0.25 * params.layered * lines)
    )
    # Little light reaches the foot of a deep joint.
    albedo = albedo * (0.62 + 0.38 * smoothstep(-0.001, 0.008, rim_m))[..., None]
    gloss = np.broadcast_to(np.float32(params.roughness), canvas.size_px) + np.float32(0.03) * rock
    face = Layers.of(albedo, height, gloss)
    return fill(face, params.joint, rim_m, canvas, rng)


STONEWORK = TextureKind("stonework", Stonework, paint)
"""Kind of walls of rough stone."""
