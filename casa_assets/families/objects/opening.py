"""Joints of what closes a thing: a lid that is lifted off, one that swings up, with the states of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from casa_assets.core import hand_dynamics
from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.mass_properties import combine_masses
from casa_assets.model.record import Vec3

LID, LID_JOINT, LID_GRIP = "lid", "lid_joint", "lid_main"
GRAVITY = 9.81
# A lid stays where a hand lets go of it: its friction carries so many times its weight, and so much more, N. It is less
# than what holds a light jar down, so that a lid comes off a jar that nobody holds.
CARRIED, LEAST_N = 1.15, 0.3
# Beyond that, so much lifts it all the way in hand_dynamics.OPENS_IN_S, N.
EASE_N, SWING_EASE_N = 0.6, 2.0
# Flaps of card are so light that a simulation would let them creep: a hinge has at least this armature, kg*m^2.
LEAST_ARMATURE = 5e-5
# How far a lid is lifted: by the width of what it closes and somewhat more, so that things get in below it; metres.
EXTRA, LEAST_LIFT, MOST_LIFT = 0.02, 0.05, 0.16


def lift_off(builder: AssetBuilder, width: float, link: str = LID, most: float = MOST_LIFT) -> None:
    """Let a lid slide up from a mouth.

    Args:
        width: of the mouth, metres. link: of the lid; all that is on it is there already, its grip is LID_GRIP.
        most: room above it, metres.
    """
    travel = round(min(max(width + EXTRA, LEAST_LIFT), most, MOST_LIFT), 3)
    mass = combine_masses(builder.links[link].masses).mass
    start = LEAST_N + CARRIED * GRAVITY * mass
    feel = hand_dynamics.feel(mass, 1.0, travel, start, start + EASE_N)
    builder.slide(LID_JOINT, link, (0.0, 0.0, 1.0), (0.0, travel), LID_GRIP, feel=feel)
    _states(builder, travel)


def swing_up(builder: AssetBuilder, axis: Vec3, angle: float, link: str = LID) -> None:
    """Let a lid swing up about the origin of its link.

    Args:
        axis: link frame; a right-handed turn about it opens. angle: of the turn, rad.
    """
    lid = combine_masses(builder.links[link].masses)
    start = LEAST_N + CARRIED * GRAVITY * lid.mass
    arm = lid.center - np.array(axis) * float(lid.center @ np.array(axis))
    lever = max(0.01, float(np.linalg.norm(arm)))
    feel = hand_dynamics.feel(1.4 * lid.mass * lever**2, lever, angle, start, start + SWING_EASE_N)
    feel = replace(feel, armature=max(feel.armature, LEAST_ARMATURE))
    builder.hinge(LID_JOINT, link, axis, (0.0, angle), LID_GRIP, feel=feel)
    _states(builder, angle)


def _states(builder: AssetBuilder, end: float) -> None:
    builder.door_states(LID_JOINT)
    builder.keyframe("closed")
    builder.keyframe("open", **{LID_JOINT: end})
