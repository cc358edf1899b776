"""States of a kitchen at rest from which episodes begin: where every joint and every loose thing is, and the robot."""

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
        name: in scene.xml. address: of its first number in a row. width: how many it has: 1, or 7 where it is free.
    """

    name: str
    address: Annotated[int, Field(ge=0)]
    width: Literal[1, 7]


class StateNotes(Record):
    """What is known of one state besides its numbers.

    Attributes:
        placed: loose thing that was put somewhere -> where: `<fixture>/<region>`.
        parked: fixture that the robot stands before. opened: joints that are not where they rest.
    """

    placed: dict[str, str]
    parked: str
    opened: tuple[str, ...] = ()


class StartStates(Record):
    """Start states of one scene. Metres, radians, quaternions (w, x, y, z), frame of the world.

    Attributes:
        key: of all that they were made from. scene: id. scene_xml: digest of the bytes of its scene.xml.
        mujoco: version in which they were settled. seed: that drew them.
        limits: depth and motion (m) that each stays within.
        envelope: boxes that are kept free for the robot where it parks: least and largest corner of each, in the frame
            of the middle of its base, x ahead (m).
        joints: of the scene, in the order of qpos. notes: of each state.
        qpos: (states, nq). base: (states, 3) x, y and yaw of the middle of the robot's base.
        depth: (states,) deepest contact at the start and in the 2 s after it, m. motion: (states,) farthest that any
            part goes in these 2 s, m.
        refused: reason -> how many draws were given up for it.
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
        """All but the arrays, as JSON has it."""
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
