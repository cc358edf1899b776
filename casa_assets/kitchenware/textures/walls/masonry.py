"""Walls of pieces: glazed tiles, bricks and terracotta, rough stone."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Canvas,
    Joint,
    Layers,
    Laying,
    Map,
    PieceMap,
    Share,
    TextureKind,
    blend,
    fill,
    lay,
    rgb,
    rgb_table,
    rim,
    smoothstep,
    stratified,
)

# Ceramic --------------------------------------------------------------------------------------------------------------
# Glazed tiles in any laying: subway, zellige, penny, scales; also bare porcelain, glass and metal ones.


class ColorAssignment(StrEnum):
    """Assignment of colours to pieces."""

    LOT = "lot"  # as often as the others, in no order
    SORT = "sort"  # by its shape, orientation or place in the pattern


class CeramicTile(Record):
    """Tiles."""

    laying: Laying
    joint: Joint = Joint()
    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=12, description="of the glaze")
    color_order: ColorAssignment = Field(ColorAssignment.LOT, description="which piece gets which colour")
    variety: Share = Field(0.25, description="how much pieces of one colour differ in tone")
    glaze_pooling: Share = Field(
        0.2, description="how unevenly the glaze flowed; where it is thin, `body` shows through"
    )
    body: HexColor = Field("#cdb8a0", description="colour of the clay under the glaze")
    tilt: float = Field(0.002, ge=0, le=0.05, description="standard deviation of the slope of a piece, metres a metre")
    wave_m: float = Field(0.00003, ge=0, le=0.001, description="height of the waves in the glaze")
    crackle: Share = Field(0.0, description="how plain the net of fine cracks is")
    speckle: Share = Field(0.0, description="share of small dark specks")
    rib_count: int = Field(0, ge=0, le=16, description="relief lines along each piece; 0: none")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.14
    metallic: Share = 0.0


def paint_ceramic(params: CeramicTile, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of tiles."""
    pieces = lay(params.laying, canvas, rng)
    rim_m = rim(params.joint, pieces, canvas, rng)
    number, tone = colors_of(params.color_order, len(params.colors), pieces, rng), stratified(pieces.count, rng)
    glaze = read_per_piece(canvas.noise(0.035, 0.035, rng, 4), canvas, pieces, rng)
    albedo = rgb_table(params.colors)[number][pieces.owner]
    shade = 1.0 + params.variety * 0.13 * pieces.read(tone) + params.glaze_pooling * 0.045 * glaze
    albedo = albedo * shade[..., None]
    if params.glaze_pooling > 0:
        # Glaze draws back from the rim and gathers in low spots.
        thin = np.exp(-np.maximum(rim_m, 0.0) / 0.0025) + 0.35 * smoothstep(0.9, 2.4, glaze)
        share = params.glaze_pooling * np.clip(0.55 * thin, 0.0, 0.7)
        albedo = blend(albedo, rgb(params.body) * albedo**0.4, share)
    if params.speckle > 0:
        dots = canvas.noise(0.004, 0.004, rng) + 0.5 * canvas.noise(0.009, 0.009, rng)
        edge = 3.2 - 1.6 * params.speckle
        dots = smoothstep(edge, edge + 0.3, dots * (0.4 + 0.6 * canvas.resolved(0.004, 0.004)))
        albedo = albedo * (1.0 - 0.55 * dots)[..., None]
    if params.crackle > 0:
        albedo = albedo * (1.0 - 0.16 * params.crackle * _cracks(canvas, rng))[..., None]
    height = _relief(params, pieces, glaze, rng)
    gloss = (
        params.roughness
        + 0.02 * glaze * params.glaze_pooling
        + 0.03 * params.variety * stratified(pieces.count, rng)[pieces.owner]
    )
    face = Layers.of(albedo, height, gloss, params.metallic)
    return fill(face, params.joint, rim_m, canvas, rng)


