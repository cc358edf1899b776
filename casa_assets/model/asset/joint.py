"""Joints between links, and named poses of a whole asset."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, MixedCaseId, Record, Vec2, Vec3, Vec5

NotNegative = Annotated[float, Field(ge=0.0)]


class JointKind(StrEnum):
    """Hinge (rad) or slide (m)."""

    HINGE = "hinge"
    SLIDE = "slide"


class Drive(Record):
    """A spring to a target: stiffness and damping in N/m, N*s/m or N*m/rad, N*m*s/rad; target in m or rad."""

    stiffness: NotNegative
    damping: NotNegative
    target: float = 0.0


class Joint(Record):
    """Joint between a link and its parent: kind, axis, range, friction. Zero is closed.

    Attributes:
        name: unique.
        child: link that moves.
        kind: hinge or slide.
        axis: unit vector, child frame.
        anchor: a point on the axis, metres, child frame.
        range: (low, high), rad or m; low < high.
        damping: N*m*s/rad or N*s/m.
        frictionloss: N*m or N.
        armature: kg*m^2 or kg.
        friction_impedance: stiffness of dry friction as in MuJoCo: impedance at both ends, width, midpoint, power. With
            MuJoCo's default of 0.9 a light lever creeps under its own weight; with this value it does not. Ref: MuJoCo
            XML reference, solimpfriction.
        limit_impedance: stiffness of the ends of the range as in MuJoCo. With MuJoCo's default a spring presses a key
            0.8 mm out of its range of 3 mm; with this value, a few micrometres. Ref: MuJoCo XML reference, solimplimit.
        limit_margin: for joints with a drive, distance from the ends of the range at which they begin to push back, rad
            or m, so that a part that is pressed against an end comes to rest within the range. Ref: MuJoCo XML
            reference, margin.
        drive: spring to a target, or None.
        grip: collider that a hand takes hold of, on the moved link or on one that it carries rigidly; None if unknown.
        behind: joint that has to be open before this one can move: the door in front of a rack.
    """

    name: Id
    child: Id
    kind: JointKind
    axis: Vec3
    anchor: Vec3 = (0.0, 0.0, 0.0)
    range: Vec2
    damping: NotNegative = 0.0
    frictionloss: NotNegative = 0.0
    armature: NotNegative = 0.0
    friction_impedance: Vec5 = (0.9999, 0.9999, 0.001, 0.5, 2.0)
    limit_impedance: Vec5 = (0.9999, 0.9999, 0.001, 0.5, 2.0)
    limit_margin: NotNegative = 1e-5
    drive: Drive | None = None
    grip: MixedCaseId | None = None
    behind: Id | None = None

    @field_validator("axis")
    @classmethod
    def _unit(cls, axis: Vec3) -> Vec3:
        norm = float(np.linalg.norm(axis))
        if norm < 1e-9:
            raise ValueError("axis has no direction")
        if abs(norm - 1.0) <= 1e-12:
            return axis
        return (axis[0] / norm, axis[1] / norm, axis[2] / norm)

    @field_validator("range")
    @classmethod
    def _ordered(cls, span: Vec2) -> Vec2:
        if not span[0] < span[1]:
            raise ValueError(f"range {span} must rise")
        return span

    def motion(self, position: float) -> Pose:
        """Pose of the child at a joint position (rad or m), relative to its frame at position zero."""
        x, y, z = self.axis
        if self.kind is JointKind.SLIDE:
            return Pose(position=(x * position, y * position, z * position))
        # Not numpy's functions: their last bit depends on the processor.
        c, s = math.cos(position / 2), math.sin(position / 2)
        anchor = Pose(position=self.anchor)
        return anchor @ Pose(quaternion=(c, s * x, s * y, s * z)) @ anchor.inverse()


class State(Record):
    """A named interval of a joint, as fractions of the way from closed (0) to open (1): `open` is (0.9, 1)."""

    name: Id
    joint: Id
    value: Id
    interval: Vec2


class JointValue(Record):
    """Position of one joint, rad or m."""

    joint: Id
    value: float


def joint_positions(values: Iterable[JointValue]) -> dict[str, float]:
    """Joint name -> position, rad or m."""
    return {at.joint: at.value for at in values}


class Keyframe(Record):
    """A named pose of the whole asset: `closed`, `open`, `on`. Joints that are not named are at zero."""

    name: Id
    joints: tuple[JointValue, ...] = ()


class Exclusion(Record):
    """Two links that never collide with each other."""

    first: Id
    second: Id
