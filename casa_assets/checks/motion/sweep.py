"""Sweep a joint of a compiled asset through its range and find parts that run into each other."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.motion.simulation import altered, box_around, collision_spec, find_contacts, geom_boxes, subtree
from casa_assets.checks.readers import mujoco_facts
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.files import Files

# How far the part of a joint that moves fastest goes between two poses. A corner that swings past an edge on an arm of
# 0.6 m and meets it by half a millimetre does so over 49 mm of its way. Parts of 4 mm that slide past each other meet
# over 8 mm, and are near for 14 mm.
STEP_M = 0.012
MIN_POSES, MAX_POSES = 12, 160
# Parts nearer than this are reported. Around the deepest of the poses at which they come nearest, poses are finer.
MARGIN_M = 0.003
FINE_POSES = 6
REFINED_PEAKS = 2


@dataclass(frozen=True)
class Penetration:
    """Deepest contact of two geoms, metres (negative: their distance), and the names of them and of their bodies."""

    depth: float = -MARGIN_M
    geom1: str = ""
    geom2: str = ""
    body1: str = ""
    body2: str = ""


@dataclass(frozen=True)
class SweepResult:
    """The deepest contact of a sweep, and (2, 3) corners of the box that the moved geoms passed through, metres."""

    worst: Penetration
    bounds: Floats


def deepest_contacts(scene: Path) -> dict[str, float]:
    """Joint name -> deepest penetration between bodies of the asset, metres, over its range with all others at zero.

    Those that the file names as standing before a joint are open. Contacts that the model excludes do not count, nor do
    those with the floor. Empty where the scene does not compile.
    """
    loaded = mujoco_facts.load_mjcf(scene).model
    found = {} if loaded is None else _deepest_contacts(loaded)
    return {joint: max(0.0, contact.depth) for joint, contact in found.items()}


def contacts_of_files(mjcf: Files) -> dict[str, tuple[Penetration, float]]:
    """Joint name -> deepest contact over its range, as `deepest_contacts` has it, and how deep the same two bodies are.

    The second is with all joints at zero, metres; 0 where the bodies are apart.

    Args:
        mjcf: a package in memory with its `scene.xml`, whose way of finding contacts is that of the check.
    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    model = collision_spec(mjcf, "scene.xml").compile()
    return {joint: (contact, _depth_at_rest(model, contact)) for joint, contact in _deepest_contacts(model).items()}


def _deepest_contacts(compiled: mujoco.MjModel) -> dict[str, Penetration]:
    """Joint name -> deepest contact over its range."""
    model, texts = with_margins(compiled), mujoco_facts.texts(compiled)
    found: dict[str, Penetration] = {}
    data = mujoco.MjData(model)
    for joint in map(int, np.flatnonzero(model.jnt_type != mujoco.mjtJoint.mjJNT_FREE)):
        mujoco.mj_resetData(model, data)
        # Joints that have to be open before it can move, as the custom texts `behind__<joint>` have it.
        opened: set[int] = set()
        before = texts.get(f"behind__{model.joint(joint).name}")
        while before is not None and (number := int(model.joint(before).id)) not in opened:
            opened.add(number)
            data.qpos[model.jnt_qposadr[number]] = max(model.jnt_range[number], key=abs)
            before = texts.get(f"behind__{before}")
        everything = np.ones(model.nbody, dtype=bool)
        found[model.joint(joint).name] = sweep(model, data, joint, everything).worst
    return found


def _depth_at_rest(model: mujoco.MjModel, contact: Penetration) -> float:
    """Depth to which the two bodies of a contact are in each other with all joints at zero, metres; 0 where apart."""
    if not contact.body1:
        return 0.0
    data = mujoco.MjData(model)
    find_contacts(model, data)
    bodies = {model.body(contact.body1).id, model.body(contact.body2).id}
    pairs = model.geom_bodyid[data.contact.geom]
    depths = [-float(d) for pair, d in zip(pairs, data.contact.dist, strict=True) if set(pair.tolist()) == bodies]
    return max([0.0, *depths])


