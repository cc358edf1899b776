"""Closures of bottles, jars and cans (caps, corks, lids, pumps), and the joints of what closes a thing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from casa_assets.ext.arrays import counter_clockwise
from casa_assets.ext.families import hand_dynamics
from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import AssetBuilder, Solid, ball, box, circle, combine_masses, lathe, loft, prism, rod, tube
from casa_assets.kitchenware.parts.decor import JarLid, jar

LID, LID_JOINT, LID_GRIP = "lid", "lid_joint", "lid_main"
GRAVITY = 9.81
# A lid stays where a hand leaves it: its friction carries a multiple of its weight, and a little more. That is less
# than what holds a light jar down, so that a lid comes off a jar that nobody holds.
CARRIED, LEAST_N = 1.15, 0.3
# Beyond that, so much lifts it all the way in hand_dynamics.OPENS_IN_S, N.
EASE_N, SWING_EASE_N = 0.6, 2.0
# Flaps of card are so light that a simulation would let them creep: a hinge has at least this armature, kg*m^2.
LEAST_ARMATURE = 5e-5
# How far a lid is lifted: by the width of what it closes and somewhat more, so that things get in below it; metres.
EXTRA, LEAST_LIFT, MOST_LIFT = 0.02, 0.05, 0.16


def lift_off(builder: AssetBuilder, width: float, most: float = MOST_LIFT) -> None:
    """Let the link LID, with all its parts, slide up from a mouth of a width; most: room above the lid, metres."""
    travel = round(min(max(width + EXTRA, LEAST_LIFT), most, MOST_LIFT), 3)
    mass = combine_masses(builder.links[LID].masses).mass
    start = LEAST_N + CARRIED * GRAVITY * mass
    feel = hand_dynamics.feel(mass, 1.0, travel, start, start + EASE_N)
    builder.slide(LID_JOINT, LID, (0.0, 0.0, 1.0), (0.0, travel), LID_GRIP, feel=feel)
    _states(builder, travel)


def swing_up(builder: AssetBuilder, axis: Vec3, angle: float) -> None:
    """Let the link LID, with all its parts, swing up round its origin, right-handed about an axis, by an angle, rad."""
    lid = combine_masses(builder.links[LID].masses)
    start = LEAST_N + CARRIED * GRAVITY * lid.mass
    lever = max(0.01, float(np.linalg.norm(lid.center - np.array(axis) * float(lid.center @ np.array(axis)))))
    feel = hand_dynamics.feel(1.4 * lid.mass * lever**2, lever, angle, start, start + SWING_EASE_N)
    feel = replace(feel, armature=max(feel.armature, LEAST_ARMATURE))
    builder.hinge(LID_JOINT, LID, axis, (0.0, angle), LID_GRIP, feel=feel)
    _states(builder, angle)


def _states(builder: AssetBuilder, end: float) -> None:
    builder.door_states(LID_JOINT)
    builder.keyframe("closed")
    builder.keyframe("open", **{LID_JOINT: end})


AROUND = 28

# Closure of a container: SCREW a ribbed cap; LID a wide one of sheet metal or plastic; CROWN a crown cork; STOPPER a
# wooden or plastic knob on a cork; TAB the end of a drink can; RING the end of a food can, with a ring to pull; FLIP a
# cap with a hinge; NOZZLE a cone to squeeze through; SPRAY a trigger; BUTTON of an aerosol can; SPOUT a pourer of
# steel; BALL a ball of glass; HOLES a dome with holes; SIFTER a wide flat cap, ribbed, as spice jars have; CUP the cup
# of a flask; SPORT a cap with a nipple; LOOP a cap to carry it by; CLIP a lid of glass with a wire.
Closure = StrEnum(
    "Closure",
    "NONE SCREW LID CROWN CORK STOPPER PUMP TAB RING FLIP NOZZLE SPRAY BUTTON SPOUT BALL HOLES SIFTER CUP SPORT LOOP "
    "CLIP KNOB WICK",
)

# What comes off, and by what share of its height it covers the neck where it is drawn closed for good.
COVERED: Mapping[Closure, float] = {
    Closure.SCREW: 0.8, Closure.LID: 0.8, Closure.CROWN: 0.0, Closure.CORK: 0.0, Closure.STOPPER: 0.0,
    Closure.FLIP: 0.45, Closure.BALL: 0.0, Closure.HOLES: 0.3, Closure.SIFTER: 0.9, Closure.CUP: 0.35,
    Closure.SPORT: 0.48, Closure.LOOP: 0.5, Closure.CLIP: 0.0, Closure.KNOB: 0.0,
}  # fmt: skip
# What swings up on a hinge at its back; the others are lifted.
HINGED = frozenset({Closure.FLIP, Closure.CLIP})
# By how much what opens covers the neck, metres: it collides above the mouth, and is seen a little beyond.
SKIRT = 0.003
# How far down a crown cork reaches, metres: for good, and where it comes off. It is so flat that it would else have its
# centre of mass below its collision shapes.
CROWN_DOWN, CROWN_SKIRT = 0.004, 0.002


@dataclass(frozen=True)
class Mouth:
    """The mouth that is closed."""

    radius: float  # m
    z: float  # m
    height: float  # of the closure, m
    wide: float  # radius of the closure by that of the mouth
    room: float  # neck below the mouth that a cap may cover, m
    opens: bool = False  # its closure comes off


@dataclass(frozen=True)
class Part:
    """A solid of a closure, which brings its collider along, or none."""

    solid: Solid  # brings its collider along, or none
    second: bool = False  # of the second finish
    fixed: bool = False  # stays where it is when the rest comes off


def loose_skirt(kind: Closure) -> float:
    """By how much what comes off covers the neck, metres."""
    return CROWN_SKIRT if kind is Closure.CROWN else SKIRT


def lowered(kind: Closure, height: float, room: float) -> float:
    """How much lower, metres, a mouth ends below a closure that comes off; room: of the neck that it may cover."""
    return max(0.0, min((CROWN_DOWN if kind is Closure.CROWN else COVERED[kind] * height), room) - loose_skirt(kind))


def closure_parts(kind: Closure, mouth: Mouth) -> list[Part]:
    """The solids of a closure."""
    return _MAKERS[kind](mouth) if kind in _MAKERS else []


def _turned(profile: Sequence[Vec2], around: int = AROUND, second: bool = False, hit: bool = True) -> Part:
    solid = lathe(profile, around, 42.0)
    return Part(solid.with_hull_collider() if hit else solid.without_colliders(), second)


def _ribbed(radius: float, low: float, high: float) -> Solid:
    ribs = max(18, min(40, round(2 * math.pi * radius / 0.004)))
    turns = np.linspace(0.0, 2 * np.pi, 2 * ribs + 1)[:-1]
    ring = radius - 0.0008 * (np.arange(2 * ribs) % 2)
    outline = np.column_stack([ring * np.cos(turns), ring * np.sin(turns)])
    solid = prism(outline, high - low, min(0.0012, 0.3 * (high - low))).with_crease(30.0).translated(z=low)
    return solid.with_colliders_of(rod(radius, high - low).translated(z=(high + low) / 2))


def _cover(m: Mouth, share: float = 0.8) -> Vec2:
    """Lower and upper end of a cap that covers the neck by a share of its height."""
    down = min(share * m.height, m.room)
    return m.z - down, m.z - down + m.height


def _screw(m: Mouth) -> list[Part]:
    low, high = _cover(m)
    r = m.radius * m.wide + 0.0012
    collar = _turned([(r, low - 0.0032), (r, low - 0.0008)], AROUND, hit=False)
    parts = [Part(_ribbed(r, low, high))]
    return [*parts, collar] if m.room > m.height + 0.004 else parts


def _lid(m: Mouth) -> list[Part]:
    low, high = _cover(m)
    r, e = m.radius * m.wide + 0.001, min(0.0015, 0.15 * m.height)
    rim = [(r - 0.0006, low), (r + 0.0006, low + 0.0006), (r + 0.0006, low + 0.0018), (r, low + 0.0026)]
    top = [(r, high - e), (r - e, high), (0.86 * r, high), (0.84 * r, high - 0.0009), (0.0, high - 0.0009)]
    return [Part(lathe([*rim, *top], 36, 42.0).with_colliders_of(rod(r, high - low).translated(z=(low + high) / 2)))]


def _crown(m: Mouth) -> list[Part]:
    down = min(CROWN_DOWN, m.room)
    r, low, high = m.radius, m.z - down, m.z + 0.0022 + (CROWN_DOWN - down)
    turns = np.arange(42) * 2 * np.pi / 42
    rings = []
    for radius, wave, z in (
        (r + 0.0026, 0.0012, low),
        (r + 0.0012, 0.0006, (low + high) / 2),
        (r + 0.0006, 0.0, high - 0.0012),
        (r - 0.0012, 0.0, high),
    ):
        q = radius + wave * np.where(np.arange(42) % 2 == 0, 1.0, -1.0)
        rings.append(np.column_stack([q * np.cos(turns), q * np.sin(turns), np.full(42, z)]))
    return [Part(loft(rings, 45.0).with_hull_collider())]


def _cork(m: Mouth) -> list[Part]:
    r, z = m.radius, m.z
    return [_turned([(0.8 * r, z - 0.002), (0.84 * r, z), (0.92 * r, z + m.height - 0.001), (0.86 * r, z + m.height)])]


def _stopper(m: Mouth) -> list[Part]:
    r, z, h, w = m.radius, m.z, m.height, m.radius * m.wide
    profile = [(0.8 * r, z - 0.002), (w, z + 0.0005), (w + 0.0008, z + 0.002), (w + 0.0008, z + h - 0.003)]
    return [_turned([*profile, (w - 0.002, z + h), (0.0, z + h + 0.0006)])]


def _pump(m: Mouth) -> list[Part]:
    n = m.radius * m.wide
    low, high = _cover(replace(m, height=0.018))
    collar = _ribbed(n + 0.002, low, high)
    neck = lathe([(n + 0.001, high - 0.0005), (0.5 * n, high + 0.005), (0.0048, high + 0.006)], AROUND, 42.0)
    stem = rod(0.0042, m.height, 0.0006).translated(z=high + m.height / 2)
    top = high + m.height
    head = lathe([(0.008, top - 0.003), (0.0105, top), (0.0105, top + 0.006), (0.0088, top + 0.0085)], AROUND, 42.0)
    nose = tube([(0.0, 0.002, top + 0.0045), (0.0, -0.036, top + 0.0045), (0.0, -0.043, top - 0.005)], 0.0042, 0.008)
    return [Part(collar), Part(neck.without_colliders()), Part(stem, True), Part(head.with_hull_collider()), Part(nose)]


def _end(m: Mouth, rim: float) -> Part:
    r, z = m.radius, m.z
    ring = [(r + rim, z - 0.0005), (r + rim, z + 0.0018), (r + rim - 0.0006, z + 0.0024), (r - 0.0012, z + 0.0024)]
    ring = [(r - 0.002, z - 0.0005), *ring, (r - 0.002, z + 0.0018)]
    return Part(lathe(ring, 36, 45.0, closed=True).with_colliders_of(rod(r + rim, 0.004).translated(z=z + 0.0004)))


def _tab(m: Mouth) -> list[Part]:
    rim, z = _end(m, 0.0004), m.z
    plate = lathe([(0.86 * m.radius, z - 0.0005), (0.84 * m.radius, z + 0.0006)], 32, 45.0)
    turns = np.linspace(0.0, 2 * np.pi, 21)[:-1]
    oval = np.column_stack([0.0072 * np.cos(turns), 0.0115 * np.sin(turns)])
    hole = np.column_stack([0.0042 * np.cos(turns), -0.0052 + 0.0042 * np.sin(turns)])
    tab = prism(oval, 0.0012, 0.0003, [hole]).translated(y=-0.004, z=z + 0.0009)
    mouth = np.column_stack([0.0085 * np.cos(turns), 0.0062 * np.sin(turns)])
    score = prism(mouth, 0.0003, 0.0).translated(y=0.0125, z=z + 0.0005)
    flat = (Part(plate), Part(score, True), Part(tab), Part(lathe([(0.003, z + 0.0008), (0.0025, z + 0.0026)], 14)))
    return [rim, *(Part(part.solid.without_colliders(), part.second) for part in flat)]


def _ring(m: Mouth) -> list[Part]:
    r, z = m.radius, m.z
    profile = [(0.9 * r, z - 0.0005), (0.88 * r, z + 0.0006), (0.72 * r, z + 0.0006), (0.71 * r, z + 0.0001)]
    steps = _turned([*profile, (0.55 * r, z + 0.0001), (0.54 * r, z + 0.0007), (0.0, z + 0.0007)], 32, hit=False)
    parts = [_end(m, 0.0014), steps]
    if m.height < 0.001:  # an end to be cut open
        return parts
    turns = np.linspace(0.0, 2 * np.pi, 21)[:-1]
    oval = np.column_stack([0.0105 * np.cos(turns), 0.013 * np.sin(turns)])
    hole = np.column_stack([0.0075 * np.cos(turns), 0.0035 + 0.0075 * np.sin(turns)])
    tab = prism(oval, 0.0013, 0.0003, [hole]).translated(y=-0.62 * m.radius + 0.012, z=z + 0.0008)
    return [*parts, Part(tab.without_colliders())]


def _flip(m: Mouth) -> list[Part]:
    low, high = _cover(m, COVERED[Closure.FLIP])
    r, seam = m.radius * m.wide + 0.001, low + 0.55 * (high - low)
    foot = [(r, low), (r, seam - 0.0006), (r - 0.0008, seam - 0.0004)]
    head = [(r - 0.0008, seam + 0.0004), (r, seam + 0.0006)]
    head += [(0.97 * r, high - 0.003), (0.88 * r, high - 0.0008), (0.7 * r, high)]
    lip = Part(box((0.6 * r, 0.003, 0.0022), (0.0, -r - 0.0004, seam + 0.0022), 0.0008).without_colliders())
    if not m.opens:
        body = lathe([*foot, *head], AROUND, 42.0)
        return [Part(body.with_colliders_of(rod(r, high - low).translated(z=(low + high) / 2))), lip]
    base, top = (lathe(line, AROUND, 42.0) for line in (foot, head))
    under = rod(r, seam - 0.0004 - low).translated(z=(low + seam - 0.0004) / 2)
    return [Part(top.with_hull_collider()), lip, Part(base.with_colliders_of(under), fixed=True)]


def _nozzle(m: Mouth) -> list[Part]:
    r = m.radius * m.wide + 0.001
    skirt = _ribbed(r, m.z - min(0.014, m.room), m.z + 0.002)
    top = m.z + m.height
    cone = [(0.86 * r, m.z + 0.0015), (0.8 * r, m.z + 0.006), (0.0042, top - 0.008), (0.0034, top - 0.002)]
    tip = [(0.0043, top - 0.0075), (0.0043, top - 0.0015), (0.003, top)]
    return [Part(skirt), _turned(cone, 20), _turned(tip, 16, second=True, hit=False)]


def _button(m: Mouth) -> list[Part]:
    r, z, h = m.radius, m.z, m.height
    dome = [(r, z - 0.001), (r + 0.0008, z + 0.001), (r + 0.0002, z + 0.003)]
    dome += [(0.8 * r, z + 0.3 * h), (0.4 * r, z + 0.5 * h)]
    button = [(0.36 * r, z + 0.48 * h), (0.36 * r, z + 0.92 * h), (0.28 * r, z + h)]
    hole = rod(0.0022, 0.0016, 0.0002, "y").translated(y=-0.36 * r, z=z + 0.74 * h).without_colliders()
    return [_turned(dome), _turned(button, 20, second=True), Part(hole, False)]


def _spray(m: Mouth) -> list[Part]:
    r = m.radius * m.wide + 0.0015
    low, z = m.z - min(0.014, m.room), m.z
    k = m.height / 0.06
    skirt = _ribbed(r, low, z + 0.004)
    side = [(0.6 * r, z + 0.003), (0.6 * r, z + 0.018 * k), (0.030 * k, z + 0.04 * k), (0.031 * k, z + 0.052 * k)]
    side += [(0.022 * k, z + 0.06 * k), (-0.022 * k, z + 0.06 * k), (-0.035 * k, z + 0.056 * k)]
    side += [(-0.035 * k, z + 0.042 * k), (-0.018 * k, z + 0.038 * k), (-0.6 * r, z + 0.02 * k), (-0.6 * r, z + 0.003)]
    head = _sideways(side, 0.019 * k)
    trigger = [(-0.014 * k, z + 0.041 * k), (-0.028 * k, z + 0.041 * k), (-0.031 * k, z + 0.026 * k)]
    trigger += [(-0.043 * k, z - 0.001), (-0.037 * k, z - 0.003), (-0.022 * k, z + 0.02 * k)]
    nozzle = rod(0.0072 * k, 0.011 * k, 0.001, "y").translated(y=-0.039 * k, z=z + 0.049 * k)
    return [Part(skirt), Part(head), Part(_sideways(trigger, 0.01 * k), True), Part(nozzle, True)]


def _sideways(side: Sequence[Vec2], thick: float) -> Solid:
    """An outline in (y, z) drawn along x; its collider is its hull."""
    solid = prism(counter_clockwise(np.array(side)), thick, 0.0015)
    points = solid.points[:, [2, 0, 1]] - (thick / 2, 0.0, 0.0)
    return Solid(points, solid.faces, crease_deg=50.0).oriented_outwards().with_hull_collider()


def _spout(m: Mouth) -> list[Part]:
    n, z = m.radius, m.z
    base = [(n - 0.001, z - 0.001), (n + 0.0015, z + 0.0005), (n + 0.0015, z + 0.005), (0.005, z + 0.011)]
    path = [(0.0, 0.0, z + 0.008), (0.0, 0.0, z + 0.55 * m.height), (0.02, 0.0, z + m.height)]
    return [_turned(base, 20), Part(tube(path, 0.004, 0.012))]


def _ball(m: Mouth) -> list[Part]:
    r = m.radius * m.wide
    neck = _turned([(0.9 * m.radius, m.z - 0.001), (m.radius, m.z + 0.003)], 20)
    return [neck, Part(ball(r, 12).translated(z=m.z + r))]


def _holes(m: Mouth) -> list[Part]:
    low, _ = _cover(m, COVERED[Closure.HOLES])
    r, z = m.radius * m.wide + 0.0008, m.z
    rise = m.height - (z - low)
    angles = np.linspace(0.0, math.pi / 2, 7)
    cap = lathe([(r, low), *([(r * math.cos(t), z + rise * math.sin(t)) for t in angles])], AROUND, 60.0)
    parts = [Part(cap.with_hull_collider())]
    size = min(0.0016, 0.1 * r)
    for k in range(7):
        turn, out = 2 * math.pi * k / 6, 0.0 if k == 6 else 0.42
        tilt = math.atan2(rise * out, r * math.sqrt(1 - out * out))
        hole = rod(size, 0.0006, 0.0).rotated("y", tilt).rotated("z", turn)
        at = (out * r * math.cos(turn), out * r * math.sin(turn), z + rise * math.sqrt(1 - out * out))
        parts.append(Part(hole.translated(*at).without_colliders(), True))
    return parts


def _sifter(m: Mouth) -> list[Part]:
    low, high = _cover(m, COVERED[Closure.SIFTER])
    r = m.radius * m.wide + 0.001
    seam = [(r - 0.0004, high - 0.0005), (r - 0.0004, high + 0.0012), (0.9 * r, high + 0.0022)]
    return [Part(_ribbed(r, low, high)), _turned(seam, AROUND, hit=False)]


def _cup(m: Mouth) -> list[Part]:
    low, high = _cover(m, COVERED[Closure.CUP])
    r, h = m.radius * m.wide, m.height
    ring = [(r, low), (r + 0.0012, low + 0.001), (r + 0.0012, low + 0.004), (r, low + 0.005)]
    solid = lathe([*ring, *[(0.97 * r, high - 0.16 * h), (0.93 * r, high - 0.06 * h), (0.82 * r, high)]], 32, 42.0)
    return [Part(solid.with_colliders_of(rod(r, high - low).translated(z=(low + high) / 2)))]


def _sport(m: Mouth) -> list[Part]:
    low, high = _cover(replace(m, height=0.6 * m.height))
    r, top = m.radius * m.wide + 0.001, high + 0.4 * m.height
    cone = [(0.94 * r, high - 0.0005), (0.6 * r, high + 0.12 * m.height), (0.4 * r, high + 0.14 * m.height)]
    tip = [(0.36 * r, high + 0.1 * m.height), (0.3 * r, top - 0.005), (0.4 * r, top - 0.004), (0.38 * r, top - 0.001)]
    return [Part(_ribbed(r, low, high)), _turned(cone, hit=False), _turned([*tip, (0.2 * r, top)], 20, second=True)]


def _loop(m: Mouth) -> list[Part]:
    low, high = _cover(replace(m, height=0.62 * m.height))
    r, rise = m.radius * m.wide + 0.001, 0.38 * m.height
    cap = [(r, low), (r, high - 0.002), (r - 0.002, high), (0.6 * r, high + 0.0008)]
    bar = np.array([(-0.0055, -0.002), (0.0055, -0.002), (0.0055, 0.002), (-0.0055, 0.002)])
    turns = np.linspace(0.0, math.pi, 11)
    arc = [(0.8 * r * math.cos(t), 0.0, high - 0.003 + (rise + 0.001) * math.sin(t)) for t in turns]
    loop = tube(arc, bar, up=(0.0, 1.0, 0.0)).with_hull_collider()
    body = lathe(cap, 32, 42.0)
    return [Part(body.with_colliders_of(rod(r, high - low).translated(z=(low + high) / 2))), Part(loop, True)]


def _clip(m: Mouth) -> list[Part]:
    made = jar(m.radius, m.z, JarLid.CLIP)
    lid = [Part(s.with_hull_collider()) for s in made.lid]
    r, z = m.radius, m.z
    rim = [(0.94 * r, z - 0.001), (1.045 * r, z - 0.0005), (1.045 * r, z + 0.0018), (0.94 * r, z + 0.002)]
    seal = lathe(rim, 36, closed=True)
    _, band, over, lever = made.fittings
    wires = [Part(over, True), Part(lever, True)]
    if m.opens:  # the wire ends at the lid's edge; its lever hangs at the neck
        top, ends = made.top - 0.001, z - 0.002
        path = [(0.0, 1.05 * r, ends), (0.0, 1.06 * r, top), (0.0, -1.04 * r, top), (0.0, -1.045 * r, ends)]
        wires = [Part(tube(path, circle(0.0012, 6), 0.005), True), Part(lever, True, fixed=True)]
    parts = [Part(seal, True), Part(band, True, fixed=True), *wires]
    return [*lid, *(Part(part.solid.without_colliders(), part.second, part.fixed) for part in parts)]


def _knob(m: Mouth) -> list[Part]:
    r, z, h = m.radius * m.wide, m.z, min(0.009, 0.4 * m.height)
    size = 0.5 * (m.height - h) / 1.2
    disc = [(r - 0.002, z), (r, z + 0.0015), (r, z + h - 0.002), (r - 0.003, z + h), (0.6 * size, z + h + 0.001)]
    neck = (0.5 * size, z + h + 0.3 * size)
    knob = [(size * math.cos(t), z + h + 1.25 * size + size * math.sin(t)) for t in np.linspace(-0.9, math.pi / 2, 8)]
    return [_turned([*disc, neck, *knob], 32)]


def _wick(m: Mouth) -> list[Part]:
    path = [(0.0, 0.0, m.z - 0.002), (0.0, 0.0, m.z + 0.6 * m.height), (0.0015, 0.0, m.z + m.height)]
    return [Part(tube(path, circle(0.0011, 8)).with_hull_collider(), True)]


_MAKERS: Mapping[Closure, Callable[[Mouth], list[Part]]] = {
    Closure(maker.__name__.removeprefix("_")): maker
    for maker in (
        *(_screw, _lid, _crown, _cork, _stopper, _pump, _tab, _ring, _flip, _nozzle, _button),
        *(_spray, _spout, _ball, _holes, _sifter, _cup, _sport, _loop, _clip, _knob, _wick),
    )
}
