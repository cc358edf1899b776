"""States of a kitchen at rest from which episodes begin: poses of all joints and loose objects, and of the robot."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from casa_assets.model.kitchen.scene import SceneId
from casa_assets.model.record import ArrayOf, Record, Sha256, Vec3

FREE_WIDTH = 7  # numbers in qpos of a free joint: x, y, z, quaternion (w, x, y, z)
Rows = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1, -1))]
Bases = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1, 3))]
Numbers = Annotated[npt.NDArray[np.float32], ArrayOf("float32", (-1,))]


class StateJoint(Record):
    """A joint of the kitchen.

    Attributes:
        name: name in scene.xml.
        address: index of its first number in a row.
        width: count of its numbers: 1, or 7 for a free joint.
    """

    name: str
    address: Annotated[int, Field(ge=0)]
    width: Literal[1, 7]


class StateNotes(Record):
    """Notes on one state, in addition to its numbers.

    Attributes:
        placed: loose object that was put somewhere -> its place as `<fixture>/<region>`.
        parked: fixture in front of which the robot is parked.
        opened: joints that are not in their rest position.
    """

    placed: dict[str, str]
    parked: str
    opened: tuple[str, ...] = ()


class StartStates(Record):
    """Start states of one scene. Metres, radians, quaternions (w, x, y, z), world frame.

    Attributes:
        key: digest of everything that they were made from.
        scene: id of the scene.
        scene_xml: digest of the bytes of its scene.xml.
        mujoco: version of MuJoCo with which they were settled.
        seed: seed that drew them.
        limits: maximum depth and motion (m) of each state.
        envelope: boxes that are kept free for the robot at its parking place: lower and upper corner of each, in the
            frame of the middle of its base, x ahead (m).
        joints: joints of the scene, in the order of qpos.
        notes: notes on each state.
        qpos: (states, nq).
        base: (states, 3) x, y and yaw of the middle of the robot's base.
        depth: (states,) deepest contact at the start and in the 2 s after it, m.
        motion: (states,) greatest distance that any part moves in these 2 s, m.
        refused: reason -> number of draws that were rejected for it.
    """

    format: Literal[1] = 1
    key: str
    scene: SceneId
    scene_xml: Sha256
    mujoco: str
    seed: Annotated[int, Field(ge=0)]
    limits: tuple[float, float]
    envelope: tuple[tuple[Vec3, Vec3], ...]
    joints: tuple[StateJoint, ...]
    notes: tuple[StateNotes, ...]
    qpos: Rows
    base: Bases
    depth: Numbers
    motion: Numbers
    refused: dict[str, int] = Field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.notes)

    @property
    def header(self) -> dict[str, Any]:
        """Everything except the arrays, as JSON data."""
        return self.model_dump(mode="json", exclude=set(ARRAYS))

    @model_validator(mode="after")
    def _fits(self) -> Self:
        counts = {name: len(getattr(self, name)) for name in (*ARRAYS, "notes")}
        if len(set(counts.values())) != 1:
            raise ValueError(f"as many rows are expected of each: {counts}")
        ends = [0, *(joint.address + joint.width for joint in self.joints)]
        if [joint.address for joint in self.joints] != ends[:-1] or self.qpos.shape[1] != ends[-1]:
            raise ValueError(f"joints follow each other and fill a row of {self.qpos.shape[1]} numbers")
        return self


ARRAYS = ("qpos", "base", "depth", "motion")
