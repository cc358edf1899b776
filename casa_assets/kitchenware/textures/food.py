"""Skins and cut faces of fruit, vegetables, bread and meat."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from casa_assets.ext.records import HexColor, Record, Vec2
from casa_assets.ext.textures import Canvas, Layers, Map, Share, TextureKind, blend, rgb, ridged, smoothstep, worley

Count = Annotated[int, Field(ge=0, le=400)]
Distance = Annotated[float, Field(ge=0, le=1)]
# The rim of the section lies on this circle, by half the width of the picture.
RIM = 0.98


class _Colors(Record):
    """Colours in order along a line, and the place of each on it."""

    colors: tuple[HexColor, ...] = Field(min_length=1)
    at: tuple[Share, ...] = Field((), description="place of each colour; empty: evenly")

    @model_validator(mode="after")
    def _places_of_all_colors(self) -> Self:
        if self.at and len(self.at) != len(self.colors):
            raise ValueError(f"a place for each of {len(self.colors)} colours is expected, got {len(self.at)}")
        return self

    def along(self, place: Map) -> Map:
        """The (H, W, 3) colours at places, 0..1."""
        colors = np.array([rgb(c).reshape(3) for c in self.colors], dtype=np.float32)
        at = np.array(self.at or np.linspace(0.0, 1.0, len(self.colors)))
        if len(colors) == 1:
            return np.broadcast_to(colors[0], (*place.shape, 3)).copy()
        return np.stack([np.interp(place, at, colors[:, k]) for k in range(3)], axis=2).astype(np.float32)


class Section(_Colors):
    """A cut face, its colours from the middle to the rim; the picture is a disc from the flesh to the skin.

    Distances are from the middle, 0, to the rim, 1. Angle 0 is to the right; the axis of a thing cut along points up.
    """

    mottle: Share = Field(0.2, description="how far the lightness wanders")
    mottle_mm: float = Field(4.0, gt=0, le=60, description="size of its clouds")
    wander: Share = Field(0.2, description="how far the figure is from a true circle")
    rings: Count = Field(0, description="lines round the middle")
    ring_color: HexColor = "#ffffff"
    ring_width: Share = Field(0.2, description="by the distance between two rings")
    rays: Count = Field(0, description="lines outwards")
    ray_color: HexColor = "#ffffff"
    ray_width: Share = Field(0.03, description="by the radius")
    ray_at: Vec2 = Field((0.08, 0.85), description="from where to where rays go")
    fibres: Count = Field(0, description="fine broken streaks outwards")
    fibre_color: HexColor = "#ffffff"
    fibre_at: Vec2 = Field((0.2, 0.9), description="from where to where fibres show")
    chambers: Count = Field(0, description="hollows or gel round the middle")
    chamber_color: HexColor = "#c0a040"
    chamber_at: Distance = Field(0.5, description="how far out chambers lie")
    chamber_size: Vec2 = Field((0.4, 0.3), description="their length and width")
    seeds: Count = Field(0, description="point outwards; with chambers they lie in these")
    seed_color: HexColor = "#e8d8a0"
    seed_at: Vec2 = Field((0.3, 0.6), description="from where to where seeds lie")
    seed_size: Vec2 = Field((0.1, 0.05), description="their length and width")
    turn: float = Field(0.0, ge=-7, le=7, description="angle of the first ray or chamber, rad")
    relief_mm: float = Field(0.05, ge=0, le=2, description="depth of an even roughness")
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.4


def paint_section(p: Section, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one cut face."""
    x, y = canvas.axes()
    right = np.asarray((2 * x / canvas.tile_m[0] - 1) / RIM + 0 * y, dtype=np.float32)
    up = np.asarray((1 - 2 * y / canvas.tile_m[1]) / RIM + 0 * x, dtype=np.float32)
    clouds = canvas.noise(0.3 * canvas.tile_m[1], 0.3 * canvas.tile_m[0], rng, 3)
    away = np.minimum(np.hypot(right, up), 1.0)
    # The rim stays where it is, or the skin would show inside.
    away = away * (1.0 + 0.05 * p.wander * clouds * (1.0 - away))
    angle = np.arctan2(up, right) + 0.1 * p.wander * canvas.noise(0.4 * canvas.tile_m[1], 0.4 * canvas.tile_m[0], rng)
    albedo, height = p.along(away), np.zeros(canvas.size_px, dtype=np.float32)
    size = p.mottle_mm / 1000
    mottle = canvas.noise(size, size, rng, 3)
    albedo = albedo * (1.0 + 0.16 * p.mottle * mottle)[..., None]
    if p.fibres:
        albedo = blend(albedo, rgb(p.fibre_color), 0.6 * _fibres(p, away, angle, rng))
    if p.rings:
        near = np.abs(np.mod(away * p.rings, 1.0) - 0.5) * 2
        albedo = blend(albedo, rgb(p.ring_color), 0.85 * smoothstep(1 - p.ring_width, 1 - 0.4 * p.ring_width, near))
    places = p.turn + 2 * np.pi * np.arange(p.chambers) / max(1, p.chambers)
    if p.chambers:
        mask = _chambers(p, away, angle, places)
        albedo = blend(albedo, rgb(p.chamber_color) * (1.0 + 0.1 * p.mottle * mottle)[..., None], mask)
        height -= 0.0004 * mask
    if p.rays:
        off = np.abs(np.mod((angle - p.turn) * p.rays / (2 * np.pi) + 0.5, 1.0) - 0.5) * 2 * np.pi / p.rays * away
        line = smoothstep(p.ray_width, 0.4 * p.ray_width, off) * smoothstep(p.ray_at[0] - 0.03, p.ray_at[0], away)
        line = line * smoothstep(p.ray_at[1] + 0.04, p.ray_at[1], away)
        albedo = blend(albedo, rgb(p.ray_color), 0.9 * line)
    if p.seeds:
        mask = _seeds(p, right, up, places, rng)
        albedo = blend(albedo, rgb(p.seed_color), mask)
        height += 0.0005 * mask
    height += 0.001 * p.relief_mm * canvas.noise(0.0012, 0.0012, rng, 2)
    return Layers.of(albedo, height, np.clip(p.roughness + 0.05 * mottle, 0.05, 1.0))


