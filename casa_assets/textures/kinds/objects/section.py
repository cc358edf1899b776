"""Cut faces of fruit, vegetables, bread and meat: flesh from the middle to the rim, rings, rays, chambers, seeds."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.finish import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep
from casa_assets.textures.kind import TextureKind

Count = Annotated[int, Field(ge=0, le=400)]
Distance = Annotated[float, Field(ge=0, le=1)]
# The rim of the section lies on this circle, by half the width of the picture.
RIM = 0.98


class Section(Record):
    """A cut face; the picture holds a disc whose middle is that of the flesh and whose rim is the skin.

    Distances are from the middle, 0, to the rim, 1. Angle 0 is to the right; the axis of a thing cut along points up.

    Attributes:
        colors: from the middle to the rim; `at` says where each lies, evenly where it is left out.
        mottle, mottle_mm: how far the lightness wanders, and size of these clouds.
        wander: how far the figure is from a true circle, 0..1.
        rings, ring_color, ring_width: lines round the middle, and their width by the distance between two.
        rays, ray_color, ray_width, ray_at: lines outwards, their width by the radius, and from where to where they go.
        fibres, fibre_color, fibre_at: fine broken streaks outwards, and from where to where they show.
        chambers, chamber_color, chamber_at, chamber_size: hollows or gel round the middle, how far out they lie, and
            how long and wide they are.
        seeds, seed_color, seed_at, seed_size: seeds that point outwards, from where to where they lie, and how long and
            wide they are; with chambers they lie in these.
        turn: angle of the first ray or chamber, rad.
        relief_mm: depth of an even roughness. roughness: 0..1.
    """

    colors: Annotated[tuple[HexColor, ...], Field(min_length=1)]
    at: tuple[Share, ...] = ()
    mottle: Share = 0.2
    mottle_mm: Annotated[float, Field(gt=0, le=60)] = 4.0
    wander: Share = 0.2
    rings: Count = 0
    ring_color: HexColor = "#ffffff"
    ring_width: Share = 0.2
    rays: Count = 0
    ray_color: HexColor = "#ffffff"
    ray_width: Share = 0.03
    ray_at: Vec2 = (0.08, 0.85)
    fibres: Count = 0
    fibre_color: HexColor = "#ffffff"
    fibre_at: Vec2 = (0.2, 0.9)
    chambers: Count = 0
    chamber_color: HexColor = "#c0a040"
    chamber_at: Distance = 0.5
    chamber_size: Vec2 = (0.4, 0.3)
    seeds: Count = 0
    seed_color: HexColor = "#e8d8a0"
    seed_at: Vec2 = (0.3, 0.6)
    seed_size: Vec2 = (0.1, 0.05)
    turn: Annotated[float, Field(ge=-7, le=7)] = 0.0
    relief_mm: Annotated[float, Field(ge=0, le=2)] = 0.05
    roughness: Annotated[float, Field(ge=0.05, le=0.98)] = 0.4

    @model_validator(mode="after")
    def _places_of_all_colors(self) -> Section:
        if self.at and len(self.at) != len(self.colors):
            raise ValueError(f"a place for each of {len(self.colors)} colours is expected, got {len(self.at)}")
        return self


def paint(p: Section, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one cut face."""
    x, y = canvas.axes()
    right = np.asarray((2 * x / canvas.tile_m[0] - 1) / RIM + 0 * y, dtype=np.float32)
    up = np.asarray((1 - 2 * y / canvas.tile_m[1]) / RIM + 0 * x, dtype=np.float32)
    clouds = canvas.noise(0.3 * canvas.tile_m[1], 0.3 * canvas.tile_m[0], rng, 3)
    away = np.minimum(np.hypot(right, up), 1.0)
    # The rim stays where it is, or the skin would show inside.
    away = away * (1.0 + 0.05 * p.wander * clouds * (1.0 - away))
    angle = np.arctan2(up, right) + 0.1 * p.wander * canvas.noise(0.4 * canvas.tile_m[1], 0.4 * canvas.tile_m[0], rng)
    albedo, height = _flesh(p, away), np.zeros(canvas.size_px, dtype=np.float32)
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
        line = smoothstep(p.ray_width, 0.4 * p.ray_width, off)
        line = (
            line * smoothstep(p.ray_at[0] - 0.03, p.ray_at[0], away) * smoothstep(p.ray_at[1] + 0.04, p.ray_at[1], away)
        )
        albedo = blend(albedo, rgb(p.ray_color), 0.9 * line)
    if p.seeds:
        mask = _seeds(p, right, up, places, rng)
        albedo = blend(albedo, rgb(p.seed_color), mask)
        height += 0.0005 * mask
    grain = canvas.noise(0.0012, 0.0012, rng, 2)
    height += 0.001 * p.relief_mm * grain
    return Layers.of(albedo, height, np.clip(p.roughness + 0.05 * mottle, 0.05, 1.0))


def _flesh(p: Section, away: Map) -> Map:
    """The (H, W, 3) colours from the middle to the rim."""
    colors = np.array([rgb(c).reshape(3) for c in p.colors], dtype=np.float32)
    at = np.array(p.at or np.linspace(0.0, 1.0, len(p.colors)))
    if len(colors) == 1:
        return np.broadcast_to(colors[0], (*away.shape, 3)).copy()
    return np.stack([np.interp(away, at, colors[:, k]) for k in range(3)], axis=2).astype(np.float32)


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


SECTION = TextureKind("section", Section, paint)
