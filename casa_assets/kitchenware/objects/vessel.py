"""Open things turned on a wheel or drawn from sheet: bowls, cups, jugs, pots and pans, with handles, spout and lid."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np

from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats
from casa_assets.ext.solids import ROOT, AssetBuilder, Placed, Solid
from casa_assets.kitchenware.objects import vessel_surface
from casa_assets.kitchenware.objects.closures import LID, MOST_LIFT, lift_off
from casa_assets.kitchenware.objects.vessel_fittings import (
    HandleForm,
    KnobForm,
    Lid,
    Vessel,
    add_lid,
    handles,
    rim_bead,
    seated,
    sieve_wires,
    spouts,
    strap,
)
from casa_assets.kitchenware.objects.vessel_surface import RIM_V, Plan, Profile

# Slabs are at least as thick as this, metres.
THICK = 0.003
# A ring has eight slabs; twelve from one radius on, six up to another, metres.
WIDE, SMALL = 0.18, 0.075
# Corners of a rectangle that are rounder than this get a slab of their own, metres.
ROUND_CORNER = 0.03
# Slabs bulge as the wall does where straight ones would end so far from it, metres.
BULGE = 0.008
# How far a bead on the rim may stand over the slabs, metres.
OVER = 0.0035


def open_shapes(
    profile: Profile, plan: Plan, floor: float, low: float, room: int, bead: float = 0.0
) -> tuple[Placed, ...]:
    """The shapes of an open vessel.

    floor: height of the inside's floor. low: height of the top of a stem, where the wall begins. room: most shapes.
    bead: radius of a wire round the rim, metres.
    """
    outside = profile.outside
    solid = [*outside[outside[:, 1] < floor], (profile.radius(floor), floor)]
    shapes = closed_shapes(np.array(solid), plan, 0.05 * plan.half_x)
    ways = _ways(plan)
    levels = max(1, (room - len(shapes) - (plan.lip > 0)) // len(ways))
    start = low + max(0.0035, 0.25 * (floor - low))
    wall = np.concatenate([[[profile.radius(start), start]], outside[outside[:, 1] > start + 1e-5]])
    line = _levels(wall, plan, min(levels, 3))
    thickness = max(THICK, float(np.linalg.norm(profile.inside[-1] - outside[-1])))
    inner = line + thickness * _inwards(line)
    inner[:, 0] = np.maximum(inner[:, 0], 0.02 * plan.half_x)
    bulging = wall if _error(wall, line) > BULGE else wall[:0]
    over = max(0.0, bead - OVER)
    line[-1] += over  # outwards and upwards
    inner[-1, 1] += over
    for lower, upper in pairwise(range(len(line))):
        sides = [(float(r), float(z)) for ring in (line, inner) for r, z in (ring[lower], ring[upper])]
        sides += [(float(r), float(z)) for r, z in bulging if line[lower, 1] < z < line[upper, 1]]
        rings = [_polygon(plan, r, z, ways) for r, z in sides]
        for i in range(len(ways)):
            j = (i + 1) % len(ways)
            shapes += solids.hull_around(np.array([ring[k] for ring in rings for k in (i, j)])).shapes
    if plan.lip > 0:
        shapes += _lip(profile, plan, thickness)
    return tuple(shapes)


def _levels(wall: Floats, plan: Plan, most: int) -> Floats:
    """The (N, 2) corners of the line that follows a wall's profile best with few pieces."""
    marks = vessel_surface.thinned(wall, 0.0008)
    tolerance = max(0.0035, 0.035 * plan.half_x)
    best = marks[[0, -1]]
    for inner in range(most):
        choices = [marks[[0, *chosen, -1]] for chosen in combinations(range(1, len(marks) - 1), inner)]
        errors = [_error(marks, line) for line in choices]
        best = choices[int(np.argmin(errors))] if choices else best
        if not choices or min(errors) < tolerance:
            break
    return best


def _error(points: Floats, line: Floats) -> float:
    found = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        share = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1))
    return float(found.max())


def _lip(profile: Profile, plan: Plan, thickness: float) -> tuple[Placed, ...]:
    near = np.abs((np.arange(plan.around) * 2 * np.pi / plan.around) - np.pi) < 1.25 * plan.lip_width
    low = plan.lip_from + 0.35 * (1 - plan.lip_from)
    points = []
    for z in (low * plan.height, plan.height):
        r = profile.radius(z)
        points += [plan.ring(r, z)[near], replace(plan, lip=0.0).ring(r - thickness, z)[near]]
    return solids.hull_around(np.concatenate(points)).shapes