def _fibres(p: Section, away: Map, angle: Map, rng: np.random.Generator) -> Map:
    """The (H, W) share of fine streaks outwards, of several lengths."""
    row = np.mod(angle / (2 * np.pi), 1.0) * p.fibres
    number = np.floor(row).astype(np.int64) % p.fibres
    strength = rng.uniform(0.1, 1.0, p.fibres).astype(np.float32)[number]
    start = rng.uniform(0.0, 0.3, p.fibres).astype(np.float32)[number] * (p.fibre_at[1] - p.fibre_at[0]) + p.fibre_at[0]
    line = smoothstep(0.5, 0.15, np.abs(row - np.floor(row) - 0.5))
    shown = smoothstep(start - 0.04, start + 0.04, away) * smoothstep(p.fibre_at[1] + 0.03, p.fibre_at[1] - 0.1, away)
    return np.asarray(strength * line * shown, dtype=np.float32)


def _chambers(p: Section, away: Map, angle: Map, places: Map) -> Map:
    """The (H, W) mask of the chambers, 0..1."""
    long, wide = p.chamber_size
    mask = np.zeros(away.shape, dtype=np.float32)
    for place in places:
        off = (angle - place + np.pi) % (2 * np.pi) - np.pi
        along, across = (away * np.cos(off) - p.chamber_at) / (long / 2), away * np.sin(off) / (wide / 2)
        inside = (np.abs(along) ** 2.5 + np.abs(across) ** 2.5) ** 0.4
        mask = np.maximum(mask, smoothstep(1.06, 0.9, np.where(np.cos(off) > 0, inside, 2.0)))
    return mask


def _seeds(p: Section, right: Map, up: Map, places: Map, rng: np.random.Generator) -> Map:
    """The (H, W) mask of the seeds, 0..1."""
    mask = np.zeros(right.shape, dtype=np.float32)
    for k in range(p.seeds):
        if len(places):
            spread = 0.42 * p.chamber_size[1] / max(p.chamber_at, 0.1)
            angle = places[k % len(places)] + float(rng.uniform(-spread, spread))
        else:
            angle = p.turn + 2 * np.pi * (k + float(rng.uniform(-0.25, 0.25))) / p.seeds
        away = float(rng.uniform(*p.seed_at))
        long, wide = (0.5 * side * float(rng.uniform(0.85, 1.1)) for side in p.seed_size)
        c, s = np.cos(angle), np.sin(angle)
        along, across = right * c + up * s - away, up * c - right * s
        # A seed is a drop whose point looks to the middle.
        slim = wide * (1.0 + 0.35 * np.clip(along / long, -1.0, 1.0))
        mask = np.maximum(mask, smoothstep(1.15, 0.8, np.hypot(along / long, across / slim)))
    return mask


SECTION = TextureKind("section", Section, paint_section)


Millimetres = Annotated[float, Field(ge=0, le=60)]


