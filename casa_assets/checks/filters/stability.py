"""Find objects that slide, tip over or cannot be stacked when left alone (FLT)."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.asset.built import NO_COMPILE, is_loose_mesh
from casa_assets.checks.check import Measurement, not_applicable, not_run, required_limit
from casa_assets.checks.filters.welded_surface import NOT_LOOSE
from casa_assets.checks.motion.collision_only import remove_visuals
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Base
from casa_assets.model.registry.category import Affordance, RestingPose

FIXED = "it is fixed in its place"
RATE_HZ = 240
# The steps of a runtime. Slender things jitter more on long ones, on the few points that a hull touches a floor with.
FINE_HZ = 500
# How long a thing that was put down may take to settle, and how long it is then watched, seconds; what moves more than
# this, metres, is watched again in finer steps, up to so many times: what stood on an edge falls late, and then lies.
SETTLE_S, WATCH_S = 4.0, 3.0
QUIET_M, TIMES = 1e-3, 3
# Metres that stand for any way that is longer, for reports hold numbers alone.
FAR = 1e3
# How far above the lower one the upper one is let go, metres, and how long both are left, seconds.
GAP_M, STACK_S = 0.005, 3.0
# How far the upper one may tilt.
TILTED_DEG = 30.0
UPPER, LOWER = "upper_", "lower_"


@dataclass(frozen=True)
class RestResult:
    """Motion of an object that was put down as it stands.

    Attributes:
        tilt_deg: angle between its up axis as it was put and at the end.
        wander_m: farthest that a corner of its box goes while it is watched; the least where it was watched again.
    """

    tilt_deg: float
    wander_m: float


def lies_still(package: Package, limit: float | None) -> Measurement:
    """FLT015: farthest that a corner still moves after the object was put down and has settled, metres."""
    rest = _rest_of(package)
    if rest is None:
        return _unrested(package)
    message = f"{WATCH_S:g} s after it was put down a corner of it still goes {1000 * rest.wander_m:.1f} mm by itself"
    problem = (("scene.xml", f"{message}; mend its collision shapes"),)
    return Measurement(rest.wander_m, problem if not rest.wander_m <= required_limit(limit) else ())


def does_not_fall_over(package: Package, limit: float | None) -> Measurement:
    """FLT016: tilt of the object after it was put down as it stands, degrees."""
    if package.category.upright is not RestingPose.STANDS:
        return not_applicable(f"a {package.category.id} does not stand by itself")
    rest = _rest_of(package)
    if rest is None:
        return _unrested(package)
    message = f"tips over by {rest.tilt_deg:.0f} degrees when it is put down, though a {package.category.id} stands"
    problem = (("scene.xml", f"{message}; look at its pose and its foot"),)
    return Measurement(rest.tilt_deg, problem if not rest.tilt_deg <= required_limit(limit) else ())


def stacks_on_another(package: Package, limit: float | None) -> Measurement:
    """FLT017: offset of a second object let down on the first, in parts of its width."""
    asset = package.asset
    if not is_loose_mesh(asset) or asset.base is not Base.FREE:
        return not_applicable(FIXED if is_loose_mesh(asset) else NOT_LOOSE)
    if not package.category.can(Affordance.STACKABLE):
        return not_applicable(f"nobody stacks a {package.category.id}")
    if mujoco_load.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    off, tilt = _stacked(package.mjcf, tuple(float(v) for v in np.ptp(asset.bounds, axis=0)))
    message = f"another one put on it ends {off:.2f} widths off its middle, tilted by {tilt:.0f} degrees"
    problem = (("model.xml", f"{message}; look at its pose, its foot and its rim"),)
    return Measurement(off, problem if not (off <= required_limit(limit) and tilt <= TILTED_DEG) else ())


def _rest_of(package: Package) -> RestResult | None:
    """None where it cannot move, is no loose mesh, or does not compile."""
    if not is_loose_mesh(package.asset) or package.asset.base is not Base.FREE:
        return None
    model = mujoco_load.load_mjcf(package.scene).model
    low, high = package.asset.bounds
    return None if model is None else _left_alone(model, (*map(float, low), *map(float, high)))


def _unrested(package: Package) -> Measurement:
    """Result where there is no rest to look at, with the reason."""
    if not is_loose_mesh(package.asset) or package.asset.base is not Base.FREE:
        return not_applicable(FIXED if is_loose_mesh(package.asset) else NOT_LOOSE)
    return not_run("scene.xml does not compile")


@lru_cache(maxsize=4)
def _left_alone(shared: mujoco.MjModel, box: tuple[float, ...]) -> RestResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / RATE_HZ
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = int(model.jnt_bodyid[int(np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)[0])])
    upright = data.xmat[body].reshape(3, 3).copy()
    corners = np.array([[x, y, z] for x in box[::3] for y in box[1::3] for z in box[2::3]])
    mujoco.mj_step(model, data, nstep=int(SETTLE_S * RATE_HZ))
    wander = FAR
    for _ in range(TIMES):
        wander = min(wander, _watched(model, data, body, corners))
        if wander <= QUIET_M:
            break
        model.opt.timestep = 1.0 / FINE_HZ
    return RestResult(_tilt_deg(data.xmat[body].reshape(3, 3) @ upright.T), wander)


def _watched(model: mujoco.MjModel, data: mujoco.MjData, body: int, corners: Floats) -> float:
    """Farthest that a corner goes in the time that it is watched, metres; `FAR` where that cannot be told."""
    start, wander = _placed(data, body, corners), 0.0
    for _ in range(int(WATCH_S / model.opt.timestep / 8)):
        mujoco.mj_step(model, data, nstep=8)
        wander = max(wander, float(np.linalg.norm(_placed(data, body, corners) - start, axis=1).max()))
    return min(wander, FAR) if np.isfinite(data.qpos).all() else FAR


def _placed(data: mujoco.MjData, body: int, corners: Floats) -> Floats:
    placed: Floats = data.xpos[body] + corners @ data.xmat[body].reshape(3, 3).T
    return placed


def _tilt_deg(turn: Floats) -> float:
    return math.degrees(math.acos(min(1.0, max(-1.0, float(turn[2, 2])))))


def _stacked(mjcf: Path, size: tuple[float, ...]) -> tuple[float, float]:
    """Offset of the upper object from the lower one, in parts of its width, and its tilt, degrees."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / RATE_HZ
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], friction=[0.6, 0.005, 0.0001])
    for prefix, height in ((LOWER, 0.0), (UPPER, size[2] + GAP_M)):
        one = mujoco.MjSpec.from_file(str(mjcf))
        remove_visuals(one)
        frame = spec.worldbody.add_frame(pos=[0, 0, height])
        frame.attach_body(one.body("object"), prefix, "").add_freejoint()
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=int(STACK_S * RATE_HZ))
    upper, lower = data.body(f"{UPPER}object"), data.body(f"{LOWER}object")
    beside = np.linalg.norm((upper.xpos - lower.xpos)[:2]) / max(size[:2])
    # What lies on the floor beside the other one, or under it, is not on it: it counts as a width farther off.
    below = 1.0 if float(upper.xpos[2]) <= float(lower.xpos[2]) else 0.0
    return min(float(np.nan_to_num(beside, nan=FAR)), FAR) + below, _tilt_deg(upper.xmat.reshape(3, 3))
