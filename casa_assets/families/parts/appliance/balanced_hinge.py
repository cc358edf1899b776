"""Flaps and heads that turn about x: a spring carries their weight, friction holds them where they are left."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core import hand_dynamics
from casa_assets.core.rounding import significant
from casa_assets.families.kit.asset_builder import AssetBuilder

GRAVITY = 9.81  # m/s^2


def balanced_hinge(builder: AssetBuilder, link: str, joint: str, grip: str, way: float) -> None:
    """Hinge a link about x through its origin; it opens by `way` rad: to the front where positive, up where negative.

    The spring is the straight line that comes nearest to the moment of the weight over the way; what is left over
    is held by friction.
    """
    piece = builder.links[link]
    mass = sum(q.mass for q in piece.masses)
    center = sum((q.mass * q.center for q in piece.masses), np.zeros(3)) / mass
    hand = np.array(next(c for c in piece.colliders if c.name == grip).pose.position)
    lever = math.hypot(float(hand[1]), float(hand[2]))
    turns = np.linspace(0.0, way, 33)
    pull = mass * GRAVITY * (center[2] * np.sin(turns) - center[1] * np.cos(turns))
    stiffness = float(np.polyfit(turns, pull, 1)[0])
    rest = pull - stiffness * turns
    bias = (float(rest.max()) + float(rest.min())) / 2
    left = float(rest.max()) - bias
    start = max(hand_dynamics.START_N, 1.35 * left / lever)
    inertia = mass * float(center[1] ** 2 + center[2] ** 2) * 1.35
    feel = hand_dynamics.feel(inertia, lever, abs(way), start, max(start + 2.5, hand_dynamics.PULL_N - left / lever))
    spring = hand_dynamics.Spring(significant(stiffness, 4), significant(-bias / stiffness, 4))
    builder.hinge(joint, link, (1.0, 0.0, 0.0), (min(0.0, way), max(0.0, way)), grip, spring=spring, feel=feel)
