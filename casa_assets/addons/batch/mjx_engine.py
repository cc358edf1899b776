"""Worlds of a batch in MJX (JAX): one model of which the arrays in which kitchens differ have a row per world."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jp
import mujoco
import numpy as np
from mujoco import mjx

from casa_assets import CasaError
from casa_assets.addons.batch.engines import ITERATIONS, Engine, Parts
from casa_assets.ext.arrays import Floats, Ints


class MjxEngine(Engine):
    """Steps worlds with MJX: `model` has rows per world in `fields`, `data` in each array; `jax.vmap` wants `axes`."""

    def __init__(self, parts: Parts) -> None:
        self._mounted, self._ctrl = parts.mounted, parts.ctrl
        models = [_plain(model) for model in parts.models]
        heaviest = max(models, key=lambda model: int(model.ngravcomp))
        one = mjx.put_model(heaviest)
        self.fields = _differing([mjx.put_model(model) for model in models], one)
        rows = {name: jp.asarray(values)[parts.kitchen_of_world] for name, values in self.fields.items()}
        self.model: mjx.Model = _anywhere(one.tree_replace(rows))
        self.axes = jax.tree.map(lambda _: None, one).tree_replace(dict.fromkeys(rows, 0))
        worlds = len(parts.kitchen_of_world)
        first = mjx.make_data(heaviest)
        self.data: mjx.Data = _anywhere(
            jax.tree.map(lambda array: np.repeat(np.asarray(array)[None], worlds, axis=0), first)
        )
        self._step = jax.jit(partial(_steps, self.axes))

    def reset(self, worlds: Ints, qpos: Floats, asleep: Ints, mounts: Floats) -> None:
        """Put worlds into states at rest; see `Engine`. MJX does not know sleep."""
        data = self.data
        values: dict[str, Any] = {"qpos": data.qpos.at[worlds].set(jp.asarray(qpos))}
        for name in ("qvel", "qacc", "qacc_warmstart", "qfrc_applied", "xfrc_applied", "act", "time"):
            values[name] = getattr(data, name).at[worlds].set(0)
        values["ctrl"] = data.ctrl.at[worlds].set(jp.asarray(self._ctrl))
        if self._mounted:
            values["mocap_pos"] = data.mocap_pos.at[worlds, 0].set(jp.asarray(mounts[:, :3]))
            values["mocap_quat"] = data.mocap_quat.at[worlds, 0].set(jp.asarray(mounts[:, 3:]))
        self.data = data.replace(**values)

    def step(self, count: int) -> None:
        """Step all worlds `count` times."""
        self.data = self._step(self.model, self.data, count)

    @property
    def qpos(self) -> Floats:
        """(worlds, nq)."""
        return np.asarray(self.data.qpos, dtype=np.float64)

    @property
    def qvel(self) -> Floats:
        """(worlds, nv)."""
        return np.asarray(self.data.qvel, dtype=np.float64)

    @property
    def bytes_per_world(self) -> int:
        """Arrays of `data`, bytes."""
        return sum(int(array.nbytes) for array in jax.tree.leaves(self.data)) // int(self.data.qpos.shape[0])


def _steps(axes: Any, model: Any, data: Any, count: Any) -> Any:
    """Return the data of all worlds after `count` steps."""
    step = jax.vmap(mjx.step, in_axes=(axes, 0))
    return jax.lax.fori_loop(0, count, lambda _, state: step(model, state), data)


def _anywhere(tree: Any) -> Any:
    """Return the same arrays, bound to no device, like the arrays that a user adds: JAX then compiles only once."""
    return jax.tree.map(lambda array: jp.asarray(np.asarray(array)), tree)


def _plain(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy without what MJX does not know."""
    plain = copy.copy(model)
    plain.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)  # batch forms switch it on
    plain.opt.iterations = min(plain.opt.iterations, ITERATIONS)
    return plain


def _differing(models: Sequence[Any], first: Any) -> dict[str, Floats]:
    """Array in which models differ -> (kitchens, ...). Raises CasaError for one that is no array of MJX's."""
    found: dict[str, Floats] = {}
    paths = jax.tree_util.tree_flatten_with_path(first)[0]
    leaves = [jax.tree.leaves(model) for model in models]
    for number, (path, _) in enumerate(paths):
        values = [np.asarray(row[number]) for row in leaves]
        if all(np.array_equal(values[0], other) for other in values[1:]):
            continue
        name = "".join(str(part) for part in path).lstrip(".")
        if "[" in name:
            raise CasaError(f"kitchens of a batch differ in {name}, which MJX has once for all worlds")
        found[name] = np.stack(values)
    return found
