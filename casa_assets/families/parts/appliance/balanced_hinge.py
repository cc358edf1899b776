"""Hinges about x of flaps, heads and oven doors: a spring carries the weight, friction holds the link in place."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from casa_assets.core import hand_dynamics
from casa_assets.core.rounding import significant
from casa_assets.core.typing import Floats
from casa_assets.families.kit.asset_builder import AssetBuilder

GRAVITY = 9.81  # m/s^2
OVEN_DOOR_TRAVEL = 1.48  # rad
OVEN_DOOR_START_N = 6.0  # least force at the handle that starts an oven door


@dataclass(frozen=True)
class HingeLoad:
    """Weight of a link about a hinge along x through its origin.

    Attributes:
        inertia: kg*m^2. lever: metres from the axis to the grip.
        angles: (N,) rad over the travel of the hinge. moment: (N,) N*m of the weight there.
    """

    inertia: float
    lever: float
    angles: Floats
    moment: Floats

    @staticmethod
    def of(builder: AssetBuilder, link: str, grip: str, angles: Floats) -> HingeLoad:
        """The load of a link whose grip is the collider of that name."""
        owner = builder.links[link]
        mass = sum(m.mass for m in owner.masses)
        center = sum((m.mass * m.center for m in owner.masses), np.zeros(3)) / mass
        hand = next(c for c in owner.colliders if c.name == grip).pose.position
        moment = mass * GRAVITY * (center[2] * np.sin(angles) - center[1] * np.cos(angles))
        inertia = mass * float(center[1] ** 2 + center[2] ** 2) * 1.35
        return HingeLoad(inertia, math.hypot(hand[1], hand[2]), angles, moment)

    def add_hinge(
        self,
        builder: AssetBuilder,
        link: str,
        grip: str,
        stiffness: float,
        bias: float,
        unbalanced: float,
        start_n: float,
        name: str | None = None,
    ) -> None:
        """Add a hinge with a spring whose moment is bias + stiffness * angle.

        Args:
            name: of the joint; None for `<link>_joint`.
            unbalanced: N*m of the weight's moment that the spring leaves over. start_n: force that starts the link, N.
        """
        travel = float(self.angles[-1])
        push_n = max(start_n + 2.5, hand_dynamics.PULL_N - unbalanced / self.lever)
        feel = hand_dynamics.feel(self.inertia, self.lever, abs(travel), start_n, push_n)
        spring = hand_dynamics.Spring(significant(stiffness, 4), significant(-bias / stiffness, 4))
        span = (min(0.0, travel), max(0.0, travel))
        builder.hinge(name or f"{link}_joint", link, (1.0, 0.0, 0.0), span, grip, spring=spring, feel=feel)


def balanced_hinge(builder: AssetBuilder, link: str, grip: str, travel: float) -> None:
    """Hinge a link about x through its origin; its spring is fitted to the moment of its weight by least squares.

    Args:
        grip: collider that a hand takes. travel: rad; it opens to the front where positive, up where negative.
    """
    load = HingeLoad.of(builder, link, grip, np.linspace(0.0, travel, 33))
    stiffness = float(np.polyfit(load.angles, load.moment, 1)[0])
    residual = load.moment - stiffness * load.angles
    bias = (float(residual.max()) + float(residual.min())) / 2
    unbalanced = float(residual.max()) - bias
    start_n = max(hand_dynamics.START_N, 1.35 * unbalanced / load.lever)
    load.add_hinge(builder, link, grip, stiffness=stiffness, bias=bias, unbalanced=unbalanced, start_n=start_n)


def oven_door_hinge(builder: AssetBuilder, link: str, name: str | None = None) -> None:
    """Hinge a door at its lower edge; of 61 springs it gets the one whose largest unbalanced moment is least.

    Args:
        name: of the joint; None for `<link>_joint`.
    """
    grip = f"{link}_handle_main"
    load = HingeLoad.of(builder, link, grip, np.linspace(0.0, OVEN_DOOR_TRAVEL, 25))
    stiffnesses = np.linspace(0.2, 1.4, 61) * max(float(load.moment[-1]), 0.5) / OVEN_DOOR_TRAVEL
    residual = load.moment - stiffnesses[:, None] * load.angles
    bias = (residual.max(axis=1) + residual.min(axis=1)) / 2
    unbalanced = np.abs(residual - bias[:, None]).max(axis=1)
    k = int(np.argmin(unbalanced))
    worst = float(unbalanced[k])
    start_n = max(OVEN_DOOR_START_N, 1.25 * worst / load.lever)
    stiffness = float(stiffnesses[k])
    load.add_hinge(
        builder, link, grip, stiffness=stiffness, bias=float(bias[k]), unbalanced=worst, start_n=start_n, name=name
    )
