"""Worlds of a batch in MuJoCo itself: one MjData each, stepped by as many threads as there are cores."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mujoco
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.pipeline.batches.engine import Parts


class MujocoEngine:
    """Steps worlds with MuJoCo.

    Attributes:
        model: list with the model of each world. data: list with the state of each.
    """

    def __init__(self, parts: Parts) -> None:
        self.model = [parts.models[kitchen] for kitchen in parts.kitchen_of_world]
        self.data = [mujoco.MjData(model) for model in self.model]
        self._mounted, self._ctrl = parts.mounted, parts.ctrl
        self._pool = ThreadPoolExecutor(os.cpu_count())

    @property
    def control(self) -> Any:
        """The same as `data`."""
        return self.data

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest; see `Engine`. MuJoCo finds out by itself in ten steps that they are."""
        for world, row, mount in zip(worlds, qpos, mounts, strict=True):
            model, data = self.model[world], self.data[world]
            mujoco.mj_resetData(model, data)
            data.qpos[:] = row
            if self._mounted:
                data.mocap_pos[0], data.mocap_quat[0] = mount[:3], mount[3:]
            data.ctrl[:] = self._ctrl
            mujoco.mj_forward(model, data)

    def step(self, count: int) -> None:
        """Step all worlds so many times."""

        def step(world: int) -> None:
            mujoco.mj_step(self.model[world], self.data[world], nstep=count)

        list(self._pool.map(step, range(len(self.data))))

    @property
    def qpos(self) -> Floats:
        """(worlds, nq)."""
        return np.stack([data.qpos for data in self.data])

    @property
    def qvel(self) -> Floats:
        """(worlds, nv)."""
        return np.stack([data.qvel for data in self.data])

    @property
    def bytes_per_world(self) -> int:
        """Buffer of an MjData, and the most of its arena that was used so far, bytes."""
        return max(int(data.nbuffer) + int(data.maxuse_arena) for data in self.data)
