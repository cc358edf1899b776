"""A robot that stands in every world of a batch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import CasaError


@dataclass(frozen=True)
class Robot:
    """A robot.

    Attributes:
        make: a new MjSpec of it, for each kitchen one.
        qpos, ctrl: of its first keyframe; without one as it is built, and zeros.
        freedoms: of all its joints.
        floats: its base has a free joint, so that it stands in the world and not on a body that a reset moves.
    """

    make: Callable[[], mujoco.MjSpec]
    qpos: Floats
    ctrl: Floats
    freedoms: int
    floats: bool


def robot_of(robot: str | Path | mujoco.MjSpec) -> Robot:
    """A robot from its MJCF file or a copy of its MjSpec. Raises CasaError for one that does not load."""

    def make() -> mujoco.MjSpec:
        spec = robot.copy() if isinstance(robot, mujoco.MjSpec) else mujoco.MjSpec.from_file(str(robot))
        # A keyframe of the robot alone would not fit a kitchen.
        for key in list(spec.keys):
            spec.delete(key)
        return spec

    try:
        whole = robot.copy() if isinstance(robot, mujoco.MjSpec) else mujoco.MjSpec.from_file(str(robot))
        model = whole.compile()
    except (ValueError, OSError) as error:
        name = robot.modelname if isinstance(robot, mujoco.MjSpec) else robot
        raise CasaError(f"{name}: MuJoCo cannot load this robot: {error}") from error
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    if len(free) and free[0] != 0:
        raise CasaError(f"{model.joint(int(free[0])).name}: a free joint of a robot has to be its first joint")
    qpos, ctrl = (model.key_qpos[0], model.key_ctrl[0]) if model.nkey else (model.qpos0, np.zeros(model.nu))
    return Robot(make, np.array(qpos), np.array(ctrl), int(model.nv), bool(len(free)))
