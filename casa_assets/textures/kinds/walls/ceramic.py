"""Glazed tiles in any laying: subway, zellige, penny, scales; also bare porcelain, glass and metal ones."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, rgb_table, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, lay
from casa_assets.textures.laying.pieces import PieceMap


class ColorAssignment(StrEnum):
    """Assignment of colours to pieces."""

    LOT = "lot"  # as often as the others, in no order
    SORT = "sort"  # by its shape, orientation or place in the pattern


class CeramicTile(Record):
    """Tiles.

    Attributes:
        laying, joint: how they lie and what is between them.
        colors: of the glaze; `color_order` says which piece gets which.
        variety: 0..1, how much pieces of one colour differ in tone.
        glaze_pooling: 0..1, how unevenly the glaze flowed within a piece; where it is thin, `body` shows through.
        body: colour of the clay under the glaze.
        tilt: standard deviation of the slope of a piece, metres a metre.
        wave_m: height of the waves in the glaze, metres.
        crackle: 0..1, how plain the net of fine cracks is.
        speckle: 0..1, share of small dark specks.
        rib_count: relief lines along each piece; 0 for none.
        roughness: 0..1; metallic: 0..1.
    """

    laying: Laying
    joint: Joint = Joint()
    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=12)]
    color_order: ColorAssignment = ColorAssignment.LOT
    variety: Share = 0.25
    glaze_pooling: Share = 0.2
    body: HexColor = "#cdb8a0"
    tilt: Annotated[float, Field(ge=0, le=0.05)] = 0.002
    wave_m: Annotated[float, Field(ge=0, le=0.001)] = 0.00003
    crackle: Share = 0.0
    speckle: Share = 0.0
    rib_count: Annotated[int, Field(ge=0, le=16)] = 0
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.14
    metallic: Share = 0.0


def paint(params: CeramicTile, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of tiles."""
    pieces = lay(params.laying, canvas, rng)
    rim_m = rim(params.joint, pieces, canvas, rng)
    number, tone = colors_of(params.color_order, len(params.colors), pieces, rng), stratified(pieces.count, rng)
    glaze = read_per_piece(canvas.noise(0.035, 0.035, rng, 4), canvas, pieces, rng)
    albedo = rgb_table(params.colors)[number][pieces.owner]
    shade = 1.0 + params.variety * 0.13 * tone.astype(np.float32)[pieces.owner] + params.glaze_pooling * 0.045 * glaze
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
        across = pieces.u_m / pieces.half_m[:, 0].astype(np.float32)[pieces.owner]
        height = height + 0.0022 * np.abs(np.sin(np.pi / 2 * params.rib_count * (across + 1.0)))
    return np.asarray(height, dtype=np.float32)


def _cracks(canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: a net of hair lines."""
    lines = np.minimum(np.abs(canvas.noise(0.02, 0.02, rng, 2)), np.abs(canvas.noise(0.035, 0.035, rng, 2)))
    wide = 0.05 * max(1.0, canvas.pixel_m / 0.001)
    return np.asarray(np.clip(1.3 - lines / wide, 0.0, 1.0) / max(1.0, canvas.pixel_m / 0.001), dtype=np.float32)


CERAMIC = TextureKind("ceramic_tile", CeramicTile, paint)
"""Kind of tile."""
