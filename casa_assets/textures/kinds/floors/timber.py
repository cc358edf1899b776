"""Wooden floors and walls: planks, herringbone, chevron, basket weave, panels, end grain."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.model.record import Record
from casa_assets.textures import wood
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb, smoothstep, stratified
from casa_assets.textures.kind import TextureKind
from casa_assets.textures.laying.inlay import Slab, inlay, slab_canvas
from casa_assets.textures.laying.joint import Joint, TileEdge, fill, rim
from casa_assets.textures.laying.laying import Laying, lay
from casa_assets.textures.laying.pieces import PieceMap
from casa_assets.textures.wood import WoodPalette
from casa_assets.textures.wood_grain import SawCut, WoodSpecies

_SLAB_LONG_M = 1.6
_SHORTEST_SLAB_M = 0.12


class TimberFloor(Record):
    """A wooden floor.

    Attributes:
        laying, joint: how boards lie and their edges.
        species, palette: anatomy of the wood and colours of its finish.
        saw_cuts: how boards were sawn, in equal parts.
        variety: 0..1, how much boards differ in tone; warmth: in hue.
        scraping_m: depth of the hollows that a scraper left, metres.
        saw_marks: 0..1, strength of marks of the saw across the boards.
        wear: 0..1, how much dirt and light have marked it.
    """

    laying: Laying
    joint: Joint = Joint(
        color="#2a2019", width_m=0.001, depth_m=0.0012, edge=TileEdge.BEVEL, edge_width_m=0.0015, rim_drop_m=0.0006
    )
    species: WoodSpecies
    palette: WoodPalette
    saw_cuts: Annotated[tuple[SawCut, ...], Field(min_length=1, max_length=4)] = (SawCut.FLAT, SawCut.FLAT, SawCut.RIFT)
    variety: Share = 0.4
    warmth: Share = 0.3
    scraping_m: Annotated[float, Field(ge=0, le=0.003)] = 0.0
    saw_marks: Share = 0.0
    wear: Share = 0.0


def paint(params: TimberFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of boards."""
    pieces = lay(params.laying, canvas, rng)
    face = _boards(params, pieces, canvas, rng)
    tone = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
    warm = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
    hue = np.stack([1.0 + 0.03 * params.warmth * warm, np.ones_like(warm), 1.0 - 0.07 * params.warmth * warm], axis=2)
    shade = 1.0 + 0.26 * params.variety * tone
    albedo = face.albedo * hue * shade[..., None]
    height: Map = face.height_m
    roughness: Map = face.roughness
    if params.scraping_m > 0:
        hollow = canvas.noise(0.22, 0.22, rng) + 0.6 * pieces.u_m / pieces.half_m[:, 0].astype(np.float32)[pieces.owner]
        height = height + np.float32(0.4 * params.scraping_m) * hollow
    if params.saw_marks > 0:
        phase = rng.uniform(0.0, 1.0, pieces.count).astype(np.float32)[pieces.owner]
        lines = np.sin(2 * np.pi * (pieces.v_m + 0.6 * pieces.u_m**2 / 0.1) / 0.006 + 20.0 * phase)
        lines = lines * canvas.resolved(0.003, 1.0) * smoothstep(-0.2, 1.6, canvas.noise(0.2, 0.1, rng, 2) + 1.5 * tone)
        albedo = albedo * (1.0 - 0.09 * params.saw_marks * np.maximum(lines, -0.4))[..., None]
        height = height - np.float32(0.00015 * params.saw_marks) * lines
    if params.wear > 0:
        dirt = smoothstep(-0.4, 2.2, canvas.noise(0.25, 0.25, rng, 5))
        rims = np.exp(-np.maximum(pieces.inside_m, 0.0) / 0.006)
        albedo = albedo * (1.0 - params.wear * (0.22 * dirt + 0.3 * rims))[..., None]
        roughness = roughness + 0.12 * params.wear * dirt
    dressed = Layers.of(albedo, height, roughness)
    return fill(dressed, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


def _boards(params: TimberFloor, pieces: PieceMap, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Boards cut from a few sawn faces, each at a different place of its face."""
    wide = 2.0 * float(pieces.half_m[:, 0].max())
    slabs, roots = [], []
    for n, cut in enumerate(params.saw_cuts):
        # A flat-cut face has its heart in the middle and a joint at its border: boards keep clear of it.
        room = max(_SHORTEST_SLAB_M, 1.35 * wide if cut is SawCut.FLAT else 2.5 * wide)
        tile_m = (room, _SLAB_LONG_M * (1.0 + 0.11 * n))
        slabs.append(Slab(wood.board(slab_canvas(canvas, tile_m), params.species, cut, params.palette, rng), tile_m))
        roots.append(0.5 * room if cut is SawCut.FLAT else 0.0)
    pick = rng.permutation(np.arange(pieces.count) % len(slabs))
    rooms = np.array([s.tile_m[0] for s in slabs])[pick]
    free = np.maximum(rooms - 2.0 * pieces.half_m[:, 0], 0.0) / 2.0
    flat = np.array(roots)[pick]
    stray = np.where(flat > 0, free, rooms / 2.0) * rng.uniform(-1.0, 1.0, pieces.count)
    down = rng.permutation(np.arange(pieces.count)) * 0.6180339887 % 1.0 * _SLAB_LONG_M  # places that keep apart
    mirrored = rng.permutation(np.arange(pieces.count) % 2) * 2.0 - 1.0
    return inlay(pieces, tuple(slabs), pick, flat + stray, down, mirrored)


class EndGrainFloor(Record):
    """Blocks that show the end of the trunk.

    Attributes:
        laying, joint: how they lie.
        species, palette: rings and colours; pores are dots here.
        variety: 0..1, how much blocks differ.
    """

    laying: Laying
    joint: Joint = Joint(color="#3a2a1c", width_m=0.0015, depth_m=0.001)
    species: WoodSpecies
    palette: WoodPalette
    variety: Share = 0.5


def paint_ends(params: EndGrainFloor, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """Paint one field of blocks: arcs of rings, about a different pith in each block."""
    pieces = lay(params.laying, canvas, rng)
    wide = float(pieces.half_m.max())
    angle = rng.uniform(0.0, 2 * np.pi, pieces.count)
    far = wide * rng.uniform(0.3, 3.2, pieces.count)
    pu, pv = (far * np.cos(angle)).astype(np.float32), (far * np.sin(angle)).astype(np.float32)
    radius = np.hypot(pieces.u_m - pu[pieces.owner], pieces.v_m - pv[pieces.owner])
    radius = radius + 0.0012 * canvas.noise(0.03, 0.03, rng, 3)
    part = np.mod(radius / params.species.ring_m + rng.random(pieces.count).astype(np.float32)[pieces.owner], 1.0)
    seen = np.float32(min(1.0, 0.5 * params.species.ring_m / canvas.pixel_m))
    ring = 0.4 + (smoothstep(0.2, 0.9, part) * (1.0 - smoothstep(0.94, 1.0, part)) - 0.4) * seen
    tone = stratified(pieces.count, rng).astype(np.float32)[pieces.owner]
    check = _checks(pieces, pu, pv, canvas, rng)
    light, dark = rgb(params.palette.light), rgb(params.palette.dark)
    fibre = canvas.resolved(0.002, 0.002) * canvas.noise(0.002, 0.002, rng)
    mix = np.clip(params.species.contrast * ring + 0.35 * params.variety * tone + 0.045 * fibre + 0.2, 0.0, 1.0)
    albedo = blend(light, dark, mix) * (1.0 - 0.5 * check)[..., None]
    face = Layers(
        albedo.astype(np.float32),
        np.asarray(0.00006 * ring - 0.0008 * check, dtype=np.float32),
        np.asarray(params.palette.roughness + 0.1 * ring + 0.2 * check, dtype=np.float32),
    )
    return fill(face, params.joint, rim(params.joint, pieces, canvas, rng), canvas, rng)


def _checks(pieces: PieceMap, pu: Map, pv: Map, canvas: Canvas, rng: np.random.Generator) -> Map:
    """Mask 0..1: cracks that run out from the pith of some blocks."""
    bearing = np.arctan2(pieces.v_m - pv[pieces.owner], pieces.u_m - pu[pieces.owner])
    crack = rng.uniform(-np.pi, np.pi, pieces.count).astype(np.float32)[pieces.owner]
    has = (rng.random(pieces.count) < 0.35).astype(np.float32)[pieces.owner]
    off = np.abs(np.mod(bearing - crack + np.pi, 2 * np.pi) - np.pi + 0.02 * canvas.noise(0.03, 0.03, rng, 2))
    return np.asarray(has * np.clip(1.2 - off / 0.03, 0.0, 1.0), dtype=np.float32)


TIMBER = TextureKind("timber", TimberFloor, paint)
"""Kind of boards."""
END_GRAIN = TextureKind("end_grain_block", EndGrainFloor, paint_ends)
"""Kind of wooden blocks."""
