"""Controls: keys that are pressed, knobs that turn, and the figures, signs and gauges beside them."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from casa_assets.ext.families import hand_dynamics
from casa_assets.ext.records import Condition, Cylinder, Pose, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, BehaviorBuilder, Solid, box, concatenate, lathe, prism, rod

KEY_TRAVEL = 0.0025  # metres
KEY_CLEARANCE = 0.0004  # metres that are left under a pressed key

_FACES: dict[str, tuple[tuple[str, float] | None, Vec3]] = {
    "front": (("x", 1.5707963267948966), (0.0, 1.0, 0.0)), "back": (("x", -1.5707963267948966), (0.0, -1.0, 0.0)),
    "left": (("y", -1.5707963267948966), (1.0, 0.0, 0.0)), "right": (("y", 1.5707963267948966), (-1.0, 0.0, 0.0)),
    "up": (None, (0.0, 0.0, -1.0)),
}  # fmt: skip

# Ref: RoboCasa v1.0, class Stove: on from 0.35 rad, high from 80 degrees, set up to 2 pi - 0.35.
KNOB_TRAVEL = 2.6

# Style of a knob: SKIRT a pointer on a skirt; FLUTED a cylinder with grooves; BAR a drum with a bar across,
# professional; DISC flat with a ridge; SLIM a narrow cylinder.
KnobStyle = StrEnum("KnobStyle", "SKIRT FLUTED BAR DOME DISC SLIM CHICKEN_HEAD")

# Bars of each figure: top, upper left, upper right, middle, lower left, lower right, bottom.
SEGMENTS = {
    "0": "1110111", "1": "0010010", "2": "1011101", "3": "1011011", "4": "0111010", "5": "1101011", "6": "1101111",
    "7": "1010010", "8": "1111111", "9": "1111011", "-": "0001000",
}  # fmt: skip
FIGURE_WIDTH = 0.52  # width of a figure over its height
FIGURE_PITCH = 0.74  # from one figure to the next, over their height
COLON_WIDTH = 0.36  # width of a colon, over the height
INK_THICKNESS = 0.0004  # metres: thickness of what is printed or glows; its back stands free of what is behind it

KeySign = StrEnum("KeySign", "PLUS MINUS PLAY STOP LAMP POWER BARS")


# Buttons --------------------------------------------------------------------------------------------------------------


def round_key(radius: float, height: float = 0.005) -> Solid:
    """A round cap whose foot is at z = 0."""
    return rod(radius, height, min(0.0015, 0.3 * height)).translated(z=height / 2)


def flat_key(width: float, tall: float, height: float = 0.005) -> Solid:
    """A rectangular cap whose foot is at z = 0; wide along x, tall along y."""
    return box((width, tall, height), (0.0, 0.0, height / 2), 0.0015, 2)


def add_key(
    builder: AssetBuilder,
    name: str,
    joint: str,
    at: Vec3,
    cap: Solid,
    finish: str,
    *,
    face: str = "front",
    parent: str = ROOT,
) -> None:
    """A sprung key; its collider is called `name`, its link `<name>_key`.

    at: middle of its foot on the surface that it is set in, parent's frame, metres. cap: standing on z = 0. face: where
    it looks: `front` (-y), `up`, `left` (-x), `right` or `back`.
    """
    turn, direction = _FACES[face]
    lift = KEY_TRAVEL + KEY_CLEARANCE
    place = (at[0] - direction[0] * lift, at[1] - direction[1] * lift, at[2] - direction[2] * lift)
    link = builder.link(f"{name}_key", at=place, parent=parent)
    builder.add(link, _turned(cap, turn), finish, "button", name=name)
    lower, upper = cap.bounds
    width, height = float(upper[0] - lower[0]) - 0.003, float(upper[1] - lower[1]) - 0.003
    stem = box((width, height, lift + 0.0015), (0.0, 0.0, -(lift + 0.0015) / 2 + 0.001), 0.0)
    # The stem goes into its hole when the key is pressed.
    builder.draw(link, _turned(stem, turn), "plastic_black", "button", density=0.0)
    spring = hand_dynamics.press(KEY_TRAVEL, hand_dynamics.KEY_FULL_N, hand_dynamics.KEY_PRELOAD_N)
    builder.slide(joint, link, direction, (0.0, KEY_TRAVEL), name, spring=spring, feel=hand_dynamics.KEY)


def _turned(solid: Solid, turn: tuple[str, float] | None) -> Solid:
    return solid if turn is None else solid.rotated(*turn)


def add_toggle(behavior: BehaviorBuilder, variable: str, collider: str) -> None:
    """Add a variable that one key switches on and off: on a press, once for each press.

    A second variable, `<variable>_latch`, follows when the key is let go, so that one press counts once.
    """
    latch = f"{variable}_latch"
    press = Condition(contact=collider, begins=True)
    free = Condition(contact=collider, negated=True)
    behavior.variable(variable)
    behavior.variable(latch)
    behavior.rule(variable, "off", press, Condition(variable=latch, equals="on"), before="on")
    behavior.rule(variable, "on", press, Condition(variable=latch, equals="off"), before="off")
    behavior.rule(latch, "on", free, Condition(variable=variable, equals="on"), before="off")
    behavior.rule(latch, "off", free, Condition(variable=variable, equals="off"), before="on")


# Knobs ----------------------------------------------------------------------------------------------------------------
# On a front, where they face -y, or on a top, where they face up.


def add_knob(
    builder: AssetBuilder,
    name: str,
    at: Vec3,
    style: KnobStyle,
    radius: float,
    finish: str,
    *,
    mark: str = "plastic_red",
    up: bool = False,
    turn: float = KNOB_TRAVEL,
) -> None:
    """A link with a knob whose foot is at `at`, its joint `<name>_joint` (0 is off), its collider `<name>_main`.

    name: of the link. radius: metres. finish, mark: finishes of the body and of its pointer. up: faces up instead of to
    the front. turn: rad, its range.
    """
    link = builder.link(name, at=at)
    depth = {KnobStyle.DISC: 0.7, KnobStyle.SLIM: 1.5}.get(style, 1.0) * min(0.026, 1.15 * radius)
    body, extra = _shape(style, radius, depth)
    shape = (Cylinder(radius=radius, height=depth), Pose(position=(0.0, 0.0, depth / 2)))
    shaped = Solid(body.points, body.faces, (shape,), crease_deg=body.crease_deg)
    face = Pose() if up else Pose(quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
    builder.add(link, shaped.transformed(face), finish, "knob", collider=f"{name}_main", density="control_knob")
    builder.draw(link, [solid.transformed(face) for solid in extra], finish, "knob", density="control_knob")
    builder.draw(link, _pointer(style, radius, depth).transformed(face), mark, "knob", density=0.0)
    axis = (0.0, 0.0, 1.0) if up else (0.0, -1.0, 0.0)
    feel = hand_dynamics.Feel(damping=0.02, frictionloss=hand_dynamics.KNOB_NM, armature=2e-4)
    builder.hinge(f"{name}_joint", link, axis, (0.0, turn), f"{name}_main", feel=feel)


def add_knob_with_scale(
    builder: AssetBuilder,
    name: str,
    at: Vec3,
    knob: tuple[KnobStyle, float],
    finishes: tuple[str, str, str],
    turn: float,
    steps: int,
) -> None:
    """Add a knob with a bezel behind it and printed ticks round it; `at` lies on the front, which faces -y.

    knob: its style and radius, metres. finishes: of knob, bezel and print. steps: number of ticks over its turn, rad.
    """
    (x, y, z), (style, radius), (finish, bezel_finish, ink) = at, knob, finishes
    builder.draw(ROOT, bezel(radius).translated(x, y - 2e-4, z), bezel_finish, "bezel")
    builder.draw(ROOT, dial(radius, turn, steps=steps).translated(x, y - 3e-4, z), ink, "print", density=0.0)
    add_knob(builder, name, (x, y - 0.0032, z), style, radius, finish, turn=turn)


def _shape(style: KnobStyle, r: float, d: float) -> tuple[Solid, list[Solid]]:
    """The turned body about z from z = 0 to d, and what sits on it."""
    e = 0.0015
    if style is KnobStyle.SKIRT:
        body = lathe([(r, 0.0), (r, 0.2 * d), (0.8 * r, 0.3 * d), (0.68 * r, d - e), (0.68 * r - e, d)], 32)
        return body, []
    if style is KnobStyle.FLUTED:
        return lathe([(r, 0.0), (r, 0.12 * d), (0.93 * r, 0.15 * d), (0.93 * r, d - e), (0.93 * r - e, d)], 36), [
            box((0.0026, 0.0026, 0.7 * d), (0.0, 0.93 * r, 0.5 * d), 0.0).rotated("z", math.pi * k / 9)
            for k in range(18)
        ]
    if style is KnobStyle.BAR:
        body = lathe([(r, 0.0), (r, 0.35 * d), (0.86 * r, 0.45 * d), (0.86 * r, 0.62 * d)], 32)
        return body, [box((0.42 * r, 1.9 * r, 0.55 * d), (0.0, 0.0, 0.84 * d), 0.003, 2)]
    if style is KnobStyle.DOME:
        curve = [(r * math.cos(t), 0.3 * d + 0.7 * d * math.sin(t)) for t in (0.0, 0.35, 0.7, 1.0, 1.25, 1.45)]
        return lathe([(r, 0.0), *curve], 32, 60.0), []
    if style is KnobStyle.DISC:
        body = lathe([(r - e, 0.0), (r, e), (r, 0.5 * d), (r - 0.004, 0.6 * d)], 40)
        return body, [box((0.2 * r, 1.7 * r, 0.45 * d), (0.0, 0.0, 0.78 * d), 0.002, 2)]
    if style is KnobStyle.SLIM:
        return lathe([(r - 0.0005, 0.0), (r, 0.001), (r, d - e), (r - e, d)], 32), []
    body = lathe([(r, 0.0), (r, 0.18 * d), (0.55 * r, 0.3 * d), (0.5 * r, 0.8 * d)], 28)
    return body, [box((0.5 * r, 1.6 * r, 0.72 * d), (0.0, 0.18 * r, 0.63 * d), 0.004, 3)]


def _pointer(style: KnobStyle, r: float, d: float) -> Solid:
    if style is KnobStyle.DOME:
        t = 1.0  # how far up the dome, rad; the mark lies along it
        lean = -math.atan2(0.7 * d * math.cos(t), r * math.sin(t))
        line = box((0.0022, 0.34 * r, 0.0016), (0.0, 0.0, 0.0), 0.0003).rotated("x", lean)
        return line.translated(y=r * math.cos(t), z=0.3 * d + 0.7 * d * math.sin(t))
    ends = {KnobStyle.SKIRT: (0.08, 0.6), KnobStyle.SLIM: (0.3, 0.88)}.get(style, (0.21, 0.83))
    top = 1.117 * d if style is KnobStyle.BAR else d
    start, end = ends[0] * r, ends[1] * r
    return box((0.0022, end - start, 0.0012), (0.0, (start + end) / 2, top + 0.0002), 0.0002)


def dial(radius: float, turn: float = KNOB_TRAVEL, up: bool = False, steps: int = 7) -> Solid:
    """Ticks printed round a knob, from off over its range; their back is the plane of its foot at the origin."""
    parts = []
    for k in range(steps):
        length = 0.2 if k == 0 else 0.08 + 0.07 * k / (steps - 1)
        tick = box((0.0014, length * radius, 0.0003), (0.0, (1.32 + length / 2) * radius, 0.00015), 0.0)
        parts.append(tick.rotated("z", turn * k / (steps - 1)))
    ring = concatenate(parts).without_colliders()
    return ring if up else ring.rotated("x", math.pi / 2)


def bezel(radius: float, up: bool = False) -> Solid:
    """A thin ring that lies behind a knob; its foot at the origin."""
    ring = rod(radius * 1.22, 0.0024, 0.0008).translated(z=0.0012)
    return ring if up else ring.rotated("x", math.pi / 2)


# Readout --------------------------------------------------------------------------------------------------------------
# Seven-segment figures on a display, and signs printed next to keys; all face the front (-y).


def seven_segment_text(text: str, height: float) -> Solid:
    """A line of figures, `-` and `:`, `height` metres high, about the origin, back in y = 0. Raises KeyError."""
    t = 0.13 * height
    x = -(sum(COLON_WIDTH if c == ":" else FIGURE_PITCH for c in text) - (FIGURE_PITCH - FIGURE_WIDTH)) * height / 2
    parts: list[Solid] = []
    for c in text:
        if c == ":":
            at = x + (COLON_WIDTH - (FIGURE_PITCH - FIGURE_WIDTH)) * height / 2
            parts += [_ink(t, t, at, sign * 0.2 * height) for sign in (-1, 1)]
            x += COLON_WIDTH * height
            continue
        parts += _figure(SEGMENTS[c], x, height, t)
        x += FIGURE_PITCH * height
    return concatenate(parts)


def _figure(bars: str, x: float, h: float, t: float) -> list[Solid]:
    w = FIGURE_WIDTH * h
    width, height = w - 1.3 * t, h / 2 - 1.15 * t
    lower, upper = -h / 4, h / 4
    places = (
        (width, t, x + w / 2, h / 2 - t / 2), (t, height, x + t / 2, upper), (t, height, x + w - t / 2, upper),
        (width, t, x + w / 2, 0.0), (t, height, x + t / 2, lower), (t, height, x + w - t / 2, lower),
        (width, t, x + w / 2, -h / 2 + t / 2),
    )  # fmt: skip
    return [_ink(*place) for on, place in zip(bars, places, strict=True) if on == "1"]


def key_symbol(kind: KeySign, size: float) -> Solid:
    """A sign about the origin, its back in the plane y = 0, as wide as `size`, metres."""
    t = 0.16 * size
    if kind is KeySign.PLUS:
        upright = [_ink(t, 0.42 * size, 0.0, z * size) for z in (0.29, -0.29)]
        return concatenate([_ink(size, t, 0.0, 0.0), *upright])
    if kind is KeySign.MINUS:
        return _ink(size, t, 0.0, 0.0)
    if kind is KeySign.STOP:
        return _ink(0.8 * size, 0.8 * size, 0.0, 0.0)
    if kind is KeySign.BARS:
        return concatenate([_ink(size, t, 0.0, z * size) for z in (-0.32, 0.0, 0.32)])
    if kind is KeySign.PLAY:
        half = size / 2
        wedge = prism(np.array([(-0.8 * half, -half), (half, 0.0), (-0.8 * half, half)]), INK_THICKNESS, 0.0)
        return wedge.rotated("x", math.pi / 2).without_colliders()
    line = [(0.5 * size - t, 0.0), (0.5 * size, 0.0), (0.5 * size, INK_THICKNESS), (0.5 * size - t, INK_THICKNESS)]
    ring = lathe(line, 20, closed=True).rotated("x", math.pi / 2)
    inner = _ink(t, 0.5 * size, 0.0, 0.0) if kind is KeySign.POWER else _ink(0.3 * size, 0.3 * size, 0.0, 0.0)
    return concatenate([ring, inner])


def _ink(width: float, height: float, x: float, z: float) -> Solid:
    return box((width, INK_THICKNESS, height), (x, -INK_THICKNESS / 2, z), 0.0).without_colliders()


def add_pressure_gauge(builder: AssetBuilder, at: Vec3, radius: float, metal: str) -> None:
    """A round pressure gauge in a front that looks to -y."""
    x, y, z = at
    line = [(radius, 0.0), (radius, 0.005), (radius - 0.003, 0.007), (radius - 0.004, 0.0062), (0.0, 0.0062)]
    builder.draw(ROOT, lathe(line, 32).rotated("x", math.pi / 2).translated(x, y, z), metal, "gauge")
    dial = rod(radius - 0.0042, 0.0006, 0.0, "y").translated(x, y - 0.0067, z)
    builder.draw(ROOT, dial, "enamel_white", "gauge", density=0.0)
    for k in range(9):
        angle = math.radians(-130 + 260 * k / 8)
        tick = box((0.0008, 0.0004, 0.003), (0.0, -0.0072, radius - 0.0066), 0.0).rotated("y", angle)
        tick = tick.translated(x, y, z)
        builder.draw(ROOT, tick, "plastic_black", "gauge", density=0.0)
    hand = box((0.0012, 0.0004, radius - 0.008), (0.0, -0.0075, 0.3 * radius), 0.0).rotated("y", -0.9)
    hand = hand.translated(x, y, z)
    builder.draw(ROOT, hand, "plastic_red", "gauge", density=0.0)