class Skin(_Colors):
    """A skin, its colours from the lower end of the object, where the picture's height begins, to the upper one."""

    mottle: Share = Field(0.15, description="how far the lightness wanders")
    mottle_mm: Millimetres = Field(8.0, description="size of its clouds")
    blush: HexColor | None = Field(None, description="second colour in large clouds")
    blush_share: Share = Field(0.4, description="of the surface")
    blush_at: Share | None = Field(None, description="height about which the blush lies; None: anywhere")
    blush_reach: Share = Field(0.4, description="within which it fades")
    blush_edge: float = Field(0.6, ge=0.1, le=4, description="how softly its clouds end")
    streaks: HexColor | None = Field(None, description="colour of lines from end to end")
    streak_mm: Millimetres = Field(1.5, description="width of a streak")
    streak_share: Share = Field(0.4, description="how much of the streaks shows")
    spots: HexColor | None = Field(None, description="colour of spots")
    spot_mm: Millimetres = Field(4.0, description="distance between two spots")
    spot_size: Share = Field(0.2, description="diameter by that distance")
    spot_share: Share = Field(0.7, description="how much spots show")
    raised_mm: float = Field(0.0, ge=-3, le=3, description="how far spots are raised; below 0: pits")
    net: HexColor | None = Field(None, description="colour of a net of corky lines")
    net_mm: Millimetres = Field(6.0, description="width of a mesh")
    net_raised_mm: float = Field(0.3, ge=0, le=3, description="how far the net is raised")
    ribs: int = Field(0, ge=0, le=40, description="grooves from end to end")
    rib_color: HexColor | None = Field(None, description="in the grooves")
    kernels: tuple[Annotated[int, Field(ge=2, le=60)], Annotated[int, Field(ge=2, le=90)]] | None = Field(
        None, description="grains in rows, around and from end to end"
    )
    kernel_color: HexColor = Field("#c08a20", description="between the grains")
    grain_mm: float = Field(1.5, gt=0, le=20, description="size of an even roughness")
    relief_mm: float = Field(0.05, ge=0, le=2, description="depth of that roughness")
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.45
    disc: bool = Field(False, description="the colours run from the middle of the picture to the circle in it")
    wander: Share = Field(0.0, description="how far the places of the colours wander")
    veins: HexColor | None = Field(None, description="colour of branching lines, as fat in meat")
    vein_mm: Millimetres = Field(12.0, description="distance between two veins")
    vein_share: Share = Field(0.3, description="how broad veins are")


def paint_skin(p: Skin, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one skin."""
    x, y = canvas.axes()
    up = _place(p, canvas, rng)
    albedo, height = p.along(up), np.zeros(canvas.size_px, dtype=np.float32)
    size = p.mottle_mm / 1000
    cloud = canvas.noise(size, size, rng, 3)
    albedo = albedo * (1.0 + 0.16 * p.mottle * cloud)[..., None]
    if p.blush is not None:
        albedo = blend(albedo, rgb(p.blush), _blush(p, canvas, up, rng))
    if p.veins is not None:
        crests = ridged(canvas.size_px, canvas.cells(p.vein_mm / 1000, p.vein_mm / 1000), rng, 3)
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
        near, second, _ = worley(canvas.size_px, canvas.cells(p.net_mm / 1000, p.net_mm / 1000), rng)
        cord = smoothstep(0.16, 0.04, second - near) * (0.75 + 0.25 * smoothstep(-1.0, 1.0, cloud))
        albedo = blend(albedo, rgb(p.net), 0.9 * cord)
        height += 0.001 * p.net_raised_mm * cord
    if p.kernels is not None:
        tone, rise = _kernels(p.kernels, canvas, rng)
        albedo = blend(albedo * tone[..., None], rgb(p.kernel_color), 0.8 * smoothstep(0.45, 0.1, rise))
        height += np.float32(0.0008) * np.sqrt(rise)
    grain = canvas.noise(p.grain_mm / 1000, p.grain_mm / 1000, rng, 2)
    height += 0.001 * p.relief_mm * grain
    return Layers.of(np.clip(albedo, 0.0, 1.0), height, np.clip(p.roughness + 0.04 * cloud + 0.02 * grain, 0.05, 1.0))


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


def _blush(p: Skin, canvas: Canvas, up: Map, rng: np.random.Generator) -> Map:
    """The (H, W) share of the second colour."""
    field = canvas.noise(0.45 * canvas.tile_m[1], 0.3 * canvas.tile_m[0], rng, 4)
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
    near, _, owner = worley(canvas.size_px, canvas.cells(p.spot_mm / 1000, p.spot_mm / 1000), rng, 0.8)
    size = rng.uniform(0.6, 1.0, int(owner.max()) + 1).astype(np.float32)[owner] * p.spot_size / 2
    return np.asarray(smoothstep(1.15 * size, 0.75 * size, near), dtype=np.float32)


SKIN = TextureKind("skin", Skin, paint_skin)
