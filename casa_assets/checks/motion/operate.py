"""Operate a written asset in MuJoCo: drop it on the floor, set joints, press keys, read what a runtime measures."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import collision_spec, simulation_warnings, tilt_deg
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.readers.facts import rotations_of
from casa_assets.checks.readers.mujoco_facts import free_bodies, shape_bounds
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.behavior import Stimulus
from casa_assets.model.record import Vec2

# Ref: SimReady Foundation, FET003 base neutral simulation: from twice its height, at rest within 2 cm for 2 s inside 8
# s.
# Deeper than this it has fallen through the floor. Our choice.
TUNNEL_M = 0.1
CACHED_DROPS = 4
# Radius of the fingertip, a sphere; how deep it is pressed into what it touches; height at which it waits; metres.
TIP_RADIUS_M, PRESS_DEPTH_M, WAITING_HEIGHT_M = 0.004, 0.0003, 50.0
# Steps of the approach to a surface; each at worst halves the distance that is left.
APPROACH_STEPS = 12
CACHED_MODELS = 4
TIP = "casa_fingertip"


@dataclass(frozen=True)
class DropProtocol:
    """The drop test, from registry/limits.yaml: from `height_factor` times its height, metres, seconds.

    `rest_m`: diameter of the ball in which its centre of mass stays while it rests, for `rest_s`.
    """

    height_factor: float
    min_height_m: float
    rest_m: float
    rest_s: float
    rate_hz: float
    duration_s: float


@dataclass(frozen=True)
class DropResult:
    """One drop: when its rest began (None: not in time), deepest penetration ever and at the end, and tilt."""

    rest_s: float | None
    deepest_m: float
    rest_m: float
    tilt_deg: float
    warnings: tuple[str, ...]


def drop_on_floor(scene: Path, protocol: DropProtocol) -> DropResult | None:
    """Drop the free body of a scene; None if the scene does not compile or has no free body."""
    model = mujoco_facts.load_mjcf(scene).model
    bodies = [] if model is None else free_bodies(model)
    return _drop(model, bodies[0], protocol) if bodies else None


@lru_cache(maxsize=CACHED_DROPS)
def _drop(shared: mujoco.MjModel, body: int, protocol: DropProtocol) -> DropResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / protocol.rate_hz
    data = mujoco.MjData(model)
    z = int(model.jnt_qposadr[model.body_jntadr[body]]) + 2
    data.qpos[z] += max(protocol.height_factor * _height(model, body), protocol.min_height_m)
    mujoco.mj_forward(model, data)
    before = data.xmat[body].reshape(3, 3).copy()
    path: list[Floats] = []
    deepest, window = 0.0, int(protocol.rest_s * protocol.rate_hz)
    for step in range(int(protocol.duration_s * protocol.rate_hz)):
        mujoco.mj_step(model, data)
        path.append(data.xipos[body].copy())
        deepest = max(deepest, _depth(data))
        if not np.isfinite(data.qpos).all() or (step >= window and _is_at_rest(path[-window:], protocol.rest_m)):
            break
    rest_s = None
    if len(path) > window and np.isfinite(data.qpos).all() and _is_at_rest(path[-window:], protocol.rest_m):
        rest_s = (len(path) - window) / protocol.rate_hz
    tilt = tilt_deg(data.xmat[body].reshape(3, 3) @ before.T)
    return DropResult(rest_s, deepest, _depth(data), tilt, tuple(simulation_warnings(data)))


def _is_at_rest(path: list[Floats], diameter: float) -> bool:
    """True if all points lie in a ball of that diameter, metres."""
    points = np.array(path)
    return bool(np.linalg.norm(points - points.mean(axis=0), axis=1).max() <= diameter / 2)


def _height(model: mujoco.MjModel, root: int) -> float:
    """Height of all colliders of a floating body and what it carries, joints at zero, metres."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    lowest, highest, turns = np.inf, -np.inf, rotations_of(model.geom_quat)
    for geom in np.flatnonzero(model.geom_contype):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) != root:
            continue
        bounds, rotation = shape_bounds(model, int(geom), turns[geom]), data.xmat[body].reshape(3, 3)
        z = (data.xpos[body] + rotation @ bounds.mean(axis=0))[2]
        half = (np.abs(rotation) @ (np.ptp(bounds, axis=0) / 2))[2]
        lowest, highest = min(lowest, z - half), max(highest, z + half)
    return max(0.0, float(highest - lowest))


