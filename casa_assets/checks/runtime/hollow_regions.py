"""Find interior regions without room: a ball laid into each has to come to rest there (HOL001)."""

from __future__ import annotations

import mujoco
import numpy as np

from casa_assets.checks.asset.built import NO_COMPILE, NOT_BUILT, is_fixture_like
from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.motion.collision_only import remove_visuals
from casa_assets.checks.motion.motion_model import STEP_S
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.model.asset.asset import Region

BALL_M = 0.06  # diameter
SHARE = 0.8  # of the least side of a region that is narrower
DROP_M = 0.008
WATCH_S = 1.5
OUTER = frozenset({"main", "bbox"})
SLOW_M_S = 0.05
SUNK_M = 1e-3


def interiors_hold_a_ball(package: Package, limit: float | None) -> Measurement:
    """HOL001: farthest that a ball laid into a region comes to rest outside of it, metres."""
    assert limit is not None
    asset = package.asset
    regions = [r for r in asset.regions if r.name not in OUTER]
    if not regions or not is_fixture_like(asset):
        return not_applicable("it has no region to put things into" if is_fixture_like(asset) else NOT_BUILT)
    if mujoco_load.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    model, data = _with_balls(package, regions)
    mujoco.mj_forward(model, data)
    starts = {r.name: _sunk(model, data, f"ball__{r.name}") for r in regions}
    blocked = _blocked(package, model, regions)
    mujoco.mj_step(model, data, nstep=int(WATCH_S / STEP_S))
    problems, worst = [], 0.0
    for region in regions:
        pointer = f"regions/{region.name}"
        if starts[region.name] > SUNK_M:
            problems.append((pointer, f"is not hollow: a ball of {2 * _radius(region):.3f} m does not fit in"))
            continue
        if region.name in blocked:
            message = (
                f"is filled {blocked[region.name]:.3f} m above its floor: a ball let down from its top does not pass"
            )
            problems.append((pointer, message))
            continue
        off = _outside(model, data, region)
        worst = max(worst, off)
        speed = float(np.linalg.norm(data.body(f"ball__{region.name}").cvel[3:]))
        if off > limit:
            problems.append((pointer, f"a ball laid into it comes to lie {off:.3f} m off its floor or sides"))
        elif speed > SLOW_M_S:
            problems.append((pointer, f"a ball laid into it still moves at {speed:.2f} m/s"))
    return Measurement(worst, tuple(problems))


def _radius(region: Region) -> float:
    return min(BALL_M, SHARE * min(region.size[:2])) / 2


def _with_balls(package: Package, regions: list[Region]) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The asset with a ball just above the floor of each region; balls do not touch each other."""
    spec = mujoco.MjSpec.from_file(str(package.mjcf))
    remove_visuals(spec)
    for key in list(spec.keys):
        spec.delete(key)
    spec.option.timestep = STEP_S
    for region in regions:
        radius = _radius(region)
        world = package.asset.asset_from_link(region.link) @ region.pose
        place = world.apply(np.array([[0.0, 0.0, -region.size[2] / 2 + radius + DROP_M]]))[0]
        body = spec.worldbody.add_body(name=f"ball__{region.name}", pos=place)
        body.add_freejoint()
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius, radius, radius],
            mass=0.05,
            contype=0,
            conaffinity=1,
            condim=6,
            friction=[0.6, 0.02, 0.01],
        )
    model = spec.compile()
    return model, mujoco.MjData(model)


def _blocked(package: Package, model: mujoco.MjModel, regions: list[Region]) -> dict[str, float]:
    """Region name -> height above its floor at which a ball in its middle runs into something, metres."""
    data = mujoco.MjData(model)
    found: dict[str, float] = {}
    ways = {r.name: _column(r) for r in regions}
    for k in range(max(len(way) for way in ways.values())):
        for region in regions:
            at = ways[region.name][min(k, len(ways[region.name]) - 1)]
            world = package.asset.asset_from_link(region.link) @ region.pose
            start = model.jnt_qposadr[model.body_jntadr[model.body(f"ball__{region.name}").id]]
            data.qpos[start : start + 3] = world.apply(np.array([[0.0, 0.0, at - region.size[2] / 2]]))[0]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        for region in regions:
            at = ways[region.name][min(k, len(ways[region.name]) - 1)]
            if _sunk(model, data, f"ball__{region.name}") > SUNK_M:
                found.setdefault(region.name, at)
    return found


def _column(region: Region) -> list[float]:
    """Heights above its floor of a ball on the way from the top of a region to its floor, metres; none overlap less."""
    radius = _radius(region)
    low, high = radius + DROP_M, region.size[2] - radius
    if high <= low:
        return [low]
    return [float(at) for at in np.linspace(high, low, int(np.ceil((high - low) / radius)) + 1)]


def _sunk(model: mujoco.MjModel, data: mujoco.MjData, ball: str) -> float:
    """Depth that a ball sits in something, metres."""
    body = model.body(ball).id
    depths = [-c.dist for c in data.contact[: data.ncon] if body in (model.geom_bodyid[g] for g in c.geom)]
    return max([0.0, *(float(depth) for depth in depths)])


def _outside(model: mujoco.MjModel, data: mujoco.MjData, region: Region) -> float:
    """Distance of a ball at rest from the region: below or above its floor, or beyond its sides, metres."""
    link = data.body(region.link)
    center = data.body(f"ball__{region.name}").xpos
    local = link.xmat.reshape(3, 3).T @ (center - link.xpos)
    point = region.pose.rotation.T @ (local - np.array(region.pose.position))
    half, radius = np.array(region.size) / 2, _radius(region)
    floor = abs(float(point[2]) - radius + float(half[2]))
    if region.kind == "cylinder":
        sides = float(np.linalg.norm(point[:2])) - half[0]
    else:
        sides = float((np.abs(point[:2]) - half[:2]).max())
    return float(max(floor, sides))
