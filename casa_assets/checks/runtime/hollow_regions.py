"""Find interior regions without room: a ball laid into each has to come to rest there (HOL001)."""

from __future__ import annotations

import mujoco
import numpy as np

from casa_assets.checks.check import NO_COMPILE, NOT_BUILT, Measurement, is_fixture_like, not_applicable, not_run
from casa_assets.checks.motion.motion_model import STEP_S
from casa_assets.checks.motion.simulation import collision_spec, find_contacts
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts
from casa_assets.model.asset.asset import Region
from casa_assets.model.pose import Pose

BALL_DIAMETER_M = 0.06
BALL_SHARE = 0.8  # of the least side of a region that is narrower
DROP_HEIGHT_M = 0.008
SIMULATED_S = 1.5
OUTER_REGIONS = frozenset({"main", "bbox"})
MAX_SPEED_M_S = 0.05
MAX_PENETRATION_M = 1e-3


def interiors_hold_a_ball(package: Package, limit: float) -> Measurement:
    """HOL001: farthest that a ball laid into a region comes to rest outside of it, metres."""
    asset = package.asset
    regions = [r for r in asset.regions if r.name not in OUTER_REGIONS]
    if not regions or not is_fixture_like(asset):
        return not_applicable("it has no region to put things into" if is_fixture_like(asset) else NOT_BUILT)
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    model = _model_with_balls(package, regions)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    at_start = {r.name: _penetration(model, data, r) for r in regions}
    blocked = _blocked_heights(package, model, regions)
    mujoco.mj_step(model, data, nstep=int(SIMULATED_S / STEP_S))
    problems, worst = [], 0.0
    for region in regions:
        pointer = f"regions/{region.name}"
        if at_start[region.name] > MAX_PENETRATION_M:
            problems.append((pointer, f"is not hollow: a ball of {2 * _radius(region):.3f} m does not fit in"))
            continue
        if region.name in blocked:
            height = f"{blocked[region.name]:.3f} m above its floor"
            problems.append((pointer, f"is filled {height}: a ball let down from its top does not pass"))
            continue
        distance = _distance_outside(data, region)
        worst = max(worst, distance)
        speed = float(np.linalg.norm(data.body(_ball(region)).cvel[3:]))
        if distance > limit:
            problems.append((pointer, f"a ball laid into it comes to lie {distance:.3f} m off its floor or sides"))
        elif speed > MAX_SPEED_M_S:
            problems.append((pointer, f"a ball laid into it still moves at {speed:.2f} m/s"))
    return Measurement(worst, tuple(problems))


def _ball(region: Region) -> str:
    """Name of the ball of a region in the model."""
    return f"ball__{region.name}"


def _radius(region: Region) -> float:
    return min(BALL_DIAMETER_M, BALL_SHARE * min(region.size[:2])) / 2


def _pose(package: Package, region: Region) -> Pose:
    """world_from_region with every joint at zero."""
    return package.asset.asset_from_link(region.link) @ region.pose


def _model_with_balls(package: Package, regions: list[Region]) -> mujoco.MjModel:
    """The asset with a ball just above the floor of each region; balls do not touch each other."""
    spec = collision_spec(package.mjcf)
    for key in list(spec.keys):
        spec.delete(key)
    spec.option.timestep = STEP_S
    for region in regions:
        radius = _radius(region)
        center = np.array([[0.0, 0.0, -region.size[2] / 2 + radius + DROP_HEIGHT_M]])
        body = spec.worldbody.add_body(name=_ball(region), pos=_pose(package, region).apply(center)[0])
        body.add_freejoint()
        touch = {"contype": 0, "conaffinity": 1, "condim": 6, "friction": [0.6, 0.02, 0.01]}
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, radius, radius], mass=0.05, **touch)
    return spec.compile()


def _blocked_heights(package: Package, model: mujoco.MjModel, regions: list[Region]) -> dict[str, float]:
    """Region name -> height above its floor at which a ball in its middle runs into something, metres."""
    data = mujoco.MjData(model)
    blocked: dict[str, float] = {}
    heights = {r.name: _heights(r) for r in regions}
    for k in range(max(len(column) for column in heights.values())):
        present = {name: column[min(k, len(column) - 1)] for name, column in heights.items()}
        for region in regions:
            center = np.array([[0.0, 0.0, present[region.name] - region.size[2] / 2]])
            start = model.jnt_qposadr[model.body_jntadr[model.body(_ball(region)).id]]
            data.qpos[start : start + 3] = _pose(package, region).apply(center)[0]
        find_contacts(model, data)
        for region in regions:
            if _penetration(model, data, region) > MAX_PENETRATION_M:
                blocked.setdefault(region.name, present[region.name])
    return blocked


def _heights(region: Region) -> list[float]:
    """Heights above its floor of a ball on its way from the top of a region down, a radius apart at most, metres."""
    radius = _radius(region)
    low, high = radius + DROP_HEIGHT_M, region.size[2] - radius
    if high <= low:
        return [low]
    return [float(height) for height in np.linspace(high, low, int(np.ceil((high - low) / radius)) + 1)]


def _penetration(model: mujoco.MjModel, data: mujoco.MjData, region: Region) -> float:
    """Depth at which the ball of a region is in something, metres."""
    body = model.body(_ball(region)).id
    return max([0.0, *(float(-c.dist) for c in data.contact[: data.ncon] if body in model.geom_bodyid[c.geom])])


def _distance_outside(data: mujoco.MjData, region: Region) -> float:
    """Distance of the ball at rest from the region: below or above its floor, or beyond its sides, metres."""
    link = data.body(region.link)
    local = link.xmat.reshape(3, 3).T @ (data.body(_ball(region)).xpos - link.xpos)
    point = region.pose.rotation.T @ (local - np.array(region.pose.position))
    half, radius = np.array(region.size) / 2, _radius(region)
    floor = abs(float(point[2]) - radius + float(half[2]))
    if region.kind == "cylinder":
        sides = float(np.linalg.norm(point[:2])) - half[0]
    else:
        sides = float((np.abs(point[:2]) - half[:2]).max())
    return float(max(floor, sides))
