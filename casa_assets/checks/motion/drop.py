"""Drop an asset on the floor of its `scene.xml` and record how it comes to rest.

Ref: SimReady Foundation, FET003 base neutral simulation: from twice its height, at rest within 2 cm for 2 s inside 8 s.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import simulation_warnings, tilt_deg
from casa_assets.checks.readers import mujoco_load
from casa_assets.checks.readers.mujoco_facts import free_bodies, rotations_of, shape_bounds
from casa_assets.core.typing import Floats

# Deeper than this it has fallen through the floor. Our choice.
TUNNEL_M = 0.1
CACHED_DROPS = 4


@dataclass(frozen=True)
class DropProtocol:
    """Parameters of the drop test, from registry/limits.yaml.

    Attributes:
        height_factor: height of the drop over that of the asset. min_height_m: least height of the drop, metres.
        rest_m: diameter of the ball in which its centre of mass stays while it rests. rest_s: for how long, seconds.
        rate_hz: steps per second. duration_s: simulated time.
    """

    height_factor: float
    min_height_m: float
    rest_m: float
    rest_s: float
    rate_hz: float
    duration_s: float


@dataclass(frozen=True)
class DropResult:
    """Result of one drop test.

    Attributes:
        rest_s: when its rest began, seconds after the release; None if it did not come to rest in time.
        deepest_m: deepest penetration at any moment.
        rest_m: deepest penetration at the end, once at rest.
        tilt_deg: angle between its up axis before and after.
        warnings: of the simulator.
    """

    rest_s: float | None
    deepest_m: float
    rest_m: float
    tilt_deg: float
    warnings: tuple[str, ...]


def drop_on_floor(scene: Path, protocol: DropProtocol) -> DropResult | None:
    """Drop the free body of a scene; None if the scene does not compile or has no free body."""
    model = mujoco_load.load_mjcf(scene).model
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
