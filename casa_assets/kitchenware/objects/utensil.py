"""Utensils and tools: a handle swept along a curve, and a head; they lie on z = 0 at rest, handle to +x."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import convex_hull, solid_moments
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Pose, Vec2
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    Solid,
    axis_turn,
    box,
    concatenate,
    hull_around,
    prism,
    rectangle,
    rod,
    tube,
)
from casa_assets.kitchenware.objects import utensil_parts as heads
from casa_assets.kitchenware.objects.utensil_parts import Bar, Part, Size, bar, drilled, stadium, value_at

Metres = Annotated[float, Field(ge=0, le=0.6)]
Share = Annotated[float, Field(ge=0, le=1)]
# A handle of a stuff that is heavier than this, kg/m^3, is hollow: share of it that is filled.
METAL, HOLLOW = 3000.0, 0.25
# How far a head reaches into its handle, metres.
TANG = 0.015

# BAR all `front`: a spoon; FORK `front` with slots; MOUTH with that of an opener; PEELER a blade between two arms.
Head = StrEnum(
    "Head", "BAR FORK MOUTH LADLE WHISK TONGS PEELER WHEEL SCISSORS CAN_OPENER PIN GRATER REAMER BRUSH SCALE STRAW"
)


class Utensil(Params):
    """Parameters of a utensil; lengths in metres, curves as in `utensil_parts.Bar`."""

    head: Head = Field(Head.BAR, description="kind of head")
    length: Metres = Field(description="of all of it, m")
    width: Metres = Field(description="of the head, across, m")
    depth: Metres = Field(0.0, description="of a cup; length of the wires of a whisk; height of a grater, m")
    thickness: Metres = Field(0.002, description="of the sheet or wood of `front`, m")
    rise: float = Field(0.0, ge=-0.2, le=0.2, description="of the front's spine, m")
    dish: Metres = Field(0.0, description="of the front, m")
    hollow: Metres = Field(0.0, description="of the front, m")
    front: Bar | None = Field(None, description="the head; of tongs an arm, of a ladle its stem")
    split: Share = Field(1.0, description="where the grip begins, by the length; 1: no grip")
    grip: Bar | None = Field(None, description="shape of a handle of another stuff")
    grip_width: Metres = Field(0.02, description="m")
    grip_thickness: Metres = Field(0.015, description="m")
    grip_rise: float = Field(0.0, ge=-0.1, le=0.1, description="m")
    grip_aside: float = Field(0.0, ge=-0.05, le=0.05, description="how far the middle of the grip lies to +y, m")
    tip: Share = Field(0.0, description="share of the length at the tip that is of the trim, as of silicone")
    tip_thickness: Metres = Field(0.004, description="m")
    sleeve: Vec2 = Field((0.0, 0.0), description="from where to where the grip covers the arms of tongs")
    count: int = Field(4, ge=0, le=60, description="of tines, wires, teeth, tufts or slits")
    gap: Metres = Field(0.003, description="between tines; of tongs at the hinge, m")
    reach: Metres = Field(0.0, description="of slots from the tip, m")
    spread: float = Field(0.0, ge=0, le=2, description="how far two arms are open, rad or by the width")
    belly: Share = Field(0.35, description="where a whisk is widest, by its length; how narrow a grater is above")
    bolster: Metres = Field(0.0, description="length of a collar at the start of the grip, m")
    rivets: int = Field(0, ge=0, le=4, description="through the grip")
    hole: Metres = Field(0.0, description="width of a hole for hanging near the end, m")
    hole_length: Metres = Field(0.0, description="m")
    loop: Metres = Field(0.0, description="radius of a wire to hang it by, m")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    mass: float = Field(0.0, ge=0, le=3, description="of all of it, kg; 0: from what it is made of")
    front_finish: FinishId = Field("stainless_polished", description="of the head")
    grip_finish: FinishId = Field("plastic_black", description="of the handle")
    trim_finish: FinishId = Field("stainless_brushed", description="of rivets, collars, tips and small parts")


def build(builder: AssetBuilder, p: Utensil) -> None:
    """Build the asset: it rests on z = 0."""
    parts = _MAKERS[p.head](p)
    densities = []
    for part in parts:
        density = part.fill * builder.supplies.finish(part.finish).substance.density
        densities.append(density * (HOLLOW if part.label == "handle" and density > METAL else 1.0))
    masses = [abs(part.solid.volume) * density for part, density in zip(parts, densities, strict=True)]
    points, _ = convex_hull(np.concatenate([part.solid.points for part in parts]))
    moments = [solid_moments(part.solid.points, part.solid.faces)[1] for part in parts]
    center = np.average(np.array(moments), axis=0, weights=masses)
    turned = 0.0
    for _ in range(12):
        turn = axis_turn("y", turned)
        flat, middle = turn.apply(points)[:, [0, 2]], turn.apply(center[None])[0]
        left, right = _footing(flat, float(middle[0]))
        slope = math.atan2(right[1] - left[1], right[0] - left[0])
        if abs(slope) < 1e-7:
            break
        turned += slope
    turn = axis_turn("y", turned)
    pose = Pose(position=(0.0, 0.0, -float(turn.apply(points)[:, 2].min()))) @ turn
    factor = p.mass / sum(masses) if p.mass > 0 else 1.0
    for k, (part, density) in enumerate(zip(parts, densities, strict=True)):
        name = f"{part.label}_{k:02d}"
        hit = name if part.collides else False
        placed, density = part.solid.transformed(pose), density * factor
        builder.add(ROOT, placed, part.finish, label=part.label, name=name, collider=hit, density=density)


def _footing(points: np.ndarray[tuple[int, int], np.dtype[np.float64]], x: float) -> tuple[Vec2, Vec2]:
    """The two points of the lower edge, (x, z), between which a place lies."""
    order = points[np.lexsort((points[:, 1], points[:, 0]))]
    lower: list[Vec2] = []
    for q in order:
        here = (float(q[0]), float(q[1]))
        while len(lower) > 1:
            (ax, az), (bx, bz) = lower[-2], lower[-1]
            if (bx - ax) * (here[1] - az) - (bz - az) * (here[0] - ax) > 0:
                break
            lower.pop()
        if not lower or here[0] > lower[-1][0] + 1e-7:
            lower.append(here)
    for a, b in pairwise(lower):
        if a[0] <= x <= b[0]:
            return a, b
    return lower[0], lower[-1]


def _grip(p: Utensil, z: float = 0.0) -> list[Part]:
    if p.grip is None or p.split >= 1:
        return []
    start, length = p.split * p.length, (1 - p.split) * p.length
    solid = bar(p.grip, Size(length=length, width=p.grip_width, thickness=p.grip_thickness, rise=p.grip_rise), hulls=2)
    end = value_at(p.grip.spine, 1.0, 0.0) * p.grip_rise
    parts: list[Part] = []
    if p.hole > 0:
        long = max(p.hole, p.hole_length)
        tool = prism(stadium(long, p.hole), 0.08, 0.0).translated(length - long / 2 - 0.5 * p.grip_width, 0, end - 0.04)
        solid = drilled(solid, [tool])
    if p.loop > 0:
        wire = heads.ring(heads.egg(3.2 * p.loop, 2 * p.loop, 20), rectangle(0.0022, 0.0022, 0.0008, 1), 1)
        parts.append(Part(wire.translated(length + 1.1 * p.loop, 0, end), p.trim_finish, "loop"))
    parts.append(Part(solid, p.grip_finish, "handle"))
    if p.bolster > 0:
        neck = p.bolster / length
        wide = value_at(tuple((s, w) for w, s in p.grip.outline if s <= 0.5), neck, 1.0) * p.grip_width
        deep = value_at(p.grip.thick, neck, 1.0) * p.grip_thickness
        ends = tuple((w, s) for w, s in ((0.8, 0.0), (1.0, 0.15), (1.0, 0.85), (0.9, 1.0)))
        shape = Bar(outline=ends, square=p.grip.square, thick=((0, 0.8), (0.15, 1), (0.85, 1), (1, 0.9)))
        made = bar(shape, Size(length=p.bolster, width=1.04 * wide, thickness=1.06 * deep), along=8, hulls=1)
        parts.append(Part(made.translated(x=-0.15 * p.bolster), p.trim_finish, "bolster", collides=False))
    for k in range(p.rivets):
        at = 0.2 + 0.62 * k / max(p.rivets - 1, 1)
        height = value_at(p.grip.spine, at, 0.0) * p.grip_rise
        deep = value_at(p.grip.thick, at, 1.0) * p.grip_thickness
        pin = rod(0.0032, 1.005 * deep + 0.0004, 0.0004).translated(at * length, 0, height)
        parts.append(Part(pin, p.trim_finish, "rivet", collides=False))
    return [replace(part, solid=part.solid.translated(start, p.grip_aside, z)) for part in parts]


def _front_length(p: Utensil) -> float:
    return p.length if p.grip is None or p.split >= 1 else p.split * p.length + TANG


def _front(p: Utensil, thickness: float = 0.0, span: Vec2 = (0.0, 1.0), widen: float = 0.0) -> Solid:
    if p.front is None:
        raise ValueError(f"a {p.head} needs a front")
    curves = {"rise": p.rise, "dish": p.dish, "hollow": p.hollow}
    size = Size(length=_front_length(p), width=p.width + widen, thickness=thickness or p.thickness, **curves)
    return bar(p.front, size, span=span, hulls=2 if span != (0.0, 1.0) else 4)


def _front_end(p: Utensil) -> float:
    if p.front is None or p.split >= 1:
        return 0.0
    return value_at(p.front.spine, p.split * p.length / _front_length(p), 0.0) * p.rise


def _fronts(p: Utensil) -> list[Part]:
    if p.tip <= 0:
        return [Part(_front(p), p.front_finish, "head")]
    rest = _front(p, span=(max(p.tip - 0.05, 0.02), 1.0))
    tip = _front(p, thickness=p.tip_thickness, span=(0.0, p.tip))
    return [Part(rest, p.front_finish, "stem"), Part(tip, p.trim_finish, "head")]


def _bar(p: Utensil) -> list[Part]:
    return [*_fronts(p), *_grip(p, _front_end(p))]


def _fork(p: Utensil) -> list[Part]:
    front = _front(p)
    cut = drilled(front, heads.tine_cuts(p.count, p.reach, p.width, p.gap, 4 * (abs(p.rise) + p.thickness + p.dish)))
    return [Part(replace(cut, picture_uv=None), p.front_finish, "head"), *_grip(p, _front_end(p))]


def _mouth(p: Utensil) -> list[Part]:
    long, wide = p.reach, p.gap
    tool = heads.mouth_cut(long, wide, 0.06, 0.3 * long)
    front = drilled(_front(p), [tool.translated(x=long / 2 + (p.width - wide) / 2)])
    return [Part(front, p.front_finish, "head"), *_grip(p, _front_end(p))]


def _ladle(p: Utensil) -> list[Part]:
    radius = p.width / 2
    parts = [Part(heads.cup(radius, p.depth, 0.0016, 1.0 + p.belly).translated(x=radius), p.front_finish, "cup")]
    start = 2 * radius - 0.003
    if p.front is None:
        raise ValueError("a ladle needs a stem as its front")
    long = p.split * p.length + (TANG if p.split < 1 else 0.0) - start
    stem = bar(p.front, Size(length=long, width=p.gap, thickness=p.thickness, rise=p.rise), hulls=3)
    parts.append(Part(stem.translated(x=start, z=-0.0015), p.front_finish, "stem"))
    return [*parts, *_grip(p, value_at(p.front.spine, (p.split * p.length - start) / long, 0.0) * p.rise - 0.0015)]


def _whisk(p: Utensil) -> list[Part]:
    start = p.split * p.length
    neck = 0.36 * min(p.grip_width, p.grip_thickness)
    wires = heads.whisk_wires(p.count, start + 0.006, p.width / 2 - p.gap, neck, p.gap, p.belly)
    parts = [Part(wires, p.front_finish, "wires")]
    if p.spread > 0:  # a handle of wound wire
        handle = heads.wound_handle(int((p.length - start) / 0.006), start, p.length - start, p.grip_width / 2, 0.0012)
        return [*parts, Part(handle, p.grip_finish, "handle")]
    return [*parts, *_grip(p)]


def _tongs(p: Utensil) -> list[Part]:
    parts: list[Part] = []
    pieces: list[tuple[Solid, str, str]] = [(_front(p, span=(p.tip * 0.7, 1.0)), p.front_finish, "arm")]
    if p.tip > 0:
        pieces.append((_front(p, p.tip_thickness, (0.0, p.tip), 0.002), p.trim_finish, "tip"))
    if p.sleeve[1] > 0:
        pieces.append((_front(p, p.grip_thickness, p.sleeve, p.grip_width), p.grip_finish, "grip"))
    for solid, finish, label in pieces:
        arm = solid.rotated("x", -math.pi / 2)
        parts += [Part(arm, finish, label), Part(arm.rotated("x", math.pi), finish, label)]
    if p.front is None:
        raise ValueError("tongs need an arm as their front")
    half = abs(value_at(p.front.spine, 1.0, 0.0) * p.rise)
    bend = rod(half + p.thickness / 2, p.front.outline[-1][0] * p.width, 0.001).translated(x=p.length - 0.002)
    parts.append(Part(bend, p.front_finish, "hinge", fill=0.35))
    if p.loop > 0:
        wire = heads.ring(heads.egg(3.0 * p.loop, 2 * p.loop, 20), rectangle(0.0025, 0.0025, 0.0009, 1), 1)
        parts.append(Part(wire.translated(p.length + p.loop, 0, 0), p.trim_finish, "loop"))
    return parts


def _peeler(p: Utensil) -> list[Part]:
    start, half = p.split * p.length, p.width / 2 - 0.003
    reach = 0.008
    path = [(start + 0.012, 0.0, 0.0), (start - 0.004, 0.0, 0.0), (start - 0.3 * (start - reach), half, 0.0)]
    path += [(reach - 0.004, half, 0.0)]
    arm = tube(path, p.thickness / 2, 0.012)
    parts = [Part(arm, p.grip_finish if p.spread > 0 else p.front_finish, "fork")]
    parts.append(replace(parts[0], solid=arm.mirrored_x().rotated("z", math.pi)))
    shape = Bar(outline=((0.7, 0.0), (1, 0.06), (0.86, 0.2), (0.86, 0.8), (1, 0.94), (0.7, 1.0)), square=4, holes=())
    blade = bar(shape, Size(length=2 * half, width=0.013, thickness=0.0022), along=16, hulls=1)
    slot = prism(stadium(1.5 * half, 0.0028), 0.02, 0.0).translated(half, 0.0005, -0.01)
    blade = drilled(blade, [slot]).rotated("z", math.pi / 2).rotated("y", 0.25 if p.count % 2 else -0.25)
    parts.append(Part(blade.translated(reach, -half, 0.0), p.front_finish, "blade"))
    for y in (-half, half):
        pin = rod(0.0024, p.thickness + 0.003, 0.0008, "y").translated(reach, y, 0.0)
        parts.append(Part(pin, p.front_finish, "pin", collides=False))
    return [*parts, *_grip(p)]


def _wheel(p: Utensil) -> list[Part]:
    radius, start = p.width / 2, p.split * p.length
    parts = [Part(rod(radius, 0.0012, 0.0005).translated(x=radius), p.front_finish, "wheel")]
    apart, far = 0.0028, start + 0.01
    outline = ((0.0, 0.0), (0.8, 0.04), (1.0, 0.12), (0.8, 0.5), (0.75, 0.8), (0.7, 1.0))
    size = Size(length=far - radius + 0.008, width=p.gap, thickness=0.0022)
    cheek = bar(Bar(outline=outline, square=8), size, along=20)
    for side in (-1, 1):
        parts.append(Part(cheek.translated(radius - 0.008, 0, side * apart), p.trim_finish, "bracket"))
    hub = rod(0.42 * p.gap, 2 * apart + 0.004, 0.0012).translated(x=radius)
    parts.append(Part(hub, p.front_finish, "hub", collides=False))
    if p.spread > 0:
        shape = Bar(outline=((0.0, 0.0), (0.7, 0.12), (1, 0.5), (0.7, 0.88), (0.0, 1.0)), square=3)
        size = Size(length=p.spread * p.grip_width, width=0.012, thickness=0.8 * p.grip_thickness)
        guard = bar(shape, size, along=16, hulls=1)
        guard = guard.rotated("z", math.pi / 2).translated(start + 0.004, -p.spread * p.grip_width / 2, 0.0)
        parts.append(Part(guard, p.grip_finish, "guard"))
    return [*parts, *_grip(p)]


def _scissors(p: Utensil) -> list[Part]:
    pivot, thick = p.split * p.length, p.thickness
    bow_long, bow_wide = p.depth, p.gap
    parts: list[Part] = []
    if p.front is None:
        raise ValueError("scissors need a blade as their front")
    blade = bar(p.front, Size(length=pivot + 0.028, width=p.width, thickness=thick), along=26, hulls=2)
    section = rectangle(p.grip_width, p.grip_thickness, 0.45 * min(p.grip_width, p.grip_thickness), 3)
    for side in (1, -1):
        # The loops are as long as each other, or the lower one takes three fingers.
        long = bow_long * (1.0 if side > 0 else 1.0 + p.belly)
        bow = heads.ring(heads.egg(long - p.grip_width, bow_wide - p.grip_width, 28, -0.18), section)
        at = (p.length - long / 2, side * (bow_wide / 2 + 0.0015), 0.0)
        bow = bow.rotated("z", side * 0.12).translated(*at)
        start = np.array([pivot + 0.006, -side * 0.001])
        across = np.array([at[0] - long / 2 + 0.004, at[1] - side * 0.1 * bow_wide]) - start
        reach = float(np.hypot(*across))
        shape = Bar(outline=((0.6, 0.0), (0.8, 0.05), (1.0, 0.5), (0.95, 0.95), (0.7, 1.0)), square=4)
        shank = bar(shape, Size(length=reach, width=0.011, thickness=p.grip_thickness), along=12, hulls=1)
        shank = shank.rotated("z", float(math.atan2(across[1], across[0]))).translated(start[0], start[1], 0.0)
        half = (blade if side > 0 else blade.rotated("x", math.pi)).translated(z=side * 0.5 * thick)
        both = (half, p.front_finish, "blade"), (shank, p.grip_finish, "shank"), (bow, p.grip_finish, "bow")
        for solid, name, label in both:
            turned = solid.translated(x=-pivot).rotated("z", side * p.spread / 2).translated(x=pivot)
            parts.append(Part(turned, name, label))
    screw = rod(0.0042, 2 * thick + 0.0022, 0.0006).translated(x=pivot)
    parts.append(Part(screw, p.trim_finish, "screw", collides=False))
    return parts


def _can_opener(p: Utensil) -> list[Part]:
    if p.grip is None:
        raise ValueError("a can opener needs handles as its grip")
    head = p.split * p.length
    size = Size(length=p.length - head + 0.02, width=p.grip_width, thickness=p.grip_thickness, rise=p.grip_rise)
    parts: list[Part] = []
    for side in (1, -1):
        handle = bar(p.grip, size, along=22, hulls=2)
        if side < 0:
            handle = handle.mirrored_x().rotated("z", math.pi)
        handle = handle.rotated("z", side * p.spread / 2).translated(head - 0.01, side * 0.55 * p.grip_width, 0.0)
        parts.append(Part(handle, p.grip_finish, "handle"))
        shape = Bar(outline=((0.0, 0.0), (0.75, 0.03), (1, 0.1), (0.9, 0.6), (0.6, 1.0)), square=8)
        arm = bar(shape, Size(length=head + 0.03, width=1.15 * p.grip_width, thickness=0.0028), along=14, hulls=1)
        arm = arm.translated(0.0, side * 0.3 * p.grip_width, side * 0.0016)
        parts.append(Part(arm, p.front_finish, "arm"))
    top = p.grip_thickness / 2
    cutter = rod(0.012, 0.0024, 0.001).translated(0.016, 0.004, 0.0045)
    gear = heads.ribbed_cone(0.0075, 0.004, 12, 0.2).translated(0.018, -0.011, 0.003)
    parts += [Part(cutter, p.trim_finish, "cutter"), Part(gear, p.trim_finish, "gear", collides=False)]
    stem = rod(0.0035, p.depth, 0.0005).translated(0.022, -0.002, 0.002 + p.depth / 2)
    parts.append(Part(stem, p.trim_finish, "axle", collides=False))
    outline = ((0.0, 0.0), (0.8, 0.04), (1, 0.16), (0.62, 0.5), (1, 0.84), (0.8, 0.96), (0.0, 1.0))
    size = Size(length=p.width, width=0.016, thickness=max(0.6 * top, 0.007))
    key = bar(Bar(outline=outline, square=3), size, along=18, hulls=1)
    key = key.translated(x=-p.width / 2).rotated("z", 0.4 + 0.3 * (p.count % 5)).translated(0.022, -0.002, p.depth)
    parts.append(Part(key, p.grip_finish if p.count % 2 else p.trim_finish, "key"))
    return parts


def _pin(p: Utensil) -> list[Part]:
    if p.front is None:
        raise ValueError("a rolling pin needs a roller as its front")
    half, long = p.width / 2, (p.length if p.grip is None else (1 - 2 * p.split) * p.length)
    roller = heads.round_bar_x([(w * half, s * long) for w, s in p.front.outline])
    middle = [s for w, s in p.front.outline if w > 0.97]
    straight = (max(middle) - min(middle)) * long if middle else 0.0
    if straight > 0.85 * long:
        roller = roller.with_colliders_of(rod(half, long, 0.0, "x").translated(x=long / 2))
    elif straight > 0.4 * long:
        body = rod(half, straight, 0.0, "x").translated(x=(max(middle) + min(middle)) / 2 * long)
        low, high = (roller.points[:, 0] < min(middle) * long), (roller.points[:, 0] > max(middle) * long)
        roller = roller.with_colliders_of(body, hull_around(roller.points[low]), hull_around(roller.points[high]))
    else:
        roller = roller.with_hull_collider()
    parts = [Part(roller.translated(x=(0.0 if p.grip is None else p.split * p.length)), p.front_finish, "roller")]
    if p.grip is not None:
        reach = p.split * p.length
        knob = heads.round_bar_x([(w * p.grip_width / 2, s * (reach - 0.003)) for w, s in p.grip.outline], 20, 20)
        knob = knob.with_hull_collider()
        parts.append(Part(knob.mirrored_x().translated(x=reach - 0.003), p.grip_finish, "handle"))
        parts.append(Part(knob.translated(x=p.length - reach + 0.003), p.grip_finish, "handle"))
        for x in (reach - 0.0015, p.length - reach + 0.0015):
            washer = rod(0.3 * p.grip_width, 0.006, 0.001, "x").translated(x=x)
            parts.append(Part(washer, p.trim_finish, "axle", collides=False))
    return parts


def _grater(p: Utensil) -> list[Part]:
    parts = [Part(heads.grater(p.length, p.width, p.depth, p.belly, 0.0008), p.front_finish, "body")]
    holes: list[Solid] = []
    hoods: list[Solid] = []
    for turn in range(4):
        across, deep = (p.length, p.width) if turn % 2 == 0 else (p.width, p.length)
        panel = heads.Panel(across, deep, p.depth, p.belly, turn)
        kind = (turn + p.count) % 4
        sizes = ((0.0155, 0.0082, 0.003), (0.0115, 0.0052, 0.0022), (0.0104, 0.0034, 0.0016))
        made = heads.slits(panel, 4, 0.62) if kind == 3 else heads.punched(panel, *sizes[kind])
        holes += made[0]
        hoods += made[1]
    parts.append(Part(concatenate(holes), "display_dark", "holes", collides=False, fill=0.02))
    parts.append(Part(concatenate(hoods), p.front_finish, "teeth", collides=False, fill=0.1))
    long, top = p.length * p.belly, p.depth
    if p.spread > 0:  # a rim round the foot
        band = heads.ring(rectangle(p.length, p.width, 0.01, 4), rectangle(0.004, 0.008, 0.0015, 2), 4)
        parts.append(Part(band.without_colliders().translated(z=0.0046), p.trim_finish, "foot", collides=False))
    lid = heads.ring(rectangle(long, p.width * p.belly, 0.006, 4), rectangle(0.004, 0.008, 0.0015, 2), 4)
    lid = lid.translated(z=top - 0.003)
    parts.append(Part(lid.without_colliders(), p.trim_finish, "rim", collides=False))
    radius, rise = p.grip_thickness / 2, p.gap
    path = [(-0.42 * long, 0.0, top - 0.012), (-0.4 * long, 0.0, top + rise - radius)]
    path += [(0.4 * long, 0.0, top + rise - radius), (0.42 * long, 0.0, top - 0.012)]
    arch = tube(path, min(radius, 0.004 if p.grip is None else radius), 0.7 * min(rise, 0.3 * long))
    if p.grip is None:
        parts.append(Part(arch, p.trim_finish, "handle"))
        return parts
    wire = tube(path, 0.0035, 0.012)
    size = Size(length=0.78 * long, width=p.grip_width, thickness=p.grip_thickness)
    handle = bar(p.grip, size, along=24, hulls=1).translated(-0.39 * long, 0.0, top + rise - radius)
    return [*parts, Part(wire, p.front_finish, "handle"), Part(handle, p.grip_finish, "grip")]


def _reamer(p: Utensil) -> list[Part]:
    radius, wall = p.width / 2, p.thickness
    dish = heads.reamer_dish(radius, p.dish, wall)
    cone = heads.ribbed_cone(0.5 * radius, p.depth - wall, p.count, 0.16).translated(z=wall)
    parts = [Part(dish, p.front_finish, "dish"), Part(cone, p.trim_finish, "cone", fill=p.belly)]
    reach = p.length - 2 * radius
    if p.grip is not None and reach > 0.01:
        size = Size(length=reach + 0.008, width=p.grip_width, thickness=p.grip_thickness, rise=p.grip_rise)
        handle = bar(p.grip, size, along=24, hulls=1).translated(radius - 0.006, 0.0, p.dish - 0.5 * p.grip_thickness)
        if p.hole > 0:
            at = (radius + reach - 0.35 * p.hole_length - p.hole, 0.0, 0.0)
            handle = drilled(handle, [prism(stadium(max(p.hole, p.hole_length), p.hole), 0.3, 0.0).translated(*at)])
        parts.append(Part(handle, p.grip_finish, "handle"))
    if p.gap > 0:  # the lip stands out towards -x
        lip = Bar(outline=((0.0, 0.0), (0.5, 0.03), (0.8, 0.3), (1.0, 1.0)), hollow=((0.0, 0.6), (1.0, 1.0)), square=2)
        spout = bar(lip, Size(length=p.gap + 0.006, width=0.03, thickness=0.012, hollow=0.005), along=12, hulls=1)
        parts.append(Part(spout.translated(-radius - p.gap, 0.0, p.dish - 0.0045), p.front_finish, "lip"))
    return parts


def _brush(p: Utensil) -> list[Part]:
    """A brush that lies on its bristles: a block of wood or plastic with tufts, and a handle that rises from it."""
    long, wide = p.reach, p.width
    if p.spread > 0.5:
        loop = rectangle(long, wide, 0.42 * min(long, wide), 6)
    else:
        turns = np.arange(36) * 2 * np.pi / 36
        loop = np.column_stack([long / 2 * np.cos(turns), wide / 2 * np.sin(turns)])
    block = prism(loop, p.thickness, 0.25 * p.thickness).translated(x=long / 2)
    parts = [Part(block, p.grip_finish if p.front is None else p.front_finish, "block")]
    pitch = 0.0078
    grid = [((i + 0.5 * (j % 2)) * pitch, j * 0.87 * pitch) for i in range(-10, 11) for j in range(-8, 9)]
    inside = [(x, y) for x, y in grid if (x / (long / 2 - 0.005)) ** 2 + (y / (wide / 2 - 0.005)) ** 2 < 1]
    bristles = heads.tufts(np.array(inside) + np.array([long / 2, 0.0]), p.depth, 0.0026, p.gap, p.seed)
    parts.append(Part(bristles.with_hull_collider(), p.trim_finish, "bristles", fill=0.5))
    return [*parts, *_grip(p, 0.55 * p.thickness)]


def _scale(p: Utensil) -> list[Part]:
    long, wide, high = p.length, p.width, p.depth
    corner = 0.02 + 0.5 * p.belly * (min(long, wide) / 2 - 0.02)
    case = prism(rectangle(long, wide, corner, 6), high, 0.003)
    case = case.with_colliders_of(box((long, wide, high), (0, 0, high / 2)))
    top = high
    parts: list[Part] = []
    foot = rod(0.007, 0.003, 0.0005)
    x, y = long / 2 - 0.024, wide / 2 - 0.024
    front = 0.22 * wide
    parts.append(Part(case.translated(z=0.002), p.grip_finish, "case", fill=0.35))
    top += 0.002
    for sx, sy in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        parts.append(Part(foot.translated(sx * x, sy * y, 0.0015), "rubber_black", "foot", collides=False))
    plate_deep, middle = wide - front - 0.012, front / 2 - 0.001
    if p.spread > 0.5:
        plate = rod(plate_deep / 2, p.thickness, 0.0012)
    else:
        plate = prism(rectangle(long - 0.014, plate_deep, min(corner, 0.45 * plate_deep), 6), p.thickness, 0.0012)
        size = (long - 0.014, plate_deep, p.thickness)
        plate = plate.with_colliders_of(box(size, (0, 0, p.thickness / 2))).translated(z=-p.thickness / 2)
    stand = p.gap
    if stand > 0:
        post = rod(0.3 * plate_deep, stand + 0.002, 0.0).translated(0, middle, top + stand / 2 - 0.001)
        parts.append(Part(post, p.trim_finish, "post", fill=0.3, collides=False))
    plate = plate.translated(0, middle, top + stand + p.thickness / 2 + 0.0002)
    parts.append(Part(plate, p.front_finish, "plate"))
    y = -wide / 2 + 0.55 * front
    glass = prism(rectangle(0.34 * long, 0.6 * front, 0.003, 3), 0.0012, 0.0004).translated(0, y, top - 0.0004)
    parts.append(Part(glass, "display_dark", "display", collides=False))
    number = heads.digits(str(100 + 37 * (p.seed % 200) % 900), 0.36 * front, 0.0018)
    parts.append(Part(number.translated(0, y, top + 0.0008), "display_white", "digits", collides=False, fill=0.1))
    for side in (-1, 1):
        key = rod(0.2 * front + 0.002, 0.002, 0.0006).translated(side * 0.32 * long, y, top + 0.0005)
        parts.append(Part(key, p.trim_finish, "key", collides=False))
    return parts


def _straw(p: Utensil) -> list[Part]:
    return [Part(heads.straw(p.length, p.width / 2, p.thickness, p.spread * 2, p.count), p.front_finish, "straw")]


_MAKERS: dict[Head, Callable[[Utensil], list[Part]]] = {
    Head(maker.__name__.removeprefix("_")): maker
    for maker in (
        *(_bar, _fork, _mouth, _ladle, _whisk, _tongs, _peeler, _wheel),
        *(_scissors, _can_opener, _pin, _grater, _reamer, _brush, _scale, _straw),
    )
}
