"""Sheet metal: brushed, swirled, hammered, and how zinc and copper age."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.voronoi import voronoi_cells


class MetalTooling(StrEnum):
    """Marks of the tool on the metal."""

    ALONG = "along"  # brushed along u
    UPRIGHT = "upright"  # brushed along v
    ORBITAL = "orbital"  # many small arcs
    TURNED = "turned"  # rows of overlapping round swirls
    HAMMERED = "hammered"
    ROLLED = "rolled"  # as it left the mill
    QUILTED = "quilted"  # pressed diamonds, as behind a diner's counter


class SheetMetal(Record):
    """A metal sheet.

    Attributes:
        color: of the clean metal.
        patina_color: of its patina.
        patina: 0..1, how much of the face has it.
        spots: 0..1, drops and rings that a used counter has.
        tooling: marks of the tool; `mark_m` is the size of one in metres, where it has one.
        roughness: 0..1.
        metallic: 0..1; a thick patina is hardly metal any more.
    """

    color: HexColor
    patina_color: HexColor
    patina: Share = 0.0
    spots: Share = 0.0
    tooling: MetalTooling = MetalTooling.ALONG
    mark_m: Annotated[float, Field(gt=0.003, lt=0.4)] = 0.02
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.3
    metallic: Share = 1.0


def paint(params: SheetMetal, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one sheet."""
    tone, height, gloss = _marks(params, canvas, rng)
    cloud = canvas.noise(0.5, 0.6, rng, 3)
    albedo = rgb(params.color) * (1.0 + 0.05 * tone + 0.012 * cloud)[..., None]
    roughness = params.roughness + 0.04 * gloss + 0.015 * cloud
    if params.patina > 0:
        field = 0.8 * canvas.noise(0.25, 0.3, rng, 6) + 0.5 * canvas.noise(0.05, 0.06, rng, 5)
        edge = 1.6 - 3.0 * params.patina
        share = 0.6 * smoothstep(edge - 2.0, edge + 2.0, field)
        deep = 1.0 + 0.08 * canvas.noise(0.05, 0.05, rng, 4)
        albedo = blend(albedo, rgb(params.patina_color) * deep[..., None], share)
        roughness = roughness + 0.25 * share
        height = height + 0.000004 * share
    if params.spots > 0:
        mark = _spots(params.spots, canvas, rng)
        albedo = blend(albedo, rgb(params.patina_color), 0.45 * mark)
        roughness = roughness + 0.1 * mark
    return Layers.of(albedo, height, np.clip(roughness, 0.06, 1.0), params.metallic)


