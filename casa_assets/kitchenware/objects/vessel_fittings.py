"""Fittings of vessels: handles, spouts, wires along rims, knobs and lids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from pydantic import Field

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid
from casa_assets.kitchenware.objects.closed_surface import ellipsoid, run_along
from casa_assets.kitchenware.objects.closures import LID_GRIP
from casa_assets.kitchenware.objects.vessel_body import Plan, patched, surface


def strap(
    path: Sequence[Vec3] | Floats,
    sizes: Sequence[Vec2] | Floats,
    side: Vec3 = (0.0, 1.0, 0.0),
    power: float = 1.0,
    pieces: int = 1,
    count: int = 12,
) -> Solid:
    """A bar along a path in a plane, whose section changes on the way.

    path: (M, 3) its middle, metres. sizes: (M, 2) full width along `side`, which is square to the plane of the path,
    and thickness across it. power: 1 for an elliptic section, less for a square one. pieces: hulls along it.
    """
    line, size, across = np.array(path, dtype=np.float64), np.array(sizes, dtype=np.float64), np.array(side)
    way = np.gradient(line, axis=0)
    way /= np.linalg.norm(way, axis=1)[:, None]
    normal = np.cross(across, way)
    turn = np.arange(count) * 2 * np.pi / count + (np.pi / count if power < 0.8 else 0.0)
    x, y = (np.sign(f) * np.abs(f) ** power / 2 for f in (np.cos(turn), np.sin(turn)))
    rings = [p + x[:, None] * w * across - y[:, None] * t * n for p, (w, t), n in zip(line, size, normal, strict=True)]
    found = solids.loft(rings, 45.0).oriented_outwards()
    cuts = np.array_split(np.arange(len(line) - 1), pieces)
    hulls = [solids.hull_around(np.concatenate(rings[int(part[0]) : int(part[-1]) + 2])) for part in cuts if len(part)]
    return found.with_colliders_of(*hulls)


def ear(top: Vec2, low: Vec2, reach: float, width: float, thick: float, square: float, sag: float) -> Solid:
    """The handle of a mug: a loop in the plane x, z.

    top, low: (x, z) of its ends, within the wall. reach: farthest x. square: 1 round, less for corners. sag: how far
    its widest place lies below the middle, by half its height.
    """
    t = np.linspace(math.pi / 2, -math.pi / 2, 15)
    c, s = np.abs(np.cos(t)) ** square, np.sign(np.sin(t)) * np.abs(np.sin(t)) ** square
    base = top[0] + (low[0] - top[0]) * ((1 - s) / 2)
    half, middle = (top[1] - low[1]) / 2, (top[1] + low[1]) / 2
    z = middle + half * (s - sag * c * (1 - s * s) ** 0.5)
    x = base + (reach - base) * c
    path = np.stack([x, 0 * x, z], axis=1)
    ends = 1.0 + 0.25 * np.abs(s) ** 6
    power = 0.6 if width > 1.4 * thick else 0.9
    return strap(path, np.stack([width * ends, thick * ends], axis=1), power=power, pieces=3)


def loop(x: float, y: float, z: float, reach: float, thick: float, tall: float, square: float) -> Solid:
    """A horizontal loop at the side of a pot from (x, y) to (x, -y), towards +x by its reach; tall: its height."""
    t = np.linspace(-math.pi / 2, math.pi / 2, 13)
    c, s = np.abs(np.cos(t)) ** square, np.sign(np.sin(t)) * np.abs(np.sin(t)) ** square
    path = np.stack([x + reach * c, y * s, np.full(len(t), z)], axis=1)
    ends = 1.0 + 0.3 * np.abs(s) ** 8
    sizes = np.stack([tall * ends, thick * ends], axis=1)
    return strap(path, sizes, side=(0.0, 0.0, 1.0), power=0.75, pieces=3, count=10)


def arch(x: float, low: float, high: float, width: float, thick: float, square: float, grip: float = 1.0) -> Solid:
    """A handle in the plane x, z from -x to x; low, high: of its ends and middle; grip: how much thicker on top."""
    t = np.linspace(math.pi, 0.0, 19)
    c, s = np.sign(np.cos(t)) * np.abs(np.cos(t)) ** square, np.sin(t) ** square
    path = np.stack([x * c, 0 * t, low + (high - low) * s], axis=1)
    more = 1.0 + (grip - 1.0) * np.clip((s - 0.75) / 0.2, 0, 1)
    return strap(path, np.stack([width * more, thick * more], axis=1), power=0.8, pieces=5)


def spout(start: Vec2, end: Vec2, radius: float, tip: float, curve: float) -> Solid:
    """A hollow tube from the wall of a pot towards -x, open at its tip.

    start, end: (x, z) of its ends, start within the wall. radius, tip: of both. curve: 0 straight, 1 a swan's neck.
    """
    a, b = np.array(start), np.array(end)
    reach = b - a
    one = a + reach * (0.33 + 0.5 * curve, 0.33 - 0.33 * curve)
    two = a + reach * (0.66 - 0.16 * curve, 0.66 + 0.1 * curve)
    t = np.linspace(0.0, 1.0, 10)[:, None]
    flat = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * one + 3 * t**2 * (1 - t) * two + t**3 * b
    path = np.stack([flat[:, 0], 0 * flat[:, 0], flat[:, 1]], axis=1)
    size = radius + (tip - radius) * t[:, 0] ** 0.8
    hole = np.array([tip - 0.0022, tip - 0.0024, tip - 0.003])
    back = np.array([path[-1], path[-1] + 0.25 * (path[-2] - path[-1]), path[-2]])
    way = np.gradient(path, axis=0)
    way /= np.linalg.norm(way, axis=1)[:, None]
    ring = solids.circle(1.0, 14)
    rings = [
        p + r * (ring[:, :1] * np.array([0.0, 1.0, 0.0]) + ring[:, 1:] * np.cross((0.0, 1.0, 0.0), w))
        for p, w, r in (*zip(path, way, size, strict=True), *((q, way[-1], h) for q, h in zip(back, hole, strict=True)))
    ]
    found = solids.loft(rings, 45.0).oriented_outwards()
    spans = (rings[:5], rings[4:9], rings[8:10])
    return found.with_colliders_of(*(solids.hull_around(np.concatenate(span)) for span in spans))


def rim_bead(ring: Floats, radius: float, count: int = 8, start: float = 0.0) -> Solid:
    """A wire along a closed ring, no collider; count: corners of its section; start: angle of the first, 0 outwards."""
    n = len(ring)
    way = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)
    way /= np.linalg.norm(way, axis=1)[:, None]
    out = np.cross(way, (0.0, 0.0, 1.0))
    out /= np.linalg.norm(out, axis=1)[:, None]
    up = np.cross(out, way)
    turn = start + np.arange(count) * 2 * np.pi / count
    c, s = np.cos(turn)[None, :, None], np.sin(turn)[None, :, None]
    points = ring[:, None] + radius * (c * out[:, None] + s * up[:, None])
    i, k = np.meshgrid(np.arange(n), np.arange(count), indexing="ij")
    a, b = i * count + k, np.roll(np.arange(n), -1)[i] * count + k
    c, d = np.roll(np.arange(n), -1)[i] * count + (k + 1) % count, i * count + (k + 1) % count
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return Solid(points.reshape(-1, 3), faces.astype(np.int64), crease_deg=60.0).oriented_outwards()


def long_handle(start: Vec3, length: float, rise: float, profile: Sequence[Vec3], hole: float) -> Solid:
    """The handle of a pan along +x.

    start: its beginning. rise: rad above level, less towards its end. profile: (share of the length, width, thickness).
    hole: radius of the hole near its end, 0 for none.
    """
    s = np.linspace(0.0, 1.0, 13)
    # It starts steeper than it ends, as if bent.
    up = length * math.sin(rise) * (1 - (1 - s) ** 1.7)
    path = np.stack([start[0] + length * math.cos(rise) * s, np.full(13, start[1]), start[2] + up], axis=1)
    at = np.array(profile)
    sizes = np.stack([np.interp(s, at[:, 0], at[:, k]) for k in (1, 2)], axis=1)
    bar = strap(path, sizes, power=0.75, pieces=2, count=12)
    end = path[-1]
    if hole > 0:
        slot = solids.circle(hole, 12) * (1.8, 1.0)
        tool = solids.prism(slot, 0.08, 0.0).translated(float(end[0]) - 2.6 * hole, 0.0, float(end[2]) - 0.04)
        bar = solids.subtract(bar, tool, shapes=bar.shapes)
    return bar


def knob(radius: float, height: float, slim: float) -> Solid:
    """A knob about the z axis, from z = 0 up. slim: radius of its neck relative to the largest radius."""
    n = slim * radius
    profile = [(1.15 * n, -0.001), (n, 0.25 * height), (0.8 * radius, 0.45 * height), (radius, 0.62 * height)]
    profile += [(0.92 * radius, 0.85 * height), (0.6 * radius, 0.96 * height), (0.0, height)]
    return replace(solids.lathe(profile, 18, 50.0), uv_m=None).with_hull_collider()


def sieve_wires(outside: Floats, count: int, radius: float) -> Solid:
    """Wires of a sieve on a turned surface, from its middle to its rim and round it; no collision shape.

    outside: (N, 2) radius and height from the edge of the foot to the rim. count: wires to the rim.
    """
    line = np.concatenate([[[0.012, outside[0, 1]]], outside])
    run = run_along(line)
    at = np.linspace(0.0, run[-1], 8)
    r, z = (np.interp(at, run, line[:, k]) for k in (0, 1))
    section = solids.circle(radius, 3)
    found = []
    for k in range(count):
        turn = 2 * math.pi * k / count
        first = 0 if k % 2 == 0 else 3
        path = [(float(a * math.cos(turn)), float(a * math.sin(turn)), float(b)) for a, b in zip(r, z, strict=True)]
        found.append(solids.tube(path[first:], section).without_colliders())
    turns = np.arange(24) * 2 * np.pi / 24
    for s in np.linspace(0.12, 0.94, 9):
        places = [at * run[-1] for at in (s, s - 0.02, s + 0.02)]
        (a, b), low, high = ([float(np.interp(at, run, line[:, k])) for k in (0, 1)] for at in places)
        ring = np.stack([a * np.cos(turns), a * np.sin(turns), np.full(24, b)], axis=1)
        # A corner of it looks along the wall: a side that was parallel to the gauze would lie in it here or there.
        found.append(rim_bead(ring, radius, 3, math.atan2(high[1] - low[1], high[0] - low[0])))
    return solids.concatenate([Solid(part.points, part.faces, crease_deg=80.0) for part in found])


# Radius of the raised edge of a lid to drink through, metres.
SIP_EDGE = 0.0028

# Form of the part by which a lid is lifted: FLAT a wide disc on a neck; CONE tall; BOW a strap.
KnobForm = StrEnum("KnobForm", "NONE BALL FLAT CONE BOW")


@dataclass(frozen=True)
class Lid:
    """A lid; lengths in metres."""

    radius: float  # half its width along x
    rise: float  # height of its top over its rim
    dome: float  # 2: round; more: a flat top with steep sides
    thick: float  # of its sheet
    skirt: float  # how far its rim reaches down outside
    sip: bool  # a raised edge and a hole to drink from
    bead: float  # radius of a ring of metal round it; 0: none
    knob: KnobForm
    knob_size: float  # radius or half length
    finish: str
    knob_finish: str
    bead_finish: str


def add_lid(builder: AssetBuilder, lid: Lid, plan: Plan, z: float, link: str = ROOT) -> None:
    """Add a lid whose rim lies at height z; `plan` is the outline of the vessel seen from above.

    On a separate link it can be lifted: its collision shapes are then above its rim, and its grip is LID_GRIP.
    """
    flat = replace(plan, lip=0.0, lip_rise=0.0, facets=0, flutes=0, weave=0.0, around=min(plan.around, 40))
    flat = replace(flat, half_x=lid.radius, half_y=plan.half_y + lid.radius - plan.half_x, height=1.0)
    if plan.corner is not None:
        flat = replace(flat, corner=plan.corner + lid.radius - plan.half_x)
    s = np.concatenate([[0.0], np.linspace(0.2, 1.0, 6)])
    dome = 1 - s**lid.dome
    inset = lid.thick * (1.2 if lid.skirt > 0 else 1.0)
    top = np.stack([s * (lid.radius - 0.4 * lid.thick), z + lid.thick + (lid.rise - lid.thick) * dome], axis=1)
    below = np.stack([s * (lid.radius - inset), z + max(lid.rise - lid.thick, 0.0) * dome], axis=1)[[0, 2, 4, 5, 6]]
    edge = [(lid.radius, z - lid.skirt), (lid.radius, z + 0.6 * lid.thick)]
    if lid.skirt > 0:
        edge = [(lid.radius - 0.6 * lid.thick, z - lid.skirt), *edge]
    # Its top shows what the picture has between the foot and the rim of a vessel.
    v = [np.linspace(0.9, 0.6, len(below)), np.linspace(0.46, 0.44, len(edge)), np.linspace(0.43, 0.24, len(top))]
    body = surface(np.concatenate([below, np.array(edge), top[::-1]]), np.concatenate(v), flat)
    is_loose = link != ROOT
    above = np.column_stack([body.points[:, :2], body.points[:, 2].clip(z if is_loose else -np.inf)])
    body = body.with_colliders_of(replace(body, points=above).with_hull_collider())
    grip = LID_GRIP if is_loose and lid.knob is KnobForm.NONE else "lid"
    builder.add(link, body, lid.finish, label="lid", name="lid", collider=grip)
    if lid.bead > 0:
        ring = rim_bead(flat.ring(lid.radius, z + 0.3 * lid.thick), lid.bead)
        builder.add(link, patched(ring), lid.bead_finish, label="lid", collider=False)
    if lid.sip:
        ring = rim_bead(flat.ring(0.8 * lid.radius, z + lid.rise + 0.2 * SIP_EDGE), SIP_EDGE)
        builder.add(link, patched(ring), lid.finish, label="lid", collider=False, density=0.0)
        hole = ellipsoid((0.32 * lid.radius, 0.12 * lid.radius, 0.0016), 16, 5)
        hole = hole.translated(y=-0.62 * lid.radius, z=z + lid.rise)
        builder.add(link, patched(hole), "soil", label="hole", collider=False, density=0.0)
    if lid.knob is not KnobForm.NONE:
        _add_knob(builder, lid, z + lid.rise, link)


def _add_knob(builder: AssetBuilder, lid: Lid, top: float, link: str) -> None:
    size = lid.knob_size
    if lid.knob is KnobForm.BOW:
        part = arch(size, top - 0.004, top + 0.75 * size, 0.35 * size, 0.18 * size, 0.6)
    else:
        shape = {KnobForm.BALL: (1.0, 1.7, 0.5), KnobForm.FLAT: (1.0, 1.0, 0.45), KnobForm.CONE: (0.8, 2.4, 0.55)}
        wide, tall, slim = shape[lid.knob]
        part = knob(wide * size, tall * size, slim).translated(z=top - 0.0006)
    grip = "knob" if link == ROOT else LID_GRIP
    builder.add(link, patched(part), lid.knob_finish, label="knob", name="knob", collider=grip)


class SingleLid(Params):
    """Parameters of a lid that lies by itself."""

    width: float = Field(ge=0.06, le=0.4, description="diameter, m")
    rise: float = Field(ge=0.004, le=0.12, description="height of its top over its rim, m")
    dome: float = Field(2.5, ge=1, le=12, description="2: round; more: a flat top with steep sides")
    thick: float = Field(0.003, ge=0.0006, le=0.01, description="of its sheet, m")
    skirt: float = Field(0.0, ge=0, le=0.03, description="how far its rim reaches down outside, m")
    bead: float = Field(0.0, ge=0, le=0.006, description="radius of a ring of metal round it, m; 0: none")
    knob: KnobForm = Field(KnobForm.BALL, description="what it is lifted by")
    knob_size: float = Field(0.015, ge=0.006, le=0.06, description="radius or half length, m")
    skin: FinishId
    knob_finish: FinishId = "plastic_black"
    bead_finish: FinishId = "stainless_polished"


def build_lid(builder: AssetBuilder, p: SingleLid) -> None:
    """Build the asset: it lies on z = 0, its rim below."""
    finishes = (p.skin, p.knob_finish, p.bead_finish)
    lid = Lid(p.width / 2, p.rise, p.dome, p.thick, p.skirt, False, p.bead, p.knob, p.knob_size, *finishes)
    low = max(p.skirt, p.bead - 0.3 * p.thick)
    add_lid(builder, lid, Plan(p.width / 2, p.width / 2, corner=None, height=p.rise), low)
