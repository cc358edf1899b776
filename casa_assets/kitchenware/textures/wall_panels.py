"""Masonry, tiles and panels of walls."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Array,
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
    whole,
)

# Colours of pieces: LOT each as often as the others, in no order; SORT by shape, orientation or place in the pattern.
ColorAssignment = StrEnum("ColorAssignment", "LOT SORT")


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
    height = _relief(params, pieces, glaze, rng)
    gloss = params.roughness + 0.02 * glaze * params.glaze_pooling
    gloss = gloss + 0.03 * params.variety * stratified(pieces.count, rng)[pieces.owner]
    return fill(Layers.of(albedo, height, gloss, params.metallic), params.joint, rim_m, canvas, rng)


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


CERAMIC = TextureKind("ceramic_tile", CeramicTile, paint_ceramic)


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
        # Mask 0..1: dark toward one end of some bricks, as they lay in the kiln.
        lean = pieces.read(rng.normal(0.0, 1.0, pieces.count))
        share = pieces.read(stratified(pieces.count, rng))
        along = pieces.v_m / pieces.read(pieces.half_m[:, 1])
        dark = smoothstep(0.6, 2.2, along * lean + 1.3 * share + 0.4 * cloud) * params.kiln_marks
        albedo = albedo * (1.0 - np.array([0.55, 0.5, 0.42], dtype=np.float32) * dark[..., None])
    proud = pieces.read(rng.normal(0.0, 1.0, pieces.count).clip(-2, 2) * params.protrusion_m)
    lumps = 0.5 * grit + 0.6 * cloud - 1.2 * smoothstep(1.6, 2.3, cloud + 0.5 * grit)
    height = (proud + params.relief_m * 0.4 * lumps).astype(np.float32)
    gloss = np.broadcast_to(np.float32(params.roughness), canvas.size_px) + np.float32(0.03) * cloud
    laid = fill(Layers.of(albedo, height, gloss), params.joint, rim_m, canvas, rng)
    return _coated(params, laid, rim_m, grit, canvas, rng) if params.coat_share > 0 else laid


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


# Profile of the edges of boards, and of the gap between two: BEAD a half round with a groove on each side; SHIPLAP
# square edges, an open shadow line; VEE tongue and groove with broken edges; BATTEN flat boards, a strip on each joint.
BoardProfile = StrEnum("BoardProfile", "BEAD SHIPLAP VEE BATTEN")


class PaintedBoards(Record):
    """A panelled wall that is painted."""

    color: HexColor = Field(description="of the paint")
    ground: HexColor = Field("#242220", description="seen in open joints")
    profile: BoardProfile = Field(description="of the edges")
    pitch_m: float = Field(0.1, gt=0.01, le=1, description="from board to board")
    gap_m: float = Field(0.004, gt=0.001, le=0.2, description="width of groove, batten or opening")
    depth_m: float = Field(0.004, gt=0, le=0.03, description="of groove, batten or opening")
    horizontal: bool = Field(False, description="boards run along u, not along v")
    grain: Share = Field(0.25, description="how much of the wood shows in the relief of the paint")
    wear: Share = Field(0.0, description="how far the paint is rubbed off")
    bare_color: HexColor = Field("#a98a63", description="of the wood where it is bare")
    variety: Share = Field(0.2, description="how much boards differ")
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.5


def paint_boards(params: PaintedBoards, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
    height, groove, open_ = _profile(params, edge, canvas.pixel_width_m)
    lines = canvas.noise(0.5, 0.004, rng) + 0.6 * canvas.noise(0.9, 0.012, rng)
    drop = rng.random(count).astype(np.float32)[board] * np.float32(canvas.tile_m[1])
    lines = canvas.shifted(lines, np.zeros_like(x), drop)
    brush = canvas.noise(0.35, 0.0025, rng) * canvas.resolved(1.0, 0.0025)
    tone = stratified(count, rng).astype(np.float32)[board]
    shade = 1.0 + 0.05 * params.variety * tone + 0.010 * lines + 0.006 * brush + 0.012 * canvas.noise(0.5, 0.3, rng, 3)
    albedo = rgb(params.color) * (shade * (1.0 - 0.28 * groove))[..., None]
    if params.wear > 0:
        start = 2.5 - 1.6 * params.wear
        # Along the grain, more at the edges of a board.
        worn = 0.9 * canvas.noise(0.3, 0.08, rng, 4) + 0.7 * lines + 1.2 * np.exp(-edge / 0.006)
        rubbed = smoothstep(start, start + 0.6, np.asarray(worn, dtype=np.float32))
        bare = rgb(params.bare_color) * (1.0 + 0.07 * lines)[..., None]
        albedo = blend(albedo, bare, rubbed * (1 - groove))
    albedo = blend(albedo, rgb(params.ground), open_)
    relief = height + params.grain * (0.00012 * lines + 0.00004 * brush) * (1.0 - open_)
    rough = params.roughness + 0.02 * lines + 0.25 * open_ + 0.1 * groove
    return Layers.of(albedo, relief, rough)


def _profile(params: PaintedBoards, edge: Array, pixel: float) -> tuple[Array, Array, Array]:
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
        case _:
            strip = band(gap / 2)
            shadow = np.clip(band(gap / 2 + 0.0015) - strip, 0, 1)
            return depth * strip, 0.55 * shadow, none


BOARDS = TextureKind("painted_boards", PaintedBoards, paint_boards)


# Formwork of the concrete: PANELS large plates with joints and tie holes; BOARDS rough boards that left their grain.
Formwork = StrEnum("Formwork", "SMOOTH PANELS BOARDS")


class Concrete(Record):
    """Concrete."""

    color: HexColor = Field(description="of the cement")
    second: HexColor = Field(description="of its clouds")
    formwork: Formwork = Field(Formwork.SMOOTH, description="what it was poured against")
    formwork_unit_m: float = Field(0.6, gt=0.05, le=2, description="width of a board, height of a plate")
    cloudy: Share = Field(0.5, description="how blotchy it is")
    holes: Share = Field(0.3, description="share of bubbles")
    trowel_marks: Share = Field(0.0, description="arcs of the trowel, as on a floor")
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.7


def paint_concrete(params: Concrete, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one wall or floor."""
    cloud = 0.7 * canvas.noise(0.5, 0.45, rng, 6) + 0.5 * canvas.noise(0.08, 0.10, rng, 5)
    fine = canvas.noise(0.006, 0.006, rng, 2)
    # Trowel arcs: streaks of a noise that is bent round and round.
    arcs, dx, dy = canvas.noise(0.02, 0.24, rng, 2), canvas.noise(0.4, 0.4, rng), canvas.noise(0.4, 0.4, rng)
    arcs = canvas.shifted(arcs, 0.11 * dx, 0.11 * dy)
    share = 0.40 * params.cloudy * cloud + 0.06 * fine + 0.28 * params.trowel_marks * arcs
    # Mask 0..1: round holes of a few millimetres that come in swarms.
    dots = canvas.noise(0.009, 0.009, rng) + 0.45 * canvas.noise(0.2, 0.3, rng, 2)
    edge = 3.4 - 1.3 * params.holes
    hole = np.asarray(smoothstep(edge, edge + 0.25, dots) * (params.holes > 0), dtype=np.float32)
    height, dark = 0.0001 * cloud + 0.00004 * fine - 0.0018 * hole, 0.42 * hole
    if params.formwork is Formwork.BOARDS:
        share, height, dark = _board_marks(params, canvas, share, height, dark, rng)
    elif params.formwork is Formwork.PANELS:
        joint, tie, tone = _plates(params, canvas, canvas.pixel_m, rng)
        share, height = share + 0.22 * tone, height - 0.004 * joint - 0.012 * tie
        dark = np.maximum(dark, np.maximum(0.45 * joint, 0.6 * tie))
    albedo = blend(rgb(params.color), rgb(params.second), np.clip(share, -0.8, 1.2)) * (1.0 - dark)[..., None]
    rough = params.roughness + 0.05 * cloud * params.cloudy + 0.15 * (hole > 0.5) + 0.05 * params.trowel_marks * arcs
    return Layers.of(albedo, height, rough)


