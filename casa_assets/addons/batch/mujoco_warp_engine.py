"""Worlds of a batch in mujoco_warp: one model with a row per kitchen in each array in which kitchens differ."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from casa_assets import CasaError
from casa_assets.addons.batch.engines import ITERATIONS, Engine, Parts
from casa_assets.ext.arrays import Floats, Ints


def bytes_of(*owners: Any) -> int:
    """Memory of the arrays that objects hold as attributes, and the objects that they hold in turn, bytes."""
    total, left, seen = 0, list(owners), set[int]()
    while left:
        value = left.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, wp.array):
            total += int(value.capacity)
        elif type(value).__module__.partition(".")[0] in ("mujoco_warp", "newton"):
            left.extend(vars(value).values())
    return total


def assign_rows(array: Any, rows: Any, values: Floats | Ints) -> None:
    """Write (K, up to M) values into K rows of an (N, M) array on its device, from their first column on."""
    columns = wp.array(np.arange(values.shape[1]), dtype=int, device=array.device)
    found = wp.array(values, dtype=array.dtype, device=array.device)
    wp.copy(wp.indexedarray(array, [rows, columns]), found)


class MujocoWarpEngine(Engine):
    """Steps worlds with mujoco_warp, on a GPU or the processor; world w reads row `w % kitchens` of a model."""

    def __init__(self, parts: Parts) -> None:
        wp.init()
        self._device = wp.get_device(parts.device)
        worlds, first = len(parts.kitchen_of_world), parts.models[0]
        with wp.ScopedDevice(self._device):
            put = [mjw.put_model(model) for model in parts.models]
            self.model: mjw.Model = put[0]
            for name, rows, dtype in _differing(put):
                setattr(self.model, name, wp.array(rows, dtype=dtype))
            # The inertia matrix has rows and columns for what is awake alone.
            awake = min(parts.sizes["nvmax"], int(first.nv))
            self.data: mjw.Data = mjw.make_data(first, nworld=worlds, **{**parts.sizes, "nvmax": awake})
            self.model.opt.iterations = min(self.model.opt.iterations, ITERATIONS)
            self._place_what_stands(parts)
        # A step as a CUDA graph, which reads and writes the arrays that are there when it is recorded.
        self._graph: Any = None
        self._mounted, self._ctrl, self._worlds = parts.mounted, parts.ctrl, worlds

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest; see `Engine`."""
        model, data = self.model, self.data
        with wp.ScopedDevice(self._device):
            chosen = np.zeros(self._worlds, dtype=bool)
            chosen[worlds] = True
            mjw.reset_data(model, data, wp.array(chosen, dtype=bool))
            rows = wp.array(worlds, dtype=int)
            assign_rows(data.qpos, rows, qpos)
            assign_rows(data.ctrl, rows, np.tile(self._ctrl, (len(worlds), 1)))
            if self._mounted:
                assign_rows(data.mocap_pos, rows, mounts[:, None, :3])
                assign_rows(data.mocap_quat, rows, mounts[:, None, 3:])
            # Both say what sleeps, else mujoco_warp takes the difference for a wish to wake up.
            assign_rows(data.tree_asleep, rows, asleep)
            assign_rows(data.tree_awake, rows, np.zeros_like(asleep))

    def _place_what_stands(self, parts: Parts) -> None:
        """Poses of geoms that never move, of each world: mujoco_warp takes them from the one model it is given."""
        placed = []
        for model in parts.models:
            data = mujoco.MjData(model)
            mujoco.mj_kinematics(model, data)
            placed.append((data.geom_xpos, data.geom_xmat.reshape(-1, 3, 3)))
        for number, array in enumerate((self.data.geom_xpos, self.data.geom_xmat)):
            array.assign(np.stack([placed[kitchen][number] for kitchen in parts.kitchen_of_world]).astype(np.float32))

    def step(self, count: int) -> None:
        """Step all worlds `count` times."""
        with wp.ScopedDevice(self._device):
            left = count
            if self._device.is_cuda and self._graph is None and left:
                # Kernels are compiled by a first step; then all launches of a step are recorded and sent at once.
                mjw.step(self.model, self.data)
                left -= 1
                with wp.ScopedCapture() as capture:
                    mjw.step(self.model, self.data)
                self._graph = capture.graph
            for _ in range(left):
                if self._graph is None:
                    mjw.step(self.model, self.data)
                else:
                    wp.capture_launch(self._graph)

    @property
    def qpos(self) -> Floats:
        """(worlds, nq)."""
        return np.asarray(self.data.qpos.numpy(), dtype=np.float64)

    @property
    def qvel(self) -> Floats:
        """(worlds, nv)."""
        return np.asarray(self.data.qvel.numpy(), dtype=np.float64)

    @property
    def bytes_per_world(self) -> int:
        """Arrays of `data`, bytes."""
        return bytes_of(self.data) // self._worlds


def _differing(models: list[Any]) -> Iterator[tuple[str, Floats, Any]]:
    """Name, rows and type of each array in which models differ. Raises CasaError for one that all worlds share."""
    for field in dataclasses.fields(models[0]):
        values = [getattr(model, field.name) for model in models]
        if not isinstance(values[0], wp.array):
            continue
        arrays = [value.numpy() for value in values]
        if all(np.array_equal(arrays[0], other) for other in arrays[1:]):
            continue
        if tuple(getattr(field.type, "shape", ()))[:1] != ("*",):
            raise CasaError(f"kitchens of a batch differ in {field.name}, which mujoco_warp has once for all worlds")
        yield field.name, np.concatenate(arrays), values[0].dtype
