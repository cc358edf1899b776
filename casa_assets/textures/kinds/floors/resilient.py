"""Soft floors: marbled linoleum, studded and flecked rubber, cork, vinyl with a printed weave."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures import noise
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, rgb_table, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.laying.joint import Joint, fill, rim
from casa_assets.textures.laying.laying import Laying, lay
from casa_assets.textures.laying.pieces import whole


class ResilientSort(StrEnum):
    """Material of the sheet."""

    MARBLED = "marbled"  # linoleum: streaks of several colours, drawn along v
    FLECKED = "flecked"  # crumbs of other colours in rubber
    STUDDED = "studded"  # round studs
    CORK = "cork"
    WOVEN = "woven"  # vinyl yarns over and under
    TREAD = "tread"  # raised bars in pairs, as on plate


class ResilientFloor(Record):
    """A soft floor.

    Attributes:
        colors: the ground, then what is mixed into it.
        material: of the sheet.
        laying, joint: of its tiles; a sheet without joints if `laying` is None. Tiles of a marbled sheet alternate in
            direction.
        grain_m: size of streaks, crumbs, studs or yarns, metres.
        strength: 0..1, how clearly the other colours show.
        roughness: 0..1.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=1, max_length=8)]
    material: ResilientSort
    laying: Laying | None = None
    joint: Joint = Joint(color="#4c4a46", width_m=0.001, depth_m=0.0004)
    grain_m: Annotated[float, Field(gt=0.001, le=0.2)] = 0.02
    strength: Share = 0.6
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.55