def closed_shapes(line: Floats, plan: Plan, slack: float) -> list[Placed]:
    """The shapes of a solid body that a profile line bounds, (N, 2) radius and height: cylinders, boxes and hulls."""
    shapes: list[Placed] = []
    found = vessel_surface.thinned(line, slack)
    low = float(found[0, 1])
    if len(found) > 1 and found[0, 0] > 1.02 * plan.half_x * 0.02:
        # It stands on a plain disc or box, whatever else it is made of.
        shapes += _block(plan, float(found[0, 0]), low, max(min(low + 0.003, float(found[-1, 1])), low + 0.001))
    for (r0, z0), (r1, z1) in pairwise(found):
        if z1 - z0 < 0.001:
            continue
        if abs(r1 - r0) < 0.06 * max(r0, r1):
            shapes += _block(plan, float(r0 + r1) / 2, float(z0), float(z1))
            continue
        lift = min(0.0015, 0.3 * float(z1 - z0))
        rings = [plan.ring(float(r), float(z) + raised)[::2] for r, z, raised in ((r0, z0, lift), (r1, z1, 0.0))]
        shapes += solids.hull_around(np.concatenate(rings)).shapes
    return shapes


def _block(plan: Plan, radius: float, low: float, high: float) -> tuple[Placed, ...]:
    middle, tall = (low + high) / 2, high - low
    half_y = max(plan.half_y - (plan.half_x - radius), 0.1 * radius)
    if plan.corner is None and abs(half_y - radius) < 1e-6:
        return solids.rod(radius, tall, 0.0).translated(z=middle).shapes
    if plan.corner is not None:
        return solids.box((2 * radius, 2 * half_y, tall), (0.0, 0.0, middle), 0.0).shapes
    return solids.hull_around(np.concatenate([plan.ring(radius, z)[::2] for z in (low, high)])).shapes


def _ways(plan: Plan) -> Floats:
    """Directions of the corners of a ring of slabs: angles of an ellipse, or of a rectangle numbers of its corners."""
    if plan.corner is not None:
        return np.arange(8 if plan.corner > ROUND_CORNER else 4, dtype=np.float64)
    count = 12 if plan.half_x > WIDE else 6 if plan.half_x < SMALL else 8
    # A quarter of a step on: then the polygon is as wide in x as in y, to all four sides.
    return (np.arange(count) + 0.25) * 2 * np.pi / count


def _polygon(plan: Plan, radius: float, z: float, ways: Floats) -> Floats:
    """(N, 3) corners of a ring of slabs, half way between the polygon inside the outline and the one about it."""
    if plan.corner is not None:
        inset = plan.half_x - radius
        x, y = max(radius, 1e-4), max(plan.half_y - inset, 1e-4)
        cut = min(0.45 * (max(plan.corner - inset, 0.0) if len(ways) == 8 else 0.0), 0.8 * x, 0.8 * y)
        corners = [(x, y - cut), (x - cut, y), (-x + cut, y), (-x, y - cut)]
        corners += [(-x, -y + cut), (-x + cut, -y), (x - cut, -y), (x, -y + cut)]
        flat = np.array(corners if len(ways) == 8 else corners[::2])
        return np.column_stack([flat, np.full(len(flat), z)])
    ring = replace(plan, lip=0.0, lip_rise=0.0, flutes=0, facets=0).ring(float(radius), float(z))
    angle = np.arange(plan.around) * 2 * np.pi / plan.around
    wide = 1 + 0.5 * (1 / math.cos(math.pi / len(ways)) - 1)
    if plan.facets:
        wide *= 0.3 + 0.7 * math.cos(math.pi / plan.facets)
    parts = [np.interp(ways, angle, ring[:, k], period=2 * np.pi) for k in range(3)]
    return np.stack([parts[0] * wide, parts[1] * wide, parts[2]], axis=1)


def _inwards(line: Floats) -> Floats:
    """(N, 2) unit normals of a profile line that point to its inside."""
    way = np.gradient(line, axis=0) if len(line) > 2 else np.repeat(np.diff(line, axis=0), 2, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-9)[:, None]
    return np.stack([-way[:, 1], way[:, 0]], axis=1)


