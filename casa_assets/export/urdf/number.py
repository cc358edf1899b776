"""Pose -> `<origin>`: metres, and roll, pitch and yaw in radians."""

from __future__ import annotations

import math

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Below this cosine of the pitch, roll and yaw turn about one axis; the roll is then zero.
GIMBAL_LOCK = 1e-12


def add_origin(element: etree._Element, pose: Pose) -> None:
    """`<origin>` of parent_from_element below `element`."""
    attributes = {"xyz": number.numbers(pose.position), "rpy": number.numbers(roll_pitch_yaw(pose))}
    etree.SubElement(element, "origin", attributes)


def roll_pitch_yaw(pose: Pose) -> Vec3:
    """Angles about the fixed axes x, y, z, applied in this order, radians; the pitch is in -pi/2..pi/2.

    The yaw is computed from the rotation that remains after the roll, so that the three angles reproduce the rotation
    near a pitch of 90 degrees too.
    """
    r = [[float(v) for v in row] for row in pose.rotation]
    across = math.hypot(r[0][0], r[1][0])
    roll = math.atan2(r[2][1], r[2][2]) if across > GIMBAL_LOCK else 0.0
    c, s = math.cos(roll), math.sin(roll)
    return roll, math.atan2(-r[2][0], across), math.atan2(s * r[0][2] - c * r[0][1], c * r[1][1] - s * r[1][2])