def _marks(params: SheetMetal, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Tone and gloss of deviation about 1, height in metres."""
    tooling, mark = params.tooling, params.mark_m
    if tooling in (MetalTooling.ALONG, MetalTooling.UPRIGHT):
        sizes = ((0.0012, 0.35), (0.0025, 0.9), (0.02, 1.2))
        pairs = [s if tooling is MetalTooling.ALONG else s[::-1] for s in sizes]
        lines = sum((w * canvas.noise(*s, rng) for w, s in zip((1.0, 0.7, 0.35), pairs, strict=True)), np.float32(0))
        lines = np.asarray(lines, dtype=np.float32)
        return 0.75 * lines, 0.000002 * lines, 0.8 * lines
    if tooling is MetalTooling.ORBITAL:
        return _arcs(canvas, mark, rng)
    if tooling is MetalTooling.TURNED:
        return _turned(canvas, mark, rng)
    if tooling is MetalTooling.HAMMERED:
        dents = voronoi_cells(canvas, mark, rng, bend_m=0.05 * mark)
        bowl = np.minimum(dents.near_m / mark, 0.62) ** 2
        rim = 1.0 - smoothstep(0.0, 0.10, dents.border_m / mark)
        return 3.3 * (bowl - 0.15) + 0.4 * rim, 0.045 * mark * bowl, np.zeros_like(bowl)
    if tooling is MetalTooling.QUILTED:
        return _quilted(canvas, mark)
    cloud, fine = canvas.noise(0.1, 0.2, rng, 4), canvas.noise(0.004, 0.03, rng)
    return 0.5 * cloud + 0.25 * fine, 0.000001 * fine, 0.6 * cloud


def _arcs(canvas: Canvas, size_m: float, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Scratches around many centres, laid over each other."""
    tone = np.zeros(canvas.size_px, dtype=np.float32)
    for scale in (1.0, 0.7, 1.4):
        swirls = voronoi_cells(canvas, size_m * scale, rng, bend_m=0.15 * size_m)
        off = swirls.near_m + size_m * 3.0 * swirls.random_per_cell(rng)
        tone = tone + np.sin(off * 2.0 * np.pi / 0.0023) * (0.4 + 0.6 * swirls.random_per_cell(rng))
        tone = tone + 0.6 * (swirls.random_per_cell(rng) - 0.5)
    tone = 0.55 * tone + 0.4 * canvas.noise(0.0025, 0.0025, rng)
    return tone, 0.0000015 * tone, 0.6 * tone


def _turned(canvas: Canvas, size_m: float, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Engine turning: each round lies half over the one before it, with a fan of light on it."""
    x, y = canvas.axes()
    columns, rows = (max(2, round(t / size_m)) for t in canvas.tile_m)
    u = np.mod(x * columns / canvas.tile_m[0], 1.0)
    v = np.mod(y * rows / canvas.tile_m[1], 1.0)
    tone = np.zeros(canvas.size_px, dtype=np.float32)
    # The later round hides the earlier: of those that reach a point the one furthest down and right is on top.
    for step_y in (-1.0, 0.0, 1.0):
        for step_x in (-1.0, 0.0, 1.0):
            dx, dy = np.broadcast_arrays(u - 0.5 - step_x, v - 0.5 - step_y)
            off = np.hypot(dx, dy)
            fan = 0.8 * np.cos(2.0 * np.arctan2(dy, dx)) + 0.35 * np.sin(off * 70.0)
            tone = np.where(off < 0.75, fan - 0.8 * smoothstep(0.68, 0.75, off), tone)
    tone = np.asarray(tone + 0.2 * canvas.noise(0.002, 0.002, rng), dtype=np.float32)
    return 1.3 * tone, 0.000002 * tone, 0.5 * tone


def _quilted(canvas: Canvas, size_m: float) -> tuple[Map, Map, Map]:
    """Pressed cushions on the diagonal, `size_m` from tip to tip."""
    x, y = canvas.axes()
    columns, rows = (max(1, round(t / size_m)) for t in canvas.tile_m)
    u, v = x * columns / canvas.tile_m[0], y * rows / canvas.tile_m[1]
    one, two = np.abs(np.sin(np.pi * (u + v))), np.abs(np.sin(np.pi * (u - v)))
    cushion = np.sqrt(one * two).astype(np.float32)
    lit = (np.cos(np.pi * (u + v)) * np.sign(np.sin(np.pi * (u + v)))).astype(np.float32)
    return 3.0 * (cushion - 0.6) + 1.2 * lit * cushion, 0.05 * size_m * cushion, np.zeros_like(cushion)


def _spots(share: float, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: rings of glasses and dried drops."""
    drops = voronoi_cells(canvas, 0.11, rng, bend_m=0.004)
    radius = 0.008 + 0.03 * drops.random_per_cell(rng)
    ring = np.exp(-(((drops.near_m - radius) / 0.0018) ** 2)) + 0.3 * (drops.near_m < radius)
    return np.asarray(
        ring * (drops.random_per_cell(rng) < share) * (0.4 + 0.6 * drops.random_per_cell(rng)), dtype=np.float32
    )


METAL = TextureKind("sheet_metal", SheetMetal, paint)