# Parameters of a vessel that are the fields of its plan of the same names.
AS_IN_PLAN = (
    *("facets", "flutes", "flute_depth", "twist", "fluted_from"),
    *("lip", "lip_width", "lip_rise", "lip_from", "weave", "stakes"),
)
# The most collision shapes of a vessel with all that is on it.
MOST_SHAPES = 24
# How far the rim of a lid that can be lifted reaches down outside, metres.
LOOSE_SKIRT = 0.003
# What stays free between a lid that is lifted and a handle that arches over it: its shapes are boxes, which reach in.
UNDER_ARCH_M = 0.008


def build_vessel(builder: AssetBuilder, p: Vessel) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    plan = _plan(p)
    floor = p.stem * p.height + p.floor + p.foot
    points = [(r * p.width / 2, z * p.height) for r, z in p.profile]
    profile = vessel_surface.vessel_profile(points, p.soft, p.rounding, p.wall, floor, p.fillet, p.foot)
    parts = [*handles(p, profile, plan), *spouts(p, profile)]
    if p.weave > 0:
        profile = vessel_surface.woven(profile, plan.row / 2)
    path, v = profile.path()
    body = vessel_surface.surface(path, v, plan, replace(plan, weave=0.0))
    if p.hole > 0:
        body = _pierced(body, p, plan, profile)
    # Nothing is put in through the mouth of a kettle, under its handle.
    if p.lid and (not p.lid_opens or p.handle is HandleForm.ARCH):
        shapes = tuple(closed_shapes(profile.outside, plan, 0.025 * p.width))
    else:
        lid_shapes = 1 + (p.knob is not KnobForm.NONE) + 4 * (p.knob is KnobForm.BOW) if p.lid else 0
        room = MOST_SHAPES - lid_shapes - sum(len(part.shapes) for part, _, _ in parts)
        shapes = open_shapes(profile, plan, floor, p.stem * p.height, room, p.bead)
    density = p.matter * builder.supplies.finish(p.skin).substance.density
    builder.add(ROOT, body.with_shapes(*shapes), p.skin, label="body", name="body", density=density)
    around = math.pi * p.width
    for part, finish, label in parts:
        solid = vessel_surface.pictured(seated(part, p, plan, profile), profile, around)
        density = min(builder.supplies.finish(finish).substance.density, builder.supplies.density("vessel_handle"))
        density *= p.matter if finish == p.skin else 1.0
        builder.add(ROOT, solid, finish, label=label, density=density)
    rim = plan.ring(*(float(n) for n in (profile.outside[-1] + profile.inside[-1]) / 2))
    if p.bead > 0:
        bead = vessel_surface.patched(rim_bead(rim, p.bead, 6 if p.weave > 0 or p.hole > 0 else 8), RIM_V, 0.002)
        # Of metal it is a rolled edge with air in it.
        density = min(builder.supplies.finish(p.rim_finish).substance.density, builder.supplies.density("rolled_edge"))
        builder.add(ROOT, bead, p.rim_finish, label="rim", collider=False, density=density)
    if p.wires:
        builder.add(ROOT, sieve_wires(profile.outside, p.wires, 0.0005), p.rim_finish, label="body", collider=False)
    if p.lid:
        _lid(builder, p, plan)
    if p.content > 0:
        _content(builder, p, plan, profile)
    _prints(builder, p, plan, profile)


def _plan(p: Vessel) -> Plan:
    half_x, half_y = p.width / 2, p.width / 2 * p.across
    if p.facets:
        around = p.facets * max(2, round(40 / p.facets))
    elif p.weave > 0:
        around = 2 * p.stakes
    elif p.flutes > 12:
        around = 56
    else:
        around = 48 if (p.width > 0.21 or p.flutes) and not (p.hole > 0 or p.wires) else 40
    corner = None if p.corner >= 1 else p.corner * half_y
    copied = {name: getattr(p, name) for name in AS_IN_PLAN}
    return Plan(half_x, half_y, corner, p.height, row=p.height / p.rows, around=around, **copied)


