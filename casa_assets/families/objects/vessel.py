"""Open things turned on a wheel or drawn from sheet: bowls, cups, jugs, pots and pans, with handles, spout and lid."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.boolean import subtract
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.families.kit.solids.sweep import circle, prism
from casa_assets.families.objects.vessel_colliders import closed_shapes, open_shapes
from casa_assets.families.objects.vessel_fittings import (
    arch,
    ear,
    long_handle,
    loop,
    rim_bead,
    sieve_wires,
    spout,
    strap,
)
from casa_assets.families.objects.vessel_lids import KnobForm, Lid, add_lid
from casa_assets.families.objects.vessel_surface import (
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
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Vec2

Metres = Annotated[float, Field(gt=0, le=0.7)]
Length = Annotated[float, Field(ge=0, le=0.4)]
Share = Annotated[float, Field(ge=0, le=1)]
# The most collision shapes of a vessel with all that is on it.
MOST_SHAPES = 24


class HandleForm(StrEnum):
    """Where a hand takes it."""

    NONE = "none"
    EAR = "ear"  # the handle of a mug
    EARS = "ears"  # two of them
    LONG = "long"  # the handle of a pan, in one piece
    GRIP = "grip"  # the same with a grip of another finish
    LOOPS = "loops"  # level loops on both sides
    LONG_LOOP = "long_loop"  # a long grip, and a level loop across
    ARCH = "arch"  # over the top


class Vessel(Params):
    """Parameters of a vessel; lengths in metres.

    Attributes:
        profile: the outside from the edge of the foot to the rim, (radius, height), radius by half the width, height by
            the height. soft: a smooth curve runs through these points; else corners are rounded by `rounding`.
        width, height: of the body. across: the width in y by that in x. corner: radius of the corners seen from above
            by half the lesser width; 1 for round or oval.
        wall: its thickness. floor: thickness of the floor. stem: share of the height below the floor of the inside.
        fillet: between floor and wall inside. foot: height of a hollow under the foot.
        facets, flutes, flute_depth, twist, fluted_from: as in `Plan`. weave, stakes, rows: strands of a basket.
        lip, lip_width, lip_rise, lip_from: of a spout drawn out of the rim, as in `Plan`.
        bead: radius of a wire round the rim.
        handle: where a hand takes it. handle_reach: how far it stands out; the length of a long one; the height of an
            arch. handle_top, handle_low: of an ear, by the height. handle_width, handle_thick: of its section.
            handle_square: 1 round, less for corners. handle_sag: of an ear. handle_rise: of a long one, rad.
            handle_hole: radius of a hole in its end.
        spout: how far a tube of a spout stands out. spout_from, spout_to: heights of its ends, by the height.
            spout_radius: at the wall. spout_curve: 0 straight, 1 bent.
        lid: it has a lid on it. lid_rise, lid_dome, lid_over: height, shape, how far it reaches over the rim.
            lid_skirt: how far it reaches down outside. lid_bead: radius of a ring of metal round it.
            knob, knob_size: what it is lifted by.
        hole: radius of holes in its wall, 0 for none. hole_gap: distance of two. holes_from, holes_to: by the height.
        wires: of a sieve, from its middle to its rim; its wall is then gauze.
        content: how full it is, by the height. marks: lines of a measure. sleeve: a band of card about the middle.
        matter: share of the wall's volume that is matter.
        skin, rim_finish, handle_finish, grip_finish, spout_finish, lid_finish, knob_finish, content_finish,
            mark_finish: finishes. skin may be a picture for the whole of it; its height is the way from the middle of
            the underside (0) over the rim (0.5) to the middle of the inside (1).
    """

    profile: Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=20)]
    soft: bool = True
    rounding: Length = 0.004
    width: Metres
    height: Metres
    across: Annotated[float, Field(ge=0.3, le=1)] = 1.0
    corner: Share = 1.0
    wall: Annotated[float, Field(ge=0.0006, le=0.02)] = 0.004
    floor: Annotated[float, Field(ge=0.0006, le=0.04)] = 0.005
    stem: Share = 0.0
    fillet: Length = 0.006
    foot: Annotated[float, Field(ge=0, le=0.03)] = 0.0
    facets: Annotated[int, Field(ge=0, le=20)] = 0
    flutes: Annotated[int, Field(ge=0, le=40)] = 0
    flute_depth: Annotated[float, Field(ge=0, le=0.3)] = 0.03
    twist: Annotated[float, Field(ge=-3, le=3)] = 0.0
    fluted_from: Share = 0.0
    weave: Annotated[float, Field(ge=0, le=0.01)] = 0.0
    stakes: Annotated[int, Field(ge=8, le=48)] = 32
    rows: Annotated[int, Field(ge=3, le=20)] = 8
    lip: Length = 0.0
    lip_width: Annotated[float, Field(ge=0.1, le=1.5)] = 0.4
    lip_rise: Annotated[float, Field(ge=-0.05, le=0.1)] = 0.0
    lip_from: Annotated[float, Field(ge=0, le=0.95)] = 0.55
    bead: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    handle: HandleForm = HandleForm.NONE
    handle_reach: Length = 0.03
    handle_top: Annotated[float, Field(ge=0, le=1.2)] = 0.85
    handle_low: Share = 0.2
    handle_width: Metres = 0.014
    handle_thick: Metres = 0.008
    handle_square: Annotated[float, Field(ge=0.3, le=1.2)] = 0.8
    handle_sag: Annotated[float, Field(ge=-0.5, le=0.5)] = 0.0
    handle_rise: Annotated[float, Field(ge=-0.3, le=0.9)] = 0.15
    handle_hole: Annotated[float, Field(ge=0, le=0.012)] = 0.0
    spout: Length = 0.0
    spout_from: Share = 0.3
    spout_to: Annotated[float, Field(ge=0, le=1.4)] = 0.9
    spout_radius: Metres = 0.016
    spout_tip: Metres = 0.008
    spout_curve: Share = 0.6
    lid: bool = False
    lid_rise: Length = 0.02
    lid_dome: Annotated[float, Field(ge=1, le=12)] = 2.5
    lid_over: Annotated[float, Field(ge=-0.03, le=0.02)] = 0.002
    lid_skirt: Length = 0.0
    lid_thick: Annotated[float, Field(ge=0.0006, le=0.01)] = 0.003
    lid_bead: Annotated[float, Field(ge=0, le=0.006)] = 0.0
    knob: KnobForm = KnobForm.BALL
    knob_size: Metres = 0.012
    hole: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    hole_gap: Metres = 0.02
    holes_from: Share = 0.2
    holes_to: Share = 0.85
    wires: Annotated[int, Field(ge=0, le=40)] = 0
    content: Share = 0.0
    marks: Annotated[int, Field(ge=0, le=12)] = 0
    sleeve: bool = False
    matter: Annotated[float, Field(ge=0.05, le=1)] = 1.0
    skin: FinishId
    rim_finish: FinishId = "stainless_brushed"
    handle_finish: FinishId | None = None
    grip_finish: FinishId = "plastic_black"
    lid_finish: FinishId | None = None
    knob_finish: FinishId | None = None
    lid_bead_finish: FinishId = "stainless_polished"
    content_finish: FinishId = "coffee_dark"
    mark_finish: FinishId = "plastic_red"


def build(builder: AssetBuilder, p: Vessel) -> None:
    """Build the asset: it stands on z = 0, its handle to +x and its spout to -x."""
    plan = _plan(p)
    floor = p.stem * p.height + p.floor + p.foot
    points = [(r * p.width / 2, z * p.height) for r, z in p.profile]
    profile = vessel_profile(points, p.soft, p.rounding, p.wall, floor, p.fillet, p.foot)
    parts = [part for parts in (_handles(p, profile, plan), _spouts(p, profile)) for part in parts]
    if p.weave > 0:
        profile = woven(profile, plan.row / 2)
    path, v = profile.path()
    body = surface(path, v, plan, replace(plan, weave=0.0))
    if p.hole > 0:
        body = _pierced(body, p, plan, profile)
    if p.lid:
        shapes = tuple(closed_shapes(profile.outside, plan, 0.025 * p.width))
    else:
        room = MOST_SHAPES - sum(len(part.shapes) for part, _, _ in parts)
        shapes = open_shapes(profile, plan, floor, p.stem * p.height, room)
    substance = builder.supplies.finish(p.skin).substance
    density = p.matter * substance.density
    builder.add(ROOT, body.with_shapes(*shapes), p.skin, label="body", name="body", density=density)
    around = math.pi * p.width
    for part, finish, label in parts:
        solid = pictured(_seated(part, p, plan, profile), profile, around)
        builder.add(ROOT, solid, finish, label=label, density=_handle_density(builder, p, finish))
    rim = plan.ring(*(float(n) for n in (profile.outside[-1] + profile.inside[-1]) / 2))
    if p.bead > 0:
        bead = rim_bead(rim, p.bead, 6 if p.weave > 0 or p.hole > 0 else 8)
        bead = patched(bead, RIM_V, 0.002)
        # Of metal it is a rolled edge with air in it.
        density = builder.supplies.finish(p.rim_finish).substance.density
        builder.add(ROOT, bead, p.rim_finish, label="rim", collider=False, density=min(density, 2700.0))
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
    around = (
        2 * p.stakes
        if p.weave > 0
        else 56
        if p.flutes > 12
        else 40
        if p.hole > 0 or p.wires
        else 48
        if p.width > 0.21 or p.flutes
        else 40
    )
    if p.facets:
        around = p.facets * max(2, round(40 / p.facets))
    return Plan(
        half_x=half_x,
        half_y=half_y,
        corner=None if p.corner >= 1 else p.corner * half_y,
        height=p.height,
        facets=p.facets,
        flutes=p.flutes,
        flute_depth=p.flute_depth,
        twist=p.twist,
        fluted_from=p.fluted_from,
        lip=p.lip,
        lip_width=p.lip_width,
        lip_rise=p.lip_rise,
        lip_from=p.lip_from,
        weave=p.weave,
        stakes=p.stakes,
        row=p.height / p.rows,
        around=around,
    )


def _handle_density(builder: AssetBuilder, p: Vessel, finish: str) -> float:
    """kg/m^3 of a handle or spout, which may be hollow: of metal never more than a third of the solid."""
    density = builder.supplies.finish(finish).substance.density
    return min(density, 2600.0) * (p.matter if finish == p.skin else 1.0)


def _seated(part: Solid, p: Vessel, plan: Plan, profile: Profile) -> Solid:
    """A handle or spout whose end is drawn back into the wall where it would come out on the inside."""
    x, y, z = part.points.T
    within = np.array([profile.radius(float(h)) for h in z]) - 0.7 * p.wall
    if plan.corner is not None:
        flat = np.column_stack([np.sign(x) * np.maximum(np.abs(x), within), y])
    else:
        short = np.maximum(plan.half_y - (plan.half_x - within), 1e-4)
        far = np.hypot(x, y * within / short)
        flat = part.points[:, :2] * np.maximum(1.0, within / np.maximum(far, 1e-6))[:, None]
    below = z < p.height
    points = np.column_stack([np.where(below[:, None], flat, part.points[:, :2]), z])
    return replace(part, points=points)


Part = tuple[Solid, str, str]


def _handles(p: Vessel, profile: Profile, plan: Plan) -> list[Part]:
    """Handles with their finishes and labels."""
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
        bar = long_handle((r - into, 0.0, top), reach, p.handle_rise, taper, p.handle_hole)
        return [(bar, own, "handle")]
    # A strap of metal, and on its end a grip.
    bare = 0.26 * reach
    run = p.handle_rise
    # The strap leaves the wall as steeply as the grip begins.
    metal = strap(
        [
            (r - into, 0.0, top),
            (r + 0.2 * bare, 0.0, top + 0.3 * bare * math.sin(run)),
            *((r + s * bare * math.cos(run), 0.0, top + s * bare * math.sin(run) * 1.15) for s in (0.45, 0.8, 1.15)),
        ],
        [(1.5 * w, 0.35 * t), (1.1 * w, 0.35 * t), (0.7 * w, 0.45 * t), (0.6 * w, 0.5 * t), (0.6 * w, 0.5 * t)],
        power=0.7,
    )
    start = (r + bare * math.cos(run), 0.0, top + 1.15 * bare * math.sin(run))
    swell = ((0, 0.72 * w, 0.8 * t), (0.06, 0.85 * w, t), (0.5, w, 1.1 * t), (0.85, 1.1 * w, t), (1, 0.6 * w, 0.6 * t))
    grip = long_handle(start, reach - bare, run, swell, p.handle_hole)
    found = [(metal, own, "handle"), (grip, p.grip_finish, "handle")]
    if p.handle is HandleForm.LONG_LOOP:
        found.append((_loops(p, profile, plan, top)[1], own, "handle"))
    return found


def _loops(p: Vessel, profile: Profile, plan: Plan, z: float) -> list[Solid]:
    """Level loops to both sides."""
    r, half = profile.radius(z), 0.5 * min(0.5 * p.width * p.across, 0.1)
    short = plan.half_y - (plan.half_x - r)
    x = r - 0.55 * p.wall
    if plan.corner is None:
        # Its ends go in far enough to be covered; `_seated` keeps them within the wall.
        x = r * math.sqrt(max(0.0, 1 - (half / short) ** 2)) - 0.55 * p.wall - p.handle_thick - p.weave
    reach = r + (0.5 if p.handle is HandleForm.LONG_LOOP and p.handle_reach > 0.08 else 1.0) * min(p.handle_reach, 0.05)
    part = loop(x, half, z, reach - x, p.handle_thick, min(p.handle_width, 2 * p.handle_thick), p.handle_square)
    return [part, part.rotated("z", math.pi)]


def _spouts(p: Vessel, profile: Profile) -> list[Part]:
    """The tube of a spout."""
    if p.spout <= 0:
        return []
    z = p.spout_from * p.height
    start = (-(profile.radius(z) - 0.6 * p.wall - 0.3 * p.spout_radius), z)
    end = (-(max(profile.radius(z), profile.radius(0.5 * p.height)) + p.spout), p.spout_to * p.height)
    return [(spout(start, end, p.spout_radius, p.spout_tip, p.spout_curve), p.skin, "spout")]


def _pierced(body: Solid, p: Vessel, plan: Plan, profile: Profile) -> Solid:
    """The body with rows of holes; it has no picture any more."""
    tools = []
    low, high = p.holes_from * p.height, p.holes_to * p.height
    line = profile.outside[(profile.outside[:, 1] >= low) & (profile.outside[:, 1] <= high)]
    run = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    rows = max(1, round(run / p.hole_gap))
    zs = np.linspace(low, high, rows)
    drill = prism(circle(p.hole, 6), 0.05, 0.0).translated(z=-0.025)
    for k, z in enumerate(zs):
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
        skirt=p.lid_skirt,
        bead=p.lid_bead,
        knob=p.knob,
        knob_size=p.knob_size,
        finish=finish,
        knob_finish=p.knob_finish or finish,
        bead_finish=p.lid_bead_finish,
    )
    add_lid(builder, lid, plan, p.height + max(p.wall / 2, p.bead) + 0.0004)


def _content(builder: AssetBuilder, p: Vessel, plan: Plan, profile: Profile) -> None:
    """What is in it, a little smaller than the inside."""
    inside = profile.inside[1:]
    floor = float(inside[0, 1])
    level = floor + p.content * (p.height - floor)
    low = inside[(inside[:, 1] < level) & (inside[:, 0] > 0.004)]
    r = float(np.interp(level, inside[:, 1], inside[:, 0]))
    line = np.concatenate([low, [[r, level]]]) - (0.0005, -0.0004)
    path = np.concatenate([[[0.0, floor + 0.0004]], line, [[0.0, level + 0.0004]]])
    builder.add(ROOT, turned_on(path, plan), p.content_finish, label="content", collider=False, density=1000.0)


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
        path = np.array([(0.0, low), (a + 0.0009, low), (b + 0.0009, high), (0.0, high)])
        band = turned_on(path, plan)
        hole = turned_on(
            np.array([(0.0, low - 0.01), (a - 0.0004, low - 0.01), (b, high + 0.01), (0.0, high + 0.01)]), plan
        )
        sleeve = subtract(band, hole)
        builder.add(ROOT, sleeve, p.mark_finish, label="sleeve", collider=False)


FORM = ParametricModel("vessel", Vessel, build, base=Base.FREE)
