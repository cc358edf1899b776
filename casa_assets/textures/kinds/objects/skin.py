"""Skins of fruit, vegetables, bread and the like: colours from end to end, blush, streaks, spots, netting."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures import noise
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind

Millimetres = Annotated[float, Field(ge=0, le=60)]


class Skin(Record):
    """A skin; the picture's height runs from the lower end of the object to its upper end, its width once around it.

    Attributes:
        colors: from the lower end to the upper one; `at` says where each lies, 0..1, evenly if it is left out.
        mottle: how far the lightness wanders, 0..1; mottle_mm: size of these clouds.
        blush: second colour in large clouds, over blush_share of the surface. blush_at: height about which it lies,
            0..1, None for anywhere; it fades within blush_reach. blush_edge: how softly its clouds end.
        streaks: colour of lines from end to end; streak_mm: width of one; streak_share: how much of it shows.
        spots: colour of spots; spot_mm: distance between two; spot_size: diameter by that distance; spot_share: how
            much they show. raised_mm: how far they are raised; below 0 they are pits.
        net: colour of a net of corky lines; net_mm: width of a mesh; net_raised_mm: how far they are raised.
        ribs: number of grooves from end to end; rib_color: in them.
        kernels, kernel_color: numbers of rounded grains in rows, once around and from end to end; the colour between
            them.
        grain_mm, relief_mm: size and depth of an even roughness.
        disc: the colours run from the middle of the picture to the circle in it, as on an object seen from above.
        wander: how far the places of the colours wander to and fro, 0..1.
        veins: colour of branching lines, as fat in meat; vein_mm: distance between two; vein_share: how broad they are.
        roughness: 0..1.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=1)]
    at: tuple[Share, ...] = ()
    mottle: Share = 0.15
    mottle_mm: Millimetres = 8.0
    blush: HexColor | None = None
    blush_share: Share = 0.4
    blush_at: Share | None = None
    blush_reach: Share = 0.4
    blush_edge: Annotated[float, Field(ge=0.1, le=4)] = 0.6
    streaks: HexColor | None = None
    streak_mm: Millimetres = 1.5
    streak_share: Share = 0.4
    spots: HexColor | None = None
    spot_mm: Millimetres = 4.0
    spot_size: Share = 0.2
    spot_share: Share = 0.7
    raised_mm: Annotated[float, Field(ge=-3, le=3)] = 0.0
    net: HexColor | None = None
    net_mm: Millimetres = 6.0
    net_raised_mm: Annotated[float, Field(ge=0, le=3)] = 0.3
    ribs: Annotated[int, Field(ge=0, le=40)] = 0
    rib_color: HexColor | None = None
    kernels: tuple[Annotated[int, Field(ge=2, le=60)], Annotated[int, Field(ge=2, le=90)]] | None = None
    kernel_color: HexColor = "#c08a20"
    grain_mm: Annotated[float, Field(gt=0, le=20)] = 1.5
    relief_mm: Annotated[float, Field(ge=0, le=2)] = 0.05
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.45
    disc: bool = False
    wander: Share = 0.0
    veins: HexColor | None = None
    vein_mm: Millimetres = 12.0
    vein_share: Share = 0.3

    @model_validator(mode="after")
    def _places_of_all_colors(self) -> Skin:
        if self.at and len(self.at) != len(self.colors):
            raise ValueError(f"a place for each of {len(self.colors)} colours is expected, got {len(self.at)}")
        return self