def _pierced(body: Solid, p: Vessel, plan: Plan, profile: Profile) -> Solid:
    tools = []
    low, high = p.holes_from * p.height, p.holes_to * p.height
    line = profile.outside[(profile.outside[:, 1] >= low) & (profile.outside[:, 1] <= high)]
    rows = max(1, round(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) / p.hole_gap))
    drill = solids.prism(solids.circle(p.hole, 6), 0.05, 0.0).translated(z=-0.025)
    for k, z in enumerate(np.linspace(low, high, rows)):
        r = profile.radius(float(z))
        count = max(4, round(2 * math.pi * r / p.hole_gap))
        for i in range(count):
            angle = 2 * math.pi * (i + 0.5 * (k % 2)) / count
            tool = drill.rotated("y", math.pi / 2 + profile.slope(float(z))).translated(x=r, z=float(z))
            tools.append(tool.rotated("z", angle))
    for ring in range(int((profile.radius(0.0) - 1.5 * p.hole) / p.hole_gap) + 1):
        count = max(1, round(2 * math.pi * ring))
        for i in range(count):
            angle = 2 * math.pi * i / count
            tools.append(drill.translated(ring * p.hole_gap * math.cos(angle), ring * p.hole_gap * math.sin(angle)))
    return solids.subtract(body, *tools, shapes=body.shapes)


def _lid(builder: AssetBuilder, p: Vessel, plan: Plan) -> None:
    rim = p.profile[-1][0] * p.width / 2
    finish = p.lid_finish or p.skin
    lid = Lid(
        radius=rim + p.lid_over,
        rise=p.lid_rise,
        dome=p.lid_dome,
        thick=p.lid_thick,
        # What can be lifted has collision shapes above the rim alone, and is seen little beyond them.
        skirt=min(p.lid_skirt, LOOSE_SKIRT) if p.lid_opens else p.lid_skirt,
        sip=p.lid_sip,
        bead=p.lid_bead,
        knob=p.knob,
        knob_size=p.knob_size,
        finish=finish,
        knob_finish=p.knob_finish or finish,
        bead_finish=p.lid_bead_finish,
    )
    rim_z = p.height + max(p.wall / 2, p.bead) + 0.0004
    if not p.lid_opens:
        add_lid(builder, lid, plan, rim_z)
        return
    builder.link(LID)
    add_lid(builder, lid, plan, rim_z, LID)
    top = max(float(part.solid.bounds[1, 2]) for part in builder.links[LID].parts)
    under = p.height + p.handle_reach - p.handle_thick
    lift_off(builder, 2 * rim, most=(under - top - UNDER_ARCH_M if p.handle is HandleForm.ARCH else MOST_LIFT))


def _content(builder: AssetBuilder, p: Vessel, plan: Plan, profile: Profile) -> None:
    inside = profile.inside[1:]
    floor = float(inside[0, 1])
    level = floor + p.content * (p.height - floor)
    low = inside[(inside[:, 1] < level) & (inside[:, 0] > 0.004)]
    line = np.concatenate([low, [[float(np.interp(level, inside[:, 1], inside[:, 0])), level]]]) - (0.0005, -0.0004)
    path = np.concatenate([[[0.0, floor + 0.0004]], line, [[0.0, level + 0.0004]]])
    builder.add(
        ROOT, vessel_surface.turned_on(path, plan), p.content_finish, label="content", collider=False, density="liquid"
    )


def _prints(builder: AssetBuilder, p: Vessel, plan: Plan, profile: Profile) -> None:
    lines = []
    for k in range(p.marks):
        z = p.height * (0.2 + 0.62 * k / max(p.marks - 1, 1))
        wide = 0.34 if k % 2 == 0 else 0.2
        ring = plan.ring(profile.radius(z) + 0.0004, z)
        angle = np.arctan2(ring[:, 1], ring[:, 0])
        turn = -math.pi / 2 + np.linspace(-wide, wide, 7)
        order = np.argsort(angle)
        x, y = (np.interp(turn, angle[order], ring[order, k2], period=2 * np.pi) for k2 in (0, 1))
        lines.append(strap(np.stack([x, y, 0 * x + z], axis=1), [(0.0016, 0.0008)] * 7, side=(0.0, 0.0, 1.0), count=4))
    if lines:
        marks = solids.concatenate([line.without_colliders() for line in lines])
        builder.add(ROOT, marks, p.mark_finish, label="print", collider=False, density=0.0)
    if p.sleeve:
        low, high = 0.3 * p.height, 0.72 * p.height
        a, b = profile.radius(low) + 0.0003, profile.radius(high) + 0.0003
        band = [(0.0, low), (a + 0.0009, low), (b + 0.0009, high), (0.0, high)]
        hole = [(0.0, low - 0.01), (a - 0.0004, low - 0.01), (b, high + 0.01), (0.0, high + 0.01)]
        sleeve = solids.subtract(*(vessel_surface.turned_on(np.array(path), plan) for path in (band, hole)))
        builder.add(ROOT, sleeve, p.mark_finish, label="sleeve", collider=False)
