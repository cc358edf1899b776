"""Made stone: quartz composite, solid surface, terrazzo, recycled glass, ground concrete. Chips in a binder."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, rgb_table, smoothstep
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.kinds.counters.veined import Vein, add_vein
from casa_assets.textures.kinds.counters.voronoi import voronoi_cells


class ChipSize(Record):
    """One size of chip.

    Attributes:
        colors: drawn from with equal odds.
        size_m: of the largest, metres.
        share: 0..1, how many of the places for a chip are taken.
        spread: 0..1, how much chips of a colour differ in brightness.
        round: 0..1, from broken stone to washed pebble.
        roughness_change: change of roughness on a chip, such as -0.1 for glass.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=16)]
    size_m: Annotated[float, Field(gt=0.0005, lt=0.2)]
    share: Share
    spread: Share = 0.15
    round: Share = 0.3
    roughness_change: Annotated[float, Field(ge=-0.4, le=0.4)] = 0.0


class MadeStone(Record):
    """A slab of chips in a binder.

    Attributes:
        binder: its colour.
        clouds: 0..1, how uneven the binder is; `cloud_m` is the size of its clouds in metres.
        chips: from the largest to the smallest.
        veins: printed or poured over it.
        pinholes: 0..1, small open pores.
        roughness: 0..1.
    """

    binder: HexColor
    clouds: Share = 0.1
    cloud_m: Annotated[float, Field(gt=0.01, lt=2)] = 0.4
    chips: tuple[ChipSize, ...] = ()
    veins: tuple[Vein, ...] = ()
    pinholes: Share = 0.0
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.22


def paint(params: MadeStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab."""
    cloud = 0.7 * canvas.noise(params.cloud_m, params.cloud_m, rng, 6) + 0.5 * canvas.noise(0.06, 0.09, rng, 5)
    fine = canvas.noise(0.003, 0.003, rng)
    albedo: Map = rgb(params.binder) * (1.0 + params.clouds * (0.075 * cloud + 0.02 * fine))[..., None]
    for vein in params.veins:
        albedo, _ = add_vein(albedo, vein, canvas, rng)
    height = 0.000001 * fine
    roughness = params.roughness + params.clouds * 0.05 * cloud
    free = np.ones(canvas.size_px, dtype=np.float32)
    for chips in params.chips:
        color, mask = _chips(chips, canvas, rng)
        mask = mask * free
        albedo = blend(albedo, color, mask)
        height = height + 0.000003 * mask
        roughness = roughness + chips.roughness_change * mask
        free = free * (1.0 - mask)  # a small chip lies beside a large one, never on it
    if params.pinholes > 0:
        hole = _pinholes(params.pinholes, canvas, rng)
        albedo = albedo * (1.0 - 0.4 * hole)[..., None]
        height = height - 0.0006 * hole
    return Layers.of(albedo, height, roughness)


def _chips(chips: ChipSize, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map]:
    """(H, W, 3) colours and (H, W) 0..1 where there is a chip."""
    places = voronoi_cells(canvas, chips.size_m, rng, bend_m=0.10 * chips.round * chips.size_m)
    taken = places.random_per_cell(rng) < chips.share
    small = chips.size_m * (0.03 + 0.16 * places.random_per_cell(rng))  # how far the chip stays off its neighbours
    broken = places.border_m - small
    pebble = chips.size_m * 0.42 - small - places.near_m
    edge = np.where(chips.round > 0.5, np.minimum(broken, pebble), broken) / (0.04 * chips.size_m)
    colors = rgb_table(chips.colors)
    pick = np.minimum((places.random_per_cell(rng) * len(colors)).astype(np.intp), len(colors) - 1)
    shade = 1.0 + chips.spread * (places.random_per_cell(rng) - 0.5)
    inside = 1.0 + 0.06 * chips.spread * canvas.noise(0.4 * chips.size_m, 0.4 * chips.size_m, rng)
    return np.asarray(colors[pick] * (shade * inside)[..., None]), smoothstep(0.0, 1.0, edge) * taken


def _pinholes(share: float, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: round holes of one to three millimetres, far apart."""
    places = voronoi_cells(canvas, 0.012, rng)
    radius = 0.0004 + 0.0013 * places.random_per_cell(rng) ** 3
    return np.asarray((places.random_per_cell(rng) < 0.5 * share) * np.clip(1.5 - places.near_m / radius, 0.0, 1.0))


MADE = TextureKind("made_stone", MadeStone, paint)
