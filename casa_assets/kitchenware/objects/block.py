"""Bare blocks: cheese, butter, tofu, soap, sponges, cubes of ice and sugar, marshmallows, bars of chocolate."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats, face_normals
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Portion
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, ball, concatenate, subtract
from casa_assets.kitchenware.objects.closed_surface import bumped
from casa_assets.kitchenware.objects.wrapping import Outline, Part, four_sides, round_sides, wrapped

Metres = Annotated[float, Field(gt=0, le=0.5)]
Small = Annotated[float, Field(ge=0, le=0.1)]
Share = Annotated[float, Field(ge=0, le=1)]
# Rings over an end, as shares of its half size.
INWARDS = (0.92, 0.78, 0.6, 0.4, 0.2, 0.05)
# A sector of more than this is no convex wedge, and is covered by several hulls, rad.
WIDE_SECTOR = 1.6
# Parts that weigh nothing and have no collision shape of their own.
UNTOUCHED = ("cut", "core")

# Kind of block: WEDGE a sector of a wheel; a whole wheel with a piece cut out where the angle is large; STACK slices
# one on another; TABLET a bar with segments to break off.
Shape = StrEnum("Shape", "SLAB WEDGE STACK TABLET")


class Block(Params):
    """Parameters of a block; lengths in metres, its length along x."""

    shape: Shape = Field(Shape.SLAB, description="kind of block")
    width: Metres = Field(description="along x, of a wedge its radius, m")
    depth: Metres = Field(description="along y, not of a wedge, m")
    height: Metres = Field(description="along z, m")
    corner: float = Field(0.2, ge=0.02, le=1, description="radius of upright edges by half the smaller side; 1: round")
    edge: Small = Field(0.002, description="radius of the horizontal edges, m")
    bulge: Small = Field(0.0, description="of the sides, m")
    crown: Small = Field(0.0, description="how far the upper end is raised in its middle, m")
    press: Small = Field(0.0, description="depth of a hollow in the upper end, m")
    press_size: Share = Field(0.6, description="share of the upper end that the hollow takes")
    taper: float = Field(1.0, ge=0.5, le=1.2, description="size of the upper end by the lower one")
    waist: Small = Field(0.0, description="how far its long sides are drawn in, m")
    bumps: float = Field(0.0, ge=0, le=0.2, description="unevenness by the size")
    waves: float = Field(1.2, ge=0.3, le=6, description="of the unevenness, over the largest side")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    angle: float = Field(0.7, ge=0.2, le=6, description="of a wedge, rad")
    rind: Small = Field(0.002, description="width of the border around a wedge's cut faces, m")
    holes: int = Field(0, ge=0, le=30, description="round ones; with holes there is no picture")
    hole: Small = Field(0.006, description="radius of the largest hole, m")
    slices: int = Field(4, ge=1, le=12, description="of a stack")
    shift: Small = Field(0.004, description="how far slices are displaced, m")
    rows: int = Field(3, ge=1, le=8, description="segments of a tablet")
    columns: int = Field(6, ge=1, le=12, description="segments of a tablet")
    gap: Small = Field(0.0015, description="width of the grooves between segments, m")
    pad: Small = Field(0.0, description="height of a layer on top, such as that of a sponge, m")
    pad_out: float = Field(0.0, ge=-0.003, le=0.003, description="how far the pad projects, m")
    core: Share = Field(0.0, description="size of a cloudy core by the block")
    portion: Portion | None = Field(None, description="kind of portion if it was cut; None: whole")
    heft: Annotated[float, Field(gt=5, le=3000)] | None = Field(None, description="kg/m^3; None: that of the substance")
    skin: FinishId
    second: FinishId = Field("plastic_green", description="of the pad, the core, or the cut faces of a wedge")


def slab(p: Block) -> list[Part]:
    """A block with rounded edges, and where it has one a pad on top."""
    low = p.height - p.pad
    body = _shaped(_slab(p, low, 0.0), p)
    if p.holes:
        body = _with_holes(body, p)
    parts = [Part(body, p.skin, "body")]
    if p.pad > 0:
        sharp = p.replace(edge=min(p.edge, 0.0015, 0.3 * p.pad), crown=0.0, press=0.0, pad=0.0, taper=1.0)
        parts.append(Part(_shaped(_slab(sharp, p.pad, p.pad_out), p).translated(z=low - 0.0002), p.second, "pad"))
    if p.core > 0:
        points = body.points * p.core
        points[:, 2] += 0.5 * (1.0 - p.core) * p.height
        parts.append(Part(replace(body, points=points, shapes=()), p.second, "core"))
    return parts


def _slab(p: Block, height: float, beyond: float) -> Solid:
    """A block from z = 0 to `height`."""
    outline = round_sides(40) if p.corner >= 1 else four_sides(0.3, 0.2, 4)
    e = min(p.edge, 0.49 * height)
    turns = np.linspace(0.0, math.pi / 2, 4 if e < 0.004 else 6)
    lower = [(e * (1 - math.sin(t)), e * (1 - math.cos(t))) for t in turns]
    wall = [(0.0, e + (height - 2 * e) * s) for s in (0.25, 0.5, 0.75)]
    upper = [(inset_, height - z) for inset_, z in lower[::-1]]
    rings = [_ring(p, outline, beyond, cut, z, height) for cut, z in (*lower, *wall, *upper)]
    rim = rings[-1][:, :2]
    middle = rim.mean(axis=0)
    uneven = p.crown > 0 or p.press > 0 or p.bumps > 0
    for share in INWARDS if uneven else ():
        z = height + p.crown * (1 - share**2)
        z -= p.press * min(1.0, max(0.0, (p.press_size - share) / 0.2))
        flat = middle + (rim - middle) * share
        rings.append(np.column_stack([flat, np.full(len(flat), z)]))
    return wrapped(np.stack(rings), outline.sides, np.linspace(0, 1, len(rings)), crease_deg=50.0)


def _ring(p: Block, outline: Outline, beyond: float, cut: float, z: float, height: float) -> Floats:
    share = z / height
    scale = 1.0 + (p.taper - 1.0) * share
    half_x, half_y = scale * p.width / 2 + beyond - cut, scale * p.depth / 2 + beyond - cut
    ring = outline.ring(half_x, half_y, p.corner * min(half_x, half_y), z)
    ring[:, :2] += outline.bent * (p.bulge * (1 - (2 * share - 1) ** 2))
    # The long sides are drawn in midway, as those of a sponge that fits the hand.
    near = np.cos(np.clip(ring[:, 0] / half_x, -1, 1) * math.pi) * 0.5 + 0.5
    ring[:, 1] -= np.sign(ring[:, 1]) * p.waist * near * np.abs(ring[:, 1]) / half_y
    return ring


def _shaped(solid: Solid, p: Block) -> Solid:
    points = bumped(solid.points, p.bumps, p.waves, p.rng())
    low = float(points[:, 2].min())
    points[:, 2] = np.where(solid.points[:, 2] < 1e-6, low, points[:, 2]) - low
    return from_each_side(replace(solid, points=points))


def from_each_side(solid: Solid) -> Solid:
    """The solid with a picture of its largest side laid on each face from the side that it looks to."""
    low, size = solid.points.min(axis=0), float(np.ptp(solid.points, axis=0).max())
    place = 0.02 + 0.96 * (solid.points - low) / size
    normals, _ = face_normals(solid.points, solid.faces)
    axis = np.abs(normals).argmax(axis=1)
    seen = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    uv = np.take_along_axis(place[solid.faces], np.repeat(seen[:, None, :], 3, axis=1), axis=2)
    # Looked at from behind, right is left.
    behind = np.where(axis == 1, normals[:, 1] > 0, np.where(axis == 0, normals[:, 0] < 0, normals[:, 2] < 0))
    uv[..., 0] = np.where(behind[:, None], 1.0 - uv[..., 0], uv[..., 0])
    return replace(solid, picture_uv=uv)


def _with_holes(body: Solid, p: Block) -> Solid:
    rng, tools = p.rng(), []
    normals, areas = face_normals(body.points, body.faces)
    # None opens downwards, as nobody sees it and it would stand on an edge.
    weights = areas * (normals[:, 2] > -0.5)
    for face in rng.choice(len(areas), p.holes, p=weights / weights.sum()):
        corners, share = body.points[body.faces[face]], rng.dirichlet((1.0, 1.0, 1.0))
        size = p.hole * float(rng.uniform(0.4, 1.0))
        at = share @ corners + 0.3 * size * normals[face]
        if size < at[2]:
            tools.append(ball(size, 8).translated(*(float(v) for v in at)))
    return subtract(body, *tools) if tools else body


def wedge(p: Block) -> list[Part]:
    """A sector of a wheel with its rind, and the two faces where it was cut."""
    turns = np.linspace(-p.angle / 2, p.angle / 2, max(5, math.ceil(p.angle / 0.1)) + 1)
    outline = np.array([(0.0, 0.0), *([(p.width * math.cos(t), p.width * math.sin(t)) for t in turns])])
    e = min(p.edge, 0.3 * p.height)
    levels = [(e, 0.0), (0.3 * e, 0.3 * e), (0.0, e), (-p.bulge, p.height / 2)]
    levels += [(0.0, p.height - e), (0.3 * e, p.height - 0.3 * e), (e, p.height)]
    rings = []
    for cut, z in levels:
        flat = outline.copy()
        # Only the rind is rounded, the cut edges are sharp.
        flat[1:] *= 1.0 - cut / p.width
        rings.append(np.column_stack([flat, np.full(len(flat), z)]))
    body = wrapped(np.stack(rings), np.zeros((len(outline), 2, 2)), np.linspace(0, 1, len(rings)), crease_deg=40.0)
    body = from_each_side(body)
    if p.holes:
        body = _with_holes(body, p)
    parts = [Part(body, p.skin, "body")]
    if p.rind > 0:
        for sign in (-1, 1):
            parts.append(Part(_cut_face(p, sign), p.second, "cut"))
    return parts


def _cut_face(p: Block, sign: int) -> Solid:
    along = np.array([math.cos(sign * p.angle / 2), math.sin(sign * p.angle / 2), 0.0])
    out = np.array([-along[1], along[0], 0.0]) * sign
    reach, low, high = p.width - 1.6 * p.rind, p.rind, p.height - p.rind
    flat = [(0.0008, low), (reach - 0.002, low), (reach, low + 0.003)]
    flat += [(reach, high - 0.003), (reach - 0.002, high), (0.0008, high)]
    front = np.array([along * x + (0.0, 0.0, z) for x, z in flat])
    loops = np.stack([front - 0.0006 * out, front + 0.00035 * out])
    n = len(front)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    cap = np.array([(0, k, k + 1) for k in range(1, n - 1)])
    faces = np.concatenate([np.stack([i, j, n + j], 1), np.stack([i, n + j, n + i], 1), cap[:, ::-1], cap + n])
    return from_each_side(Solid(loops.reshape(-1, 3), faces.astype(np.int64), crease_deg=30.0).oriented_outwards())


def stack(p: Block) -> list[Part]:
    """Slices that lie one on another, a little askew."""
    rng = p.rng()
    thick = p.height / p.slices
    parts = []
    one, circle = p.replace(edge=min(p.edge, 0.3 * thick), crown=0.0, press=0.0, pad=0.0), round_sides(16)
    for k in range(p.slices):
        slice_ = _slab(one, thick - 0.0003, 0.0)
        x, y = rng.uniform(-p.shift, p.shift, 2)
        if p.holes:
            tools = []
            for _ in range(p.holes):
                at = rng.uniform((-0.4 * p.width, -0.4 * p.depth), (0.4 * p.width, 0.4 * p.depth))
                size = p.hole * float(rng.uniform(0.4, 1.0))
                rings = np.stack([circle.ring(size, size, size, z) for z in (-0.001, thick + 0.001)])
                tools.append(wrapped(rings, circle.sides, np.array([0.0, 1.0])).translated(float(at[0]), float(at[1])))
            slice_ = subtract(slice_, *tools)
        turned = slice_.rotated("z", float(rng.uniform(-0.08, 0.08))).translated(float(x), float(y), k * thick)
        parts.append(from_each_side(turned))
    return [Part(concatenate(parts), p.skin, "body")]


def tablet(p: Block) -> list[Part]:
    """A bar of chocolate with segments on a thin plate."""
    base = 0.42 * p.height
    plate = _slab(p.replace(crown=0.0, press=0.0, taper=1.0, edge=min(p.edge, 0.3 * base)), base, 0.0)
    size_x, size_y = p.width / p.columns, p.depth / p.rows
    outline = four_sides(0.3, 0.2, 1, (-1.0, 0.0, 1.0))
    rise = p.height - base
    steps = ((0.5 * p.gap, -0.0004), (0.5 * p.gap + 0.55 * rise, 0.86 * rise), (0.5 * p.gap + 0.75 * rise, rise))
    pieces = [plate]
    for i in range(p.columns):
        for j in range(p.rows):
            x, y = (i + 0.5) * size_x - p.width / 2, (j + 0.5) * size_y - p.depth / 2
            rings = np.stack([outline.ring(size_x / 2 - cut, size_y / 2 - cut, 0.0006, base + z) for cut, z in steps])
            pieces.append(wrapped(rings, outline.sides, np.array([0.0, 0.5, 1.0]), crease_deg=35.0).translated(x, y))
    return [Part(from_each_side(replace(concatenate(pieces), crease_deg=35.0)), p.skin, "body")]


SHAPES: Mapping[Shape, Callable[[Block], list[Part]]] = {
    Shape(maker.__name__): maker for maker in (slab, wedge, stack, tablet)
}


def build(builder: AssetBuilder, p: Block) -> None:
    """Build the asset: it rests on z = 0."""
    builder.portion = p.portion
    for k, part in enumerate(SHAPES[p.shape](p)):
        touched = part.label not in UNTOUCHED
        density = p.heft if p.heft is not None else builder.supplies.finish(part.finish).substance.density
        solid = part.solid.with_colliders_of(*_hulls(p, part.solid)) if k == 0 else part.solid
        density = density if touched else 0.0
        builder.add(ROOT, solid, part.finish, label=part.label, collider=touched, density=density)


def _hulls(p: Block, body: Solid) -> list[Solid]:
    if p.shape is not Shape.WEDGE or p.angle <= WIDE_SECTOR:
        return [body.with_box_collider() if p.shape in (Shape.STACK, Shape.TABLET) else body.with_hull_collider()]
    edges = np.linspace(-p.angle / 2, p.angle / 2, math.ceil(p.angle / 1.3) + 1)
    out = []
    for low, high in pairwise(edges):
        turns, heights = np.linspace(low, high, 8), (p.edge, p.height - p.edge)
        rim = [(p.width * math.cos(t), p.width * math.sin(t), z) for t in turns for z in heights]
        ends = [(0.96 * x, 0.96 * y, 0.0 if z < p.height / 2 else p.height) for x, y, z in rim]
        points = np.array([*rim, *ends, (0.0, 0.0, 0.0), (0.0, 0.0, p.height)])
        out.append(Solid(points, body.faces[:0]).with_hull_collider())
    return out
