"""Grasps of a parallel-jaw gripper on an object as it rests."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.model.record import Record, Vec3


class GraspFeature(StrEnum):
    """Part of the object that the fingers close on."""

    BODY = "body"  # the thing itself, near its middle
    RIM = "rim"  # the wall of a vessel, from above
    HANDLE = "handle"  # what sticks out to be held


class Grasp(Record):
    """One grasp of an object: its centre, directions and opening width.

    Attributes:
        feature: part that the fingers close on.
        center: middle between the fingers, metres.
        closing: unit vector along which they close. approach: unit vector of the approach, at a right angle to it.
        width: distance between the fingers as they touch, metres.
    """

    feature: GraspFeature
    center: Vec3
    closing: Vec3
    approach: Vec3
    width: Annotated[float, Field(gt=0)]
