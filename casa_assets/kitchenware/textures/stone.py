"""Stone worktops: granites, marble and other veined stone, stone in layers, and made stone of chips in a binder."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy import ndimage

from casa_assets.ext.records import HexColor, Record
from casa_assets.ext.textures import Canvas, Layers, Map, Share, TextureKind, blend, rgb, rgb_table, smoothstep

Ids = npt.NDArray[np.intp]


@dataclass(frozen=True)
class VoronoiCells:
    """Nearest seed of every pixel, each array (H, W).

    Distances are metres along y, and along x as well where cells are as wide as high (stretch 1).
    """

    count: int  # number of cells
    id: Ids  # 0..count-1, of the nearest seed
    near_m: Map  # to the nearest seed
    second_m: Map  # to the second nearest seed
    dx_m: Map  # along x from the nearest seed to the pixel
    dy_m: Map  # along y

    @property
    def border_m(self) -> Map:
        """(H, W) approximate distance to the border of the cell, scaled as `near_m` is."""
        return (self.second_m - self.near_m) / np.float32(2.0)

    def random_per_cell(self, rng: np.random.Generator) -> Map:
        """(H, W) one uniform number 0..1 for each cell."""
        return rng.uniform(0.0, 1.0, self.count).astype(np.float32)[self.id]


def voronoi_cells(
    canvas: Canvas, size_m: float, rng: np.random.Generator, stretch: float = 1.0, bend_m: float = 0.0
) -> VoronoiCells:
    """Assign every pixel of the canvas to the nearest jittered seed, periodically.

    `size_m`: of a cell along y. `stretch`: how much longer cells are along x. `bend_m`: how far borders are bent.
    """
    rows, columns = canvas.cells(size_m, size_m * stretch)
    tall, wide = canvas.tile_m[1] / rows, canvas.tile_m[0] / columns
    # Seeds keep 0.08 of a cell away from its sides, so that seeds of neighbouring cells do not coincide.
    seed_y, seed_x = rng.uniform(0.08, 0.92, (2, rows, columns)).astype(np.float32)
    x, y = canvas.axes()
    if bend_m > 0:
        x = x + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
        y = y + bend_m * canvas.noise(size_m * 0.7, size_m * 0.7 * stretch, rng)
    x, y = np.broadcast_arrays(x / np.float32(wide), y / np.float32(tall))
    column, row = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    nearest2 = np.full(canvas.size_px, np.inf, dtype=np.float32)
    second2, best_x, best_y = nearest2.copy(), nearest2.copy(), nearest2.copy()
    ids = np.zeros(canvas.size_px, dtype=np.intp)
    # Each cell of the grid has one seed; only those of the pixel's own cell and of the 8 around it are looked at.
    for step in range(9):
        r, c = row + step // 3 - 1, column + step % 3 - 1
        cell = np.mod(r, rows) * columns + np.mod(c, columns)
        dx = x - c - seed_x.ravel()[cell]
        dy = y - r - seed_y.ravel()[cell]
        distance2 = dx * dx + dy * dy
        closer = distance2 < nearest2
        second2 = np.where(closer, nearest2, np.minimum(second2, distance2))
        nearest2, ids = np.where(closer, distance2, nearest2), np.where(closer, cell, ids)
        best_x, best_y = np.where(closer, dx, best_x), np.where(closer, dy, best_y)
    scale = np.float32(tall)
    near_m, second_m = np.sqrt(nearest2) * scale, np.sqrt(second2) * scale
    return VoronoiCells(rows * columns, ids, near_m, second_m, best_x * np.float32(wide), best_y * scale)


# Course of the veins: FLOW long lines side by side; NET between the pieces of a broken stone that has healed.
VeinCourse = StrEnum("VeinCourse", "FLOW NET")


class Vein(Record):
    """One family of veins."""

    color: HexColor
    strength: Share = Field(0.8, description="how much of the vein is seen")
    course: VeinCourse = Field(VeinCourse.FLOW, description="how they run")
    spacing_m: float = Field(0.3, gt=0.01, lt=3, description="usual distance of two veins")
    width_m: float = Field(0.004, gt=0.0002, lt=0.2, description="of a vein where it is strong")
    halo_m: float = Field(0.02, gt=0.001, lt=0.3, description="how far its colour bleeds")
    bleed: Share = Field(0.3, description="strength of the halo")
    stretch: float = Field(3.0, ge=1, le=8, description="length before they turn, by their distance")
    shear: int = Field(1, ge=-3, le=3, description="how often they climb the height of the picture over its width")
    wobble: Share = Field(0.5, description="how restless the lines are")
    gaps: Share = Field(0.4, description="how much of the veins has faded away")


class VeinedStone(Record):
    """A veined slab."""

    ground: HexColor = Field(description="of the stone")
    cloud: HexColor = Field(description="of the clouds in it")
    cloudy: Share = Field(0.5, description="strength of the clouds")
    cloud_m: float = Field(0.4, gt=0.01, lt=2, description="size of the clouds")
    shear: int = Field(1, ge=-3, le=3, description="slant of the clouds, as that of veins")
    veins: tuple[Vein, ...] = Field((), description="laid over it in order")
    crystal: Share = Field(0.3, description="how much the sugar of the crystals sparkles")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.2


def paint_veined(params: VeinedStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab."""
    # Banks of cloud are drawn out along the slant.
    size = params.cloud_m
    field = canvas.noise(0.6 * size, 1.5 * size, rng, 5)
    bend = 0.25 * size * canvas.noise(size, size, rng, 2)
    clouds = smoothstep(-1.2, 1.8, slanted(canvas, canvas.shifted(field, bend, bend), params.shear))
    albedo = blend(rgb(params.ground), rgb(params.cloud), params.cloudy * clouds)
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
    width = vein.width_m * np.exp(0.45 * canvas.noise(0.07, 0.07, rng, 2) - 0.2) * (0.12 + 0.88 * alive**1.5)
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
        planes = (pieces.border_m, smaller.border_m, pieces.random_per_cell(rng) - 0.5)
        moved = [slanted(canvas, plane, vein.shear) for plane in planes]
        near, twig, side = (canvas.shifted(m, 1.6 * bend + fine, fine - 1.6 * bend) for m in moved)
        return near, twig + 0.0012, side
    tilt = canvas.noise(size, size * vein.stretch, rng)
    tilt = tilt + 0.25 * canvas.noise(0.4 * size, 0.4 * size * vein.stretch, rng)
    field = slanted(canvas, canvas.shifted(tilt, bend, 0.6 * bend + fine), vein.shear)
    split = 0.45 * slanted(canvas, canvas.noise(0.5 * size, 0.8 * size * vein.stretch, rng, 2), vein.shear)
    return _off(field, size, canvas), _off(field + split, size, canvas), field


