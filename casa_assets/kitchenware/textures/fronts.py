"""Fronts of cabinets: manufactured boards, painted fronts, solid wood and veneers."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import (
    Canvas,
    Layers,
    Map,
    SawCut,
    Share,
    TextureKind,
    WoodPalette,
    WoodSpecies,
    blend,
    grain_maps,
    line_coverage,
    rgb,
    smoothstep,
    wood,
)

# Print or relief of the face.
FrontFace = Literal["plain", "linen", "concrete", "ribbed", "fluted", "brushed", "peel", "linoleum", "leather", "cane"]


class PressedFront(Record):
    """A manufactured front."""

    color: HexColor = Field(description="of the face")
    second: HexColor = Field(description="of threads, clouds or lines on it")
    face: FrontFace = Field("plain", description="pattern")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.6
    strength: Share = Field(0.5, description="how plain the pattern is to see")
    pitch_m: float = Field(0.02, gt=0.003, lt=0.2, description="distance of ribs, flutes or cane holes")


def paint_board(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of board; ribs run along v."""
    share, height, gloss, shade = _FACES[params.face](params, canvas, rng)
    share = np.clip(params.strength * share, 0.0, 1.0)
    albedo = blend(rgb(params.color), rgb(params.second), share) * shade[..., None]
    return Layers.of(albedo, np.broadcast_to(height, canvas.size_px), params.roughness + gloss)


_Parts = tuple[Map, Map, Map, Map]


