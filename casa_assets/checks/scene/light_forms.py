"""The light and the batch form of a scene: same mechanism, at rest, joints that open, surfaces and room kept."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.motion.joints import PUSH_S, hand_effort, push
from casa_assets.checks.motion.simulation import START, altered, open_before, open_end, reset_to_start
from casa_assets.checks.readers.mujoco_facts import Loaded, free_bodies, load_asset_file
from casa_assets.checks.scene.formats import LIGHT_FILE, MAX_LISTED, SceneFiles
from casa_assets.checks.scene.rest import IdleRun, deepest, farthest, left_alone
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.asset.asset import Asset, Base, Joint, Region
from casa_assets.model.kitchen.scene import OPEN_POSE, PICTURE_PX, BatchScene, Placement
from casa_assets.model.pose import Pose

# Fields of MjModel with a row per joint, dof or body that are the same in both forms.
LIGHT_JOINT_FIELDS = ("jnt_type", "jnt_range", "jnt_axis", "jnt_pos", "jnt_stiffness")
DOF_FIELDS = ("dof_damping", "dof_frictionloss", "dof_armature")
BODY_FIELDS = ("body_mass", "body_inertia", "body_ipos")
BATCH_FILE = "scene_batch.xml"
UNREADABLE = "MuJoCo cannot read scene_batch.xml (BAT001)"
BOX, CYLINDER = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
SPHERE, CAPSULE = mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE
# Fields of MjModel with a row per joint that are the same in the light form, of those with one degree of freedom.
BATCH_JOINT_FIELDS = ("jnt_type", "jnt_range", "jnt_stiffness")
REST_S = 0.5  # things settle in 0.2 s, and what does not move falls asleep 10 steps later
POINTS, RAYS, SEED = 60, 400, 0  # points in the room, and rays from each, in each pose; all drawn from the same seed
# Heights of the points above the floor, metres, and how far they are from anything at least.
LOWEST_M, HIGHEST_M, CLEAR_M = 0.2, 1.9, 0.03
FARTHEST_M = 30.0
OFF_M = 0.005  # rays that meet something nearer or farther by more than this are off, metres
GROUPS = np.array([1, 1, 1, 1, 1, 0], dtype=np.uint8)  # what rays may meet: regions are in group 5
REGION_POINTS = 9  # points along each axis of a region
BLOCK_MARGIN_M = 0.03  # thickness of the walls of a drawer, of which the middles are known, metres
WHOLE = "main"  # region around a whole asset
FLOOR = "floor"  # category of floors


def mechanism_is_the_same(files: SceneFiles) -> check.Measurement:
    """SCN021: differences in joints, bodies and poses between the light form and the full one."""
    full, light = files.scene_subject.loaded.model, files.light_form
    name = files.light.name
    if full is None:
        return check.not_run("MuJoCo cannot read scene.xml, which the light form is held against")
    if light.model is None:
        return check.Measurement(1.0, ((name, light.error),))
    problems = [(name, f"MuJoCo warns: {warning}") for warning in light.warnings]
    meshes, pictures = int(light.model.nmesh), int((light.model.mat_texid >= 0).sum())
    if meshes:
        problems.append((name, f"has {meshes} meshes; use boxes, cylinders and spheres"))
    if pictures:
        problems.append((name, f"has {pictures} materials with pictures; use plain colours"))
    problems += _differences(full, light.model)
    return check.Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))


def light_form_settles_apart(files: SceneFiles, limit: float) -> check.Measurement:
    """SCN022: deepest penetration in the light form at the start and after 1 s, metres."""
    where = "in the light form; see the shapes that stand for it there"
    return deepest(_settled_light_form(files).depths, limit, where)


def light_things_stay_put(files: SceneFiles, limit: float) -> check.Measurement:
    """SCN028: largest distance that a free-standing object moves in 5 s in the light form, metres."""
    advice = " in the light form; the shapes that stand for it there do not stand"
    return farthest(_settled_light_form(files).drift, limit, advice, MAX_LISTED)


@lru_cache(maxsize=1)
def _settled_light_form(files: SceneFiles) -> IdleRun:
    """The light form left alone, once. Raises Unmeasured if it does not load."""
    if files.light_form.model is None:
        raise check.Unmeasured(check.not_run("MuJoCo cannot read scene_light.xml"))
    return left_alone(files.light_form.model)


def _differences(full: mujoco.MjModel, light: mujoco.MjModel) -> Iterator[check.Problem]:
    """Names of joints, bodies that move and poses that only one has, and numbers of them that differ."""
    for kind, word, field in ((mujoco.mjtObj.mjOBJ_JOINT, "joints", "njnt"), (mujoco.mjtObj.mjOBJ_KEY, "keys", "nkey")):
        full_names, light_names = (
            [str(mujoco.mj_id2name(model, kind, i)) for i in range(getattr(model, field))] for model in (full, light)
        )
        if full_names != light_names:
            only_one = [n for n in [*full_names, *light_names] if (n in full_names) != (n in light_names)]
            yield word, f"are others, or in another order, than in the full form: {', '.join(only_one[:5])}"
            return
    full_bodies, light_bodies = (np.flatnonzero(model.body_weldid != 0) for model in (full, light))
    if [full.body(b).name for b in full_bodies] != [light.body(b).name for b in light_bodies]:
        yield "bodies", f"{len(full_bodies)} move in the full form, {len(light_bodies)} in the light one"
        return
    for field in (*LIGHT_JOINT_FIELDS, *DOF_FIELDS, "key_qpos"):
        yield from _number_differences(field, getattr(full, field), getattr(light, field))
    for field in BODY_FIELDS:
        yield from _number_differences(field, getattr(full, field)[full_bodies], getattr(light, field)[light_bodies])


def _number_differences(field: str, full: np.ndarray, light: np.ndarray) -> Iterator[check.Problem]:
    off = ~np.isclose(full, light, rtol=1e-6, atol=1e-9)
    if off.any():
        yield field, f"differs in {int(off.sum())} numbers, by at most {np.abs(full - light)[off].max():.3g}"


@dataclass(frozen=True, eq=False)
class BatchSubject:
    """A batch form and the folder of its kitchen; each file is read once, and a subject is equal to itself alone."""

    form: BatchScene
    root: Path

    @cached_property
    def batch(self) -> Loaded:
        """The batch form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.root / BATCH_FILE)

    @cached_property
    def light(self) -> Loaded:
        """The light form compiled."""
        return load_asset_file(self.root / LIGHT_FILE)

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled batch form. Raises Unmeasured where it does not load."""
        if self.batch.model is None:
            raise check.Unmeasured(check.not_run(UNREADABLE))
        return self.batch.model

    @property
    def models(self) -> tuple[mujoco.MjModel, mujoco.MjModel]:
        """The batch and the light form. Raises Unmeasured if either does not load."""
        if self.light.model is None:
            raise check.Unmeasured(check.not_run(UNREADABLE))
        return self.model, self.light.model

    @cached_property
    def colliding(self) -> Mask:
        """(ngeom,) which geoms of the batch form touch anything. Raises Unmeasured where it does not load."""
        return np.asarray((self.model.geom_contype | self.model.geom_conaffinity) != 0, dtype=bool)


def pose_both(batch: mujoco.MjModel, light: mujoco.MjModel, key: str) -> tuple[mujoco.MjData, mujoco.MjData]:
    """Both forms in a named keyframe, without dynamics; joints locked in the batch form are as at the start."""
    of_light, at_start = mujoco.MjData(light), mujoco.MjData(light)
    mujoco.mj_resetDataKeyframe(light, of_light, light.key(key).id)
    mujoco.mj_resetDataKeyframe(light, at_start, light.key(START).id)
    names = {str(batch.joint(number).name) for number in range(batch.njnt)}
    of_batch = mujoco.MjData(batch)
    for number in range(light.njnt):
        name, first = str(light.joint(number).name), int(light.jnt_qposadr[number])
        size = 7 if light.jnt_type[number] == mujoco.mjtJoint.mjJNT_FREE else 1
        if name not in names:
            of_light.qpos[first : first + size] = at_start.qpos[first : first + size]
            continue
        to = int(batch.jnt_qposadr[batch.joint(name).id])
        of_batch.qpos[to : to + size] = of_light.qpos[first : first + size]
    for model, data in ((batch, of_batch), (light, of_light)):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    return of_batch, of_light


def batch_form_loads(subject: BatchSubject) -> check.Measurement:
    """BAT001: warnings, shapes that are no primitives, and joints that are others than in the light form."""
    if subject.batch.model is None:
        return check.Measurement(1.0, ((BATCH_FILE, subject.batch.error),))
    if subject.light.model is None:
        return check.not_run("MuJoCo cannot read scene_light.xml, which the batch form is held against")
    problems = list(_problems(subject, subject.batch.model, subject.light.model))
    return check.Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))


def _problems(subject: BatchSubject, batch: mujoco.MjModel, light: mujoco.MjModel) -> Iterator[check.Problem]:
    for warning in subject.batch.warnings:
        yield BATCH_FILE, f"MuJoCo warns: {warning}"
    for geom in np.flatnonzero(subject.colliding & ~np.isin(batch.geom_type, (BOX, SPHERE, CYLINDER, CAPSULE))):
        yield f"geoms/{batch.geom(int(geom)).name}", "is no box, sphere, cylinder or capsule"
    if batch.nmesh:
        yield BATCH_FILE, f"has {batch.nmesh} meshes; use primitives alone"
    shown = np.unique(batch.mat_texid[batch.mat_texid >= 0])
    for number in shown[np.maximum(batch.tex_width, batch.tex_height)[shown] > PICTURE_PX].tolist():
        size = f"{batch.tex_width[number]} x {batch.tex_height[number]} pixels"
        yield f"textures/{batch.tex(number).name}", f"has {size}; {PICTURE_PX} on a side are enough"
    known = {str(light.joint(number).name) for number in range(light.njnt)}
    for number in range(batch.njnt):
        name = str(batch.joint(number).name)
        if name not in known:
            yield f"joints/{name}", "is not in the light form"
            continue
        other, dofs = light.joint(name), (int(batch.jnt_dofadr[number]), int(light.joint(name).dofadr[0]))
        rows = [(field, number, other.id) for field in BATCH_JOINT_FIELDS] + [(field, *dofs) for field in DOF_FIELDS]
        for field, one, two in rows:
            if not np.allclose(getattr(batch, field)[one], getattr(light, field)[two], rtol=1e-6, atol=1e-9):
                yield f"joints/{name}", f"has another {field} than in the light form"


def collider_count_is_bounded(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT002: number of primitives that touch anything."""
    advice = "{:.0f} primitives that touch anything; lock more joints (`--joints`), or take things out"
    number = float(subject.colliding.sum())
    return check.at_most(number, limit, BATCH_FILE, advice.format(number))