def with_margins(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy that reports pairs of geoms which come near, too. It is for looking alone: its contacts push too early."""
    copied = copy.copy(model)
    # MuJoCo takes the larger margin of the two geoms of a pair.
    copied.geom_margin[:] = MARGIN_M
    return copied


def moved_by(model: mujoco.MjModel, joint: int) -> Mask:
    """(nbody,) which bodies a joint carries along."""
    return subtree(model, int(model.jnt_bodyid[joint]))


def sweep(model: mujoco.MjModel, data: mujoco.MjData, joint: int, against: Mask, step_m: float = STEP_M) -> SweepResult:
    """Move one joint from end to end, with the others at their positions in `data`.

    Args:
        model: as `with_margins` made it. data: its state; the joint is left at an end.
        joint: number of the joint.
        against: (nbody,) bodies that the moved ones may not touch; those that move along and the world are left out.
        step_m: distance that the farthest moved point travels between two poses.
    """
    moved = moved_by(model, joint)
    against = against & ~moved
    against[0] = False
    geoms = np.flatnonzero(moved[model.geom_bodyid] & (model.geom_contype | model.geom_conaffinity).astype(bool))
    positions = _positions(model, data, joint, geoms, step_m)
    contacts, boxes = [], []
    for position in positions:
        contacts.append(_deepest_contact(model, data, joint, position, moved, against))
        boxes.append(box_around(geom_boxes(model, data, geoms)))
    depths = np.array([contact.depth for contact in contacts])
    for at in _peaks(depths)[:REFINED_PEAKS]:
        low, high = positions[max(at - 1, 0)], positions[min(at + 1, len(positions) - 1)]
        for position in np.linspace(low, high, FINE_POSES + 2)[1:-1]:
            contacts.append(_deepest_contact(model, data, joint, position, moved, against))
    bounds = box_around(np.array(boxes)) + np.array([[-step_m], [step_m]])
    return SweepResult(max(contacts, key=lambda contact: contact.depth), bounds)


def _positions(model: mujoco.MjModel, data: mujoco.MjData, joint: int, geoms: Ints, step_m: float) -> Floats:
    """(N,) positions of a joint from end to end, rad or m."""
    low, high = model.jnt_range[joint]
    reach = 1.0
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and len(geoms):
        mujoco.mj_kinematics(model, data)
        arm = data.geom_xpos[geoms] - data.xanchor[joint]
        radial = arm - np.outer(arm @ data.xaxis[joint], data.xaxis[joint])
        reach = float((np.linalg.norm(radial, axis=1) + model.geom_rbound[geoms]).max())
    return np.linspace(low, high, int(np.clip(np.ceil((high - low) * reach / step_m), MIN_POSES, MAX_POSES)) + 1)


def _deepest_contact(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, position: float, moved: Mask, against: Mask
) -> Penetration:
    """The deepest contact between moved bodies and those that they may not touch, at one position of the joint.

    MuJoCo widens shapes by their margin before it measures penetration. For two thin shapes that are near but do not
    touch, it then returns an arbitrary direction and a depth of centimetres: contacts found this way are measured again
    without margins.
    """
    data.qpos[model.jnt_qposadr[joint]] = position
    seeming = _deepest_counted(model, data, moved, against)
    if seeming.depth <= 0.0:
        return seeming
    with altered(model, geom_margin=0.0):
        touching = _deepest_counted(model, data, moved, against)
    return touching if touching.geom1 else replace(seeming, depth=0.0)


def _deepest_counted(model: mujoco.MjModel, data: mujoco.MjData, moved: Mask, against: Mask) -> Penetration:
    """The deepest contact between moved bodies and those that they may not touch, at the joint positions in `data`."""
    find_contacts(model, data)
    if data.ncon == 0:
        return Penetration()
    geoms = data.contact.geom
    body1, body2 = model.geom_bodyid[geoms].T
    counted = np.flatnonzero((moved[body1] & against[body2]) | (moved[body2] & against[body1]))
    if not len(counted):
        return Penetration()
    worst = counted[np.argmin(data.contact.dist[counted])]
    names = (model.geom(int(g)).name for g in geoms[worst])
    bodies = (model.body(int(model.geom_bodyid[g])).name for g in geoms[worst])
    return Penetration(-float(data.contact.dist[worst]), *names, *bodies)


def _peaks(depths: Floats) -> list[int]:
    """Indices of the poses at which parts come nearest, the nearest first; a constant gap has none."""
    padded = np.concatenate([[-MARGIN_M], depths, [-MARGIN_M]])
    rises, falls = depths - padded[:-2], depths - padded[2:]
    peaks = np.flatnonzero((depths > -MARGIN_M) & (rises >= 0) & (falls >= 0) & (np.maximum(rises, falls) > 1e-6))
    return [int(i) for i in peaks[np.argsort(-depths[peaks], kind="stable")]]
