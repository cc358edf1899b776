"""Boards and mats, and trays with pockets."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from itertools import pairwise

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    Solid,
    box,
    circle,
    concatenate,
    inset,
    inset_rings,
    intersect,
    loft,
    prism,
    rectangle,
    ring_walls,
    rod,
    subtract,
)

# Outline seen from above: OVAL also round; PADDLE a rectangle with a handle; ARCHED one end is half a circle.
Outline = StrEnum("Outline", "RECTANGLE OVAL PADDLE ROUND_PADDLE ARCHED")


class Board(Params):
    """Parameters of a board; lengths in metres."""

    outline: Outline = Field(Outline.RECTANGLE, description="from above")
    length: float = Field(ge=0.1, le=0.6, description="along x, without a handle, m")
    width: float = Field(ge=0.08, le=0.5, description="along y, m")
    thickness: float = Field(ge=0.002, le=0.06, description="m")
    corner: float = Field(0.01, ge=0, le=0.1, description="radius of its corners, m")
    edge: float = Field(0.002, ge=0, le=0.01, description="radius of its upper and lower edges, m")
    handle: float = Field(0.1, ge=0, le=0.2, description="length of a paddle's handle, towards +x, m")
    handle_width: float = Field(0.04, ge=0.01, le=0.1, description="m")
    hole: float = Field(0.0, ge=0, le=0.03, description="radius of a hole in the handle or near an end, m; 0: none")
    slot: float = Field(0.0, ge=0, le=0.15, description="the hole is a slot that long, m")
    groove: float = Field(0.0, ge=0, le=0.05, description="distance of a groove from the rim, m; 0: none")
    strips: int = Field(1, ge=1, le=15, description="glued together side by side")
    narrow: float = Field(1.0, ge=0.1, le=1, description="width of every other strip by that of its neighbours")
    feet: float = Field(0.0, ge=0, le=0.02, description="height of four feet, m; 0: none")
    matter: float = Field(1.0, ge=0.1, le=1, description="share of its volume that is solid material")
    skin: FinishId = Field(description="of the board; a picture covers it from end to end")
    second: FinishId = Field("walnut_plain", description="of every other strip and the feet")


def build_board(builder: AssetBuilder, p: Board) -> None:
    """Build the asset: it lies on z = 0, its length along x, a handle to +x."""
    loop = _outline(p)
    t = p.thickness
    e = min(p.edge, 0.45 * t)
    arc = [(e * (1 - math.cos(a)), e * (1 - math.sin(a))) for a in (math.pi / 2, math.pi / 4, 0.0)]
    # Points of an arc of the edge: inset and height, below and above.
    levels = [(e, 0.0), (arc[1][0], arc[1][0]), (0.0, e), (0.0, t - e), (arc[1][0], t - arc[1][0]), (e, t)]
    body = loft(inset_rings(loop, levels if e > 0 else [(0.0, 0.0), (0.0, t)]), 50.0)
    tools = []
    if p.hole > 0:
        slot = rectangle(2 * p.hole, max(2 * p.hole, p.slot), 0.98 * p.hole, 5) if p.slot > 0 else circle(p.hole, 20)
        at = p.length / 2 - p.hole - 0.014
        if p.outline in (Outline.PADDLE, Outline.ROUND_PADDLE):
            at = p.length / 2 + p.handle - p.handle_width / 2
        tools.append(prism(slot, 2 * t, 0.0).translated(at, z=-0.5 * t))
    if p.groove > 0:
        wide, deep = 0.007, min(0.002, 0.2 * t)
        ring = prism(inset(_plain(p), p.groove), 2 * deep, 0.0)
        tools.append(subtract(ring, prism(inset(_plain(p), p.groove + wide), 0.1, 0.0).translated(z=-0.05)))
        tools[-1] = tools[-1].translated(z=t - deep)
    if tools:
        body = subtract(body, *tools)
    shapes = _shapes(p)
    density = p.matter * builder.supplies.finish(p.skin).substance.density
    widths = np.array([1.0 if k % 2 == 0 else p.narrow for k in range(p.strips)])
    edges = np.concatenate([[0.0], np.cumsum(widths)]) / widths.sum() * (p.width + 0.002) - p.width / 2 - 0.001
    for k, (low, high) in enumerate(pairwise(edges.tolist())):
        part = body
        if p.strips > 1:
            slab = box((2.0, high - low, 1.0), (0.0, (low + high) / 2, 0.0), 0.0)
            part = replace(intersect(body, slab), crease_deg=30.0)
        part = _pictured(part, body).translated(z=p.feet)
        part = part.with_shapes(*(s for shape in shapes for s in shape.translated(z=p.feet).shapes))
        own = p.skin if k % 2 == 0 else p.second
        builder.add(ROOT, part, own, label="board", grain=(1.0, 0.0, 0.0), collider=k == 0, density=density)
    if p.feet > 0:
        x, y = p.length / 2 - 0.025, p.width / 2 - 0.025
        foot = rod(0.008, p.feet - 0.0002, 0.001)
        for sx, sy in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            builder.add(ROOT, foot.translated(sx * x, sy * y, p.feet / 2 - 0.0001), p.second, label="foot")


def _plain(p: Board) -> Floats:
    if p.outline in (Outline.OVAL, Outline.ROUND_PADDLE):
        return circle(1.0, 56) * (p.length / 2, p.width / 2)
    if p.outline is Outline.ARCHED:
        r = p.width / 2
        turns = np.linspace(-math.pi / 2, math.pi / 2, 25)
        end = np.stack([p.length / 2 - r + r * np.cos(turns), r * np.sin(turns)], axis=1)
        return np.concatenate([end, rectangle(p.length, p.width, p.corner, 4)[5:15]])
    return rectangle(p.length, p.width, p.corner, 5)


def _outline(p: Board) -> Floats:
    loop = _plain(p)
    if p.outline not in (Outline.PADDLE, Outline.ROUND_PADDLE):
        return loop
    half, x = p.handle_width / 2, p.length / 2
    start = x if p.outline is Outline.PADDLE else x * math.sqrt(max(0.0, 1 - (half / (p.width / 2)) ** 2))
    keep = loop[~((np.abs(loop[:, 1]) < 1.6 * half) & (loop[:, 0] > 0))]
    turns = np.linspace(-math.pi / 2, math.pi / 2, 9)
    end = np.stack([x + p.handle - half + half * np.cos(turns), half * np.sin(turns)], axis=1)
    throat = [(start + 0.35 * half, -1.05 * half), *end, (start + 0.35 * half, 1.05 * half)]
    return np.concatenate([np.array(throat), keep[np.argsort(np.mod(np.arctan2(keep[:, 1], keep[:, 0]), 2 * math.pi))]])


def _shapes(p: Board) -> list[Solid]:
    t = p.thickness
    if p.outline in (Outline.OVAL, Outline.ROUND_PADDLE):
        if abs(p.length - p.width) < 1e-6:
            found = [rod(p.length / 2, t, 0.0).translated(z=t / 2)]
        else:
            found = [prism(_plain(p)[::2], t, 0.0).with_hull_collider()]
    elif p.outline is Outline.ARCHED:
        found = [prism(_plain(p), t, 0.0).with_hull_collider()]
    else:
        found = [box((p.length, p.width, t), (0.0, 0.0, t / 2), 0.0)]
    if p.outline in (Outline.PADDLE, Outline.ROUND_PADDLE):
        found.append(box((1.06 * p.handle, p.handle_width, t), ((p.length / 2 + 0.47 * p.handle), 0.0, t / 2), 0.0))
    return found


def _pictured(part: Solid, whole: Solid) -> Solid:
    low, high = whole.bounds
    share = (part.points - low) / (high - low)
    # The height of the picture runs along x: so stripes that run round a thing run across a mat.
    uv = np.stack([share[:, 1] * 0.98 + 0.01 - 0.004 * share[:, 2], share[:, 0] * 0.98 + 0.01 - 0.004 * share[:, 2]], 1)
    return replace(part, picture_uv=uv[part.faces])


class PocketTray(Params):
    """Parameters of a tray with pockets; lengths in metres."""

    columns: int = Field(6, ge=1, le=10, description="of pockets")
    rows: int = Field(2, ge=1, le=6, description="of pockets")
    pitch_x: float = Field(0.036, ge=0.014, le=0.12, description="between the middles of pockets, m")
    pitch_y: float = Field(0.045, ge=0.014, le=0.12, description="m")
    gap: float = Field(0.004, ge=0.002, le=0.03, description="between two pockets, m")
    depth: float = Field(0.03, ge=0.01, le=0.06, description="of a pocket, m")
    narrow: float = Field(0.8, ge=0.4, le=1, description="floor of a pocket by its mouth")
    rounding: float = Field(0.3, ge=0.02, le=1, description="of a pocket's corners by half its lesser side; 1: round")
    border: float = Field(0.004, ge=0.001, le=0.05, description="of the tray about the pockets, m")
    end: float = Field(0.008, ge=0, le=0.06, description="more of it at both ends, to be held by, m")
    wall: float = Field(0.0015, ge=0.0008, le=0.004, description="thickness, m")
    rim: float = Field(0.008, ge=0, le=0.05, description="height of a rim that goes down around the tray, m")
    skin: FinishId


def build_pocket_tray(builder: AssetBuilder, p: PocketTray) -> None:
    """Build the asset: it rests on the floors of its pockets, at z = 0, its length along x."""
    length = p.columns * p.pitch_x + 2 * (p.border + p.end)
    width = p.rows * p.pitch_y + 2 * p.border
    x, y = p.pitch_x - p.gap, p.pitch_y - p.gap
    mouth = circle(min(x, y) / 2, 14) if p.rounding >= 1 else rectangle(x, y, p.rounding * min(x, y) / 2, 2)
    top = p.depth + p.wall
    xs = [(i - (p.columns - 1) / 2) * p.pitch_x for i in range(p.columns)]
    places = [(x, (j - (p.rows - 1) / 2) * p.pitch_y) for x in xs for j in range(p.rows)]
    outline = rectangle(length, width, min(0.012, 0.4 * width), 4)
    cover = prism(outline, p.wall, 0.0004, [mouth + place for place in places]).translated(z=top - p.wall)
    half = float(np.abs(mouth[:, 1]).max()) * (1 - p.narrow)
    inside = [(0.0, p.depth), (half, 0.18 * p.depth), (1.0 * half + 0.12 * p.depth, 0.0)]
    w = p.wall - 0.0002
    outside = [(half + 0.12 * p.depth - 0.4 * w, 0.0), (half - w, 0.16 * p.depth)]
    steps = [*outside, (-w, p.depth - 0.0004), (-0.0001, p.depth - 0.0004), *((d, z + p.wall) for d, z in inside[1:])]
    cup = loft(inset_rings(mouth, steps), 40.0)
    parts = [cover, *([cup.translated(*place) for place in places])]
    if p.rim > 0:
        hoop = [(0.0006, top - 0.0004), (0.0, top - 0.001), (-0.001, top - p.rim)]
        points = np.concatenate(inset_rings(outline, [*hoop, (p.wall - 0.001, top - p.rim), (p.wall, top - 0.0004)]))
        # The last ring is followed by the first.
        faces = np.concatenate(ring_walls(len(outline), 6)) % len(points)
        parts.append(Solid(points, faces.astype(np.int64), crease_deg=50.0).oriented_outwards())
    body = concatenate([part.without_colliders() for part in parts])
    builder.add(ROOT, body, p.skin, label="body", name="body", collider=False)
    _add_shapes(builder, p, length, width, top)


def _add_shapes(builder: AssetBuilder, p: PocketTray, length: float, width: float, top: float) -> None:
    x, y = p.columns * p.pitch_x, p.rows * p.pitch_y
    builder.add_collider(ROOT, box((0.96 * x, 0.94 * y, p.wall), (0.0, 0.0, p.wall / 2), 0.0), p.skin, "body", "floor")
    for i in range(1, p.columns):
        at = (i - p.columns / 2) * p.pitch_x
        builder.add_collider(ROOT, box((p.gap, y, top - 0.001), (at, 0.0, top / 2), 0.0), p.skin, "body")
    for j in range(1, p.rows):
        at = (j - p.rows / 2) * p.pitch_y
        builder.add_collider(ROOT, box((x, p.gap, top - 0.001), (0.0, at, top / 2), 0.0), p.skin, "body")
    side, high = (width - y) / 2 + 0.4 * p.gap, max(p.rim, 0.6 * top)
    end = (length - x) / 2 + 0.4 * p.gap
    for s in (-1, 1):
        at = s * (width - side) / 2
        builder.add_collider(ROOT, box((length, side, high), (0.0, at, top - high / 2), 0.0), p.skin, "body")
        at = s * (length - end) / 2
        builder.add_collider(ROOT, box((end, width, high), (at, 0.0, top - high / 2), 0.0), p.skin, "body")
