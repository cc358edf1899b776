"""Sweep a joint of a compiled asset through its range and find parts that run into each other."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.readers import mujoco_load
from casa_assets.core.typing import Floats, Mask

# How far the part of a joint that moves fastest goes between two poses. A corner that swings past an edge on an arm of
# 0.6 m and meets it by half a millimetre does so over 49 mm of its way. Parts of 4 mm that slide past each other meet
# over 8 mm, and are near for 14 mm.
STEP_M = 0.012
MOST_POSES = 160
LEAST_POSES = 12
# Between poses where parts come nearer than this and part again, there are finer ones.
NEAR_M = 0.003
FINER = 6
PEAKS = 2


@dataclass(frozen=True)
class Penetration:
    """Deepest contact of two geoms, metres (negative: their distance), and their names."""

    depth: float = -NEAR_M
    one: str = ""
    other: str = ""


@dataclass(frozen=True)
class SweepResult:
    """Result of a sweep: the worst contact, and (2, 3) corners of the box that the moved geoms passed, metres."""

    worst: Penetration
    bounds: Floats


def deepest(scene: Path) -> dict[str, float]:
    """Joint name -> deepest penetration between bodies of the asset, metres, over its range with all others at zero.

    Those that the file names as standing before a joint are open. Contacts that the model excludes do not count, nor do
    those with the floor. Empty where the scene does not compile.
    """
    loaded = mujoco_load.load_mjcf(scene).model
    if loaded is None:
        return {}
    model = with_margins(loaded)
    found: dict[str, float] = {}
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            continue
        mujoco.mj_resetData(model, data)
        for before in _before(model, joint):
            data.qpos[model.jnt_qposadr[before]] = max(model.jnt_range[before], key=abs)
        found[model.joint(joint).name] = max(0.0, sweep(model, data, joint, ~moved_by(model, joint)).worst.depth)
    return found


def with_margins(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy that reports pairs of geoms which come near, too. It is for looking alone: its contacts push too early."""
    near = copy.copy(model)
    # MuJoCo takes the larger margin of the two geoms of a pair.
    near.geom_margin[:] = NEAR_M
    return near


def moved_by(model: mujoco.MjModel, joint: int) -> Mask:
    """(nbody,) which bodies a joint carries along."""
    moved = np.zeros(model.nbody, dtype=bool)
    moved[model.jnt_bodyid[joint]] = True
    for body in range(int(model.jnt_bodyid[joint]) + 1, model.nbody):
        moved[body] |= moved[model.body_parentid[body]]
    return moved


def sweep(model: mujoco.MjModel, data: mujoco.MjData, joint: int, against: Mask, step_m: float = STEP_M) -> SweepResult:
    """One joint from end to end, the others as they stand in `data`.

    Args:
        model: as `alert` made it. data: its state; the joint is left at an end.
        joint: number of the joint.
        against: (nbody,) bodies that the moved ones may not meet; those that move along and the world are left out.
        step_m: way of the farthest moved point between two poses.
    """
    moved = moved_by(model, joint)
    against = against & ~moved
    against[0] = False
    geoms = np.flatnonzero(moved[model.geom_bodyid] & (model.geom_contype | model.geom_conaffinity).astype(bool))
    values = _poses(model, data, joint, geoms, step_m)
    found, boxes = [], []
    for value in values:
        found.append(_meet(model, data, joint, value, moved, against))
        boxes.append(bounds_of(model, data, geoms))
    depths = np.array([m.depth for m in found])
    for at in _peaks(depths)[:PEAKS]:
        low, high = values[max(at - 1, 0)], values[min(at + 1, len(values) - 1)]
        for value in np.linspace(low, high, FINER + 2)[1:-1]:
            found.append(_meet(model, data, joint, value, moved, against))
    corners = np.array(boxes)
    bounds = np.array([corners[:, 0].min(axis=0) - step_m, corners[:, 1].max(axis=0) + step_m])
    return SweepResult(max(found, key=lambda m: m.depth), bounds)


def bounds_of(model: mujoco.MjModel, data: mujoco.MjData, geoms: npt.NDArray[np.int64]) -> Floats:
    """(2, 3) corners of the box around geoms where they are now, metres, world frame; empty where there are none."""
    turn = data.geom_xmat[geoms].reshape(-1, 3, 3)
    middle = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", turn, model.geom_aabb[geoms, :3])
    half = np.einsum("nij,nj->ni", np.abs(turn), model.geom_aabb[geoms, 3:])
    return np.array([(middle - half).min(axis=0, initial=np.inf), (middle + half).max(axis=0, initial=-np.inf)])


def _before(model: mujoco.MjModel, joint: int) -> list[int]:
    """Joints that have to be open before one can move, as the custom texts `behind__<joint>` have it."""
    kind = mujoco.mjtObj.mjOBJ_TEXT
    ends = zip(model.text_adr, model.text_adr + model.text_size, strict=True)
    told = [bytes(model.text_data[start : end - 1]).decode() for start, end in ends]
    texts = {mujoco.mj_id2name(model, kind, i): text for i, text in enumerate(told)}
    found: list[int] = []
    at = texts.get(f"behind__{model.joint(joint).name}")
    while at is not None and model.joint(at).id not in found:
        found.append(int(model.joint(at).id))
        at = texts.get(f"behind__{at}")
    return found


def _poses(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, geoms: npt.NDArray[np.int64], step_m: float
) -> Floats:
    low, high = model.jnt_range[joint]
    reach = 1.0
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and len(geoms):
        mujoco.mj_kinematics(model, data)
        arm = data.geom_xpos[geoms] - data.xanchor[joint]
        off = arm - np.outer(arm @ data.xaxis[joint], data.xaxis[joint])
        reach = float((np.linalg.norm(off, axis=1) + model.geom_rbound[geoms]).max())
    return np.linspace(low, high, int(np.clip(np.ceil((high - low) * reach / step_m), LEAST_POSES, MOST_POSES)) + 1)


def _meet(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, value: float, moved: Mask, against: Mask
) -> Penetration:
    """The deepest contact between what moved and what it may not meet, at one value of the joint."""
    data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    if data.ncon == 0:
        return Penetration()
    geom = data.contact.geom
    one, other = model.geom_bodyid[geom[:, 0]], model.geom_bodyid[geom[:, 1]]
    counts = np.flatnonzero((moved[one] & against[other]) | (moved[other] & against[one]))
    if not len(counts):
        return Penetration()
    worst = counts[np.argmin(data.contact.dist[counts])]
    first, second = (model.geom(int(g)).name for g in geom[worst])
    return Penetration(-float(data.contact.dist[worst]), first, second)


def _peaks(depths: Floats) -> list[int]:
    """Indices of the poses at which parts come nearest, the nearest first; a constant gap has none."""
    beside = np.concatenate([[-NEAR_M], depths, [-NEAR_M]])
    rises, falls = depths - beside[:-2], depths - beside[2:]
    found = np.flatnonzero((depths > -NEAR_M) & (rises >= 0) & (falls >= 0) & (np.maximum(rises, falls) > 1e-6))
    return [int(i) for i in found[np.argsort(-depths[found], kind="stable")]]