def _board_marks(
    params: Concrete, canvas: Canvas, share: Map, height: Map, dark: Map, rng: np.random.Generator
) -> tuple[Map, Map, Map]:
    """Grain and ridges of a formwork of level boards."""
    _, y = canvas.axes()
    count, pitch = whole(canvas.tile_m[1], params.formwork_unit_m)
    board = np.minimum((y / pitch).astype(np.intp), count - 1)
    jump = rng.random(count).astype(np.float32)[board] * np.float32(canvas.tile_m[0])
    lines = canvas.shifted(canvas.noise(0.0055, 0.7, rng) + 0.8 * canvas.noise(0.016, 1.0, rng, 2), jump + 0 * share)
    edge = (0.5 - np.abs(np.mod(y / pitch, 1.0) - 0.5)) * pitch
    pixel = canvas.tile_m[1] / canvas.size_px[0]
    ridge = np.clip(1.4 - edge / max(0.0018, 0.7 * pixel), 0, 1) * min(1.0, 0.004 / pixel)
    tone, step = stratified(count, rng).astype(np.float32)[board], rng.normal(0, 1, count).astype(np.float32)[board]
    return (
        np.asarray(share + 0.09 * lines + 0.30 * tone),
        np.asarray(height + 0.0005 * lines + 0.0011 * np.clip(step, -2, 2) + 0.0016 * ridge),
        np.maximum(dark, 0.30 * ridge),
    )


