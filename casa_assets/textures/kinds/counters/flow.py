"""Stone in layers: quartzite, onyx, travertine, slate, limestone. Bands that fold, with pits and fossils."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from scipy import ndimage

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, rgb_table, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.veined import Vein, add_vein


class BandedStone(Record):
    """A slab of layered stone.

    Attributes:
        colors: of the layers, in the order in which they follow; the last is followed by the first.
        layers: how often the whole order fits into the height of the picture.
        shear: how often a layer climbs the height of the picture over its width.
        fold_m: how far layers are folded, metres; `fold_size_m` is the length of a fold.
        fine: 0..1, strength of the thin lines along the layers.
        mottle: 0..1, strength of clouds that do not follow the layers.
        pits: 0..1, share of open pores, as in travertine.
        fossils: 0..1, small pale shells and dark grains.
        cleft_m: relief of a split face, metres.
        veins: laid over it.
        roughness: 0..1.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=2, max_length=16)]
    layers: Annotated[int, Field(ge=1, le=24)] = 2
    shear: Annotated[int, Field(ge=-3, le=3)] = 0
    fold_m: Annotated[float, Field(ge=0, le=0.5)] = 0.05
    fold_size_m: Annotated[float, Field(gt=0.02, le=2)] = 0.6
    fine: Share = 0.4
    mottle: Share = 0.3
    pits: Share = 0.0
    fossils: Share = 0.0
    cleft_m: Annotated[float, Field(ge=0, le=0.004)] = 0.0
    veins: tuple[Vein, ...] = ()
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.3


def paint(params: BandedStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab, layers along u."""
    x, y = canvas.axes()
    size = params.fold_size_m
    fold = params.fold_m * (canvas.noise(0.7 * size, size, rng) + 0.35 * canvas.noise(0.25 * size, 0.4 * size, rng, 3))
    depth = y + fold + params.shear * x * np.float32(canvas.tile_m[1] / canvas.tile_m[0])
    part = depth / np.float32(canvas.tile_m[1]) * params.layers + 0.03 * params.mottle * canvas.noise(0.06, 0.2, rng, 5)
    albedo = _ramp(params.colors, part)
    thread = canvas.noise(0.0045, 1.2, rng) + 0.7 * canvas.noise(0.016, 1.6, rng)
    thread = canvas.shifted(thread, np.zeros_like(x), depth - y)
    cloud = canvas.noise(0.25, 0.3, rng, 5)
    grain = canvas.noise(0.003, 0.003, rng)
    shade = 1.0 + 0.055 * params.fine * thread + 0.05 * params.mottle * cloud + 0.012 * grain
    albedo = albedo * shade[..., None]
    for vein in params.veins:
        albedo, _ = add_vein(albedo, vein, canvas, rng)
    if params.fossils > 0:
        albedo = _fossils(params, albedo, canvas, rng)
    height = 0.000002 * grain + params.cleft_m * (0.3 * cloud + 0.12 * thread)
    roughness = params.roughness + 0.02 * params.fine * thread + 0.02 * grain
    if params.pits > 0:
        pit = _pits(params, depth - y, canvas, rng)
        albedo = albedo * (1.0 - 0.45 * pit)[..., None]
        height = height - 0.0012 * pit
        roughness = roughness + 0.3 * pit
    return Layers.of(albedo, height, roughness)


def _ramp(colors: tuple[str, ...], part: Map) -> Map:
    """(H, W, 3) colour at a place in the order of layers, smooth from one to the next."""
    table = rgb_table(colors)
    at = np.mod(part, 1.0) * len(colors)
    sharp = np.floor(at) + smoothstep(0.15, 0.85, at - np.floor(at))
    planes = [ndimage.map_coordinates(plane, [sharp], order=1, mode="grid-wrap") for plane in table.T]
    return np.stack(planes, axis=-1).astype(np.float32)


def _pits(params: BandedStone, fold: Map, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: holes longer than high that lie in rows."""
    x, _ = canvas.axes()
    holes = canvas.noise(0.006, 0.018, rng) + 0.5 * canvas.noise(0.003, 0.006, rng)
    rows = canvas.noise(0.05, 0.9, rng)
    field = canvas.shifted(holes + 0.8 * rows, np.zeros_like(x), fold)
    edge = 3.2 - 1.9 * params.pits
    return smoothstep(edge, edge + 0.45, field)


def _fossils(params: BandedStone, albedo: Map, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Shell fragments a few millimetres long, pale and dark."""
    for tone, size in ((1.10, 0.006), (0.82, 0.004)):
        shell = smoothstep(1.7, 2.1, canvas.noise(size, 1.8 * size, rng) + 0.4 * canvas.noise(0.2, 0.2, rng))
        albedo = albedo * (1.0 + (tone - 1.0) * params.fossils * shell)[..., None]
    return albedo


BANDED = TextureKind("banded_stone", BandedStone, paint)
