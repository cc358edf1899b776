"""Knobs that turn: on a front, where they face -y, or on a top, where they face up."""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.core import hand_dynamics
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import box, lathe, rod
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.model.asset.shape import Cylinder
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Ref: RoboCasa v1.0, class Stove: on from 0.35 rad, high from 80 degrees, set up to 2 pi - 0.35.
KNOB_TRAVEL = 2.6


class KnobStyle(StrEnum):
    """Style of a knob."""

    SKIRT = "skirt"  # a pointer on a skirt
    FLUTED = "fluted"  # a cylinder with grooves
    BAR = "bar"  # a drum with a bar across, professional
    DOME = "dome"
    DISC = "disc"  # flat with a ridge
    SLIM = "slim"  # a narrow cylinder
    CHICKEN_HEAD = "chicken_head"


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

    Args:
        name: of the link. radius: metres. finish, mark: finishes of the body and of its pointer.
        up: faces up instead of to the front. turn: rad, its range.
    """
    link = builder.link(name, at=at)
    depth = {KnobStyle.DISC: 0.7, KnobStyle.SLIM: 1.5}.get(style, 1.0) * min(0.026, 1.15 * radius)
    body, extra = _shape(style, radius, depth)
    shape = (Cylinder(radius=radius, height=depth), Pose(position=(0.0, 0.0, depth / 2)))
    shaped = Solid(body.points, body.faces, (shape,), crease_deg=body.crease_deg)
    face = Pose() if up else Pose(quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
    builder.add(link, shaped.transformed(face), finish, label="knob", collider=f"{name}_main", density="control_knob")
    for solid in extra:
        builder.add(link, solid.transformed(face), finish, label="knob", collider=False, density="control_knob")
    pointer = _pointer(style, radius, depth)
    builder.add(link, pointer.transformed(face), mark, label="knob", collider=False, density=0.0)
    axis = (0.0, 0.0, 1.0) if up else (0.0, -1.0, 0.0)
    feel = hand_dynamics.Feel(damping=0.02, frictionloss=hand_dynamics.KNOB_NM, armature=2e-4)
    builder.hinge(f"{name}_joint", link, axis, (0.0, turn), f"{name}_main", feel=feel)


def add_knob_with_scale(
    builder: AssetBuilder,
    name: str,
    at: Vec3,
    style: KnobStyle,
    radius: float,
    finish: str,
    *,
    bezel_finish: str,
    ink: str,
    turn: float,
    steps: int,
) -> None:
    """Add a knob with a bezel behind it and printed ticks round it; `at` lies on the front, which faces -y."""
    x, y, z = at
    builder.add(ROOT, bezel(radius).translated(x, y - 2e-4, z), bezel_finish, label="bezel", collider=False)
    ticks = dial(radius, turn, steps=steps).translated(x, y - 3e-4, z)
    builder.add(ROOT, ticks, ink, label="print", collider=False, density=0.0)
    add_knob(builder, name, (x, y - 0.0032, z), style, radius, finish, turn=turn)


def _shape(style: KnobStyle, r: float, d: float) -> tuple[Solid, list[Solid]]:
    """The turned body about z from z = 0 to d, and what sits on it."""
    e = 0.0015
    if style is KnobStyle.SKIRT:
        body = lathe([(r, 0.0), (r, 0.2 * d), (0.8 * r, 0.3 * d), (0.68 * r, d - e), (0.68 * r - e, d)], 32)
        return body, []
    if style is KnobStyle.FLUTED:
        grips = [
            box((0.0026, 0.0026, 0.7 * d), (0.0, 0.93 * r, 0.5 * d), 0.0).rotated("z", math.pi * k / 9)
            for k in range(18)
        ]
        return lathe([(r, 0.0), (r, 0.12 * d), (0.93 * r, 0.15 * d), (0.93 * r, d - e), (0.93 * r - e, d)], 36), grips
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
    """The mark on top of a knob that shows its position; it points towards y."""
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
