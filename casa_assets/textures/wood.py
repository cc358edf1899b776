"""Wood textures: growth rings, fibres, pores, rays and knots, and the palette that colours them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy import ndimage

from casa_assets.model.record import Record
from casa_assets.model.registry.rows import HexColor
from casa_assets.textures.canvas import (
    Canvas,
    Layers,
    Map,
    Share,
    blend,
    line_coverage,
    periodic_curve,
    rgb,
    smoothstep,
    stratified,
)

# A glued joint is a hair line; it is drawn as wide as it looks from arm's length.
_JOINT_M = 0.001


# Cut of the board out of the log, which decides the figure on its face: FLAT arches; QUARTER straight lines, and rays
# where the species has them; RIFT straight lines, a little wider, no rays; ROTARY peeled: wide clouds and islands.
SawCut = StrEnum("SawCut", "FLAT QUARTER RIFT ROTARY")


# Appearance of one growth ring from earlywood to latewood: RING_POROUS (oak, ash) a row of large pores, then plain
# wood; CONIFER (pine, larch) pale, darker, a sharp end; DIFFUSE (maple, beech) plain but for a thin line; BANDED
# (walnut, rosewood, zebrano) broad bands of pigment.
GrowthRings = StrEnum("GrowthRings", "RING_POROUS CONIFER DIFFUSE BANDED")


class WoodSpecies(Record):
    """Anatomy of a wood, as far as it can be seen on a board."""

    rings: GrowthRings = Field(GrowthRings.DIFFUSE, description="course of one year")
    ring_m: float = Field(0.0025, gt=0.0005, lt=0.1, description="usual width of a year")
    unevenness: Share = Field(0.4, description="how much years differ in width and in strength")
    contrast: Share = Field(0.5, description="of the rings")
    pores: Share = Field(0.3, description="how open the grain is")
    pore_m: float = Field(0.008, gt=0.001, lt=0.1, description="length of a pore line")
    rays: Share = Field(0.0, description="flecks on a quartered face, small dashes on a flat one")
    ribbon: Share = Field(0.0, description="stripes of interlocked grain")
    ribbon_m: float = Field(0.012, gt=0.002, lt=0.1, description="width of a stripe")
    curl: Share = Field(0.0, description="waves across the grain")
    fibre: Share = Field(0.5, description="strength of the fine lines")
    clouds: Share = Field(0.4, description="strength of broad changes of tone")
    knots_per_m2: float = Field(0.0, ge=0, le=60, description="of the size of a thumb nail")


@dataclass(frozen=True)
class GrainMaps:
    """Maps of a board face, each (H, W) float32."""

    ring: Map  # 0..1, how dark the year is here
    early: Map  # 0..1, the porous start of a year (ring porous woods), else 1
    fibre: Map  # about -1..1, fine lines along the grain
    zone: Map  # about -1..1, broad changes of tone that follow the years
    pore: Map  # 0..1, open pores
    fleck: Map  # 0..1, rays on a quartered face
    dash: Map  # 0..1, ends of rays on a flat face
    sheen: Map  # about -1..1, ribbon and curl
    knot: Map  # 0..1, knots
    tone: Map  # about -1..1, one value for each leaf
    joint: Map  # 0..1, 1 on the line between two leaves
    edge_m: Map  # to the nearest joint; large without joints


def grain_maps(canvas: Canvas, species: WoodSpecies, cut: SawCut, leaves: int, rng: np.random.Generator) -> GrainMaps:
    """Maps of a face made of `leaves` boards or veneers side by side; 1 is one piece without a joint.

    A flat-cut face without joints is not possible, so 1 gives 1 joint. The maps depend on metres, not on pixels.
    """
    x, y = canvas.axes()
    leaf, edge, left, wide = _leaves(canvas, x, leaves, rng)
    seeds = rng.uniform(0.0, 1.0, (6, leaves)).astype(np.float32)
    wander = 0.010 * canvas.noise(0.9, 0.35, rng) + 0.0006 * canvas.noise(0.15, 0.05, rng)
    # Tones are stratified out, not drawn: a face of few leaves is as dark as one of many.
    tones = stratified(leaves, rng).astype(np.float32)
    # Each leaf bends in its own way: what is drawn once for the sheet is read at another height for each.
    drop = seeds[0][leaf] * canvas.tile_m[1] if leaves > 1 else np.zeros_like(x)
    wander = canvas.shifted(wander, np.zeros_like(x), drop)
    knot, push = _knots(canvas, x, y, species, rng)
    across = wander + push
    radius = _radius(canvas, cut, x + across - (left + wide * (0.25 + 0.5 * seeds[1][leaf])), y + drop, rng)
    if cut in (SawCut.QUARTER, SawCut.RIFT):
        radius = x + across * (0.5 if cut is SawCut.QUARTER else 1.2) + seeds[2][leaf] * (leaves > 1)
    jagged = min(0.1 * species.ring_m, 0.0003) * canvas.resolved(0.06, 0.0025)
    radius = radius + jagged * canvas.noise(0.06, 0.0025, rng)
    ring, early, zone = ring_maps(canvas, species, radius, rng)
    fine = canvas.resolved(0.06, 0.0016) * canvas.noise(0.06, 0.0016, rng) + 0.7 * canvas.noise(0.22, 0.005, rng)
    fine = canvas.shifted(fine, across, drop)
    # Two sizes that share no lattice: pores of one noise would stand in rows.
    pores = canvas.noise(species.pore_m, 0.0017, rng) + 0.9 * canvas.noise(1.7 * species.pore_m, 0.0027, rng)
    pores = canvas.shifted(pores, across, drop)
    clouds = 0.6 * zone + 0.8 * canvas.shifted(canvas.noise(0.5, 0.06, rng, 2), across, drop)
    clouds = clouds - clouds.mean()  # a board is neither paler nor darker than its palette
    return GrainMaps(
        ring=ring,
        early=early,
        fibre=fine / 1.6,
        zone=clouds,
        pore=_kept(smoothstep(0.4, 2.6, pores), canvas.resolved(species.pore_m, 0.0017)),
        fleck=_flecks(canvas, across, rng) if cut is SawCut.QUARTER else np.zeros_like(ring),
        dash=_dashes(canvas, across, rng),
        sheen=_sheen(canvas, species, across, rng),
        knot=knot,
        tone=np.broadcast_to(tones[leaf], ring.shape),
        joint=np.broadcast_to(line_coverage(edge, _JOINT_M, canvas.pixel_width_m), ring.shape),
        edge_m=np.broadcast_to(edge, ring.shape),
    )


def _kept(mask: Map, seen: float) -> Map:
    """A mask of features too small to be seen one by one, faded into their mean."""
    return np.asarray(mask.mean() + (mask - mask.mean()) * seen, dtype=np.float32)


def _leaves(canvas: Canvas, x: Map, count: int, rng: np.random.Generator) -> tuple[npt.NDArray[np.intp], Map, Map, Map]:
    """Number of the leaf, metres to its nearer edge, its left edge and its width, each (1, W)."""
    widths = rng.uniform(0.75, 1.25, count)
    edges = np.concatenate([[0.0], np.cumsum(widths / widths.sum())]) * canvas.tile_m[0]
    leaf = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, count - 1)
    near = np.abs(x[..., None] - edges).min(axis=-1) if count > 1 else np.ones_like(x)
    left, wide = edges[leaf], edges[leaf + 1] - edges[leaf]
    return leaf, near.astype(np.float32), left.astype(np.float32), wide.astype(np.float32)


def _radius(canvas: Canvas, cut: SawCut, x: Map, y: Map, rng: np.random.Generator) -> Map:
    """Distance from the pith in metres: flat and rotary cuts."""
    tall = canvas.tile_m[1]
    warp = 0.0016 * canvas.noise(0.35, 0.06, rng) + 0.0007 * canvas.noise(0.09, 0.02, rng)
    if cut is SawCut.ROTARY:
        field = canvas.noise(0.6, 0.16, rng) + 0.25 * canvas.noise(0.2, 0.06, rng)
        return np.asarray(0.03 * field + warp, dtype=np.float32)
    # The pith leans and the trunk tapers, so the face comes nearer to it and leaves it again: that makes the arches.
    depth = 0.045 + 0.05 * periodic_curve(y, tall, 0.8, rng) + 0.006 * periodic_curve(y, tall, 0.2, rng)
    depth = 0.004 + 0.012 * np.logaddexp(0.0, depth / 0.012)
    return np.asarray(np.hypot(x, depth) + warp, dtype=np.float32)


def ring_maps(canvas: Canvas, species: WoodSpecies, radius: Map, rng: np.random.Generator) -> tuple[Map, Map, Map]:
    """(H, W) darkness of the year, its porous part, the drift of tone over years; `radius`: metres from the pith."""
    length = canvas.tile_m[0]  # years repeat over the width, so that straight grain closes at the border
    count = max(4, round(length / species.ring_m))
    widths = np.exp(species.unevenness * (rng.normal(0, 0.45, count) + 0.8 * _slow(count, rng)))
    edges = np.concatenate([[0.0], np.cumsum(widths / widths.sum())]) * length
    at = np.mod(radius, np.float32(length))
    index = np.interp(at, edges, np.arange(count + 1.0)).astype(np.float32)
    year = np.minimum(index.astype(np.intp), count - 1)
    part = index - year
    strength = (1.0 - species.unevenness * rng.uniform(0.0, 0.9, count)).astype(np.float32)[year]
    # Years narrower than two pixels would flicker: they fade into their mean.
    across = np.abs(np.gradient(radius, axis=1)), np.abs(np.gradient(radius, axis=0))
    narrow = np.hypot(*across) * (count / length) / (widths / widths.mean()).astype(np.float32)[year]
    shown = np.clip(1.5 - 1.6 * narrow, 0.0, 1.0)
    dark, mean = _course(species.rings, part)
    ring = strength * (mean + (dark - mean) * shown)
    porous = species.rings is GrowthRings.RING_POROUS
    early = 0.25 + shown * (1.0 - smoothstep(0.15, 0.45, part) - 0.25) if porous else np.ones_like(ring)
    tones = _slow(count, rng) + 0.5 * rng.normal(0, 1, count)
    zone = np.interp(at, (edges[:-1] + edges[1:]) / 2.0, tones, period=length)
    return np.asarray(ring, dtype=np.float32), np.asarray(early, dtype=np.float32), zone.astype(np.float32)


def _course(rings: GrowthRings, part: Map) -> tuple[Map, float]:
    """Darkness 0..1 over one year and its mean."""
    if rings is GrowthRings.CONIFER:
        return smoothstep(0.25, 0.9, part) * (1.0 - smoothstep(0.95, 1.0, part)), 0.36
    if rings is GrowthRings.RING_POROUS:
        return np.maximum(1.0 - smoothstep(0.1, 0.42, part), 0.35 * smoothstep(0.55, 1.0, part)), 0.33
    if rings is GrowthRings.BANDED:
        return smoothstep(0.3, 0.72, part) * (1.0 - smoothstep(0.88, 1.0, part)), 0.4
    return smoothstep(0.55, 0.97, part) * (1.0 - smoothstep(0.97, 1.0, part)), 0.22


def _slow(count: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
    """(count,) periodic values that change over about eight years, deviation about 1."""
    coarse = rng.normal(0.0, 1.0, max(2, count // 8))
    where = np.arange(count) / count * len(coarse)
    return np.asarray(ndimage.map_coordinates(coarse, [where], order=3, mode="grid-wrap"))


def _sheen(canvas: Canvas, species: WoodSpecies, across: Map, rng: np.random.Generator) -> Map:
    """Stripes of interlocked grain, and waves across it."""
    ribbon = canvas.shifted(canvas.noise(0.4, species.ribbon_m, rng), across)
    curl = canvas.noise(0.013, 0.14, rng) * smoothstep(-1.2, 1.0, canvas.noise(0.5, 0.2, rng))
    bent = canvas.shifted(curl, np.zeros_like(across), 0.0018 * canvas.noise(0.2, 0.05, rng))
    return np.asarray(species.ribbon * ribbon + species.curl * canvas.resolved(0.006, 1.0) * bent)


def _dashes(canvas: Canvas, across: Map, rng: np.random.Generator) -> Map:
    """Ends of rays on a flat face: dashes of a few millimetres."""
    dashes = canvas.shifted(canvas.noise(0.004, 0.0016, rng), across)
    return _kept(smoothstep(1.1, 1.7, dashes), canvas.resolved(0.004, 0.0016))


def _flecks(canvas: Canvas, across: Map, rng: np.random.Generator) -> Map:
    """Rays of a quartered face: short level ribbons that lean and break off."""
    lean = 0.05 * canvas.noise(0.05, 0.2, rng)
    rays = canvas.noise(0.006, 0.022, rng) + 0.7 * canvas.noise(0.0035, 0.009, rng)
    rays = canvas.shifted(rays, np.zeros_like(across), 0.12 * lean + 0.001 * canvas.noise(0.02, 0.006, rng))
    return _kept(smoothstep(0.7, 2.2, rays + 0.6 * canvas.noise(0.35, 0.04, rng)), canvas.resolved(0.003, 0.01))


def _knots(canvas: Canvas, x: Map, y: Map, species: WoodSpecies, rng: np.random.Generator) -> tuple[Map, Map]:
    """Darkness of the knots, and how far the grain gives way to them in metres."""
    wide, tall = canvas.tile_m
    dark = np.zeros(canvas.size_px, dtype=np.float32)
    push = np.zeros(canvas.size_px, dtype=np.float32)
    count = round(species.knots_per_m2 * wide * tall)
    # One to a cell of a jittered grid: knots that touch look like a fault of the picture.
    columns = max(1, round(np.sqrt(count * wide / tall)))
    rows = max(1, round(count / columns)) if count else 0
    rough = 0.16 * canvas.noise(0.02, 0.01, rng) if rows else dark
    for cell in range(rows * columns):
        spot = (np.array(divmod(cell, columns)) + rng.uniform(0.15, 0.85, 2)) / (rows, columns)
        size = 0.008 * np.exp(rng.normal(0.0, 0.4))
        dx = np.mod(x - spot[1] * wide + wide / 2.0, wide) - wide / 2.0
        dy = np.mod(y - spot[0] * tall + tall / 2.0, tall) - tall / 2.0
        distance = np.hypot(dx, dy / 1.25) / size * (1.0 + rough)
        rim = np.exp(-(((distance - 1.0) / 0.22) ** 2))
        heart = (0.62 + 0.2 * np.sin(9.0 * distance)) * (1.0 - smoothstep(0.85, 1.1, distance))
        dark = np.maximum(dark, np.maximum(rim, heart)).astype(np.float32)
        # Lines close to the middle are led around: they are drawn where they stand pushed out by one knot.
        push = push - dx * np.exp(-((dx / (2.2 * size)) ** 2 + (dy / (5.5 * size)) ** 2))
    return dark, push.astype(np.float32)


# Between the deepest pore and the face of a planed board. Ref: about the vessel diameter of open woods, 0.1 to 0.3 mm.
_PORE_DEPTH_M = 0.00018
_RING_DEPTH_M = 0.00008
_JOINT_DEPTH_M = 0.00015


class WoodPalette(Record):
    """Colours of a finished wood, as a colour card shows them."""

    light: HexColor = Field(description="the plain wood")
    dark: HexColor = Field(description="the strong part of a year, and the tone that broad clouds lean to")
    pore: HexColor = Field(description="in the pores; pale where they are limed")
    heart: HexColor = Field(description="of knots, mineral streaks and dark bands")
    variety: Share = Field(0.35, description="how much the leaves differ from each other")
    streaks: Share = Field(0.0, description="share of the face that leans to `heart` in long streaks")
    roughness: Annotated[float, Field(ge=0.05, le=0.95)] = 0.45
    brushed: Share = Field(0.0, description="how far the soft wood was brushed out")


def board(canvas: Canvas, species: WoodSpecies, cut: SawCut, palette: WoodPalette, rng: np.random.Generator) -> Layers:
    """A face that tiles in both directions, grain along the height; a flat cut has a joint at the border."""
    return finish_wood(grain_maps(canvas, species, cut, 1, rng), species, palette, canvas, rng)


def finish_wood(
    grain: GrainMaps, species: WoodSpecies, palette: WoodPalette, canvas: Canvas, rng: np.random.Generator
) -> Layers:
    """Give maps of a face their colours, relief and gloss."""
    light, dark, pore, heart = (rgb(c) for c in (palette.light, palette.dark, palette.pore, palette.heart))
    cloud = np.clip(0.5 + 0.22 * grain.zone, 0.0, 1.0)
    mix = species.contrast * grain.ring * (0.75 + 0.5 * cloud) + 0.75 * species.clouds * (cloud - 0.35)
    mix = mix + 0.5 * palette.variety * grain.tone + 0.10 * species.fibre * grain.fibre
    albedo = _toward(light, dark, np.clip(mix, -0.35, 1.0))
    if palette.streaks > 0:
        vein = 1.0 * grain.zone + 0.6 * canvas.noise(1.8, 0.022, rng) + 0.12 * grain.fibre
        edge = 1.5 - 2.2 * palette.streaks
        albedo = _toward(albedo, heart, 0.6 * smoothstep(edge, edge + 2.0, vein))
    shade = 1.0 + 0.035 * species.fibre * grain.fibre + 0.07 * grain.sheen + 0.03 * palette.variety * grain.tone
    albedo = albedo * shade[..., None]
    open_pores = species.pores * grain.pore * (0.2 + 0.8 * grain.early)
    # The first wood of a year is so full of pores that it takes their colour as a whole.
    porous = np.clip(grain.early - grain.early.mean(), 0.0, 1.0)
    albedo = _toward(albedo, pore, 0.85 * open_pores)
    albedo = _toward(albedo, pore, 0.4 * species.pores * porous)
    albedo = _toward(albedo, pore, 0.45 * grain.dash * species.rays * (1.0 - (grain.fleck.max() > 0)))
    albedo = _toward(albedo, np.clip(light * 1.05 + 0.02, 0.0, 1.0), 0.6 * species.rays * grain.fleck)
    albedo = _toward(albedo, heart, 0.85 * grain.knot)
    albedo = albedo * (1.0 - 0.22 * grain.joint)[..., None]
    relief = -_PORE_DEPTH_M * (1.0 + 2.0 * palette.brushed) * open_pores
    relief = relief + _RING_DEPTH_M * (0.3 + 4.0 * palette.brushed) * (grain.ring - 0.5)
    relief = relief + 0.00001 * grain.fibre - _JOINT_DEPTH_M * grain.joint
    roughness = palette.roughness + 0.10 * open_pores - 0.06 * species.rays * grain.fleck - 0.03 * grain.sheen
    roughness = roughness + 0.015 * grain.fibre + 0.05 * grain.knot
    return Layers.of(albedo, relief, roughness)


def _toward(albedo: Map, color: Map, share: Map) -> Map:
    """`blend` in single precision; a share below 0 goes on past `albedo`."""
    return np.asarray(blend(albedo, color, share), dtype=np.float32)