def pair_count_is_bounded(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT003: number of pairs of geoms that an engine has to look at."""
    number = float(candidate_pairs(subject.model).sum())
    message = f"{number:.0f} candidate pairs; lock more joints, or take things out"
    return check.at_most(number, limit, BATCH_FILE, message)


def nothing_is_awake_at_rest(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT004: degrees of freedom that are awake, and constraint rows, once the scene has been left alone for 0.5 s."""
    model = subject.model
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data, nstep=round(REST_S / model.opt.timestep))
    number = float(data.nv_awake + data.nefc)
    message = f"{data.nv_awake} degrees of freedom are awake and there are {data.nefc} constraint rows at rest"
    return check.at_most(number, limit, BATCH_FILE, f"{message}; look for what touches or moves there")


def candidate_pairs(model: mujoco.MjModel) -> Mask:
    """(ngeom, ngeom) pairs of geoms, the first before the second, that MuJoCo does not rule out beforehand.

    As in mujoco_warp's `put_model`: by bits, by body, by parent, by exclusion.
    """
    body, weld = model.geom_bodyid, model.body_weldid[model.geom_bodyid]
    parent = model.body_weldid[model.body_parentid[weld]]
    bits = model.geom_contype[:, None] & model.geom_conaffinity[None, :]
    pairs = (bits | bits.T) != 0
    pairs &= weld[:, None] != weld[None, :]
    carries = (weld[:, None] != 0) & (weld[None, :] != 0)
    pairs &= ~(carries & ((weld[:, None] == parent[None, :]) | (weld[None, :] == parent[:, None])))
    is_still = model.body_dofnum[weld] == 0
    pairs &= ~(is_still[:, None] & is_still[None, :])
    low, high = np.minimum(body[:, None], body[None, :]), np.maximum(body[:, None], body[None, :])
    pairs &= ~np.isin((low.astype(np.int64) << 16) + high, model.exclude_signature)
    return np.asarray(np.triu(pairs, 1), dtype=bool)