def _plates(params: Concrete, canvas: Canvas, pixel: float, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Joints, tie holes 0..1, and the tone of each plate."""
    x, y = canvas.axes()
    rows, tall = whole(canvas.tile_m[1], params.formwork_unit_m)
    columns, wide = whole(canvas.tile_m[0], 2 * params.formwork_unit_m)
    row, column = np.minimum((y / tall).astype(np.intp), rows - 1), np.minimum((x / wide).astype(np.intp), columns - 1)
    in_x, in_y = np.mod(x, wide), np.mod(y, tall)
    edge = np.minimum(np.minimum(in_x, wide - in_x), np.minimum(in_y, tall - in_y))
    joint = np.clip((0.003 - edge) / pixel + 0.5, 0, 1) - np.clip((-0.003 - edge) / pixel + 0.5, 0, 1)
    # Four ties to a plate, a quarter in from its ends and its edges.
    tx, ty = np.abs(np.abs(in_x - wide / 2) - wide / 4), np.abs(np.abs(in_y - tall / 2) - tall / 4)
    tie = np.clip((0.012 - np.hypot(tx, ty)) / pixel + 0.5, 0, 1)
    tone = stratified(rows * columns, rng).astype(np.float32)[row * columns + column]
    return joint.astype(np.float32), tie.astype(np.float32), tone


class PressedTin(Record):
    """Pressed metal plates."""

    color: HexColor = Field(description="of the metal or of the paint on it")
    hollow_color: HexColor = Field(description="gathers in the hollows")
    plate_m: float = Field(0.3, gt=0.1, le=1, description="side of a plate")
    rings: int = Field(2, ge=1, le=5, description="mouldings that frame the middle")
    petals: int = Field(8, ge=0, le=16, description="of the flower in the middle")
    metallic: Share = 0.0
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.4


def paint_tin(params: PressedTin, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of plates."""
    x, y = canvas.axes()
    _, wide = whole(canvas.tile_m[0], params.plate_m)
    _, tall = whole(canvas.tile_m[1], params.plate_m)
    u, v = np.mod(x / wide, 1.0) - 0.5, np.mod(y / tall, 1.0) - 0.5
    side, far = 2.0 * np.maximum(np.abs(u), np.abs(v)), 2.0 * np.hypot(u, v)
    height = _moulding(side, 0.93, 0.03) + 0.55 * _moulding(side, 0.80, 0.02)
    for ring in range(params.rings):
        height = height + 0.8 * _moulding(far, 0.70 - 0.13 * ring, 0.025)
    if params.petals:
        height = height + _flower(u, v, params.petals)
    corner = np.hypot(np.abs(u) - 0.5, np.abs(v) - 0.5)
    height = height + 1.1 * np.sqrt(np.clip(1.0 - (corner / 0.09) ** 2, 0, 1)) + _scroll(u, v)
    height = np.asarray(height, dtype=np.float32)
    seam = np.clip(1.2 - (0.5 - np.maximum(np.abs(u), np.abs(v))) * params.plate_m / 0.0015, 0, 1)
    dent = canvas.noise(0.12, 0.12, rng, 2)
    tone = canvas.noise(0.25, 0.25, rng, 4)
    hollow = smoothstep(0.35, -0.05, height) * (0.6 + 0.25 * tone)
    albedo = blend(rgb(params.color), rgb(params.hollow_color), np.clip(0.7 * hollow, 0, 1))
    return Layers.of(
        albedo * (1.0 + 0.025 * tone - 0.3 * seam)[..., None],
        0.005 * height + 0.00012 * dent - 0.001 * seam,
        params.roughness + 0.15 * hollow + 0.03 * tone,
        params.metallic,
    )


def _moulding(at: Array, middle: float, half: float) -> Array:
    """A half round around a distance."""
    return np.asarray(np.sqrt(np.clip(1.0 - ((at - middle) / half) ** 2, 0.0, 1.0)))


def _flower(u: Array, v: Array, petals: int) -> Array:
    far, bearing = 2.0 * np.hypot(u, v), np.arctan2(v, u)
    reach = 0.12 + 0.24 * np.abs(np.cos(bearing * petals / 2.0)) ** 0.7
    leaf = np.clip(1.0 - (far / reach) ** 2, 0, 1) * smoothstep(0.06, 0.12, far)
    vein = 0.25 * np.abs(np.sin(bearing * petals / 2.0)) ** 8
    return np.asarray(0.9 * leaf - vein * leaf + 1.2 * np.sqrt(np.clip(1.0 - (far / 0.08) ** 2, 0, 1)))


def _scroll(u: Array, v: Array) -> Array:
    """A leaf that points at each corner."""
    a, b = (np.abs(u) + np.abs(v)) / np.sqrt(2.0), np.abs(np.abs(u) - np.abs(v)) / np.sqrt(2.0)
    t = (a - 0.40) / 0.20
    half = 0.075 * np.sqrt(np.clip(t * (1.0 - t) * 4.0, 0, 1)) * (t > 0) * (t < 1)
    return np.asarray(0.8 * np.sqrt(np.clip(1.0 - (b / np.maximum(half, 1e-4)) ** 2, 0, 1)) * (half > 0.002))


CONCRETE = TextureKind("concrete", Concrete, paint_concrete)
TIN = TextureKind("pressed_tin", PressedTin, paint_tin)
