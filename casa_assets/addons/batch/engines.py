"""Engines that step a batch: what they can do, which there are, and MuJoCo itself as one of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np

from casa_assets import CasaError, UnknownId
from casa_assets.ext.arrays import Floats, Ints

# Sizes of buffers for a kitchen without `batch.json`: the most of 120 kitchens, with a margin of 1.5.
COMMON_SIZES = {"nconmax": 144, "njmax": 872, "nccdmax": 144, "nvmax": 128}
TRIAL_ROBOT_FREEDOMS = 9  # joints of the robot in the trials that these were counted in, and those in `batch.json`
# Iterations of the solver at most, for engines in single precision: it does not get below its tolerance there and would
# go on to the last. After eight nothing changed any more in three kitchens.
ITERATIONS = 20
# Name of an engine -> what to install for it.
ENGINES = {"mujoco": "mujoco", "mujoco_warp": "mujoco-warp", "mjx": "mujoco-mjx", "newton": "newton mujoco-warp"}


@dataclass(frozen=True)
class Parts:
    """Inputs from which an engine is made; models and texts are of the kitchens, all of one structure.

    `kitchen_of_world`: (worlds,) index. `sizes`: nconmax, njmax, nccdmax and nvmax of a world. `mounted`: a robot is on
    a mocap body, which a reset moves. `ctrl`: (nu,) values that a reset sets. `device`: such as `cuda:0`, None: any.
    """

    models: Sequence[mujoco.MjModel]
    texts: Sequence[str]
    kitchen_of_world: Ints
    sizes: Mapping[str, int]
    mounted: bool
    ctrl: Floats
    device: str | None = None


class Engine(Protocol):
    """Worlds of a batch in an engine, with its own model and data."""

    model: Any
    data: Any

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest.

        Args:
            worlds: (n,) their numbers. qpos: (n, nq). asleep: (n, trees of the kitchen) as MuJoCo's `tree_asleep`.
            mounts: (n, 7) pose of the mocap body that carries a robot: x, y, z (m), quaternion (w, x, y, z).
        """

    def step(self, count: int) -> None:
        """Step all worlds `count` times."""

    @property
    def qpos(self) -> Floats:
        """(worlds, nq)."""

    @property
    def qvel(self) -> Floats:
        """(worlds, nv)."""

    @property
    def bytes_per_world(self) -> int:
        """Memory of the state of a world, without the model and without what an engine holds during a step, bytes."""


def engine_named(name: str) -> Callable[[Parts], Engine]:
    """Return the maker of an engine. Raises UnknownId for an unknown name, CasaError if the engine is not installed."""
    if name not in ENGINES:
        raise UnknownId("engine", name, ENGINES)
    try:
        if name == "mujoco_warp":
            from casa_assets.addons.batch.mujoco_warp_engine import MujocoWarpEngine

            return MujocoWarpEngine
        if name == "mjx":
            from casa_assets.addons.batch.mjx_engine import MjxEngine

            return MjxEngine
        if name == "newton":
            from casa_assets.addons.batch.newton_engine import NewtonEngine

            return NewtonEngine
    except ImportError as error:
        raise CasaError(f"the engine {name} is not installed ({error}): pip install {ENGINES[name]}") from error
    return MujocoEngine


class MujocoEngine(Engine):
    """Steps worlds with MuJoCo itself: one MjModel and MjData each, stepped by as many threads as there are cores."""

    def __init__(self, parts: Parts) -> None:
        self.model: list[mujoco.MjModel] = [parts.models[kitchen] for kitchen in parts.kitchen_of_world]
        self.data: list[mujoco.MjData] = [mujoco.MjData(model) for model in self.model]
        self._mounted, self._ctrl = parts.mounted, parts.ctrl
        self._pool = ThreadPoolExecutor(os.cpu_count())

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
        """Step all worlds `count` times."""

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