def _off(field: Map, size_m: float, canvas: Canvas) -> Map:
    """About the metres to where a field is 0."""
    step_x, step_y = (m / p for m, p in zip(canvas.tile_m, canvas.size_px[::-1], strict=True))
    rise_x = (np.roll(field, -1, axis=1) - np.roll(field, 1, axis=1)) / (2.0 * step_x)
    rise_y = (np.roll(field, -1, axis=0) - np.roll(field, 1, axis=0)) / (2.0 * step_y)
    # Near a saddle the slope vanishes, and a vein would run out into a blot.
    return np.asarray(np.abs(field) / np.maximum(np.hypot(rise_x, rise_y), 1.2 / size_m), dtype=np.float32)


VEINED = TextureKind("veined_stone", VeinedStone, paint_veined)


class BandedStone(Record):
    """A slab of layered stone."""

    colors: tuple[HexColor, ...] = Field(min_length=2, max_length=16, description="of the layers in order")
    layers: int = Field(2, ge=1, le=24, description="how often the whole order fits into the height of the picture")
    shear: int = Field(0, ge=-3, le=3, description="how often a layer climbs the height of the picture over its width")
    fold_m: float = Field(0.05, ge=0, le=0.5, description="how far layers are folded")
    fold_size_m: float = Field(0.6, gt=0.02, le=2, description="length of a fold")
    fine: Share = Field(0.4, description="strength of the thin lines along the layers")
    mottle: Share = Field(0.3, description="strength of clouds that do not follow the layers")
    pits: Share = Field(0.0, description="share of open pores, as in travertine")
    fossils: Share = Field(0.0, description="small pale shells and dark grains")
    cleft_m: float = Field(0.0, ge=0, le=0.004, description="relief of a split face")
    veins: tuple[Vein, ...] = Field((), description="laid over it")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.3


