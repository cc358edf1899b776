"""Build the joint of each moving part with friction, damping and springs for a human hand, and its named states."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.plan import PartKind, PartPlan
from casa_assets.articulate.vectors import round7
from casa_assets.core import hand_dynamics
from casa_assets.core.hand_dynamics import START_N
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Collider, Drive, Joint, JointKind, Link, State

# Force that starts a part; all others start as a door does.
STARTS_N = {
    PartKind.KNOB: hand_dynamics.KNOB_START_N,
    PartKind.LEVER: hand_dynamics.TAP_START_N,
    PartKind.SPOUT: hand_dynamics.TAP_START_N,
    PartKind.TRAY: hand_dynamics.TRAY_START_N,
}
# A door whose weight turns it by less than this torque needs no spring.
MIN_SPRING_TORQUE_NM = 0.05
# Parts that fingers take at the rim.
RIM_GRIPPED_KINDS = frozenset({PartKind.KNOB})
# Shortest travel that friction is computed for, rad or m.
MIN_TRAVEL = 1e-4


def build_joint(part: PartPlan, metres: float, link: Link, behind: int | None, names: Sequence[str]) -> Joint:
    """Return the joint of a part in the child's frame, with friction and damping that fit the hand that moves it.

    Args:
        metres: length of the diagonal, in which the ranges of slides are given. link: the one that moves.
        behind: index of the part that must be open first, or None. names: of all links, the body first.
    """
    slides = part.joint.kind is JointKind.SLIDE
    lower, upper = (r * metres if slides else r for r in part.joint.range)
    way = upper - lower
    axis = np.array(part.joint.axis)
    grip = next((c for c in link.colliders if c.label == "handle"), link.colliders[0] if link.colliders else None)
    arm = 1.0 if slides else _arm(link, grip, axis, part.kind in RIM_GRIPPED_KINDS)
    inertia = link.inertial.mass if slides else _about(link, axis)
    spring = None if slides else _balance(link, axis, upper)
    feel = hand_dynamics.feel_against(spring, inertia, arm, max(way, MIN_TRAVEL), STARTS_N.get(part.kind, START_N))
    if part.kind is PartKind.BUTTON:
        spring = hand_dynamics.press(max(way, MIN_TRAVEL), hand_dynamics.KEY_FULL_N, hand_dynamics.KEY_PRELOAD_N)
        feel = hand_dynamics.KEY
    return Joint(
        name=f"{part.name}_joint",
        child=part.name,
        kind=part.joint.kind,
        axis=part.joint.axis,
        range=(round7(lower), round7(upper)),
        damping=feel.damping,
        frictionloss=feel.frictionloss,
        armature=feel.armature,
        drive=None if spring is None else Drive(stiffness=spring.stiffness, damping=0.0, target=spring.rest),
        grip=None if grip is None else grip.name,
        behind=None if behind is None else f"{names[behind + 1]}_joint",
    )


def _balance(link: Link, axis: Floats, far: float) -> hand_dynamics.Spring | None:
    """Return the spring of a door that would otherwise fall open, None if it would not."""
    center = np.array(link.inertial.center_of_mass)
    turned = center * math.cos(far) + np.cross(axis, center) * math.sin(far)
    turned = turned + axis * float(axis @ center) * (1 - math.cos(far))
    falls = float(np.cross(turned, np.array([0.0, 0.0, -9.81 * link.inertial.mass])) @ axis)
    return None if falls <= MIN_SPRING_TORQUE_NM else hand_dynamics.carry(falls, far)


def _arm(link: Link, grip: Collider | None, axis: Floats, rim: bool) -> float:
    """Return the distance from the axis to the hand, metres: to the handle, or to the rim of what fingers turn."""
    if grip is None:
        return 0.01
    points = tessellate(grip.shape, grip.pose)[0] if rim else np.array([grip.pose.position])
    off = points - np.outer(points @ axis, axis)
    return max(0.005, float(np.linalg.norm(off, axis=1).max()))


def _about(link: Link, axis: Floats) -> float:
    """Return the inertia of a link about an axis through its origin, kg*m^2."""
    center = np.array(link.inertial.center_of_mass)
    off = center - axis * float(center @ axis)
    return float(axis @ link.inertial.tensor @ axis) + link.inertial.mass * float(off @ off)


def open_closed_states(part: PartPlan) -> tuple[State, ...]:
    """Return the closed and open states of a front. Ref: robocasa v1.0, is_closed 0.005, is_open 0.9."""
    if part.kind not in (PartKind.DOOR, PartKind.DRAWER, PartKind.LID):
        return ()
    joint = f"{part.name}_joint"
    return (
        State(name=f"{joint}_closed", joint=joint, value="closed", interval=(0.0, 0.005)),
        State(name=f"{joint}_open", joint=joint, value="open", interval=(0.9, 1.0)),
    )
