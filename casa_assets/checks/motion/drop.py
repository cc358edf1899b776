"""Drop an asset on the floor of its own scene and record how it comes to rest.

Ref: SimReady Foundation, FET003 base neutral simulation: from twice its height, at rest within 2 cm for 2 s inside 8 s.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.readers import mujoco_load
from casa_assets.checks.readers.mujoco_facts import shape_bounds

# Deeper than this it has fallen through.
TUNNEL_M = 0.1

KEPT = 4


@dataclass(frozen=True)
class DropProtocol:
    """Parameters of the drop test, from registry/limits.yaml.

    Attributes:
        height_factor: height of the drop over that of the thing. least_height_m: the least height, metres.
        rest_m: ball in which its centre of mass stays while it rests, diameter in metres. rest_s: for so long.
        rate_hz: steps per second. limit_s: for how long it is watched.
    """

    height_factor: float
    least_height_m: float
    rest_m: float
    rest_s: float
    rate_hz: float
    limit_s: float


@dataclass(frozen=True)
class DropResult:
    """Result of one drop test.

    Attributes:
        rest_s: when its rest began, seconds after the release; None where it did not rest in time.
        deepest_m: deepest penetration at any moment.
        rest_m: deepest penetration at the end, once at rest.
        tilt_deg: angle between its up axis before and after.
        troubles: what the simulator complained of.
    """

    rest_s: float | None
    deepest_m: float
    rest_m: float
    tilt_deg: float
    troubles: tuple[str, ...]


def drop_on_floor(scene: Path, protocol: DropProtocol) -> DropResult | None:
    """Drop the free body of a scene; None where the scene does not compile or has no free body."""
    model = mujoco_load.load_mjcf(scene).model
    joint = None if model is None else _free_joint(model)
    return None if joint is None else _drop(model, joint, protocol)


@lru_cache(maxsize=KEPT)
def _drop(shared: mujoco.MjModel, joint: int, protocol: DropProtocol) -> DropResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / protocol.rate_hz
    data = mujoco.MjData(model)
    body, start = int(model.jnt_bodyid[joint]), int(model.jnt_qposadr[joint])
    data.qpos[start + 2] += max(protocol.height_factor * _height(model, body), protocol.least_height_m)
    mujoco.mj_forward(model, data)
    up = data.xmat[body].reshape(3, 3).copy()
    path: list[npt.NDArray[np.float64]] = []
    deepest, window = 0.0, int(protocol.rest_s * protocol.rate_hz)
    rest_s = None
    for step in range(int(protocol.limit_s * protocol.rate_hz)):
        mujoco.mj_step(model, data)
        path.append(data.xipos[body].copy())
        deepest = max(deepest, _depth(data))
        if not np.isfinite(data.qpos).all() or (step >= window and _quiet(path[-window:], protocol.rest_m)):
            break
    if len(path) > window and np.isfinite(data.qpos).all() and _quiet(path[-window:], protocol.rest_m):
        rest_s = (len(path) - window) / protocol.rate_hz
    # The body's turn takes its old up axis to the new one.
    turned = (data.xmat[body].reshape(3, 3) @ up.T)[2, 2]
    tilt = math.degrees(math.acos(min(1.0, max(-1.0, float(turned)))))
    return DropResult(rest_s, deepest, _depth(data), tilt, _troubles(data))


def _quiet(path: list[npt.NDArray[np.float64]], width: float) -> bool:
    """True if all points lie in a ball of that width, metres."""
    points = np.array(path)
    return bool(np.linalg.norm(points - points.mean(axis=0), axis=1).max() <= width / 2)


def _free_joint(model: mujoco.MjModel) -> int | None:
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    return int(free[0]) if len(free) else None


def _height(model: mujoco.MjModel, root: int) -> float:
    """Height of all colliders of a floating body and what it carries, joints at zero, metres."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    low, high = math.inf, -math.inf
    for geom in np.flatnonzero(model.geom_contype):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) != root:
            continue
        centre, half = shape_bounds(model, int(geom)).mean(axis=0), np.ptp(shape_bounds(model, int(geom)), axis=0) / 2
        rotation = data.xmat[body].reshape(3, 3)
        z, reach = (data.xpos[body] + rotation @ centre)[2], (np.abs(rotation) @ half)[2]
        low, high = min(low, z - reach), max(high, z + reach)
    return max(0.0, high - low)


def _depth(data: mujoco.MjData) -> float:
    """Deepest penetration of all present contacts, metres."""
    return max(0.0, -float(data.contact.dist.min())) if data.ncon else 0.0


def _troubles(data: mujoco.MjData) -> tuple[str, ...]:
    kinds = {int(k): k.name.removeprefix("mjWARN_").lower() for k in mujoco.mjtWarning.__members__.values()}
    return tuple(f"{kinds[i]} x {w.number}" for i, w in enumerate(data.warning) if w.number)
