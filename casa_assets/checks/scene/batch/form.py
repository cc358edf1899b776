"""The batch form of a scene as MuJoCo has it: what an engine pays for, things at rest, joints that a hand opens."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, Problem, at_most, not_applicable, not_run
from casa_assets.checks.motion.joints import PUSH_S, hand_effort, push
from casa_assets.checks.motion.motion_model import open_before, open_end
from casa_assets.checks.motion.simulation import START, altered, reset_to_start
from casa_assets.checks.readers.mujoco_facts import Loaded, load_asset_file
from casa_assets.checks.scene.formats.light_form import LIGHT_FILE
from casa_assets.checks.scene.motion.rest import Settled, farthest, settle
from casa_assets.core.hand_dynamics import PULL_N
from casa_assets.core.numeric import Mask
from casa_assets.model.asset.asset import Asset, Base, Joint
from casa_assets.model.kitchen.scene import PICTURE_PX, BatchScene

# Subject --------------------------------------------------------------------------------------------------------------
# The batch form of a scene as MuJoCo has it, beside the light form that it is held against.

BATCH_FILE = "scene_batch.xml"
UNREADABLE = "MuJoCo cannot read scene_batch.xml (BAT001)"


@dataclass(frozen=True, eq=False)
class BatchSubject:
    """A batch form and the folder of its kitchen; each file is read once, and a subject is equal to itself alone.

    Attributes:
        form: what the writer was given. root: the folder, with `scene_light.xml` and `scene_batch.xml`.
    """

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

    @cached_property
    def models(self) -> tuple[mujoco.MjModel, mujoco.MjModel] | None:
        """The batch and the light form; None if either does not load."""
        batch, light = self.batch.model, self.light.model
        return None if batch is None or light is None else (batch, light)

    @cached_property
    def colliding(self) -> Mask:
        """(ngeom,) which geoms of the batch form touch anything. Raises ValueError where it does not load."""
        model = self.batch.model
        if model is None:
            raise ValueError(self.batch.error)
        return np.asarray((model.geom_contype | model.geom_conaffinity) != 0, dtype=bool)


@contextmanager
def awake(model: mujoco.MjModel) -> Iterator[mujoco.MjData]:
    """The scene as it begins, with nothing asleep while the block lasts."""
    with altered(model.opt, enableflags=model.opt.enableflags & ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)):
        data = mujoco.MjData(model)
        reset_to_start(model, data)
        mujoco.mj_forward(model, data)
        yield data


def pose_both(batch: mujoco.MjModel, light: mujoco.MjModel, key: str) -> tuple[mujoco.MjData, mujoco.MjData]:
    """Both forms in a named pose, without dynamics; joints that are locked in the batch form are as at the start.

    Args:
        key: name of a keyframe of both.
    """
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


# Size -----------------------------------------------------------------------------------------------------------------
# Count what a GPU engine pays for: primitives, pairs, degrees of freedom that are awake, constraint rows.

PRIMITIVES = (
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
    mujoco.mjtGeom.mjGEOM_CAPSULE,
)
# Fields of MjModel with a row per joint that are the same in the light form, of those with one degree of freedom.
JOINT_FIELDS = ("jnt_type", "jnt_range", "jnt_stiffness")
DOF_FIELDS = ("dof_damping", "dof_frictionloss", "dof_armature")
MAX_LISTED = 20
# Things settle in 0.2 s, and what does not move falls asleep 10 steps later.
REST_S = 0.5


def batch_form_loads(subject: BatchSubject) -> Measurement:
    """BAT001: warnings, shapes that are no primitives, and joints that are others than in the light form."""
    if subject.batch.model is None:
        return Measurement(1.0, ((BATCH_FILE, subject.batch.error),))
    if subject.light.model is None:
        return not_run("MuJoCo cannot read scene_light.xml, which the batch form is held against")
    problems = list(_problems(subject, subject.batch.model, subject.light.model))
    return Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))


def _problems(subject: BatchSubject, batch: mujoco.MjModel, light: mujoco.MjModel) -> Iterator[Problem]:
    for warning in subject.batch.warnings:
        yield BATCH_FILE, f"MuJoCo warns: {warning}"
    for geom in np.flatnonzero(subject.colliding & ~np.isin(batch.geom_type, PRIMITIVES)):
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
        rows = [(field, number, other.id) for field in JOINT_FIELDS] + [(field, *dofs) for field in DOF_FIELDS]
        for field, one, two in rows:
            if not np.allclose(getattr(batch, field)[one], getattr(light, field)[two], rtol=1e-6, atol=1e-9):
                yield f"joints/{name}", f"has another {field} than in the light form"


def collider_count_is_bounded(subject: BatchSubject, limit: float) -> Measurement:
    """BAT002: number of primitives that touch anything."""
    if subject.batch.model is None:
        return not_run(UNREADABLE)
    advice = "{:.0f} primitives that touch anything; lock more joints (`--joints`), or take things out"
    number = float(subject.colliding.sum())
    return at_most(number, limit, BATCH_FILE, advice.format(number))


def pair_count_is_bounded(subject: BatchSubject, limit: float) -> Measurement:
    """BAT003: number of pairs of geoms that an engine has to look at."""
    if subject.batch.model is None:
        return not_run(UNREADABLE)
    number = float(candidate_pairs(subject.batch.model).sum())
    return at_most(number, limit, BATCH_FILE, f"{number:.0f} candidate pairs; lock more joints, or take things out")


def nothing_is_awake_at_rest(subject: BatchSubject, limit: float) -> Measurement:
    """BAT004: degrees of freedom that are awake, and constraint rows, once the scene has been left alone for 0.5 s."""
    model = subject.batch.model
    if model is None:
        return not_run(UNREADABLE)
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data, nstep=round(REST_S / model.opt.timestep))
    number = float(data.nv_awake + data.nefc)
    message = f"{data.nv_awake} degrees of freedom are awake and there are {data.nefc} constraint rows at rest"
    return at_most(number, limit, BATCH_FILE, f"{message}; look for what touches or moves there")


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


# Rest -----------------------------------------------------------------------------------------------------------------
# Find things that stand in each other in the batch form, or do not stay where they stand.


def no_penetration(subject: BatchSubject, limit: float) -> Measurement:
    """BAT005: deepest penetration at the start and after 1 s with nothing asleep, metres."""
    settled = _settled(subject)
    if settled is None:
        return not_run(UNREADABLE)
    return settled.deepest(limit, "in the batch form")


def loose_things_stay_put(subject: BatchSubject, limit: float) -> Measurement:
    """BAT006: largest distance that a free-standing object moves in 5 s with nothing asleep, metres."""
    settled = _settled(subject)
    return not_run(UNREADABLE) if settled is None else farthest(settled.drift, limit, " in the batch form", MAX_LISTED)


@lru_cache(maxsize=1)
def _settled(subject: BatchSubject) -> Settled | None:
    """Simulate the batch form for 5 s, once; None if it does not load."""
    if subject.batch.model is None:
        return None
    with awake(subject.batch.model) as data:
        return settle(data, subject.colliding)


# Opening --------------------------------------------------------------------------------------------------------------
# Find joints that a hand of 20 N does not open in the batch form as far as it has to.


def joints_open_by_hand(subject: BatchSubject, limit: float) -> Measurement:
    """BAT009: least share of its range that a joint of a fixture covers within 2 s under 20 N at its grip."""
    model = subject.batch.model
    if model is None:
        return not_run(UNREADABLE)
    locked = {(ref.placement, ref.joint) for ref in subject.form.locked}
    shares, problems = list[float](), list[tuple[str, str]]()
    assets = subject.form.scene.asset_of
    for place in subject.form.scene.placements:
        asset = assets[place.name]
        for joint in asset.joints:
            if asset.base is not Base.FIXED or place.resting is not None or (place.name, joint.name) in locked:
                continue
            share = _share(model, place.name, asset, joint, limit)
            shares.append(share)
            if share < limit:
                message = f"goes {share:.0%} of its way under {PULL_N:g} N in {PUSH_S:g} s in the batch form"
                problems.append((f"joints/{place.name}__{joint.name}", message))
    if not shares:
        return not_applicable("all joints of its fixtures are locked")
    return Measurement(min(shares), tuple(problems))


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
