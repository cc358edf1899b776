"""Open things turned on a wheel or drawn from sheet: bowls, cups, jugs, pots and pans, with handles, spout and lid."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext import solids
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid
from casa_assets.kitchenware.objects import vessel_body
from casa_assets.kitchenware.objects.closures import LID, MOST_LIFT, lift_off
from casa_assets.kitchenware.objects.vessel_body import RIM_V, Plan, Profile, closed_shapes, open_shapes
from casa_assets.kitchenware.objects.vessel_fittings import (
    KnobForm,
    Lid,
    add_lid,
    arch,
    ear,
    long_handle,
    loop,
    rim_bead,
    sieve_wires,
    spout,
    strap,
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
Metres = Annotated[float, Field(gt=0, le=0.7)]
Length = Annotated[float, Field(ge=0, le=0.4)]
Share = Annotated[float, Field(ge=0, le=1)]

# Where a hand takes it: EAR the handle of a mug; EARS two of them; LONG the handle of a pan, in one piece; GRIP the
# same with a grip of another finish; LOOPS level loops on both sides; LONG_LOOP a long grip, and a level loop across;
# ARCH over the top.
HandleForm = StrEnum("HandleForm", "NONE EAR EARS LONG GRIP LOOPS LONG_LOOP ARCH")
# A solid, its finish and its label.
Part = tuple[Solid, str, str]


class Vessel(Params):
    """Parameters of a vessel; lengths in metres."""

    profile: tuple[Vec2, ...] = Field(
        min_length=2,
        max_length=20,
        description="outside from foot to rim, (radius by half the width, height by the height)",
    )
    soft: bool = Field(True, description="the profile is a smooth curve, else its corners are rounded")
    rounding: Length = Field(0.004, description="radius of the profile's corners, m")
    width: Metres = Field(description="of the body, m")
    height: Metres = Field(description="of the body, m")
    across: float = Field(1.0, ge=0.3, le=1, description="width in y by that in x")
    corner: Share = Field(1.0, description="from above, by half the smaller width; 1: round or oval")
    wall: float = Field(0.004, ge=0.0006, le=0.02, description="thickness, m")
    floor: float = Field(0.005, ge=0.0006, le=0.04, description="thickness, m")
    stem: Share = Field(0.0, description="share of the height below the floor of the inside")
    fillet: Length = Field(0.006, description="radius between floor and wall inside, m")
    foot: float = Field(0.0, ge=0, le=0.03, description="height of a hollow under the foot, m")
    facets: int = Field(0, ge=0, le=20, description="as in `Plan`")
    flutes: int = Field(0, ge=0, le=40, description="as in `Plan`")
    flute_depth: float = Field(0.03, ge=0, le=0.3, description="as in `Plan`")
    twist: float = Field(0.0, ge=-3, le=3, description="as in `Plan`, rad")
    fluted_from: Share = Field(0.0, description="as in `Plan`")
    weave: float = Field(0.0, ge=0, le=0.01, description="how far strands of a basket go out and in, m")
    stakes: int = Field(32, ge=8, le=48, description="of a basket")
    rows: int = Field(8, ge=3, le=20, description="of strands")
    lip: Length = Field(0.0, description="how far a spout is drawn out of the rim, m")
    lip_width: float = Field(0.4, ge=0.1, le=1.5, description="rad")
    lip_rise: float = Field(0.0, ge=-0.05, le=0.1, description="m")
    lip_from: float = Field(0.55, ge=0, le=0.95, description="share of the height above which the lip begins")
    bead: float = Field(0.0, ge=0, le=0.02, description="radius of a wire around the rim, m")
    handle: HandleForm = Field(HandleForm.NONE, description="kind of handle")
    handle_reach: Length = Field(0.03, description="how far it projects; length of a long one; height of an arch, m")
    handle_top: float = Field(0.85, ge=0, le=1.2, description="upper end of an ear, by the height")
    handle_low: Share = Field(0.2, description="lower end of an ear, by the height")
    handle_width: Metres = Field(0.014, description="of its section, m")
    handle_thick: Metres = Field(0.008, description="of its section, m")
    handle_square: float = Field(0.8, ge=0.3, le=1.2, description="1: round; less: with corners")
    handle_sag: float = Field(0.0, ge=-0.5, le=0.5, description="of an ear")
    handle_rise: float = Field(0.15, ge=-0.3, le=0.9, description="of a long handle, rad")
    handle_hole: float = Field(0.0, ge=0, le=0.012, description="radius of a hole in its end, m")
    spout: Length = Field(0.0, description="how far a tubular spout projects, m; 0: none")
    spout_from: Share = Field(0.3, description="height of its lower end, by the height")
    spout_to: float = Field(0.9, ge=0, le=1.4, description="height of its tip, by the height")
    spout_radius: Metres = Field(0.016, description="at the wall, m")
    spout_tip: Metres = Field(0.008, description="radius at its tip, m")
    spout_curve: Share = Field(0.6, description="0: straight, 1: bent")
    lid: bool = Field(False, description="it has a lid on it")
    lid_opens: bool = Field(False, description="the lid can be lifted off, and the vessel is hollow below it")
    lid_rise: Length = Field(0.02, description="height of the lid, m")
    lid_dome: float = Field(2.5, ge=1, le=12, description="2: round; more: a flat top with steep sides")
    lid_over: float = Field(0.002, ge=-0.03, le=0.02, description="how far the lid reaches over the rim, m")
    lid_skirt: Length = Field(0.0, description="how far the lid reaches down outside, m")
    lid_thick: float = Field(0.003, ge=0.0006, le=0.01, description="of its sheet, m")
    lid_sip: bool = Field(False, description="the lid has a raised edge and a hole to drink from")
    lid_bead: float = Field(0.0, ge=0, le=0.006, description="radius of a ring of metal around the lid, m")
    knob: KnobForm = Field(KnobForm.BALL, description="what the lid is lifted by")
    knob_size: Metres = Field(0.012, description="radius or half length, m")
    hole: float = Field(0.0, ge=0, le=0.02, description="radius of holes in its wall, m; 0: none")
    hole_gap: Metres = Field(0.02, description="distance between two holes, m")
    holes_from: Share = Field(0.2, description="lowest holes, by the height")
    holes_to: Share = Field(0.85, description="highest holes, by the height")
    wires: int = Field(0, ge=0, le=40, description="of a sieve, from its middle to its rim; its wall is then gauze")
    content: Share = Field(0.0, description="filling level, by the height")
    marks: int = Field(0, ge=0, le=12, description="lines of a measure")
    sleeve: bool = Field(False, description="a band of card around the middle")
    matter: float = Field(1.0, ge=0.05, le=1, description="share of the wall's volume that is solid material")
    skin: FinishId = Field(description="a picture runs from the underside (0) over the rim (0.5) to the inside (1)")
    rim_finish: FinishId = "stainless_brushed"
    handle_finish: FinishId | None = None
    grip_finish: FinishId = "plastic_black"
    lid_finish: FinishId | None = None
    knob_finish: FinishId | None = None
    lid_bead_finish: FinishId = "stainless_polished"
    content_finish: FinishId = "coffee_dark"
    mark_finish: FinishId = "plastic_red"


def build(builder: AssetBuilder, p: Vessel) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    plan = _plan(p)
    floor = p.stem * p.height + p.floor + p.foot
    points = [(r * p.width / 2, z * p.height) for r, z in p.profile]
    profile = vessel_body.vessel_profile(points, p.soft, p.rounding, p.wall, floor, p.fillet, p.foot)
    parts = _handles(p, profile, plan)
    if p.spout > 0:
        parts.append((_spout(p, profile), p.skin, "spout"))
    if p.weave > 0:
        profile = vessel_body.woven(profile, plan.row / 2)
    path, v = profile.path()
    body = vessel_body.surface(path, v, plan, replace(plan, weave=0.0))
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
        solid = vessel_body.pictured(_seated(part, p, plan, profile), profile, around)
        density = min(builder.supplies.finish(finish).substance.density, builder.supplies.density("vessel_handle"))
        density *= p.matter if finish == p.skin else 1.0
        builder.add(ROOT, solid, finish, label=label, density=density)
    rim = plan.ring(*(float(n) for n in (profile.outside[-1] + profile.inside[-1]) / 2))
    if p.bead > 0:
        bead = vessel_body.patched(rim_bead(rim, p.bead, 6 if p.weave > 0 or p.hole > 0 else 8), RIM_V, 0.002)
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
    # What can be lifted has collision shapes above the rim alone, and is seen little beyond them.
    skirt = min(p.lid_skirt, LOOSE_SKIRT) if p.lid_opens else p.lid_skirt
    shape = (rim + p.lid_over, p.lid_rise, p.lid_dome, p.lid_thick, skirt, p.lid_sip, p.lid_bead)
    lid = Lid(*shape, p.knob, p.knob_size, finish, p.knob_finish or finish, p.lid_bead_finish)
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
    held = vessel_body.turned_on(path, plan)
    builder.add(ROOT, held, p.content_finish, label="content", collider=False, density="liquid")


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
        sleeve = solids.subtract(*(vessel_body.turned_on(np.array(path), plan) for path in (band, hole)))
        builder.add(ROOT, sleeve, p.mark_finish, label="sleeve", collider=False)


def _seated(part: Solid, p: Vessel, plan: Plan, profile: Profile) -> Solid:
    """A handle or spout whose end is drawn back into the wall where it would come out on the inside."""
    x, y, z = part.points.T
    within = np.array([profile.radius(float(h)) for h in z]) - 0.7 * p.wall
    if plan.corner is not None:
        flat = np.column_stack([np.sign(x) * np.maximum(np.abs(x), within), y])
    else:
        far = np.hypot(x, y * within / np.maximum(plan.half_y - (plan.half_x - within), 1e-4))
        flat = part.points[:, :2] * np.maximum(1.0, within / np.maximum(far, 1e-6))[:, None]
    return replace(part, points=np.column_stack([np.where((z < p.height)[:, None], flat, part.points[:, :2]), z]))


def _handles(p: Vessel, profile: Profile, plan: Plan) -> list[Part]:
    own = p.handle_finish or p.skin
    top, low = p.handle_top * p.height, p.handle_low * p.height
    into = 0.55 * p.wall
    r = profile.radius(top)
    reach = p.handle_reach
    if p.handle in (HandleForm.EAR, HandleForm.EARS):
        ends = [(profile.radius(z) - into, z) for z in (top, low)]
        out = max(profile.radius(z) for z in np.linspace(low, top, 5)) + reach
        part = ear(ends[0], ends[1], out, p.handle_width, p.handle_thick, p.handle_square, p.handle_sag)
        both = [part] if p.handle is HandleForm.EAR else [part, part.rotated("z", math.pi)]
        return [(part, own, "handle") for part in both]
    if p.handle is HandleForm.LOOPS:
        return [(part, own, "handle") for part in _loops(p, profile, plan, top)]
    if p.handle is HandleForm.ARCH:
        part = arch(r - into, top, p.height + reach, p.handle_width, p.handle_thick, p.handle_square, 1.25)
        return [(part, own, "handle")]
    if p.handle is HandleForm.NONE:
        return []
    w, t = p.handle_width, p.handle_thick
    if p.handle is HandleForm.LONG:
        taper = ((0, 1.5 * w, 1.1 * t), (0.12, w, t), (0.55, 0.8 * w, t), (0.9, 1.15 * w, t), (1, 0.7 * w, 0.8 * t))
        return [(long_handle((r - into, 0.0, top), reach, p.handle_rise, taper, p.handle_hole), own, "handle")]
    # A strap of metal, which leaves the wall as steeply as the grip on its end begins.
    bare, run = 0.26 * reach, p.handle_rise
    path = [(r - into, 0.0, top), (r + 0.2 * bare, 0.0, top + 0.3 * bare * math.sin(run))]
    for s in (0.45, 0.8, 1.15):
        path.append((r + s * bare * math.cos(run), 0.0, top + s * bare * math.sin(run) * 1.15))
    sizes = [(1.5 * w, 0.35 * t), (1.1 * w, 0.35 * t), (0.7 * w, 0.45 * t), (0.6 * w, 0.5 * t), (0.6 * w, 0.5 * t)]
    metal = strap(path, sizes, power=0.7)
    start = (r + bare * math.cos(run), 0.0, top + 1.15 * bare * math.sin(run))
    swell = ((0, 0.72 * w, 0.8 * t), (0.06, 0.85 * w, t), (0.5, w, 1.1 * t), (0.85, 1.1 * w, t), (1, 0.6 * w, 0.6 * t))
    grip = long_handle(start, reach - bare, run, swell, p.handle_hole)
    found = [(metal, own, "handle"), (grip, p.grip_finish, "handle")]
    if p.handle is HandleForm.LONG_LOOP:
        found.append((_loops(p, profile, plan, top)[1], own, "handle"))
    return found


def _loops(p: Vessel, profile: Profile, plan: Plan, z: float) -> list[Solid]:
    r, half = profile.radius(z), 0.5 * min(0.5 * p.width * p.across, 0.1)
    short, x = plan.half_y - (plan.half_x - r), r - 0.55 * p.wall
    if plan.corner is None:
        # Its ends go in far enough to be covered; `_seated` keeps them within the wall.
        x = r * math.sqrt(max(0.0, 1 - (half / short) ** 2)) - 0.55 * p.wall - p.handle_thick - p.weave
    reach = r + (0.5 if p.handle is HandleForm.LONG_LOOP and p.handle_reach > 0.08 else 1.0) * min(p.handle_reach, 0.05)
    part = loop(x, half, z, reach - x, p.handle_thick, min(p.handle_width, 2 * p.handle_thick), p.handle_square)
    return [part, part.rotated("z", math.pi)]


def _spout(p: Vessel, profile: Profile) -> Solid:
    z = p.spout_from * p.height
    start = (-(profile.radius(z) - 0.6 * p.wall - 0.3 * p.spout_radius), z)
    end = (-(max(profile.radius(z), profile.radius(0.5 * p.height)) + p.spout), p.spout_to * p.height)
    return spout(start, end, p.spout_radius, p.spout_tip, p.spout_curve)
