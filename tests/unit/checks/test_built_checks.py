"""Checks of what is built from numbers: each code is silent on what is right and speaks alone where one thing is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from casa_assets import registry
from casa_assets.checks import asset as asset_checks
from casa_assets.checks import force, motion
from casa_assets.checks.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table import TABLE
from casa_assets.export.mjcf import write
from casa_assets.model.asset import Asset, Drive, JointKind
from casa_assets.model.issue import Report
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box
from tests.articulated import drawer_unit, microwave
from tests.assets import category, write_to
from tests.cupboard import (
    ball_of,
    caught_by,
    cupboard,
    filled_to,
    joint_changed,
    link_changed,
    pictured_at,
    shape,
    with_grip,
    with_mass_within,
    with_pointer,
    with_shapes,
    with_trim,
)
from tests.packages import written

OURS = ("AST017", "VIS009", "VIS010", "KIN", "HOL")
ROWS = {check.code: check for check in TABLE if check.code.startswith(OURS)}
LIMITS = registry.load().limits
Build = Callable[[], Asset]


def pulled_back(stiffness: float) -> Asset:
    """A spring draws its drawer shut."""
    return joint_changed("drawer_slide", drive=Drive(stiffness=stiffness, damping=0.0, target=0.0))


def tilted(angle: float) -> Asset:
    """The hinge of its door leans to the right."""
    return joint_changed("door_hinge", axis=(math.sin(angle), 0.0, math.cos(angle)))


# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "AST017": (lambda: with_mass_within(0.2), lambda: with_mass_within(0.05)),
    "VIS009": (lambda: pictured_at(1.01), lambda: pictured_at(1.03)),
    "VIS010": (lambda: with_trim(0.0005), lambda: with_trim(0.0)),
    "KIN001": (lambda: caught_by(0.0), lambda: caught_by(0.00045 + 0.01)),
    "KIN002": (cupboard, lambda: joint_changed("drawer_slide", damping=200.0)),
    "KIN003": (lambda: joint_changed("drawer_slide", frictionloss=0.3), lambda: joint_changed("drawer_slide", frictionloss=0.1)),
    "KIN004": (lambda: joint_changed("key_press", frictionloss=0.5), lambda: joint_changed("key_press", frictionloss=2.5)),
    "KIN005": (lambda: with_pointer(0.06), lambda: with_pointer(0.16)),
    "KIN006": (lambda: pulled_back(15.0), lambda: pulled_back(40.0)),
    "KIN007": (lambda: with_grip("knob_turn", ball_of(0.03)), lambda: joint_changed("drawer_slide", grip=None)),
    "KIN008": (lambda: tilted(0.0), lambda: tilted(0.001)),
    "HOL001": (lambda: filled_to(-0.1), lambda: filled_to(0.1)),
}  # fmt: skip