def paint(p: Skin, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one skin."""
    x, y = canvas.axes()
    up = _place(p, canvas, rng)
    albedo, height = _ends(p, up), np.zeros(canvas.size_px, dtype=np.float32)
    size = p.mottle_mm / 1000
    cloud = canvas.noise(size, size, rng, 3)
    albedo = albedo * (1.0 + 0.16 * p.mottle * cloud)[..., None]
    if p.blush is not None:
        albedo = blend(albedo, rgb(p.blush), _blush(p, canvas, up, rng))
    if p.veins is not None:
        mesh = canvas.cells(p.vein_mm / 1000, p.vein_mm / 1000)
        crests = noise.ridged(canvas.size_px, mesh, rng, 3)
        edge = float(np.quantile(crests, 1.0 - 0.5 * p.vein_share))
        albedo = blend(albedo, rgb(p.veins), 0.9 * smoothstep(edge - 0.05, edge + 0.05, crests))
    if p.streaks is not None:
        lines = canvas.noise(0.5 * canvas.tile_m[1], p.streak_mm / 1000, rng, 2)
        broken = smoothstep(-1.2, 0.6, canvas.noise(0.2 * canvas.tile_m[1], 4 * p.streak_mm / 1000, rng, 2))
        albedo = blend(albedo, rgb(p.streaks), p.streak_share * smoothstep(0.1, 1.1, lines) * broken)
    if p.ribs:
        groove = np.asarray(np.abs(np.sin(np.pi * p.ribs * x / canvas.tile_m[0])), dtype=np.float32)
        near = smoothstep(0.35, 0.0, groove) + 0.0 * y
        albedo = blend(albedo, rgb(p.rib_color or p.colors[0]), 0.8 * near)
    if p.spots is not None:
        mask = _spots(p, canvas, rng)
        albedo = blend(albedo, rgb(p.spots), p.spot_share * mask)
        height += 0.001 * p.raised_mm * mask
    if p.net is not None:
        near, second, _ = noise.worley(canvas.size_px, canvas.cells(p.net_mm / 1000, p.net_mm / 1000), rng)
        cord = smoothstep(0.16, 0.04, second - near) * (0.75 + 0.25 * smoothstep(-1.0, 1.0, cloud))
        albedo = blend(albedo, rgb(p.net), 0.9 * cord)
        height += 0.001 * p.net_raised_mm * cord
    if p.kernels is not None:
        tone, rise = _kernels(p.kernels, canvas, rng)
        albedo = blend(albedo * tone[..., None], rgb(p.kernel_color), 0.8 * smoothstep(0.45, 0.1, rise))
        height += np.float32(0.0008) * np.sqrt(rise)
    grain = canvas.noise(p.grain_mm / 1000, p.grain_mm / 1000, rng, 2)
    height += 0.001 * p.relief_mm * grain
    rough = np.clip(p.roughness + 0.04 * cloud + 0.02 * grain, 0.05, 1.0)
    return Layers.of(np.clip(albedo, 0.0, 1.0), height, rough)


def _place(p: Skin, canvas: Canvas, rng: np.random.Generator) -> Map:
    """(H, W) where a point lies between the lower end, 0, and the upper one, 1."""
    x, y = canvas.axes()
    up = np.asarray(1.0 - y / canvas.tile_m[1] + 0.0 * x, dtype=np.float32)
    if p.disc:
        across, along = x / canvas.tile_m[0] - 0.5, y / canvas.tile_m[1] - 0.5
        up = np.asarray(np.minimum(np.hypot(across, along) / 0.49, 1.0), dtype=np.float32)
    if p.wander:
        clouds = canvas.noise(0.2 * canvas.tile_m[1], 0.2 * canvas.tile_m[0], rng, 4)
        up = np.asarray(np.clip(up + 0.2 * p.wander * clouds, 0.0, 1.0), dtype=np.float32)
    return up


def _ends(p: Skin, up: Map) -> Map:
    """The (H, W, 3) colours from the lower end to the upper one."""
    colors = np.array([rgb(c).reshape(3) for c in p.colors], dtype=np.float32)
    at = np.array(p.at or np.linspace(0.0, 1.0, len(p.colors)))
    if len(colors) == 1:
        return np.broadcast_to(colors[0], (*up.shape, 3)).copy()
    return np.stack([np.interp(up, at, colors[:, k]) for k in range(3)], axis=2).astype(np.float32)


def _blush(p: Skin, canvas: Canvas, up: Map, rng: np.random.Generator) -> Map:
    """The (H, W) share of the second colour."""
    size: Vec2 = (0.45 * canvas.tile_m[1], 0.3 * canvas.tile_m[0])
    field = canvas.noise(size[0], size[1], rng, 4)
    edge = float(np.quantile(field, 1.0 - p.blush_share))
    share = smoothstep(edge - p.blush_edge, edge + p.blush_edge, field)
    if p.blush_at is not None:
        share = share * smoothstep(p.blush_reach, 0.4 * p.blush_reach, np.abs(up - p.blush_at))
    return np.asarray(share, dtype=np.float32)


def _kernels(counts: tuple[int, int], canvas: Canvas, rng: np.random.Generator) -> tuple[Map, Map]:
    """(H, W) tone of the grains, about 1, and how far each rises, 0 between them and 1 in its middle."""
    x, y = canvas.axes()
    across, along = counts
    column = x / canvas.tile_m[0] * across + 0.0 * y
    # Every second row is half a grain further.
    row = (1.0 - y / canvas.tile_m[1]) * along + 0.5 * (np.floor(column) % 2)
    off = np.stack([column - np.floor(column), row - np.floor(row)]) * 2 - 1
    rise = np.clip(1.0 - np.abs(off[0]) ** 3 - np.abs(off[1]) ** 3, 0.0, 1.0).astype(np.float32)
    tones = rng.uniform(0.9, 1.06, (across, along + 1)).astype(np.float32)
    return tones[np.floor(column).astype(int) % across, np.floor(row).astype(int) % (along + 1)], rise


def _spots(p: Skin, canvas: Canvas, rng: np.random.Generator) -> Map:
    """The (H, W) mask of the spots, 0..1."""
    near, _, owner = noise.worley(canvas.size_px, canvas.cells(p.spot_mm / 1000, p.spot_mm / 1000), rng, 0.8)
    size = rng.uniform(0.6, 1.0, int(owner.max()) + 1).astype(np.float32)[owner] * p.spot_size / 2
    return np.asarray(smoothstep(1.15 * size, 0.75 * size, near), dtype=np.float32)


SKIN = TextureKind("skin", Skin, paint)