def paint(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one floor."""
    albedo, height, gloss = _SORTS[params.material](params, canvas, rng)
    face = Layers.of(albedo, height, params.roughness + gloss)
    if params.laying is None:
        return face
    pieces = lay(params.laying, canvas, rng)
    if params.material is not ResilientSort.STUDDED:
        jump = rng.random((2, pieces.count)).astype(np.float32)
        size = np.array(canvas.tile_m, dtype=np.float32)[:, None]
        dx, dy = (jump * size)[:, pieces.owner]
        at_x, at_y = pieces.u_m + dx - canvas.axes()[0], pieces.v_m + dy - canvas.axes()[1]
        tone = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
        planes = [canvas.shifted(face.albedo[..., n], at_x, at_y) * (1.0 + 0.04 * tone) for n in range(3)]
        face = Layers.of(
            np.stack(planes, axis=2),
            canvas.shifted(face.height_m, at_x, at_y),
            canvas.shifted(face.roughness, at_x, at_y),
        )
    return fill(face, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


_Parts = tuple[Map, Map, Map]


def _marbled(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    size = params.grain_m
    albedo: Map = np.broadcast_to(rgb(params.colors[0]), (*canvas.size_px, 3))
    bend = 0.7 * size * canvas.noise(6 * size, 3 * size, rng, 2)
    for color in params.colors[1:]:
        streak = canvas.noise(4.0 * size, 0.45 * size, rng, 3) + 0.6 * canvas.noise(1.2 * size, 0.3 * size, rng, 2)
        share = smoothstep(0.1, 1.9, canvas.shifted(streak, bend))
        albedo = blend(albedo, rgb(color), params.strength * share)
    crumb = canvas.noise(0.004, 0.003, rng, 2)
    return albedo * (1.0 + 0.015 * crumb)[..., None], 0.000005 * crumb, 0.02 * crumb


def _flecked(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    albedo: Map = rgb(params.colors[0]) * (1.0 + 0.015 * canvas.noise(0.3, 0.3, rng, 3))[..., None]
    for n, color in enumerate(params.colors[1:]):
        size = params.grain_m * (1.0 - 0.18 * n)
        first, second, owner = noise.worley(canvas.size_px, canvas.cells(size, size), rng, 0.95)
        lot = rng.random((2, int(owner.max()) + 1)).astype(np.float32)
        reach = 0.14 + 0.28 * lot[0][owner]
        crumb = smoothstep(reach, reach - 0.10, first) * (lot[1][owner] < 0.55) * smoothstep(0.0, 0.12, second - first)
        albedo = blend(albedo, rgb(color), params.strength * crumb)
    peel = canvas.noise(0.005, 0.005, rng, 2)
    return albedo, 0.00003 * peel, 0.02 * peel


def _studded(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Round studs with flat tops in a square net."""
    x, y = canvas.axes()
    pixel = canvas.pixel_width_m
    _, wide = whole(canvas.tile_m[0], params.grain_m)
    _, tall = whole(canvas.tile_m[1], params.grain_m)
    far = np.hypot((np.mod(x / wide, 1.0) - 0.5) * wide, (np.mod(y / tall, 1.0) - 0.5) * tall)
    radius = 0.40 * params.grain_m
    rise = np.clip((radius - far) / max(0.0015, pixel) + 0.5, 0.0, 1.0)
    scuff = canvas.noise(0.12, 0.12, rng, 5)
    top, ground = rgb(params.colors[-1]), rgb(params.colors[0])
    albedo = blend(ground, top, rise)
    foot = np.exp(-((far - radius - 0.0012) ** 2) / (2.0 * max(0.0014, 0.7 * pixel) ** 2))
    albedo = albedo * (1.0 - 0.30 * foot + 0.02 * scuff)[..., None]
    grain = canvas.noise(0.004, 0.004, rng)
    return albedo, np.asarray(0.0011 * rise + 0.00001 * grain), -0.06 * rise + 0.03 * scuff


def _cork(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Granules of bark pressed together, with dark crumbs between."""
    size = params.grain_m
    albedo: Map = np.broadcast_to(rgb(params.colors[0]), (*canvas.size_px, 3))
    colors = rgb_table(params.colors)
    height = np.zeros(canvas.size_px, dtype=np.float32)
    for scale in (1.0, 0.5):
        first, second, owner = noise.worley(canvas.size_px, canvas.cells(scale * size, scale * size), rng, 0.95)
        count = int(owner.max()) + 1
        pick = rng.integers(0, len(colors), count)
        tone = rng.normal(0.0, 1.0, count).clip(-2, 2).astype(np.float32)
        bend = 0.25 * scale * size
        granule = colors[pick][owner] * (1.0 + 0.10 * tone[owner])[..., None]
        edge = smoothstep(0.02, 0.14, second - first)
        share = (edge if scale < 1 else np.ones_like(edge)) * (1.0 if scale == 1 else (rng.random(count) < 0.45)[owner])
        dx, dy = bend * canvas.noise(size, size, rng), bend * canvas.noise(size, size, rng)
        share = canvas.shifted(np.asarray(share, dtype=np.float32), dx, dy)
        granule = np.stack([canvas.shifted(granule[..., n], dx, dy) for n in range(3)], axis=2)
        albedo = blend(albedo, granule, params.strength * share)
        height = height + np.float32(0.00008 * scale) * canvas.shifted(edge, dx, dy)
    lenticel = smoothstep(2.0, 2.5, canvas.noise(0.5 * size, 0.16 * size, rng) + 0.5 * canvas.noise(0.2, 0.2, rng))
    grain = canvas.noise(0.003, 0.003, rng)
    albedo = albedo * (1.0 - 0.45 * lenticel + 0.02 * grain)[..., None]
    return albedo, height - 0.0003 * lenticel, 0.1 * lenticel


def _woven(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Round yarns, two over and two under, so that slanting ribs appear."""
    x, y = canvas.axes()
    columns, wide = whole(canvas.tile_m[0], params.grain_m)
    rows, tall = whole(canvas.tile_m[1], params.grain_m)
    column, row = (x / wide).astype(np.intp) % columns, (y / tall).astype(np.intp) % rows
    upright = (column + row) % 4 < 2
    across = np.where(upright, np.mod(x / wide, 1.0) - 0.5 + 0 * y, np.mod(y / tall, 1.0) - 0.5 + 0 * x)
    yarn = np.sqrt(np.clip(1.0 - (2.0 * across) ** 2, 0.0, 1.0)) * canvas.resolved(params.grain_m, params.grain_m)
    colors = rgb_table(params.colors)
    warp, weft = colors[rng.integers(0, len(colors), columns)][column], colors[rng.integers(0, len(colors), rows)][row]
    albedo = np.where(upright[..., None], warp, weft) * (0.78 + 0.22 * yarn)[..., None]
    return np.asarray(albedo), np.asarray(0.2 * params.grain_m * yarn), np.asarray(-0.05 * yarn)


def _tread(params: ResilientFloor, canvas: Canvas, rng: np.random.Generator) -> _Parts:
    """Raised lozenges, each at right angles to its neighbours."""
    x, y = canvas.axes()
    columns, wide = whole(canvas.tile_m[0], params.grain_m, even=True)
    rows, tall = whole(canvas.tile_m[1], params.grain_m, even=True)
    turned = ((x / wide).astype(np.intp) % columns + (y / tall).astype(np.intp) % rows) % 2 == 0
    a, b = np.mod(x / wide, 1.0) - 0.5, np.mod(y / tall, 1.0) - 0.5
    s, t = (a + b) / np.sqrt(2.0), (a - b) / np.sqrt(2.0)
    long, short = np.where(turned, s, t), np.where(turned, t, s)
    bar = 0.11 * (1.0 - (long / 0.5) ** 2) - np.abs(short)
    rise = np.clip(bar / 0.05, 0.0, 1.0)
    scuff = canvas.noise(0.1, 0.1, rng, 5)
    ground, top = rgb(params.colors[0]), rgb(params.colors[-1])
    albedo = (blend(ground, top, params.strength * rise)) * (1.0 + 0.025 * scuff)[..., None]
    return albedo, np.asarray(0.0016 * rise), -0.08 * rise + 0.04 * scuff


_SORTS: dict[ResilientSort, Callable[[ResilientFloor, Canvas, np.random.Generator], _Parts]] = {
    ResilientSort.MARBLED: _marbled,
    ResilientSort.FLECKED: _flecked,
    ResilientSort.STUDDED: _studded,
    ResilientSort.CORK: _cork,
    ResilientSort.WOVEN: _woven,
    ResilientSort.TREAD: _tread,
}

RESILIENT = TextureKind("resilient_floor", ResilientFloor, paint)
"""Kind of soft floors."""