def batch_form_settles_apart(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT005: deepest penetration at the start and after 1 s with nothing asleep, metres."""
    return deepest(_settled_batch_form(subject).depths, limit, "in the batch form")


def batch_things_stay_put(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT006: largest distance that a free-standing object moves in 5 s with nothing asleep, metres."""
    return farthest(_settled_batch_form(subject).drift, limit, " in the batch form", MAX_LISTED)


@lru_cache(maxsize=1)
def _settled_batch_form(subject: BatchSubject) -> IdleRun:
    """The batch form left alone with nothing asleep, once."""
    model = subject.model
    with altered(model.opt, enableflags=model.opt.enableflags & ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)):
        return left_alone(model, counted=subject.colliding)


def joints_open_by_hand(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT009: least share of its range that a joint of a fixture covers within 2 s under 20 N at its grip."""
    model = subject.model
    locked = {(ref.placement, ref.joint) for ref in subject.form.locked}
    rows: list[check.Row] = []
    assets = subject.form.scene.asset_of
    fixtures = [(p.name, assets[p.name]) for p in subject.form.scene.placements if p.resting is None]
    moving = [(name, asset, joint) for name, asset in fixtures if asset.base is Base.FIXED for joint in asset.joints]
    for name, asset, joint in moving:
        if (name, joint.name) not in locked:
            share = _share(model, name, asset, joint, limit)
            message = f"goes {share:.0%} of its way under {PULL_N:g} N in {PUSH_S:g} s in the batch form"
            rows.append((f"joints/{name}__{joint.name}", share, message))
    return check.worst_below(rows, limit, "all joints of its fixtures are locked")


def _share(model: mujoco.MjModel, place: str, asset: Asset, joint: Joint, enough: float) -> float:
    """Share of its range that a joint covers, no more than just over `enough`."""
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    for name, position in {**open_before(asset, joint), joint.name: 0.0}.items():
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{place}__{name}")
        if number >= 0:
            data.qpos[model.jnt_qposadr[number]] = position
    number = model.joint(f"{place}__{joint.name}").id
    goal = open_end(joint)
    data.qfrc_applied[model.jnt_dofadr[number]] = math.copysign(hand_effort(asset, joint), goal)
    return push(data, int(model.jnt_qposadr[number]), 0.0, goal, enough)


def surfaces_are_kept(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT007: share of rays from points in the room that meet the batch form elsewhere than the light one, 0..1.

    As the kitchen begins and with all open that is not locked; the larger share of the two.
    """
    batch, light = subject.models
    assets = subject.form.scene.asset_of
    floors = [name for name, asset in assets.items() if asset.labels.category == FLOOR]
    if not floors:
        return check.not_applicable("it has no floor to stand on")
    shares = {key: _share_off(batch, light, key, f"{floors[0]}__") for key in (START, OPEN_POSE)}
    message = "{:.1%} of rays meet it more than 5 mm nearer or farther than the light form"
    numbers = {f"{BATCH_FILE} {key}": share for key, share in shares.items()}
    return check.all_at_most(numbers, limit, message, "it has no floor to stand on")


def _share_off(batch: mujoco.MjModel, light: mujoco.MjModel, key: str, floor_name: str) -> float:
    """Share of rays, in a named pose, that are off; names of the floor's geoms begin with `floor_name`."""
    forms = list(zip((batch, light), pose_both(batch, light, key), strict=True))
    floor = next(number for number in range(light.ngeom) if str(light.geom(number).name).startswith(floor_name))
    center, half = forms[1][1].geom_xpos[floor], light.geom_size[floor]
    rng = np.random.default_rng(SEED)
    off, below = list[float](), np.zeros(1, dtype=np.int32)
    # Some points are in a wall or a cupboard; a room has many more that are not.
    for _ in range(POINTS * 50):
        along = rng.uniform(-1.0, 1.0, 2) * (half[:2] - CLEAR_M)
        point = np.array([*(center[:2] + along), rng.uniform(LOWEST_M, HIGHEST_M)])
        rays = rng.normal(size=(RAYS, 3))
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        # The first thing straight below the point.
        mujoco.mj_ray(*forms[1], point, np.array([0.0, 0.0, -1.0]), GROUPS, 1, -1, below)
        if below[0] < 0 or not str(light.geom(int(below[0])).name).startswith(floor_name):
            continue
        met = [_distances(model, data, point, rays) for model, data in forms]
        if min(float(distances.min()) for distances in met) < CLEAR_M:
            continue
        off.append(float((np.abs(met[0] - met[1]) > OFF_M).mean()))
        if len(off) == POINTS:
            break
    return float(np.mean(off))


def _distances(model: mujoco.MjModel, data: mujoco.MjData, point: Floats, rays: Floats) -> Floats:
    """(N,) how far from a point rays meet something, metres; FARTHEST_M where they meet nothing."""
    found, geoms = np.zeros(len(rays)), np.zeros(len(rays), dtype=np.int32)
    mujoco.mj_multiRay(model, data, point, rays.ravel(), GROUPS, 1, -1, geoms, found, None, len(rays), FARTHEST_M)
    return np.where(found < 0, FARTHEST_M, np.minimum(found, FARTHEST_M))


def room_inside_is_kept(subject: BatchSubject, limit: float) -> check.Measurement:
    """BAT008: largest share of a region that is free in the light form and filled in the batch form, 0..1.

    Points in the place of a part with a locked joint, and regions of things that are filled on purpose, do not count.
    """
    batch, light = subject.models
    in_batch, in_light = pose_both(batch, light, START)
    # Geoms of the light form that each locked joint moves.
    joints = [light.joint(f"{ref.placement}__{ref.joint}").id for ref in subject.form.locked]
    blocks = [np.flatnonzero(light.geom_bodyid == int(light.jnt_bodyid[joint])) for joint in joints]
    shares = {}
    assets, closed = subject.form.scene.asset_of, {ref.placement for ref in subject.form.locked}
    kept = [p for p in subject.form.scene.placements if p.name not in {*closed, *subject.form.filled}]
    for place, region in [(p, region) for p in kept for region in assets[p.name].regions if region.name != WHOLE]:
        asset = assets[place.name]
        body = place.name if region.link == asset.root.name else f"{place.name}__{region.link}"
        world_from_link = _pose_of(light, in_light, body, place, asset, region.link)
        points = (world_from_link @ region.pose).apply(_points_in(region))
        points = points[~_within(in_light, blocks, points)]
        if not len(points):
            continue
        before, after = (_filled(*form, points, place.name) for form in ((light, in_light), (batch, in_batch)))
        shares[f"placements/{place.name}/{region.name}"] = float((after & ~before).mean())
    if not shares:
        return check.not_applicable("it has no regions that stay open")
    message = "{:.0%} of it is filled in the batch form and free in the light one"
    return check.all_at_most(shares, limit, message, "it has no regions that stay open")


def _within(data: mujoco.MjData, blocks: list[Ints], points: Floats) -> Mask:
    """(N,) which points of the world lie in the box around one of some groups of geoms, their middles taken."""
    inside = np.zeros(len(points), dtype=bool)
    for middles in (data.geom_xpos[geoms] for geoms in blocks if len(geoms)):
        low, high = middles.min(axis=0) - BLOCK_MARGIN_M, middles.max(axis=0) + BLOCK_MARGIN_M
        inside |= ((points >= low) & (points <= high)).all(axis=1)
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
    reach = model.geom_rbound[:, None] + (high - low) / 2
    for geom in np.flatnonzero(collides & (np.abs(data.geom_xpos - (low + high) / 2) <= reach).all(axis=1)):
        local = (points - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
        size, kind = model.geom_size[geom], model.geom_type[geom]
        if kind == BOX:
            inside |= (np.abs(local) <= size).all(axis=1)
        elif kind == CYLINDER:
            inside |= (np.hypot(local[:, 0], local[:, 1]) <= size[0]) & (np.abs(local[:, 2]) <= size[1])
        elif kind in (SPHERE, CAPSULE):
            length = size[1] if kind == CAPSULE else 0.0
            local[:, 2] -= np.clip(local[:, 2], -length, length)
            inside |= np.linalg.norm(local, axis=1) <= size[0]
    return inside
