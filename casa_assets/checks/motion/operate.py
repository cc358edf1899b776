"""Operate a written asset in MuJoCo with a fingertip: set joints, press keys, read what a runtime measures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.motion.collision_only import remove_visuals
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.checks.runtime.behavior_interpreter import Stimulus
from casa_assets.model.record import Vec2

# A fingertip, as a sphere; how deep it goes in where it touches; where it waits; metres.
TIP_M, PRESSED_M, AWAY_M = 0.004, 0.0003, 50.0
# Steps after which the way to a surface has been found: each halves what is left at worst.
STEPS = 12
KEPT = 4
TIP = "casa_fingertip"


@dataclass(frozen=True)
class FingertipModel:
    """A model with a fingertip.

    Attributes:
        model: the asset, without what is only seen.
        ranges: of its joints as the file says them, rad or m.
    """

    model: mujoco.MjModel
    ranges: Mapping[str, Vec2]

    def measure(self, stands: Mapping[str, float]) -> Stimulus:
        """Stimulus of the asset with joints at these values (rad or m, others at zero) and nothing touched."""
        return Stimulus(self._joints(self._posed(stands)))

    def press(self, stands: Mapping[str, float], collider: str) -> Stimulus | None:
        """Stimulus while a fingertip touches this collider and no other; None where it cannot get at it."""
        data = self._posed(stands)
        for direction in _directions(self.model, data, collider):
            touched = self._touched(data, collider, direction)
            if touched == {collider}:
                return Stimulus(self._joints(data), frozenset(touched))
        return None

    def _posed(self, stands: Mapping[str, float]) -> mujoco.MjData:
        data = mujoco.MjData(self.model)
        data.mocap_pos[0] = (0.0, 0.0, AWAY_M)
        for name, value in stands.items():
            low, high = self.ranges[name]
            data.joint(name).qpos[0] = min(max(value, low), high)
        mujoco.mj_forward(self.model, data)
        return data

    def _joints(self, data: mujoco.MjData) -> dict[str, float]:
        return {name: float(data.joint(name).qpos[0]) for name in self.ranges}

    def _touched(self, data: mujoco.MjData, collider: str, direction: npt.NDArray[np.float64]) -> set[str]:
        """Names of what the tip touches once it has come to the collider's middle from a direction."""
        target, tip = self.model.geom(collider).id, self.model.geom(TIP).id
        middle = data.geom_xpos[target].copy()
        away = float(self.model.geom_rbound[target]) + 2 * TIP_M
        for _ in range(STEPS):
            data.mocap_pos[0] = middle + away * direction
            mujoco.mj_kinematics(self.model, data)
            gap = mujoco.mj_geomDistance(self.model, data, target, tip, 1.0, None)
            away -= gap + PRESSED_M
            if away < 0:
                return set()
        return self._met(data, tip)

    def _met(self, data: mujoco.MjData, tip: int) -> set[str]:
        """Names of the geoms that the tip reaches into. Contacts would not do: a tip and a still body make none."""
        reach = self.model.geom_rbound + TIP_M
        near = np.linalg.norm(data.geom_xpos - data.geom_xpos[tip], axis=1) <= reach
        others = [int(g) for g in np.flatnonzero(near) if g != tip]
        return {
            self.model.geom(g).name
            for g in others
            if mujoco.mj_geomDistance(self.model, data, g, tip, TIP_M, None) <= 0.0
        }


def fingertip_model(package: Package) -> FingertipModel | None:
    """The model of a package; None where it does not compile, which MJC001 says."""
    if mujoco_load.load_mjcf(package.mjcf).error:
        return None
    return _operated(package.mjcf, package.asset.digest)


@lru_cache(maxsize=KEPT)
def _operated(path: Path, digest: str) -> FingertipModel:
    assert digest, "names the content of the file in the cache"
    spec = mujoco.MjSpec.from_file(str(path))
    remove_visuals(spec)
    for key in list(spec.keys):
        spec.delete(key)
    tip = spec.worldbody.add_body(name=TIP, mocap=True)
    tip.add_geom(name=TIP, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[TIP_M, 0, 0])
    model = spec.compile()
    joints = [model.joint(i) for i in range(model.njnt)]
    return FingertipModel(model, {j.name: (float(j.range[0]), float(j.range[1])) for j in joints})


def _directions(model: mujoco.MjModel, data: mujoco.MjData, collider: str) -> Iterator[npt.NDArray[np.float64]]:
    """Ways to come from: the front, above, the sides, behind and below, then along the collider's own axes."""
    yield from np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1]], dtype=float)
    axes = data.geom_xmat[model.geom(collider).id].reshape(3, 3).T.copy()
    for axis in axes:
        yield axis
        yield -axis
