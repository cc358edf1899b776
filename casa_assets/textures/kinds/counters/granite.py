"""Granites: a mosaic of crystals of several minerals, specks of mica, clouds and movement."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.voronoi import voronoi_cells

Size = Annotated[float, Field(gt=0.0005, lt=0.5)]


class Mineral(Record):
    """One colour of crystal.

    Attributes:
        color: in the middle of its range.
        share: relative part of the face.
        spread: 0..1, how much its crystals differ in brightness.
        cluster: -1..1, whether it gathers where the stone is dark (-1) or pale (1).
    """

    color: HexColor
    share: Annotated[float, Field(gt=0, le=100)]
    spread: Share = 0.2
    cluster: Annotated[float, Field(ge=-1, le=1)] = 0.0


class Speck(Record):
    """Small crystals scattered over the mosaic.

    Attributes:
        color: of the specks.
        size_m: of one, metres.
        share: 0..1 of the face.
        flock: 0..1, how much they gather in swarms.
        stretch: how much longer than wide.
    """

    color: HexColor
    size_m: Size
    share: Share
    flock: Share = 0.4
    stretch: Annotated[float, Field(ge=0.2, le=8)] = 1.0


class Granite(Record):
    """A polished granite.

    Attributes:
        minerals: of the mosaic.
        grain_m: size of its crystals, metres.
        specks: over the mosaic, in order.
        phenocryst_color: colour of large round feldspars, None for a stone without; `phenocryst_m` is their size.
        phenocryst_rim_color: colour of the rim around them.
        cloud_m: size of the swarms, metres.
        flow: 0..1, how far the swarms are drawn out into streams.
        shear: how often the streams climb the height of the picture over its width.
        roughness: 0..1.
    """

    minerals: tuple[Mineral, ...]
    grain_m: Size = 0.005
    specks: tuple[Speck, ...] = ()
    phenocryst_color: HexColor | None = None
    phenocryst_m: Size = 0.03
    phenocryst_rim_color: HexColor = "#2a2622"
    cloud_m: Size = 0.08
    flow: Share = 0.0
    shear: Annotated[int, Field(ge=-3, le=3)] = 0
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.16


def paint(params: Granite, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab."""
    swarm = streams(canvas, params.cloud_m, params.flow, params.shear, rng)
    albedo = _mosaic(params, canvas, swarm, rng)
    if params.phenocryst_color is not None:
        albedo = _orbs(params, params.phenocryst_color, albedo, canvas, rng)
    rough = np.zeros(canvas.size_px, dtype=np.float32)
    for speck in params.specks:
        mask = _scatter(speck, canvas, swarm, rng)
        albedo = blend(albedo, rgb(speck.color), mask)
        rough = np.maximum(rough, mask)
    cloud = canvas.noise(0.004, 0.004, rng)
    return Layers.of(albedo, -0.000004 * rough + 0.000001 * cloud, params.roughness + 0.06 * rough)


def streams(canvas: Canvas, size_m: float, flow: float, shear: int, rng: np.random.Generator) -> Map:
    """Broad noise of deviation 1, drawn out along x by `flow` and slanted by whole turns, so that it closes."""
    field = canvas.noise(size_m, size_m * (1.0 + 7.0 * flow), rng, 4)
    x, _ = canvas.axes()
    wave = 0.5 * size_m * canvas.noise(0.4, 0.4, rng, 2) * (0.3 + flow)
    return canvas.shifted(field, np.zeros_like(x), shear * x * np.float32(canvas.tile_m[1] / canvas.tile_m[0]) + wave)


def _mosaic(params: Granite, canvas: Canvas, swarm: Map, rng: np.random.Generator) -> Map:
    """(H, W, 3) crystals side by side; the swarm decides the odds of each mineral."""
    mosaic = voronoi_cells(canvas, params.grain_m, rng, bend_m=0.18 * params.grain_m)
    # Crystals are as large as they like: a second mosaic of twice the size takes a third of the face.
    coarse = voronoi_cells(canvas, 2.1 * params.grain_m, rng, bend_m=0.3 * params.grain_m)
    large = coarse.random_per_cell(rng) < 0.35
    lot = np.where(large, coarse.random_per_cell(rng), mosaic.random_per_cell(rng))
    shade = np.where(large, coarse.random_per_cell(rng), mosaic.random_per_cell(rng)) - 0.5
    weights = np.stack([m.share * np.exp(0.9 * m.cluster * swarm) for m in params.minerals])
    edges = np.cumsum(weights / weights.sum(axis=0), axis=0)
    pick = np.minimum((lot > edges).sum(axis=0), len(params.minerals) - 1)
    colors = np.stack([rgb(m.color) for m in params.minerals])[pick]
    spreads = np.array([m.spread for m in params.minerals], dtype=np.float32)[pick]
    # Within a crystal the light changes a little: cleavage and what lies below the polish.
    inside = 0.10 * canvas.noise(params.grain_m * 0.6, params.grain_m * 0.6, rng)
    return np.asarray(colors * (1.0 + spreads * (1.1 * shade + inside))[..., None], dtype=np.float32)


def _orbs(params: Granite, color: str, albedo: Map, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Round feldspars with a rim, packed as they grew."""
    orbs = voronoi_cells(canvas, params.phenocryst_m, rng, bend_m=0.10 * params.phenocryst_m)
    size = params.phenocryst_m * (0.24 + 0.22 * orbs.random_per_cell(rng))
    edge = np.minimum(size - orbs.near_m, orbs.border_m - 0.04 * params.phenocryst_m) / params.phenocryst_m
    shade = 1.0 + 0.25 * (orbs.random_per_cell(rng) - 0.5) + 0.05 * canvas.noise(0.003, 0.003, rng)
    mixed = 0.28 * albedo + 0.72 * rgb(color) * shade[..., None]
    body = smoothstep(0.02, 0.06, edge)
    rim = smoothstep(-0.06, 0.0, edge) * (1.0 - smoothstep(0.03, 0.09, edge))
    albedo = blend(albedo, mixed, body)
    return np.asarray(blend(albedo, rgb(params.phenocryst_rim_color), 0.75 * rim), dtype=np.float32)


def _scatter(speck: Speck, canvas: Canvas, swarm: Map, rng: np.random.Generator) -> Map:
    """Mask 0..1: crystals of one speck; the share is kept, whatever the swarms do."""
    grains = voronoi_cells(canvas, speck.size_m, rng, speck.stretch, bend_m=0.25 * speck.size_m)
    odds = speck.share * np.exp(1.2 * speck.flock * swarm)
    chosen = grains.random_per_cell(rng) < odds * speck.share / max(float(odds.mean()), 1e-6)
    return np.asarray(chosen * smoothstep(0.0, 0.08, grains.border_m / speck.size_m), dtype=np.float32)


GRANITE = TextureKind("granite", Granite, paint)
