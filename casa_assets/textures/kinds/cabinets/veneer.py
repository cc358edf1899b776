"""Wooden fronts: solid boards and veneers, oiled, stained, limed, brushed, weathered."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures import wood
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, line_coverage, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.wood import WoodPalette
from casa_assets.textures.wood_grain import SawCut, WoodSpecies, grain_maps


class Veneer(Record):
    """A wooden front.

    Attributes:
        species, palette: anatomy of the wood and colours of its finish.
        cut: what the face shows.
        leaves: veneers or boards side by side over the width of the picture.
        gap_m: open joint between boards in metres, 0 for a glued face.
        node_spacing_m: distance of the nodes of bamboo along a strip in metres, 0 for wood.
        saw_marks: 0..1, strength of the level lines that a saw leaves.
        weather: 0..1, how grey and cracked the face has become.
    """

    species: WoodSpecies
    palette: WoodPalette
    cut: SawCut
    leaves: Annotated[int, Field(ge=1, le=64)] = 1
    gap_m: Annotated[float, Field(ge=0, le=0.01)] = 0.0
    node_spacing_m: Annotated[float, Field(ge=0, le=1)] = 0.0
    saw_marks: Share = 0.0
    weather: Share = 0.0


def paint(params: Veneer, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
        node = _nodes(params.node_spacing_m, canvas, grain.tone)
        albedo = albedo * (1.0 - 0.2 * node)[..., None]
    if params.gap_m > 0:
        gap = line_coverage(grain.edge_m, params.gap_m, canvas.pixel_width_m)
        albedo = albedo * (1.0 - 0.75 * gap)[..., None]
        height = height - 0.002 * gap
    return Layers.of(albedo, height, roughness)


def _nodes(distance_m: float, canvas: Canvas, tone: Map) -> Map:
    """Mask 0..1: a dark line across each strip, at another height in each."""
    _, y = canvas.axes()
    pitch = canvas.tile_m[1] / max(1, round(canvas.tile_m[1] / distance_m))
    off = (np.mod(y / pitch + 7.3 * tone, 1.0) - 0.5) * pitch
    line = np.exp(-((off / 0.0022) ** 2)) + 0.35 * np.exp(-np.maximum(off, 0.0) / 0.012) * (off > 0)
    return np.clip(line, 0.0, 1.0).astype(np.float32)


VENEER = TextureKind("veneer", Veneer, paint)