def _plain(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = canvas.noise(0.5, 0.4, rng, 2)
    return 0.08 * cloud, 0.000001 * canvas.noise(0.003, 0.003, rng), 0.008 * cloud, np.ones_like(cloud)


def _linen(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Threads of uneven thickness, over and under."""
    warp = canvas.noise(0.4, 0.0021, rng) + 0.45 * canvas.noise(0.037, 0.0023, rng)
    weft = canvas.noise(0.0021, 0.4, rng) + 0.45 * canvas.noise(0.0023, 0.037, rng)
    slub = smoothstep(1.3, 2.2, canvas.noise(0.05, 0.0035, rng)) + smoothstep(1.3, 2.2, canvas.noise(0.0035, 0.05, rng))
    return (0.5 + 0.24 * (warp + weft) + 0.5 * slub), 0.00003 * np.maximum(warp, weft), 0.03 * warp, np.ones_like(warp)


def _concrete(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    cloud = 0.6 * canvas.noise(0.45, 0.4, rng, 6) + 0.5 * canvas.noise(0.07, 0.09, rng, 5)
    fine = canvas.noise(0.01, 0.01, rng, 3)
    holes = smoothstep(2.3, 2.7, canvas.noise(0.006, 0.006, rng) + 0.4 * canvas.noise(0.1, 0.1, rng))
    share = 0.45 + 0.35 * cloud + 0.10 * fine
    return share, 0.00001 * fine - 0.0002 * holes, 0.04 * cloud, 1.0 - 0.3 * params.strength * holes


def _ribbed(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Narrow V grooves with flat ground between them."""
    groove = np.clip(1.0 - canvas.groove_distance(params.pitch_m) / 0.0022, 0.0, 1.0)
    lines = canvas.noise(0.3, 0.0025, rng)
    return 0.12 * lines, -0.002 * groove, 0.01 * lines, 1.0 - 0.40 * groove + 0.0 * lines


def _fluted(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Half rounds side by side."""
    count = max(1, round(canvas.tile_m[0] / params.pitch_m))
    across = canvas.groove_distance(params.pitch_m) / (canvas.tile_m[0] / count)  # 0 in the groove, 0.5 on the crest
    crest = np.sqrt(np.clip(1.0 - (1.0 - 2.0 * across) ** 2, 0.0, 1.0))
    lines = canvas.noise(0.3, 0.003, rng)
    return 0.3 + 0.25 * lines, 0.3 * params.pitch_m * crest, 0.01 * lines, 0.80 + 0.20 * crest**0.6 + 0.0 * lines


def _brushed(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    lines = canvas.noise(0.5, 0.0014, rng) + 0.6 * canvas.noise(1.0, 0.01, rng)
    return 0.5 + 0.3 * lines, 0.000006 * lines, 0.03 * lines, np.ones_like(lines)


def _peel(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    peel = canvas.noise(0.005, 0.005, rng)
    return 0.06 * canvas.noise(0.4, 0.4, rng), 0.00002 * peel, 0.004 * peel, np.ones_like(peel)


def _linoleum(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Wood flour and cork in a calendered sheet: soft crumbs of two sizes."""
    crumbs = canvas.noise(0.004, 0.003, rng) + 0.7 * canvas.noise(0.012, 0.008, rng)
    return smoothstep(0.2, 2.0, crumbs), 0.000004 * crumbs, 0.02 * crumbs, 1.0 + 0.012 * crumbs


def _leather(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Low round bumps between creases."""
    bumps = np.abs(canvas.noise(0.007, 0.007, rng)) + 0.5 * np.abs(canvas.noise(0.0035, 0.0035, rng))
    crease = 1.0 - smoothstep(0.1, 0.6, bumps)
    cloud = canvas.noise(0.3, 0.3, rng, 3)
    return crease + 0.06 * cloud, 0.00008 * np.minimum(bumps, 1.0), 0.08 * crease, np.ones_like(crease)


def _cane(params: PressedFront, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Woven cane: pairs of strands upright and level, single ones slanting, six-cornered holes between."""
    x, y = canvas.axes()
    u = x / (canvas.tile_m[0] / max(1, round(canvas.tile_m[0] / params.pitch_m)))
    v = y / (canvas.tile_m[1] / max(1, round(canvas.tile_m[1] / params.pitch_m)))
    upright, level = _strand(u, 0.30) + 0.0 * v, _strand(v, 0.30) + 0.0 * u
    rising, falling = _strand(u + v + 0.5, 0.17), _strand(u - v + 0.5, 0.17)
    over = np.maximum.reduce([upright * 0.92, level, rising * 0.85, falling * 0.8])
    tint = canvas.noise(0.2, 0.004, rng) * (upright > level) + canvas.noise(0.004, 0.2, rng) * (level >= upright)
    hole = 1.0 - smoothstep(0.05, 0.3, over)
    return hole, 0.0012 * over, 0.25 * hole, (0.80 + 0.2 * np.sqrt(over)) * (1.0 + 0.03 * tint)


def _strand(at: Map, width: float) -> Map:
    """Round profile 0..1 of a strand on every whole number, `width` of the pitch wide."""
    off = np.abs(np.mod(at + 0.5, 1.0) - 0.5) / (width / 2.0)
    return np.asarray(np.sqrt(np.clip(1.0 - off**2, 0.0, 1.0)), dtype=np.float32)


_FACES = {
    maker.__name__.removeprefix("_"): maker
    for maker in (_plain, _linen, _concrete, _ribbed, _fluted, _brushed, _peel, _linoleum, _leather, _cane)
}

PRESSED = TextureKind("pressed_front", PressedFront, paint_board)


# Method of painting.
PaintCoat = Literal["sprayed", "brushed", "chalk", "limewash"]


class PaintedFront(Record):
    """A painted front."""

    color: HexColor = Field(description="of the paint")
    undercoat: HexColor = Field("#b08d63", description="what shows where it is rubbed away, and through a thin coat")
    coat: PaintCoat = Field("sprayed", description="how it was laid on")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.4
    wear: Share = Field(0.0, description="how much is rubbed away")
    species: WoodSpecies = Field(WoodSpecies(), description="wood whose grain can be felt under the paint")
    telegraph: Share = Field(0.0, description="how much of that grain can be seen")
    groove_spacing_m: float = Field(0.0, ge=0, le=0.3, description="distance of upright grooves; 0: none")


def paint_painted(params: PaintedFront, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of paint, brush strokes and grain along v."""
    color, under = rgb(params.color), rgb(params.undercoat)
    tone, height, gloss = _coat(params.coat, canvas, rng)
    albedo = color * (1.0 + tone)[..., None]
    roughness = params.roughness + gloss
    if params.telegraph > 0:
        grain = grain_maps(canvas, params.species, SawCut.RIFT, 1, rng)
        open_grain = params.telegraph * (0.55 * grain.pore * (0.3 + 0.7 * grain.early) + 0.35 * grain.ring)
        depth = 0.35 * open_grain + 0.05 * params.telegraph * grain.fibre
        albedo = albedo * (1.0 - 0.28 * depth)[..., None]
        height = height - 0.00025 * open_grain
    if params.coat == "limewash":
        thin = smoothstep(-0.2, 1.6, canvas.noise(0.25, 0.006, rng) + 0.6 * canvas.noise(0.5, 0.06, rng))
        albedo = blend(albedo, under, 0.42 * thin)
    if params.wear > 0:
        # Mask 0..1: where the paint is gone: in streaks along the grain, in patches.
        streaks = canvas.noise(0.07, 0.004, rng) + 0.8 * canvas.noise(0.02, 0.0022, rng)
        patch = canvas.noise(0.3, 0.12, rng, 3)
        edge = 3.0 - 2.2 * params.wear
        bare = smoothstep(edge, edge + 0.5, streaks + 0.8 * patch)
        albedo = blend(albedo, under * (1.0 + 0.07 * canvas.noise(0.08, 0.002, rng))[..., None], bare)
        height, roughness = height - 0.00008 * bare, roughness + 0.12 * bare
    if params.groove_spacing_m > 0:
        # Rounded grooves at the edges of boards that are fitted to the width of the picture.
        off = canvas.groove_distance(params.groove_spacing_m)
        depth = np.broadcast_to(np.clip(1.0 - off / 0.0035, 0.0, 1.0), canvas.size_px).astype(np.float32)
        albedo = albedo * (1.0 - 0.30 * depth)[..., None]
        height = height - 0.0025 * depth
    return Layers.of(albedo, height, roughness)


def _coat(coat: PaintCoat, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Relative tone, height in metres and change of roughness that the tool leaves."""
    cloud = canvas.noise(0.5, 0.4, rng, 2)
    if coat == "sprayed":
        return 0.004 * cloud, 0.000004 * canvas.noise(0.004, 0.004, rng), 0.01 * cloud
    if coat == "chalk":
        mottle = canvas.noise(0.08, 0.06, rng, 4)
        stroke = canvas.noise(0.12, 0.003, rng)
        return 0.010 * mottle + 0.007 * stroke, 0.00003 * stroke + 0.00001 * mottle, 0.03 * mottle
    # A brush leaves hair lines a hand long, and laps where one stroke ends on another.
    lines = canvas.shifted(canvas.noise(0.28, 0.0017, rng), 0.003 * canvas.noise(0.4, 0.2, rng))
    return 0.007 * lines + 0.004 * canvas.noise(0.45, 0.035, rng) + 0.004 * cloud, 0.000025 * lines, 0.025 * lines


PAINTED = TextureKind("painted_front", PaintedFront, paint_painted)


class Veneer(Record):
    """A wooden front."""

    species: WoodSpecies
    palette: WoodPalette
    cut: SawCut = Field(description="what the face shows")
    leaves: int = Field(1, ge=1, le=64, description="veneers or boards side by side over the width of the picture")
    gap_m: float = Field(0.0, ge=0, le=0.01, description="open joint between boards; 0: a glued face")
    node_spacing_m: float = Field(0.0, ge=0, le=1, description="distance of the nodes of bamboo along a strip; 0: wood")
    saw_marks: Share = Field(0.0, description="strength of the level lines that a saw leaves")
    weather: Share = Field(0.0, description="how grey and cracked the face has become")


def paint_veneer(params: Veneer, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet of fronts, grain along v."""
    grain = grain_maps(canvas, params.species, params.cut, params.leaves, rng)
    face = wood.finish_wood(grain, params.species, params.palette, canvas, rng)
    albedo, height, roughness = face.albedo, face.height_m, face.roughness
    if params.weather > 0:
        grey = np.array([0.60, 0.57, 0.53], dtype=np.float32) * (0.9 + 0.08 * grain.fibre[..., None])
        patch = params.weather * smoothstep(-1.4, 1.2, canvas.noise(0.35, 0.09, rng, 3) + 0.4 * grain.tone)
        albedo = blend(albedo, grey, 0.75 * patch)
        crack = smoothstep(2.0, 2.5, canvas.noise(0.18, 0.0022, rng) + 0.5 * canvas.noise(0.5, 0.05, rng))
        albedo = albedo * (1.0 - 0.6 * params.weather * crack)[..., None]
        height = height - 0.0006 * params.weather * crack
        roughness = roughness + 0.25 * params.weather * patch
    if params.saw_marks > 0:
        lines = canvas.noise(0.0045, 0.25, rng) * smoothstep(-0.8, 1.2, canvas.noise(0.3, 0.1, rng) + grain.tone)
        albedo = albedo * (1.0 - 0.07 * params.saw_marks * np.maximum(lines, -0.6))[..., None]
        height = height - 0.00012 * params.saw_marks * np.maximum(lines, 0.0)
    if params.node_spacing_m > 0:
        # Mask 0..1: a dark line across each strip, at another height in each.
        _, y = canvas.axes()
        pitch = canvas.tile_m[1] / max(1, round(canvas.tile_m[1] / params.node_spacing_m))
        off = (np.mod(y / pitch + 7.3 * grain.tone, 1.0) - 0.5) * pitch
        line = np.exp(-((off / 0.0022) ** 2)) + 0.35 * np.exp(-np.maximum(off, 0.0) / 0.012) * (off > 0)
        albedo = albedo * (1.0 - 0.2 * np.clip(line, 0.0, 1.0).astype(np.float32))[..., None]
    if params.gap_m > 0:
        gap = line_coverage(grain.edge_m, params.gap_m, canvas.pixel_width_m)
        albedo = albedo * (1.0 - 0.75 * gap)[..., None]
        height = height - 0.002 * gap
    return Layers.of(albedo, height, roughness)


VENEER = TextureKind("veneer", Veneer, paint_veneer)
