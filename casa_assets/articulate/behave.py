"""How a part moves: its joint, with the friction, damping and springs that a hand feels, and its named states."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.plan import PartKind, PartPlan
from casa_assets.core.typing import Floats
from casa_assets.geometry.tessellate import surface
from casa_assets.model.asset import Collider, Drive, Joint, JointKind, Link, State

# Force that starts a part, and the one that then takes it along in about a second, N.
START_N, PUSH_N, OPENS_IN_S = 4.0, 18.0, 1.0
FORCES = {
    PartKind.KNOB: (1.0, 6.0),
    PartKind.BUTTON: (0.5, 10.0),
    PartKind.LEVER: (1.5, 8.0),
    PartKind.SPOUT: (1.5, 8.0),
    PartKind.TRAY: (2.0, 14.0),
}
# What a finger needs at the end of a button's stroke, and to begin it, N.
PRESS_N, PRELOAD_N = 3.0, 0.6
# In about this time it is back.
BACK_IN_S = 0.4
# Share of a falling door's weight that its spring carries.
CARRIED = 0.94
# Taken at the rim.
TURNED = frozenset({PartKind.KNOB})


def joint_for(part: PartPlan, metres: float, link: Link, behind: int | None, names: Sequence[str]) -> Joint:
    """The joint of a part, child frame; friction and damping by what moves it.

    Args:
        metres: length of the diagonal, in which the ranges of slides are given. link: that moves.
        behind: index of the part that has to stand open before, or None. names: of all links, the body first.
    """
    slides = part.joint.kind is JointKind.SLIDE
    low, high = (r * metres if slides else r for r in part.joint.range)
    way = high - low
    axis = np.array(part.joint.axis)
    grip = next((c for c in link.colliders if c.label == "handle"), link.colliders[0] if link.colliders else None)
    arm = 1.0 if slides else _arm(link, grip, axis, part.kind in TURNED)
    inertia = link.inertial.mass if slides else _about(link, axis)
    start, push = FORCES.get(part.kind, (START_N, PUSH_N))
    drive = None if slides else _balance(link, axis, high)
    if part.kind is PartKind.BUTTON:
        stiff = (PRESS_N - PRELOAD_N) / max(way, 1e-4)
        drive = Drive(stiffness=_three(stiff), damping=_three(way * 20), target=_three(-PRELOAD_N / stiff))
        start = 0.1
    # A key is back by its spring alone, in a moment; what a hand opens is slowed to its pace.
    slow = PRELOAD_N * BACK_IN_S / max(way, 1e-4) if part.kind is PartKind.BUTTON else None
    return Joint(
        name=f"{part.name}_joint",
        child=part.name,
        kind=part.joint.kind,
        axis=part.joint.axis,
        range=(_seven(low), _seven(high)),
        damping=_three(damping(inertia, (push - start) * arm, way) if slow is None else slow),
        frictionloss=_three(start * arm),
        armature=_three(0.02 * inertia),
        drive=drive,
        grip=None if grip is None else grip.name,
        behind=None if behind is None else f"{names[behind + 1]}_joint",
    )


def _balance(link: Link, axis: Floats, far: float) -> Drive | None:
    """The spring of a door that would fall open: it carries most of the weight, and holds it shut."""
    center = np.array(link.inertial.center_of_mass)
    turned = center * math.cos(far) + np.cross(axis, center) * math.sin(far)
    turned = turned + axis * float(axis @ center) * (1 - math.cos(far))
    falls = float(np.cross(turned, np.array([0.0, 0.0, -9.81 * link.inertial.mass])) @ axis)
    if falls <= 0.05:
        return None
    stiffness = CARRIED * falls / far
    return Drive(stiffness=_three(stiffness), damping=0.0, target=_three(-0.06 * falls / stiffness))


def _arm(link: Link, grip: Collider | None, axis: Floats, rim: bool) -> float:
    """From the axis to the hand, metres: the middle of the handle, or the rim of what is turned between fingers."""
    if grip is None:
        return 0.01
    points = surface(grip.shape, grip.pose)[0] if rim else np.array([grip.pose.position])
    off = points - np.outer(points @ axis, axis)
    return max(0.005, float(np.linalg.norm(off, axis=1).max()))


def _about(link: Link, axis: Floats) -> float:
    """Inertia of a link about an axis through its origin, kg*m^2."""
    center = np.array(link.inertial.center_of_mass)
    off = center - axis * float(center @ axis)
    return float(axis @ link.inertial.tensor @ axis) + link.inertial.mass * float(off @ off)


def damping(inertia: float, drive: float, way: float) -> float:
    """Damping under which a steady drive (N*m or N) takes a still thing over its way in OPENS_IN_S, about.

    From rest it takes way * damping / drive, and a time constant more.
    """
    free = drive * OPENS_IN_S / max(way, 1e-4)
    return max(free - inertia / OPENS_IN_S, 0.05 * free, 1e-6)


def states_for(part: PartPlan) -> tuple[State, ...]:
    """Closed and open of a front. Ref: robocasa v1.0, is_closed 0.005, is_open 0.9."""
    if part.kind not in (PartKind.DOOR, PartKind.DRAWER, PartKind.LID):
        return ()
    joint = f"{part.name}_joint"
    return (
        State(name=f"{joint}_closed", joint=joint, value="closed", interval=(0.0, 0.005)),
        State(name=f"{joint}_open", joint=joint, value="open", interval=(0.9, 1.0)),
    )


def _seven(value: float) -> float:
    return float(f"{float(value):.7g}")


def _three(value: float) -> float:
    return float(f"{value:.3g}")