def colors_of(deal: ColorAssignment, count: int, pieces: PieceMap, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """(N,) number of the colour of each piece, below `count`."""
    if deal is ColorAssignment.SORT:
        return np.asarray(pieces.sort % count)
    return np.asarray(rng.permutation(np.arange(pieces.count) % count))


def read_per_piece(image: Map, canvas: Canvas, pieces: PieceMap, rng: np.random.Generator) -> Map:
    """A picture read at a different place for each piece, so that nothing continues across a joint."""
    jump = rng.random((2, pieces.count)).astype(np.float32)
    dx, dy = jump[0] * np.float32(canvas.tile_m[0]), jump[1] * np.float32(canvas.tile_m[1])
    return canvas.shifted(image, dx[pieces.owner], dy[pieces.owner])


def _relief(params: CeramicTile, pieces: PieceMap, glaze: Map, rng: np.random.Generator) -> Map:
    slope = rng.normal(0.0, 1.0, (2, pieces.count)).clip(-2, 2).astype(np.float32) * np.float32(params.tilt)
    height = slope[0][pieces.owner] * pieces.u_m + slope[1][pieces.owner] * pieces.v_m
    height = height + np.float32(params.wave_m) * glaze
    if params.rib_count:
        across = pieces.u_m / pieces.read(pieces.half_m[:, 0])
        height = height + 0.0022 * np.abs(np.sin(np.pi / 2 * params.rib_count * (across + 1.0)))
    return np.asarray(height, dtype=np.float32)


def _cracks(canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: a net of hair lines."""
    lines = np.minimum(np.abs(canvas.noise(0.02, 0.02, rng, 2)), np.abs(canvas.noise(0.035, 0.035, rng, 2)))
    wide = 0.05 * max(1.0, canvas.pixel_m / 0.001)
    return np.asarray(np.clip(1.3 - lines / wide, 0.0, 1.0) / max(1.0, canvas.pixel_m / 0.001), dtype=np.float32)


CERAMIC = TextureKind("ceramic_tile", CeramicTile, paint_ceramic)

# Clay -----------------------------------------------------------------------------------------------------------------
# Fired clay: bricks and terracotta, bare, limewashed, painted, reclaimed.


class FiredClay(Record):
    """Bricks or unglazed tiles."""

    laying: Laying
    joint: Joint = Joint(width_m=0.01, depth_m=0.004, rim_noise_m=0.002)
    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=12, description="of the fired clay")
    color_order: ColorAssignment = Field(ColorAssignment.LOT, description="which piece gets which colour")
    variety: Share = Field(0.4, description="how much pieces of one colour differ")
    mottle: Share = Field(0.4, description="clouds of stronger and weaker fire within a piece")
    kiln_marks: Share = Field(0.0, description="dark ends and patches of the kiln")
    relief_m: float = Field(0.0005, ge=0, le=0.005, description="relief of the face")
    protrusion_m: float = Field(0.0006, ge=0, le=0.005, description="standard deviation of how far pieces protrude")
    coat_color: HexColor = Field("#eeeae1", description="of a coat of lime over all")
    coat_share: Share = Field(0.0, description="how much of the wall the coat still hides")
    paint_share: Share = Field(0.0, description="how much the coat is paint, which covers the joints too")
    roughness: Annotated[float, Field(ge=0.1, le=0.98)] = 0.85


def paint_clay(params: FiredClay, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of bricks."""
    pieces = lay(params.laying, canvas, rng)
    rim_m = rim(params.joint, pieces, canvas, rng)
    number, tone = colors_of(params.color_order, len(params.colors), pieces, rng), stratified(pieces.count, rng)
    cloud = read_per_piece(canvas.noise(0.06, 0.06, rng, 5), canvas, pieces, rng)
    grit = canvas.resolved(0.004, 0.004) * canvas.noise(0.004, 0.004, rng) + 0.6 * canvas.noise(0.011, 0.011, rng, 2)
    shade = 1.0 + params.variety * 0.17 * pieces.read(tone)
    shade = shade + params.mottle * 0.10 * cloud + 0.018 * grit
    albedo = rgb_table(params.colors)[number][pieces.owner] * shade[..., None]
    if params.kiln_marks > 0:
        dark = _burnt(pieces, cloud, rng) * params.kiln_marks
        albedo = albedo * (1.0 - np.array([0.55, 0.5, 0.42], dtype=np.float32) * dark[..., None])
    proud = pieces.read(rng.normal(0.0, 1.0, pieces.count).clip(-2, 2) * params.protrusion_m)
    lumps = 0.5 * grit + 0.6 * cloud - 1.2 * smoothstep(1.6, 2.3, cloud + 0.5 * grit)
    height = (proud + params.relief_m * 0.4 * lumps).astype(np.float32)
    gloss = np.broadcast_to(np.float32(params.roughness), canvas.size_px) + np.float32(0.03) * cloud
    laid = fill(Layers.of(albedo, height, gloss), params.joint, rim_m, canvas, rng)
    return _coated(params, laid, rim_m, grit, canvas, rng) if params.coat_share > 0 else laid


def _burnt(pieces: PieceMap, cloud: Map, rng: np.random.Generator) -> Map:
    """Mask 0..1: dark toward one end of some bricks, as they lay in the kiln."""
    lean = pieces.read(rng.normal(0.0, 1.0, pieces.count))
    share = pieces.read(stratified(pieces.count, rng))
    along = pieces.v_m / pieces.read(pieces.half_m[:, 1])
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


CLAY = TextureKind("fired_clay", FiredClay, paint_clay)

# Stonework ------------------------------------------------------------------------------------------------------------
# Walls of rough stone: ledgestone, fieldstone, ashlar.


class Stonework(Record):
    """A wall of stones."""

    laying: Laying
    joint: Joint = Joint(width_m=0.012, depth_m=0.006, rim_noise_m=0.004)
    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=12, description="drawn with equal odds")
    stain: HexColor = Field("#8a6a48", description="gathers on parts of the stones")
    variety: Share = Field(0.5, description="how much stones of one colour differ")
    stain_share: Share = Field(0.2, description="share of the face that leans to the stain")
    layered: Share = Field(0.2, description="strength of the lines along a stone")
    relief_m: float = Field(0.003, ge=0, le=0.02, description="relief of a face")
    protrusion_m: float = Field(0.003, ge=0, le=0.02, description="standard deviation of how far stones protrude")
    rim_rounding_m: float = Field(0.004, ge=0, le=0.02, description="how far a face falls off toward its rim")
    roughness: Annotated[float, Field(ge=0.1, le=0.98)] = 0.85


def paint_stonework(params: Stonework, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
    shade = 1.0 + params.variety * 0.24 * pieces.read(tone) + 0.07 * rock + 0.024 * grit
    shade = shade + 0.08 * params.layered * lines - 0.10 * crack * (1.0 - params.layered)
    albedo = rgb_table(params.colors)[number][pieces.owner] * shade[..., None]
    if params.stain_share > 0:
        bias = pieces.read(stratified(pieces.count, rng))
        edge = 2.2 - 3.6 * params.stain_share
        share = smoothstep(edge, edge + 1.8, read_per_piece(rock, canvas, pieces, rng) + 0.9 * bias)
        albedo = blend(albedo, rgb(params.stain) * shade[..., None], 0.65 * share)
    dome = 1.0 - np.exp(-np.maximum(rim_m, 0.0) / 0.018)
    out = pieces.read(rng.normal(0.0, 1.0, pieces.count).clip(-1.6, 2) * params.protrusion_m)
    # Split faces are flats that meet in edges, not dunes.
    facets = np.abs(rock) * 0.9 - np.abs(read_per_piece(canvas.noise(0.05, 0.05, rng, 2), canvas, pieces, rng)) * 0.6
    face_m = params.relief_m * (0.45 * facets + 0.10 * grit + 0.25 * params.layered * lines)
    height = out + params.rim_rounding_m * dome + face_m
    # Little light reaches the foot of a deep joint.
    albedo = albedo * (0.62 + 0.38 * smoothstep(-0.001, 0.008, rim_m))[..., None]
    gloss = np.broadcast_to(np.float32(params.roughness), canvas.size_px) + np.float32(0.03) * rock
    return fill(Layers.of(albedo, height, gloss), params.joint, rim_m, canvas, rng)


STONEWORK = TextureKind("stonework", Stonework, paint_stonework)
