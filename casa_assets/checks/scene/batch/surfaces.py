"""Hold the surfaces of the batch form, and the room inside of things, against the light form."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, all_at_most, not_applicable, not_run
from casa_assets.checks.motion.simulation import START
from casa_assets.checks.readers.mujoco_facts import free_bodies
from casa_assets.checks.scene.batch.form import BATCH_FILE, UNREADABLE, BatchSubject, pose_both
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.asset.asset import Asset, Base, Region
from casa_assets.model.kitchen.scene import OPEN_POSE, Placement
from casa_assets.model.pose import Pose

# Points in the room, and rays from each, in each pose; all drawn from the same seed.
POINTS, RAYS, SEED = 60, 400, 0
# Heights of the points above the floor, metres, and how far they are from anything at least.
LOWEST_M, HIGHEST_M, CLEAR_M = 0.2, 1.9, 0.03
FARTHEST_M = 30.0
# Rays that meet something nearer or farther by more than this are off, metres.
OFF_M = 0.005
# What rays may meet: regions are in group 5.
GROUPS = np.array([1, 1, 1, 1, 1, 0], dtype=np.uint8)
# Points along each axis of a region.
REGION_POINTS = 9
# Thickness of the walls of a drawer, of which the middles are known, metres.
BLOCK_MARGIN_M = 0.03
# Region around a whole asset.
WHOLE = "main"
# Category of floors.
FLOOR = "floor"


def surfaces_are_kept(subject: BatchSubject, limit: float) -> Measurement:
    """BAT007: share of rays from points in the room that meet the batch form elsewhere than the light one, 0..1.

    As the kitchen begins and with all open that is not locked; the larger share of the two.
    """
    if subject.models is None:
        return not_run(UNREADABLE)
    batch, light = subject.models
    assets = subject.form.scene.asset_of
    floors = [name for name, asset in assets.items() if asset.labels.category == FLOOR]
    if not floors:
        return not_applicable("it has no floor to stand on")
    shares = {key: _share_off(batch, light, key, f"{floors[0]}__") for key in (START, OPEN_POSE)}
    message = "{:.1%} of rays meet it more than 5 mm nearer or farther than the light form"
    numbers = {f"{BATCH_FILE} {key}": share for key, share in shares.items()}
    return all_at_most(numbers, limit, message, "it has no floor to stand on")


def _share_off(batch: mujoco.MjModel, light: mujoco.MjModel, key: str, floor_name: str) -> float:
    """Share of rays, in a named pose, that are off.

    Args:
        floor_name: what the names of the floor's geoms begin with.
    """
    forms = list(zip((batch, light), pose_both(batch, light, key), strict=True))
    floor = next(number for number in range(light.ngeom) if str(light.geom(number).name).startswith(floor_name))
    center, half = forms[1][1].geom_xpos[floor], light.geom_size[floor]
    rng = np.random.default_rng(SEED)
    off = list[float]()
    # Some points are in a wall or a cupboard; a room has many more that are not.
    for _ in range(POINTS * 50):
        along = rng.uniform(-1.0, 1.0, 2) * (half[:2] - CLEAR_M)
        point = np.array([*(center[:2] + along), rng.uniform(LOWEST_M, HIGHEST_M)])
        rays = rng.normal(size=(RAYS, 3))
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        if not _is_above(*forms[1], point, floor_name):
            continue
        met = [_distances(model, data, point, rays) for model, data in forms]
        if min(float(distances.min()) for distances in met) < CLEAR_M:
            continue
        off.append(float((np.abs(met[0] - met[1]) > OFF_M).mean()))
        if len(off) == POINTS:
            break
    return float(np.mean(off))


def _is_above(model: mujoco.MjModel, data: mujoco.MjData, point: Floats, floor_name: str) -> bool:
    """True if the first thing straight below a point is the floor."""
    geom = np.zeros(1, dtype=np.int32)
    mujoco.mj_ray(model, data, point, np.array([0.0, 0.0, -1.0]), GROUPS, 1, -1, geom)
    return bool(geom[0] >= 0) and str(model.geom(int(geom[0])).name).startswith(floor_name)


def _distances(model: mujoco.MjModel, data: mujoco.MjData, point: Floats, rays: Floats) -> Floats:
    """(N,) how far from a point rays meet something, metres; FARTHEST_M where they meet nothing."""
    found, geoms = np.zeros(len(rays)), np.zeros(len(rays), dtype=np.int32)
    mujoco.mj_multiRay(model, data, point, rays.ravel(), GROUPS, 1, -1, geoms, found, None, len(rays), FARTHEST_M)
    return np.where(found < 0, FARTHEST_M, np.minimum(found, FARTHEST_M))


def room_inside_is_kept(subject: BatchSubject, limit: float) -> Measurement:
    """BAT008: largest share of a region that is free in the light form and filled in the batch form, 0..1.

    Points in the place of a part with a locked joint, and regions of things that are filled on purpose, do not count.
    """
    if subject.models is None:
        return not_run(UNREADABLE)
    batch, light = subject.models
    in_batch, in_light = pose_both(batch, light, START)
    # Geoms of the light form that each locked joint moves.
    joints = [light.joint(f"{ref.placement}__{ref.joint}").id for ref in subject.form.locked]
    blocks = [np.flatnonzero(light.geom_bodyid == int(light.jnt_bodyid[joint])) for joint in joints]
    shares = {}
    for place, asset, region in _kept_regions(subject):
        body = place.name if region.link == asset.root.name else f"{place.name}__{region.link}"
        world_from_link = _pose_of(light, in_light, body, place, asset, region.link)
        points = (world_from_link @ region.pose).apply(_points_in(region))
        points = points[~_within(in_light, blocks, points)]
        if not len(points):
            continue
        before, after = (_filled(*form, points, place.name) for form in ((light, in_light), (batch, in_batch)))
        shares[f"placements/{place.name}/{region.name}"] = float((after & ~before).mean())
    if not shares:
        return not_applicable("it has no regions that stay open")
    message = "{:.0%} of it is filled in the batch form and free in the light one"
    return all_at_most(shares, limit, message, "it has no regions that stay open")


def _kept_regions(subject: BatchSubject) -> Iterator[tuple[Placement, Asset, Region]]:
    locked = {ref.placement for ref in subject.form.locked}
    assets = subject.form.scene.asset_of
    for place in subject.form.scene.placements:
        asset = assets[place.name]
        if place.name in locked or place.name in subject.form.filled:
            continue
        for region in asset.regions:
            if region.name != WHOLE:
                yield place, asset, region


def _within(data: mujoco.MjData, blocks: list[Ints], points: Floats) -> Mask:
    """(N,) which points of the world lie in the box around one of some groups of geoms, their middles taken."""
    inside = np.zeros(len(points), dtype=bool)
    for geoms in blocks:
        if len(geoms):
            low, high = data.geom_xpos[geoms].min(axis=0), data.geom_xpos[geoms].max(axis=0)
            inside |= ((points >= low - BLOCK_MARGIN_M) & (points <= high + BLOCK_MARGIN_M)).all(axis=1)
    return inside


def _pose_of(model: mujoco.MjModel, data: mujoco.MjData, body: str, place: Placement, asset: Asset, link: str) -> Pose:
    """World_from_link: as simulated where the link moves, as placed where it is one with the world."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
    if number < 0 or (asset.base is Base.FIXED and not asset.is_moved(link)):
        return place.pose @ asset.asset_from_link(link)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = data.xmat[number].reshape(3, 3), data.xpos[number]
    return Pose.from_matrix(matrix)


