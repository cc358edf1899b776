"""Painted fronts: sprayed, brushed, matt, rubbed through, with the wood showing under the paint."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.wood_grain import SawCut, WoodSpecies, grain_maps


class PaintCoat(StrEnum):
    """Method of painting."""

    SPRAYED = "sprayed"
    BRUSHED = "brushed"
    CHALK = "chalk"
    LIMEWASH = "limewash"


class PaintedFront(Record):
    """A painted front.

    Attributes:
        color: of the paint.
        undercoat: what shows where it is rubbed away, and through a thin coat.
        coat: how it was laid on.
        roughness: of the paint, 0..1.
        wear: 0..1, how much is rubbed away.
        species: wood whose grain can be felt under the paint.
        telegraph: 0..1, how much of that grain can be seen.
        groove_spacing_m: distance of upright grooves in metres (tongue and groove boards), 0 for none.
    """

    color: HexColor
    undercoat: HexColor = "#b08d63"
    coat: PaintCoat = PaintCoat.SPRAYED
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.4
    wear: Share = 0.0
    species: WoodSpecies = WoodSpecies()
    telegraph: Share = 0.0
    groove_spacing_m: Annotated[float, Field(ge=0, le=0.3)] = 0.0


def paint(params: PaintedFront, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
    if params.coat is PaintCoat.LIMEWASH:
        thin = smoothstep(-0.2, 1.6, canvas.noise(0.25, 0.006, rng) + 0.6 * canvas.noise(0.5, 0.06, rng))
        albedo = blend(albedo, under, 0.42 * thin)
    if params.wear > 0:
        bare = _rubbed(params.wear, canvas, rng)
        fibre = 1.0 + 0.07 * canvas.noise(0.08, 0.002, rng)
        albedo = blend(albedo, under * fibre[..., None], bare)
        height = height - 0.00008 * bare
        roughness = roughness + 0.12 * bare
    if params.groove_spacing_m > 0:
        depth = _grooves(params.groove_spacing_m, canvas)
        albedo = albedo * (1.0 - 0.30 * depth)[..., None]
        height = height - 0.0025 * depth
    return Layers.of(albedo, height, roughness)


def _coat(coat: PaintCoat, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Relative tone, height in metres and change of roughness that the tool leaves."""
    cloud = canvas.noise(0.5, 0.4, rng, 2)
    if coat is PaintCoat.SPRAYED:
        peel = canvas.noise(0.004, 0.004, rng)
        return 0.004 * cloud, 0.000004 * peel, 0.01 * cloud
    if coat is PaintCoat.CHALK:
        mottle = canvas.noise(0.08, 0.06, rng, 4)
        stroke = canvas.noise(0.12, 0.003, rng)
        return 0.010 * mottle + 0.007 * stroke, 0.00003 * stroke + 0.00001 * mottle, 0.03 * mottle
    # A brush leaves hair lines a hand long, and laps where one stroke ends on another.
    lines = canvas.shifted(canvas.noise(0.28, 0.0017, rng), 0.003 * canvas.noise(0.4, 0.2, rng))
    broad = canvas.noise(0.45, 0.035, rng)
    return 0.007 * lines + 0.004 * broad + 0.004 * cloud, 0.000025 * lines, 0.025 * lines


def _rubbed(worn: float, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: where the paint is gone: in streaks along the grain, in patches."""
    streaks = canvas.noise(0.07, 0.004, rng) + 0.8 * canvas.noise(0.02, 0.0022, rng)
    patch = canvas.noise(0.3, 0.12, rng, 3)
    edge = 3.0 - 2.2 * worn
    return smoothstep(edge, edge + 0.5, streaks + 0.8 * patch)


def _grooves(distance_m: float, canvas: Canvas) -> Map:
    """Mask 0..1: depth of a rounded groove at every board edge; the boards are fitted to the width of the picture."""
    off = canvas.groove_distance(distance_m)
    return np.broadcast_to(np.clip(1.0 - off / 0.0035, 0.0, 1.0), canvas.size_px).astype(np.float32)


PAINTED = TextureKind("painted_front", PaintedFront, paint)
