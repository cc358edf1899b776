"""Start states of a kitchen for a compiled model: episodes begin in states that are known to be at rest."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import CasaError
from casa_assets.model.kitchen import start_states as record


class StartStates:
    """Start states that fit a model: the kitchen in its full or light form, alone or with a robot and more in it.

    They are certified for the full kitchen alone: no contact deeper than 1 mm, nothing moves by more than 5 mm in 2 s,
    and the space of a robot with its arm at rest is free at its parking place.

    Attributes:
        base: (states, 3) parking pose of the middle of the robot's base: x, y (m), yaw (rad); read-only.
        envelope: boxes that are free there, lower and upper corner (m) in the frame of the base, x ahead.
        depth, motion: (states,) deepest contact and greatest motion of each, m; read-only.
        notes: for each state, which objects are `placed` where, in front of which fixture the robot is `parked`, and
            which joints are `opened`.
    """

    def __init__(self, states: record.StartStates, model: mujoco.MjModel, source: Path) -> None:
        """Made by `start_states(...)`. Raises CasaError if the model lacks a joint of the states."""
        self._rows: Floats = states.qpos.astype(np.float64)
        self._at = _addresses(states, model, source)
        self.base, self.depth, self.motion = (a.astype(np.float64) for a in (states.base, states.depth, states.motion))
        for array in (self._rows, self.base, self.depth, self.motion):
            array.setflags(write=False)
        self.envelope, self.notes = states.envelope, states.notes

    def __len__(self) -> int:
        """Number of states."""
        return len(self._rows)

    @property
    def qpos(self) -> Floats:
        """(states, numbers) positions of the kitchen's joints, in the order of `addresses`; read-only."""
        return self._rows

    @property
    def addresses(self) -> Ints:
        """(numbers,) index in `data.qpos` of the model for each number of a row."""
        return self._at

    def reset(self, data: mujoco.MjData, number: int) -> None:
        """Put the joints of the kitchen into one state, with everything at rest.

        It takes microseconds: poses and contacts are computed by the next `mj_forward` or `mj_step`. Joints of a robot
        are not changed; `base[number]` is its parking pose.
        """
        data.qpos[self._at] = self._rows[number]
        data.qvel[:] = 0.0
        data.qacc_warmstart[:] = 0.0
        data.time = 0.0


def _addresses(states: record.StartStates, model: mujoco.MjModel, source: Path) -> Ints:
    """(numbers,) index in qpos of a model for each number of a row."""
    found = np.empty(states.qpos.shape[1], dtype=np.int64)
    for joint in states.joints:
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        is_free = number >= 0 and model.jnt_type[number] == mujoco.mjtJoint.mjJNT_FREE
        if number < 0 or is_free != (joint.width == record.FREE_WIDTH):
            raise CasaError(
                f"{source}: the model has no joint {joint.name!r} as the start states know it; they are of the kitchen "
                f"{states.scene}, whose model casa_assets.load_scene gives"
            )
        first = int(model.jnt_qposadr[number])
        found[joint.address : joint.address + joint.width] = range(first, first + joint.width)
    return found
