"""Worlds of a batch in Newton, with its MuJoCo solver: each world is added by itself, all of one structure."""

from __future__ import annotations

from typing import Any

import mujoco
import newton
import numpy as np
import warp as wp

from casa_assets.addons.batch.engines import ITERATIONS, Parts
from casa_assets.addons.batch.mujoco_warp_engine import assign_rows, bytes_of
from casa_assets.ext.arrays import Floats, Ints
from casa_assets.ext.kitchens import FREE_WIDTH

_TO_NEWTON, _FROM_NEWTON = (1, 2, 3, 0), (3, 0, 1, 2)  # quaternions: (w, x, y, z) here, (x, y, z, w) in Newton


class NewtonEngine:
    """Steps worlds with Newton, on a GPU or the processor; `data` is the State that the last step ended in."""

    def __init__(self, parts: Parts) -> None:
        wp.init()
        self._worlds, self._timestep = len(parts.kitchen_of_world), float(parts.models[0].opt.timestep)
        kitchens = [_builder(text) for text in parts.texts]
        builder = newton.ModelBuilder()
        newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
        for kitchen in parts.kitchen_of_world:
            builder.add_world(kitchens[kitchen])
        self.model = builder.finalize(device=parts.device)
        sizes = {"nconmax": parts.sizes["nconmax"], "njmax": parts.sizes["njmax"]}
        self.solver = newton.solvers.SolverMuJoCo(self.model, iterations=ITERATIONS, enable_multiccd=True, **sizes)
        self.data, self._after, self.control = self.model.state(), self.model.state(), self.model.control()
        first = parts.models[0]
        # Where the positions of free joints begin in qpos.
        self._free = first.jnt_qposadr[first.jnt_type == mujoco.mjtJoint.mjJNT_FREE].tolist()

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest; see `Engine`. Bodies at rest are not put to sleep."""
        rows = wp.array(worlds, dtype=int, device=self.data.joint_q.device)
        speeds = self.data.joint_qd.reshape((self._worlds, -1))
        assign_rows(self.data.joint_q.reshape((self._worlds, -1)), rows, self._turned(qpos, _TO_NEWTON))
        assign_rows(speeds, rows, np.zeros((len(worlds), speeds.shape[1])))
        newton.eval_fk(self.model, self.data.joint_q, self.data.joint_qd, self.data)

    def step(self, count: int) -> None:
        """Step all worlds `count` times."""
        for _ in range(count):
            self.solver.step(self.data, self._after, self.control, None, self._timestep)
            self.data, self._after = self._after, self.data

    @property
    def qpos(self) -> Floats:
        """(worlds, nq) as MuJoCo has them."""
        rows = np.asarray(self.data.joint_q.numpy(), dtype=np.float64).reshape(self._worlds, -1)
        return self._turned(rows, _FROM_NEWTON)

    @property
    def qvel(self) -> Floats:
        """(worlds, nv) as Newton has them."""
        return np.asarray(self.data.joint_qd.numpy(), dtype=np.float64).reshape(self._worlds, -1)

    @property
    def bytes_per_world(self) -> int:
        """Arrays of both states, of the control and of the solver's data, bytes."""
        return bytes_of(self.data, self._after, self.control, self.solver.mjw_data) // self._worlds

    def _turned(self, rows: Floats, order: tuple[int, ...]) -> Floats:
        """Rows with the numbers of their quaternions in another order."""
        turned = np.array(rows)
        for first in self._free:
            turned[:, first + 3 : first + FREE_WIDTH] = rows[:, [first + 3 + number for number in order]]
        return turned


def _builder(text: str) -> Any:
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    # Newton looks for contacts 0.1 m ahead by default, and the buffers have no room for all of them.
    builder.rigid_gap = builder.default_shape_cfg.gap = 0.0
    builder.add_mjcf(text)
    return builder
