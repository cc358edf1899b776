"""Open things turned on a wheel or drawn from sheet: bowls, cups, jugs, pots and pans, with handles, spout and lid."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from casa_assets.ext.families import Family
from casa_assets.ext.records import Base
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, circle, concatenate, prism, subtract
from casa_assets.kitchenware.objects.containers.closures import LID, MOST_LIFT, lift_off
from casa_assets.kitchenware.objects.vessels.colliders import closed_shapes, open_shapes
from casa_assets.kitchenware.objects.vessels.fittings import (
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
from casa_assets.kitchenware.objects.vessels.surface import (
    RIM_V,
    Plan,
    Profile,
    patched,
    pictured,
    surface,
    turned_on,
    vessel_profile,
    woven,
)

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


def build(builder: AssetBuilder, p: Vessel) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    plan = _plan(p)
    floor = p.stem * p.height + p.floor + p.foot
    points = [(r * p.width / 2, z * p.height) for r, z in p.profile]
    profile = vessel_profile(points, p.soft, p.rounding, p.wall, floor, p.fillet, p.foot)
    parts = [*handles(p, profile, plan), *spouts(p, profile)]
    if p.weave > 0:
        profile = woven(profile, plan.row / 2)
    path, v = profile.path()
    body = surface(path, v, plan, replace(plan, weave=0.0))
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
        solid = pictured(seated(part, p, plan, profile), profile, around)
        density = min(builder.supplies.finish(finish).substance.density, builder.supplies.density("vessel_handle"))
        density *= p.matter if finish == p.skin else 1.0
        builder.add(ROOT, solid, finish, label=label, density=density)
    rim = plan.ring(*(float(n) for n in (profile.outside[-1] + profile.inside[-1]) / 2))
    if p.bead > 0:
        bead = patched(rim_bead(rim, p.bead, 6 if p.weave > 0 or p.hole > 0 else 8), RIM_V, 0.002)
        # Of metal it is a rolled edge with air in it.
        density = min(builder.supplies.finish(p.rim_finish).substance.density, builder.supplies.density("rolled_edge"))
        builder.add(ROOT, bead, p.rim_finish, label="rim", collider=False, density=density)
    if p.wires:
        wires = sieve_wires(profile.outside, p.wires, 0.0005)
        builder.add(ROOT, wires, p.rim_finish, label="body", collider=False)
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
    """The body with rows of holes; it has no picture any more."""
    tools = []
    low, high = p.holes_from * p.height, p.holes_to * p.height
    line = profile.outside[(profile.outside[:, 1] >= low) & (profile.outside[:, 1] <= high)]
    run = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    rows = max(1, round(run / p.hole_gap))
    drill = prism(circle(p.hole, 6), 0.05, 0.0).translated(z=-0.025)
    for k, z in enumerate(np.linspace(low, high, rows)):
        r = profile.radius(float(z))
        count = max(4, round(2 * math.pi * r / p.hole_gap))
        for i in range(count):
            angle = 2 * math.pi * (i + 0.5 * (k % 2)) / count
            tool = drill.rotated("y", math.pi / 2 + profile.slope(float(z))).translated(x=r, z=float(z))
            tools.append(tool.rotated("z", angle))
    bottom = profile.radius(0.0) - 1.5 * p.hole
    for ring in range(int(bottom / p.hole_gap) + 1):
        count = max(1, round(2 * math.pi * ring))
        for i in range(count):
            angle = 2 * math.pi * i / count
            tools.append(drill.translated(ring * p.hole_gap * math.cos(angle), ring * p.hole_gap * math.sin(angle)))
    return subtract(body, *tools, shapes=body.shapes)


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
    most = under - top - UNDER_ARCH_M if p.handle is HandleForm.ARCH else MOST_LIFT
    lift_off(builder, 2 * rim, most=most)


def _content(builder: AssetBuilder, p: Vessel, plan: Plan, profile: Profile) -> None:
    """Add the content, slightly smaller than the inside."""
    inside = profile.inside[1:]
    floor = float(inside[0, 1])
    level = floor + p.content * (p.height - floor)
    low = inside[(inside[:, 1] < level) & (inside[:, 0] > 0.004)]
    r = float(np.interp(level, inside[:, 1], inside[:, 0]))
    line = np.concatenate([low, [[r, level]]]) - (0.0005, -0.0004)
    path = np.concatenate([[[0.0, floor + 0.0004]], line, [[0.0, level + 0.0004]]])
    builder.add(ROOT, turned_on(path, plan), p.content_finish, label="content", collider=False, density="liquid")


def _prints(builder: AssetBuilder, p: Vessel, plan: Plan, profile: Profile) -> None:
    """Lines of a measure on the front, and a sleeve of card about a cup."""
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
        marks = concatenate([line.without_colliders() for line in lines])
        builder.add(ROOT, marks, p.mark_finish, label="print", collider=False, density=0.0)
    if p.sleeve:
        low, high = 0.3 * p.height, 0.72 * p.height
        a, b = profile.radius(low) + 0.0003, profile.radius(high) + 0.0003
        band = [(0.0, low), (a + 0.0009, low), (b + 0.0009, high), (0.0, high)]
        hole = [(0.0, low - 0.01), (a - 0.0004, low - 0.01), (b, high + 0.01), (0.0, high + 0.01)]
        sleeve = subtract(*(turned_on(np.array(path), plan) for path in (band, hole)))
        builder.add(ROOT, sleeve, p.mark_finish, label="sleeve", collider=False)


FORM = Family("vessel", Vessel, build, base=Base.FREE)
