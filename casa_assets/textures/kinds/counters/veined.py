"""Veined stone: marble, soapstone, veined quartz. Clouds under veins of true width that fade, split and meet."""

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


class VeinCourse(StrEnum):
    """Course of the veins."""

    FLOW = "flow"  # long lines side by side
    NET = "net"  # between the pieces of a broken stone that has healed


class Vein(Record):
    """One family of veins.

    Attributes:
        color: of the vein; `strength` 0..1 is how much of it is seen.
        course: how they run.
        spacing_m: usual distance of two, metres.
        width_m: of a vein where it is strong, metres.
        halo_m: how far its colour bleeds, metres.
        bleed: 0..1, strength of that halo.
        stretch: how much longer than their distance they are before they turn.
        shear: how often they climb the height of the picture over its width.
        wobble: 0..1, how restless the lines are.
        gaps: 0..1, how much of them has faded away.
    """

    color: HexColor
    strength: Share = 0.8
    course: VeinCourse = VeinCourse.FLOW
    spacing_m: Annotated[float, Field(gt=0.01, lt=3)] = 0.3
    width_m: Annotated[float, Field(gt=0.0002, lt=0.2)] = 0.004
    halo_m: Annotated[float, Field(gt=0.001, lt=0.3)] = 0.02
    bleed: Share = 0.3
    stretch: Annotated[float, Field(ge=1, le=8)] = 3.0
    shear: Annotated[int, Field(ge=-3, le=3)] = 1
    wobble: Share = 0.5
    gaps: Share = 0.4


class VeinedStone(Record):
    """A veined slab.

    Attributes:
        ground, cloud: colours of the stone and of the clouds in it.
        cloudy: 0..1, strength of the clouds; `cloud_m` is their size in metres.
        shear: slant of the clouds, as that of veins.
        veins: laid over it in order.
        crystal: 0..1, how much the sugar of the crystals sparkles.
        roughness: 0..1.
    """

    ground: HexColor
    cloud: HexColor
    cloudy: Share = 0.5
    cloud_m: Annotated[float, Field(gt=0.01, lt=2)] = 0.4
    shear: Annotated[int, Field(ge=-3, le=3)] = 1
    veins: tuple[Vein, ...] = ()
    crystal: Share = 0.3
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.2


