"""Panelled walls: beadboard, shiplap, board and batten, tongue and groove, slats; painted or of bare wood."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.laying.pieces import Array, whole


class BoardProfile(StrEnum):
    """Profile of the edges of boards, and of the gap between two."""

    BEAD = "bead"  # a half round with a groove on each side
    SHIPLAP = "shiplap"  # square edges, an open shadow line
    VEE = "vee"  # tongue and groove with broken edges
    BATTEN = "batten"  # flat boards, a strip over each joint
    SLAT = "slat"  # slim strips on a dark ground
    FLUTED = "fluted"  # half rounds side by side
    CHANNEL = "channel"  # wide flat grooves


class PaintedBoards(Record):
    """A panelled wall that is painted.

    Attributes:
        color: of the paint; `ground` what is seen between slats.
        profile: of the edges.
        pitch_m: from board to board, metres.
        gap_m: width of groove, batten or opening, metres; depth_m: its depth.
        horizontal: boards run along u, not along v.
        grain: 0..1, how much of the wood shows in the relief of the paint; wear: how far it is rubbed off.
        bare_color: colour of the wood where it is.
        variety: 0..1, how much boards differ.
        roughness: 0..1.
    """

    color: HexColor
    ground: HexColor = "#242220"
    profile: BoardProfile
    pitch_m: Annotated[float, Field(gt=0.01, le=1)] = 0.1
    gap_m: Annotated[float, Field(gt=0.001, le=0.2)] = 0.004
    depth_m: Annotated[float, Field(gt=0, le=0.03)] = 0.004
    horizontal: bool = False
    grain: Share = 0.25
    wear: Share = 0.0
    bare_color: HexColor = "#a98a63"
    variety: Share = 0.2
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.5


def paint(params: PaintedBoards, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one wall. Boards are painted upright and turned over where they are level."""
    if params.horizontal:
        return _upright(params, canvas.transposed, rng).transposed
    return _upright(params, canvas, rng)


def _upright(params: PaintedBoards, canvas: Canvas, rng: np.random.Generator) -> Layers:
    count, pitch = whole(canvas.tile_m[0], params.pitch_m)
    x, _ = canvas.axes()
    board = np.minimum((x / pitch).astype(np.intp), count - 1)
    off = np.abs(np.mod(x / pitch, 1.0) - 0.5) * pitch  # 0 in the middle of a board
    edge = pitch / 2 - off
    height, groove, open_ = _profile(params, edge, pitch, canvas.pixel_width_m)
    lines = canvas.noise(0.5, 0.004, rng) + 0.6 * canvas.noise(0.9, 0.012, rng)
    lines = canvas.shifted(
        lines, np.zeros_like(x), rng.random(count).astype(np.float32)[board] * np.float32(canvas.tile_m[1])
    )
    brush = canvas.noise(0.35, 0.0025, rng) * canvas.resolved(1.0, 0.0025)
    tone = stratified(count, rng).astype(np.float32)[board]
    shade = 1.0 + 0.05 * params.variety * tone + 0.010 * lines + 0.006 * brush + 0.012 * canvas.noise(0.5, 0.3, rng, 3)
    albedo = rgb(params.color) * (shade * (1.0 - 0.28 * groove))[..., None]
    if params.wear > 0:
        start = 2.5 - 1.6 * params.wear
        rubbed = smoothstep(start, start + 0.6, _rubbed(canvas, lines, edge, rng))
        bare = rgb(params.bare_color) * (1.0 + 0.07 * lines)[..., None]
        albedo = blend(albedo, bare, rubbed * (1 - groove))
    albedo = blend(albedo, rgb(params.ground), open_)
    relief = height + params.grain * (0.00012 * lines + 0.00004 * brush) * (1.0 - open_)
    rough = params.roughness + 0.02 * lines + 0.25 * open_ + 0.1 * groove
    return Layers.of(albedo, relief, rough)


def _rubbed(canvas: Canvas, lines: Map, edge_m: Array, rng: np.random.Generator) -> Map:
    """Wear: along the grain, more at the edges of a board."""
    rims = np.exp(-edge_m / 0.006)
    return np.asarray(0.9 * canvas.noise(0.3, 0.08, rng, 4) + 0.7 * lines + 1.2 * rims, dtype=np.float32)


def _profile(params: PaintedBoards, edge: Array, pitch: float, pixel: float) -> tuple[Array, Array, Array]:
    """Height in metres, shade of grooves 0..1, and openings 0..1, over the distance from the joint (1, W)."""
    gap, depth = params.gap_m, params.depth_m
    none = np.zeros_like(edge)

    def band(half: float) -> Array:
        # Share of a pixel within `half` of the joint: thin lines fade on coarse pictures.
        share = np.clip((half - edge) / pixel + 0.5, 0, 1) - np.clip((-half - edge) / pixel + 0.5, 0, 1)
        return np.asarray(share)

    match params.profile:
        case BoardProfile.BEAD:
            bead: Array = np.sqrt(np.clip(1.0 - (edge / (0.5 * gap)) ** 2, 0, 1))
            line: Array = np.clip(band(0.5 * gap + 0.0018) - band(0.5 * gap), 0, 1)
            return depth * (0.5 * bead - line), 0.9 * line, none
        case BoardProfile.SHIPLAP:
            line = band(gap / 2)
            return -depth * line + 0.0004 * (np.minimum(edge / 0.003, 1) - 1), 0.85 * line, 0.55 * line
        case BoardProfile.VEE:
            broken: Array = np.clip(1.0 - edge / (gap / 2), 0, 1)
            return -depth * broken, 0.30 * broken + 0.45 * band(0.0008), none
        case BoardProfile.BATTEN:
            strip = band(gap / 2)
            shadow = np.clip(band(gap / 2 + 0.0015) - strip, 0, 1)
            return depth * strip, 0.55 * shadow, none
        case BoardProfile.SLAT:
            line = band(gap / 2)
            rise: Array = np.minimum(np.maximum(edge - gap / 2, 0) / 0.0015, 1)
            return -depth * line + 0.0008 * (rise - 1), 0.2 * line, line
        case BoardProfile.FLUTED:
            across: Array = np.clip(1.0 - edge / (pitch / 2), 0, 1)
            crest: Array = np.sqrt(np.clip(1.0 - across**2, 0, 1))
            return depth * crest, 0.5 * (1 - crest), none
        case _:
            slope: Array = np.clip((gap / 2 + 0.003 - edge) / 0.003, 0, 1)
            return -depth * slope, 0.18 * slope, none


BOARDS = TextureKind("painted_boards", PaintedBoards, paint)
"""Kind of painted panelling."""