def _points_in(region: Region) -> Floats:
    """(N, 3) points evenly within a region, in its frame, metres."""
    axis = (np.arange(REGION_POINTS) + 0.5) / REGION_POINTS - 0.5
    points = np.stack([g.ravel() for g in np.meshgrid(axis, axis, axis, indexing="ij")], axis=1) * np.array(region.size)
    if region.kind == "cylinder":
        points = points[np.hypot(points[:, 0], points[:, 1]) <= region.size[0] / 2]
    return np.asarray(points, dtype=np.float64)


def _filled(model: mujoco.MjModel, data: mujoco.MjData, points: Floats, placement: str) -> Mask:
    """(N,) which points of the world lie in a collider of a fixed part, or of a placement itself.

    Other loose things in a region are ignored, since they can be taken away.
    """
    inside = np.zeros(len(points), dtype=bool)
    others = [body for body in free_bodies(model) if str(model.body(body).name) != placement]
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    collides &= ~np.isin(model.body_rootid[model.geom_bodyid], others)
    low, high = points.min(axis=0), points.max(axis=0)
    near = collides & (np.abs(data.geom_xpos - (low + high) / 2) <= model.geom_rbound[:, None] + (high - low) / 2).all(
        axis=1
    )
    for geom in np.flatnonzero(near):
        local = (points - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
        size, kind = model.geom_size[geom], model.geom_type[geom]
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            inside |= (np.abs(local) <= size).all(axis=1)
        elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
            inside |= (np.hypot(local[:, 0], local[:, 1]) <= size[0]) & (np.abs(local[:, 2]) <= size[1])
        elif kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE):
            length = size[1] if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0
            local[:, 2] -= np.clip(local[:, 2], -length, length)
            inside |= np.linalg.norm(local, axis=1) <= size[0]
    return inside
