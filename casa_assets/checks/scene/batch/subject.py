"""The batch form of a scene as MuJoCo has it, beside the light form that it is held against."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import START, reset_to_start
from casa_assets.checks.readers.mujoco_load import Loaded, load_asset_file
from casa_assets.checks.scene.formats.files import LIGHT_FILE
from casa_assets.core.typing import Mask
from casa_assets.model.kitchen.batch_scene import BatchScene

BATCH_FILE = "scene_batch.xml"
UNREADABLE = "MuJoCo cannot read scene_batch.xml (BAT001)"


@dataclass(frozen=True, eq=False)
class BatchSubject:
    """A batch form and the folder of its kitchen; each file is read once, and a subject is equal to itself alone.

    Attributes:
        form: what the writer was given. root: the folder, with `scene_light.xml` and `scene_batch.xml`.
    """

    form: BatchScene
    root: Path

    @cached_property
    def batch(self) -> Loaded:
        """The batch form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.root / BATCH_FILE)

    @cached_property
    def light(self) -> Loaded:
        """The light form compiled."""
        return load_asset_file(self.root / LIGHT_FILE)

    @cached_property
    def models(self) -> tuple[mujoco.MjModel, mujoco.MjModel] | None:
        """The batch and the light form; None where one of them does not load."""
        batch, light = self.batch.model, self.light.model
        return None if batch is None or light is None else (batch, light)

    @cached_property
    def colliding(self) -> Mask:
        """(ngeom,) which geoms of the batch form touch anything. Raises ValueError where it does not load."""
        model = self.batch.model
        if model is None:
            raise ValueError(self.batch.error)
        return np.asarray((model.geom_contype | model.geom_conaffinity) != 0, dtype=bool)


@contextmanager
def awake(model: mujoco.MjModel) -> Iterator[mujoco.MjData]:
    """The scene as it begins, with nothing asleep while the block lasts."""
    saved = int(model.opt.enableflags)
    model.opt.enableflags = saved & ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    try:
        data = mujoco.MjData(model)
        reset_to_start(model, data)
        mujoco.mj_forward(model, data)
        yield data
    finally:
        model.opt.enableflags = saved


def pose_both(batch: mujoco.MjModel, light: mujoco.MjModel, key: str) -> tuple[mujoco.MjData, mujoco.MjData]:
    """Both forms in a named pose, without dynamics; joints that are locked in the batch form are as at the start.

    Args:
        key: name of a keyframe of both.
    """
    of_light, at_start = mujoco.MjData(light), mujoco.MjData(light)
    mujoco.mj_resetDataKeyframe(light, of_light, light.key(key).id)
    mujoco.mj_resetDataKeyframe(light, at_start, light.key(START).id)
    names = {str(batch.joint(number).name) for number in range(batch.njnt)}
    of_batch = mujoco.MjData(batch)
    for number in range(light.njnt):
        name, first = str(light.joint(number).name), int(light.jnt_qposadr[number])
        size = 7 if light.jnt_type[number] == mujoco.mjtJoint.mjJNT_FREE else 1
        if name not in names:
            of_light.qpos[first : first + size] = at_start.qpos[first : first + size]
            continue
        to = int(batch.jnt_qposadr[batch.joint(name).id])
        of_batch.qpos[to : to + size] = of_light.qpos[first : first + size]
    for model, data in ((batch, of_batch), (light, of_light)):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    return of_batch, of_light
