"""Find objects that slide, tip over or cannot be stacked when left alone (FLT)."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.check import NO_COMPILE, Measurement, at_most, is_loose_mesh, not_applicable, not_run
from casa_assets.checks.filters.surface import NOT_LOOSE
from casa_assets.checks.motion.simulation import collision_spec, tilt_deg
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.readers.mujoco_facts import free_bodies
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.registry.category import Affordance, RestingPose

RATE_HZ = 240
# The steps of a runtime. Slender things jitter more on long ones, on the few points that a hull touches a floor with.
FINE_RATE_HZ = 500
# How long an object may take to settle, and how long it is then watched, seconds.
SETTLE_S, WATCH_S = 4.0, 3.0
# What moves more than this is watched again in finer steps, three times in all: an object that was put down on an edge
# falls late, and then lies still.
STILL_M, MAX_WATCHES = 1e-3, 3
# Stands for any longer way, and for one that is no number, because reports hold finite numbers.
FAR_M = 1e3
# Height above the lower object at which the upper one is let go, metres, and how long both are simulated, seconds.
STACK_GAP_M, STACK_S = 0.005, 3.0
MAX_STACK_TILT_DEG = 30.0
UPPER, LOWER = "upper_", "lower_"


@dataclass(frozen=True)
class RestResult:
    """Motion of an object that was put down in its given pose.

    Attributes:
        tilt_deg: angle between its up axis when put down and at the end.
        drift_m: largest distance that a corner of its box moves while it is watched; the least if it was watched again.
    """

    tilt_deg: float
    drift_m: float


def lies_still(package: Package, limit: float) -> Measurement:
    """FLT015: farthest that a corner still moves after the object was put down and has settled, metres."""
    rest = _rest_of(package)
    if isinstance(rest, Measurement):
        return rest
    message = f"{WATCH_S:g} s after it was put down a corner of it still goes {1000 * rest.drift_m:.1f} mm by itself"
    return at_most(rest.drift_m, limit, "scene.xml", f"{message}; correct its collision shapes")


def does_not_fall_over(package: Package, limit: float) -> Measurement:
    """FLT016: tilt of the object after it was put down in its given pose, degrees."""
    category = package.category
    if category.upright is not RestingPose.STANDS:
        return not_applicable(f"a {category.id} does not stand by itself")
    rest = _rest_of(package)
    if isinstance(rest, Measurement):
        return rest
    message = f"tips over by {rest.tilt_deg:.0f} degrees when it is put down, though a {category.id} stands"
    return at_most(rest.tilt_deg, limit, "scene.xml", f"{message}; look at its pose and its foot")


def stacks_on_another(package: Package, limit: float) -> Measurement:
    """FLT017: offset of a second object let down on the first, in parts of its width."""
    asset = package.asset
    if not _is_free_mesh(asset):
        return _not_a_free_mesh(asset)
    if not package.category.can(Affordance.STACKABLE):
        return not_applicable(f"nobody stacks a {package.category.id}")
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    offset, tilt = _stack(package.mjcf, np.ptp(asset.bounds, axis=0))
    message = f"another one put on it ends {offset:.2f} widths off its middle, tilted by {tilt:.0f} degrees"
    problems = (("model.xml", f"{message}; look at its pose, its foot and its rim"),)
    return Measurement(offset, () if offset <= limit and tilt <= MAX_STACK_TILT_DEG else problems)


def _is_free_mesh(asset: Asset) -> bool:
    return is_loose_mesh(asset) and asset.base is Base.FREE


def _not_a_free_mesh(asset: Asset) -> Measurement:
    return not_applicable("it is fixed in its place" if is_loose_mesh(asset) else NOT_LOOSE)


def _rest_of(package: Package) -> RestResult | Measurement:
    """Motion of a loose mesh on the floor of its scene, or the result of a check that has none to look at."""
    if not _is_free_mesh(package.asset):
        return _not_a_free_mesh(package.asset)
    model = mujoco_facts.load_mjcf(package.scene).model
    if model is None:
        return not_run("scene.xml does not compile")
    lower, upper = package.asset.bounds
    return _simulate_rest(model, (*map(float, lower), *map(float, upper)))


@lru_cache(maxsize=4)
def _simulate_rest(shared: mujoco.MjModel, box: tuple[float, ...]) -> RestResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / RATE_HZ
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = free_bodies(model)[0]
    before = data.xmat[body].reshape(3, 3).copy()
    corners = np.array([[x, y, z] for x in box[::3] for y in box[1::3] for z in box[2::3]])
    mujoco.mj_step(model, data, nstep=int(SETTLE_S * RATE_HZ))
    drift = FAR_M
    for _ in range(MAX_WATCHES):
        drift = min(drift, _drift(model, data, body, corners))
        if drift <= STILL_M:
            break
        model.opt.timestep = 1.0 / FINE_RATE_HZ
    return RestResult(tilt_deg(data.xmat[body].reshape(3, 3) @ before.T), drift)


def _drift(model: mujoco.MjModel, data: mujoco.MjData, body: int, corners: Floats) -> float:
    """Largest distance that a corner moves in the watched time, metres; at most `FAR_M`, and that if it diverges."""
    start, drift = _world(data, body, corners), 0.0
    for _ in range(int(WATCH_S / model.opt.timestep / 8)):
        mujoco.mj_step(model, data, nstep=8)
        drift = max(drift, float(np.linalg.norm(_world(data, body, corners) - start, axis=1).max()))
    return min(drift, FAR_M) if np.isfinite(data.qpos).all() else FAR_M


def _world(data: mujoco.MjData, body: int, points: Floats) -> Floats:
    """(N, 3) points of a body in the world frame, metres."""
    world: Floats = data.xpos[body] + points @ data.xmat[body].reshape(3, 3).T
    return world


def _stack(mjcf: Path, size: Floats) -> tuple[float, float]:
    """Offset of the upper object from the lower one, in parts of its width, and its tilt, degrees.

    Args:
        mjcf: the object. size: (3,) of its box, metres.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / RATE_HZ
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], friction=[0.6, 0.005, 0.0001])
    for prefix, height in ((LOWER, 0.0), (UPPER, float(size[2]) + STACK_GAP_M)):
        frame = spec.worldbody.add_frame(pos=[0, 0, height])
        frame.attach_body(collision_spec(mjcf).body("object"), prefix, "").add_freejoint()
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=int(STACK_S * RATE_HZ))
    upper, lower = data.body(f"{UPPER}object"), data.body(f"{LOWER}object")
    aside = np.linalg.norm((upper.xpos - lower.xpos)[:2]) / max(size[:2])
    # What lies on the floor beside the other one, or under it, is not on it: it counts as a width farther off.
    below = 1.0 if float(upper.xpos[2]) <= float(lower.xpos[2]) else 0.0
    return min(float(np.nan_to_num(aside, nan=FAR_M)), FAR_M) + below, tilt_deg(upper.xmat.reshape(3, 3))
