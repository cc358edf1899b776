"""Count what a GPU engine pays for: primitives, pairs, degrees of freedom that are awake, constraint rows."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement, Problem, at_most, not_run
from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.scene.batch.subject import BATCH_FILE, UNREADABLE, BatchSubject
from casa_assets.core.typing import Mask
from casa_assets.model.kitchen.batch_scene import PICTURE_PX

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
        for field in JOINT_FIELDS:
            if not np.allclose(getattr(batch, field)[number], getattr(light, field)[other.id], rtol=1e-6, atol=1e-9):
                yield f"joints/{name}", f"has another {field} than in the light form"
        for field in DOF_FIELDS:
            if not np.isclose(getattr(batch, field)[dofs[0]], getattr(light, field)[dofs[1]], rtol=1e-6, atol=1e-9):
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