def paint(params: VeinedStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab."""
    clouds = _clouds(params, canvas, rng)
    ground, cloud = rgb(params.ground), rgb(params.cloud)
    albedo = blend(ground, cloud, params.cloudy * clouds)
    cut = np.zeros(canvas.size_px, dtype=np.float32)
    for vein in params.veins:
        albedo, line = add_vein(albedo, vein, canvas, rng)
        cut = np.maximum(cut, line)
    sugar = canvas.noise(0.0025, 0.0025, rng)
    albedo = albedo * (1.0 + 0.012 * params.crystal * sugar)[..., None]
    return Layers.of(albedo, 0.000001 * sugar - 0.000006 * cut, params.roughness + 0.05 * cut + 0.008 * sugar)


def slanted(canvas: Canvas, image: Map, shear: int) -> Map:
    """`image` climbing `shear` times its height over its width; it still closes over the border."""
    x, _ = canvas.axes()
    return canvas.shifted(image, np.zeros_like(x), shear * x * np.float32(canvas.tile_m[1] / canvas.tile_m[0]))


def add_vein(albedo: Map, vein: Vein, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map]:
    """Colours with a family of veins drawn over them, and the mask 0..1 of the veins without their halos."""
    line, halo = _lines(vein, canvas, rng)
    return blend(albedo, rgb(vein.color), vein.strength * np.clip(line + vein.bleed * halo, 0.0, 1.0)), line


def _lines(vein: Vein, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map]:
    """Vein and its halo, each (H, W) 0..1."""
    main, branch, side = _courses(vein, canvas, rng)
    # A vein swells and dies away along its course; its branches die first.
    life = slanted(canvas, canvas.noise(0.28, 0.28 * vein.stretch**0.5, rng, 2), vein.shear)
    edge = 2.2 * vein.gaps - 1.6
    alive = smoothstep(edge, edge + 1.5, life)
    swell = np.exp(0.45 * canvas.noise(0.07, 0.07, rng, 2) - 0.2)
    width = vein.width_m * swell * (0.12 + 0.88 * alive**1.5)
    line = alive * _drawn(main * np.where(side > 0, 0.8, 1.5), width, canvas)
    twig = smoothstep(edge + 0.5, edge + 1.8, life) * _drawn(branch, 0.28 * width, canvas)
    line = np.maximum(line, 0.8 * twig) * np.clip(0.85 + 0.2 * canvas.noise(0.025, 0.025, rng, 2), 0.3, 1.1)
    # Halos lean to one side, as the water came from there.
    halo = alive * np.exp(-main / (vein.halo_m * np.where(side > 0, 1.0, 0.4)))
    torn = np.clip(0.75 + 0.3 * canvas.noise(0.06, 0.06, rng, 3), 0.0, 1.3)
    return np.clip(line, 0.0, 1.0).astype(np.float32), np.asarray(halo * torn, dtype=np.float32)


def _drawn(off: Map, width: Map, canvas: Canvas) -> Map:
    """A soft line; thinner than a pixel it is paler, not broader."""
    pixel = canvas.pixel_width_m
    drawn = np.maximum(width, 1.2 * pixel)
    return np.asarray(np.exp(-((off / (0.6 * drawn)) ** 2)) * np.minimum(width / (1.2 * pixel), 1.0) ** 0.7)


def _courses(vein: Vein, canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """Metres to the nearest vein, metres to the nearest branch, and a field that differs on the two sides of a vein."""
    size = vein.spacing_m
    bend = vein.wobble * size * 0.10 * canvas.noise(0.8 * size, 0.8 * size, rng, 2)
    fine = vein.wobble * (0.0022 * canvas.noise(0.03, 0.03, rng, 3) + 0.012 * size * canvas.noise(0.12, 0.12, rng, 2))
    if vein.course is VeinCourse.NET:
        pieces = voronoi_cells(canvas, size, rng, stretch=vein.stretch)
        smaller = voronoi_cells(canvas, 0.45 * size, rng, stretch=vein.stretch)
        # Cells lie square to the picture: slanted, they no longer do.
        moved = [
            slanted(canvas, m, vein.shear)
            for m in (pieces.border_m, smaller.border_m, pieces.random_per_cell(rng) - 0.5)
        ]
        near, twig, side = (canvas.shifted(m, 1.6 * bend + fine, fine - 1.6 * bend) for m in moved)
        return near, twig + 0.0012, side
    tilt = canvas.noise(size, size * vein.stretch, rng) + 0.25 * canvas.noise(
        0.4 * size, 0.4 * size * vein.stretch, rng
    )
    field = slanted(canvas, canvas.shifted(tilt, bend, 0.6 * bend + fine), vein.shear)
    split = 0.45 * slanted(canvas, canvas.noise(0.5 * size, 0.8 * size * vein.stretch, rng, 2), vein.shear)
    return _off(field, size, canvas), _off(field + split, size, canvas), field


def _off(field: Map, size_m: float, canvas: Canvas) -> Map:
    """About the metres to where a field is 0."""
    step_x, step_y = (m / p for m, p in zip(canvas.tile_m, canvas.size_px[::-1], strict=True))
    rise_x = (np.roll(field, -1, axis=1) - np.roll(field, 1, axis=1)) / (2.0 * step_x)
    rise_y = (np.roll(field, -1, axis=0) - np.roll(field, 1, axis=0)) / (2.0 * step_y)
    # Near a saddle the slope vanishes, and a vein would run out into a blot.
    slope = np.maximum(np.hypot(rise_x, rise_y), 1.2 / size_m)
    return np.asarray(np.abs(field) / slope, dtype=np.float32)


def _clouds(params: VeinedStone, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: banks of cloud drawn out along the slant."""
    size = params.cloud_m
    field = canvas.noise(0.6 * size, 1.5 * size, rng, 5)
    bend = 0.25 * size * canvas.noise(size, size, rng, 2)
    return smoothstep(-1.2, 1.8, slanted(canvas, canvas.shifted(field, bend, bend), params.shear))


VEINED = TextureKind("veined_stone", VeinedStone, paint)