def paint_flow(params: BandedStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab, layers along u."""
    x, y = canvas.axes()
    size = params.fold_size_m
    fold = params.fold_m * (canvas.noise(0.7 * size, size, rng) + 0.35 * canvas.noise(0.25 * size, 0.4 * size, rng, 3))
    depth = y + fold + params.shear * x * np.float32(canvas.tile_m[1] / canvas.tile_m[0])
    part = depth / np.float32(canvas.tile_m[1]) * params.layers + 0.03 * params.mottle * canvas.noise(0.06, 0.2, rng, 5)
    # (H, W, 3) colour at a place in the order of layers, smooth from one to the next.
    table, at = rgb_table(params.colors), np.mod(part, 1.0) * len(params.colors)
    sharp = np.floor(at) + smoothstep(0.15, 0.85, at - np.floor(at))
    planes = [ndimage.map_coordinates(plane, [sharp], order=1, mode="grid-wrap") for plane in table.T]
    albedo = np.stack(planes, axis=-1).astype(np.float32)
    thread = canvas.noise(0.0045, 1.2, rng) + 0.7 * canvas.noise(0.016, 1.6, rng)
    thread = canvas.shifted(thread, np.zeros_like(x), depth - y)
    cloud = canvas.noise(0.25, 0.3, rng, 5)
    grain = canvas.noise(0.003, 0.003, rng)
    shade = 1.0 + 0.055 * params.fine * thread + 0.05 * params.mottle * cloud + 0.012 * grain
    albedo = albedo * shade[..., None]
    for vein in params.veins:
        albedo, _ = add_vein(albedo, vein, canvas, rng)
    if params.fossils > 0:  # shell fragments a few millimetres long, pale and dark
        for tone, shell_m in ((1.10, 0.006), (0.82, 0.004)):
            dots = canvas.noise(shell_m, 1.8 * shell_m, rng) + 0.4 * canvas.noise(0.2, 0.2, rng)
            albedo = albedo * (1.0 + (tone - 1.0) * params.fossils * smoothstep(1.7, 2.1, dots))[..., None]
    height = 0.000002 * grain + params.cleft_m * (0.3 * cloud + 0.12 * thread)
    roughness = params.roughness + 0.02 * params.fine * thread + 0.02 * grain
    if params.pits > 0:
        pit = _pits(params, depth - y, canvas, rng)
        albedo = albedo * (1.0 - 0.45 * pit)[..., None]
        height, roughness = height - 0.0012 * pit, roughness + 0.3 * pit
    return Layers.of(albedo, height, roughness)


def _pits(params: BandedStone, fold: Map, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: holes longer than high that lie in rows."""
    x, _ = canvas.axes()
    holes = canvas.noise(0.006, 0.018, rng) + 0.5 * canvas.noise(0.003, 0.006, rng)
    field = canvas.shifted(holes + 0.8 * canvas.noise(0.05, 0.9, rng), np.zeros_like(x), fold)
    edge = 3.2 - 1.9 * params.pits
    return smoothstep(edge, edge + 0.45, field)


BANDED = TextureKind("banded_stone", BandedStone, paint_flow)


Size = Annotated[float, Field(gt=0.0005, lt=0.5)]


class Mineral(Record):
    """One colour of crystal."""

    color: HexColor = Field(description="in the middle of its range")
    share: float = Field(gt=0, le=100, description="relative part of the face")
    spread: Share = Field(0.2, description="how much its crystals differ in brightness")
    cluster: float = Field(0.0, ge=-1, le=1, description="where it gathers: where the stone is dark (-1) or pale (1)")


class Speck(Record):
    """Small crystals scattered over the mosaic."""

    color: HexColor
    size_m: Size = Field(description="of one")
    share: Share = Field(description="of the face")
    flock: Share = Field(0.4, description="how much they gather in swarms")
    stretch: float = Field(1.0, ge=0.2, le=8, description="how much longer than wide")


class Granite(Record):
    """A polished granite."""

    minerals: tuple[Mineral, ...] = Field(description="of the mosaic")
    grain_m: Size = Field(0.005, description="size of its crystals")
    specks: tuple[Speck, ...] = Field((), description="over the mosaic, in order")
    phenocryst_color: HexColor | None = Field(None, description="of large round feldspars; None: a stone without")
    phenocryst_m: Size = Field(0.03, description="size of the feldspars")
    phenocryst_rim_color: HexColor = "#2a2622"
    cloud_m: Size = Field(0.08, description="size of the swarms")
    flow: Share = Field(0.0, description="how far the swarms are drawn out into streams")
    shear: int = Field(0, ge=-3, le=3, description="how often streams climb the picture over its width")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.16


def paint_granite(params: Granite, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one slab."""
    swarm = streams(canvas, params.cloud_m, params.flow, params.shear, rng)
    # (H, W, 3) crystals side by side; the swarm decides the odds of each mineral.
    mosaic = voronoi_cells(canvas, params.grain_m, rng, bend_m=0.18 * params.grain_m)
    # Crystals are as large as they like: a second mosaic of twice the size takes a third of the face.
    coarse = voronoi_cells(canvas, 2.1 * params.grain_m, rng, bend_m=0.3 * params.grain_m)
    large = coarse.random_per_cell(rng) < 0.35
    lot = np.where(large, coarse.random_per_cell(rng), mosaic.random_per_cell(rng))
    shade = np.where(large, coarse.random_per_cell(rng), mosaic.random_per_cell(rng)) - 0.5
    weights = np.stack([m.share * np.exp(0.9 * m.cluster * swarm) for m in params.minerals])
    pick = np.minimum((lot > np.cumsum(weights / weights.sum(axis=0), axis=0)).sum(axis=0), len(params.minerals) - 1)
    colors = np.stack([rgb(m.color) for m in params.minerals])[pick]
    spreads = np.array([m.spread for m in params.minerals], dtype=np.float32)[pick]
    # Within a crystal the light changes a little: cleavage and what lies below the polish.
    inside = 0.10 * canvas.noise(params.grain_m * 0.6, params.grain_m * 0.6, rng)
    albedo = np.asarray(colors * (1.0 + spreads * (1.1 * shade + inside))[..., None], dtype=np.float32)
    if params.phenocryst_color is not None:
        albedo = _orbs(params, params.phenocryst_color, albedo, canvas, rng)
    rough = np.zeros(canvas.size_px, dtype=np.float32)
    for speck in params.specks:
        # Mask 0..1: crystals of one speck; the share is kept, whatever the swarms do.
        grains = voronoi_cells(canvas, speck.size_m, rng, speck.stretch, bend_m=0.25 * speck.size_m)
        odds = speck.share * np.exp(1.2 * speck.flock * swarm)
        chosen = grains.random_per_cell(rng) < odds * speck.share / max(float(odds.mean()), 1e-6)
        mask = np.asarray(chosen * smoothstep(0.0, 0.08, grains.border_m / speck.size_m), dtype=np.float32)
        albedo, rough = blend(albedo, rgb(speck.color), mask), np.maximum(rough, mask)
    cloud = canvas.noise(0.004, 0.004, rng)
    return Layers.of(albedo, -0.000004 * rough + 0.000001 * cloud, params.roughness + 0.06 * rough)


def streams(canvas: Canvas, size_m: float, flow: float, shear: int, rng: np.random.Generator) -> Map:
    """Broad noise of deviation 1, drawn out along x by `flow` and slanted by whole turns, so that it closes."""
    field = canvas.noise(size_m, size_m * (1.0 + 7.0 * flow), rng, 4)
    x, _ = canvas.axes()
    wave = 0.5 * size_m * canvas.noise(0.4, 0.4, rng, 2) * (0.3 + flow)
    return canvas.shifted(field, np.zeros_like(x), shear * x * np.float32(canvas.tile_m[1] / canvas.tile_m[0]) + wave)


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


GRANITE = TextureKind("granite", Granite, paint_granite)


class ChipSize(Record):
    """One size of chip."""

    colors: tuple[HexColor, ...] = Field(min_length=1, max_length=16, description="drawn from with equal odds")
    size_m: float = Field(gt=0.0005, lt=0.2, description="of the largest")
    share: Share = Field(description="how many of the places for a chip are taken")
    spread: Share = Field(0.15, description="how much chips of a colour differ in brightness")
    round: Share = Field(0.3, description="from broken stone to washed pebble")
    roughness_change: float = Field(0.0, ge=-0.4, le=0.4, description="on a chip, such as -0.1 for glass")


class MadeStone(Record):
    """A slab of chips in a binder."""

    binder: HexColor = Field(description="colour")
    clouds: Share = Field(0.1, description="how uneven the binder is")
    cloud_m: float = Field(0.4, gt=0.01, lt=2, description="size of its clouds")
    chips: tuple[ChipSize, ...] = Field((), description="from the largest to the smallest")
    veins: tuple[Vein, ...] = Field((), description="printed or poured over it")
    pinholes: Share = Field(0.0, description="small open pores")
    roughness: Annotated[float, Field(ge=0.04, le=0.95)] = 0.22


def paint_speckled(params: MadeStone, canvas: Canvas, rng: np.random.Generator) -> Layers:
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
        albedo, height = blend(albedo, color, mask), height + 0.000003 * mask
        roughness = roughness + chips.roughness_change * mask
        free = free * (1.0 - mask)  # a small chip lies beside a large one, never on it
    if params.pinholes > 0:
        # Round holes of one to three millimetres, far apart.
        places = voronoi_cells(canvas, 0.012, rng)
        radius = 0.0004 + 0.0013 * places.random_per_cell(rng) ** 3
        chosen = places.random_per_cell(rng) < 0.5 * params.pinholes
        hole = np.asarray(chosen * np.clip(1.5 - places.near_m / radius, 0.0, 1.0))
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


MADE = TextureKind("made_stone", MadeStone, paint_speckled)
