"""Joints between pieces, and the edges of the adjoining pieces."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb
from casa_assets.textures.laying.pieces import PieceMap


class TileEdge(StrEnum):
    """Profile of a piece at its rim."""

    SQUARE = "square"  # broken by half a millimetre
    BEVEL = "bevel"  # a straight slope
    PILLOW = "pillow"  # a dome that falls off toward the rim


class Joint(Record):
    """Joint between pieces.

    Attributes:
        color: of the grout or mortar.
        width_m: metres; 0 where pieces touch.
        depth_m: how far it lies below the rim of the pieces, metres.
        roughness: 0..1.
        edge: profile of the pieces; `edge_width_m` is how wide it is, `rim_drop_m` how deep it falls, metres.
        rim_noise_m: how far the rim of a piece strays from its outline, metres.
        coarseness: 0..1, how coarse the filling is.
    """

    color: HexColor = "#b8b2a6"
    width_m: Annotated[float, Field(ge=0, le=0.03)] = 0.003
    depth_m: Annotated[float, Field(ge=0, le=0.02)] = 0.001
    roughness: Annotated[float, Field(ge=0.1, le=1)] = 0.88
    edge: TileEdge = TileEdge.SQUARE
    edge_width_m: Annotated[float, Field(ge=0.0002, le=0.05)] = 0.001
    rim_drop_m: Annotated[float, Field(ge=0, le=0.01)] = 0.0004
    rim_noise_m: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    coarseness: Share = 0.3


def rim(joint: Joint, pieces: PieceMap, canvas: Canvas, rng: np.random.Generator) -> Map:
    """(H, W) metres from the rim of the piece, positive on it, with the strayings of hand-made pieces."""
    inside = pieces.inside_m - np.float32(joint.width_m / 2)
    if joint.rim_noise_m > 0:
        stray = 0.7 * canvas.noise(0.03, 0.03, rng, 2) + 0.5 * canvas.noise(0.008, 0.008, rng, 2)
        inside = inside - np.float32(0.5 * joint.rim_noise_m) * np.maximum(stray, -0.6)
    return np.asarray(inside, dtype=np.float32)


def gap(joint: Joint, rim_m: Map, canvas: Canvas) -> Map:
    """(H, W) 0..1, share of a pixel that the joint covers; thin joints of coarse pictures fade, they do not widen."""
    pixel, half = np.float32(canvas.pixel_m), np.float32(joint.width_m / 2)
    to_middle = np.maximum(rim_m + half, 0.0)
    covered = np.clip((half - to_middle) / pixel + 0.5, 0, 1) - np.clip((-half - to_middle) / pixel + 0.5, 0, 1)
    return np.asarray(np.where(rim_m + half < -0.5 * pixel, 1.0, covered), dtype=np.float32)


def profile(joint: Joint, rim_m: Map) -> Map:
    """(H, W) metres, 0 in the middle of a piece and -drop_m at its rim."""
    t = np.clip(rim_m / np.float32(joint.edge_width_m), 0.0, None)
    if joint.edge is TileEdge.BEVEL:
        rise = np.minimum(t, 1.0)
    elif joint.edge is TileEdge.PILLOW:
        rise = 1.0 - np.exp(-2.5 * t)
    else:
        rise = np.sqrt(np.clip(1.0 - (1.0 - np.minimum(t, 1.0)) ** 2, 0.0, 1.0))
    return np.asarray((rise - 1.0) * joint.rim_drop_m, dtype=np.float32)


def fill(face: Layers, joint: Joint, rim_m: Map, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """The pieces with their rims worked and the joints filled.

    Args:
        face: colour, relief and gloss of the pieces, everywhere.
        joint: what lies between. rim_m: of `rim`.
    """
    share = gap(joint, rim_m, canvas)
    sand = canvas.resolved(0.003, 0.003) * canvas.noise(0.003, 0.003, rng) + 0.5 * canvas.noise(0.012, 0.012, rng, 3)
    stain = canvas.noise(0.3, 0.3, rng, 3)
    shade = 1.0 + joint.coarseness * 0.06 * sand + 0.03 * stain
    mortar = rgb(joint.color) * shade[..., None]
    height = face.height_m + profile(joint, rim_m)
    low = -joint.rim_drop_m - joint.depth_m + 0.0004 * joint.coarseness * sand
    return Layers.of(
        blend(face.albedo, mortar, share),
        height + (low - height) * share,
        face.roughness + (joint.roughness - face.roughness) * share,
        face.metallic,
    )