def _depth(data: mujoco.MjData) -> float:
    """Deepest penetration of all present contacts, metres."""
    return max(0.0, -float(data.contact.dist.min())) if data.ncon else 0.0


@dataclass(frozen=True)
class FingertipModel:
    """An asset without what is only seen, with a fingertip, and the ranges of its joints, rad or m."""

    model: mujoco.MjModel
    ranges: Mapping[str, Vec2]

    def measure(self, positions: Mapping[str, float]) -> Stimulus:
        """Stimulus of the asset with joints at these positions (rad or m, others at zero) and nothing touched."""
        return self._stimulus(self._set_joints(positions), frozenset())

    def press(self, positions: Mapping[str, float], collider: str) -> Stimulus | None:
        """Stimulus while a fingertip touches this collider and no other; None if it cannot reach it."""
        data = self._set_joints(positions)
        # From the front, above, the sides, behind and below, then along the collider's own axes.
        directions = [*np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1]], dtype=float)]
        for axis in data.geom_xmat[self.model.geom(collider).id].reshape(3, 3).T.copy():
            directions += [axis, -axis]
        for direction in directions:
            if self._touched_from(data, collider, direction) == {collider}:
                return self._stimulus(data, frozenset({collider}))
        return None

    def _set_joints(self, positions: Mapping[str, float]) -> mujoco.MjData:
        data = mujoco.MjData(self.model)
        data.mocap_pos[0] = (0.0, 0.0, WAITING_HEIGHT_M)
        for name, value in positions.items():
            low, high = self.ranges[name]
            data.joint(name).qpos[0] = min(max(value, low), high)
        mujoco.mj_forward(self.model, data)
        return data

    def _stimulus(self, data: mujoco.MjData, touched: frozenset[str]) -> Stimulus:
        return Stimulus({name: float(data.joint(name).qpos[0]) for name in self.ranges}, touched)

    def _touched_from(self, data: mujoco.MjData, collider: str, direction: Floats) -> set[str]:
        """Names of what the tip touches once it has come to the collider's middle from a direction."""
        target, tip = self.model.geom(collider).id, self.model.geom(TIP).id
        center = data.geom_xpos[target].copy()
        distance = float(self.model.geom_rbound[target]) + 2 * TIP_RADIUS_M
        for _ in range(APPROACH_STEPS):
            data.mocap_pos[0] = center + distance * direction
            mujoco.mj_kinematics(self.model, data)
            gap = mujoco.mj_geomDistance(self.model, data, target, tip, 1.0, None)
            distance -= gap + PRESS_DEPTH_M
            if distance < 0:
                return set()
        # By distance: MuJoCo makes no contacts with still bodies.
        reach = self.model.geom_rbound + TIP_RADIUS_M
        near = np.linalg.norm(data.geom_xpos - data.geom_xpos[tip], axis=1) <= reach
        others = [int(g) for g in np.flatnonzero(near) if g != tip]
        return {
            self.model.geom(g).name
            for g in others
            if mujoco.mj_geomDistance(self.model, data, g, tip, TIP_RADIUS_M, None) <= 0.0
        }


def fingertip_model(package: Package) -> FingertipModel | None:
    """The model of a package; None if it does not compile, which MJC001 reports."""
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return None
    return _compile(package.mjcf, package.asset.digest)


@lru_cache(maxsize=CACHED_MODELS)
def _compile(path: Path, digest: str) -> FingertipModel:
    assert digest, "names the content of the file in the cache"
    spec = collision_spec(path)
    for key in list(spec.keys):
        spec.delete(key)
    tip = spec.worldbody.add_body(name=TIP, mocap=True)
    tip.add_geom(name=TIP, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[TIP_RADIUS_M, 0, 0])
    model = spec.compile()
    joints = [model.joint(i) for i in range(model.njnt)]
    return FingertipModel(model, {j.name: (float(j.range[0]), float(j.range[1])) for j in joints})
