"""Find joints of articulated meshes that do not reach all of their range (KIN009)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.asset.built import NO_COMPILE, NO_JOINTS, is_from_family
from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.motion.collision_only import remove_visuals
from casa_assets.checks.motion.hand_force import CHUNK, LONGEST_S, hand_effort
from casa_assets.checks.motion.motion_model import STEP_S, open_before, open_end
from casa_assets.checks.motion.sweep import moved_by
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.files import Files

# A contact this much deeper than the same two shapes have at rest is one. Ref: what soft contacts forgive.
BEYOND_M = 0.001
# Of its range, what counts as all of it. Ref: registry/limits.yaml, reach_share.
ALL = 0.95
# Poses at which a sweep looks: enough for a corner of a door of 0.6 m to go 20 mm between two.
POSES = 48


@dataclass(frozen=True)
class JointTravel:
    """Travel of one joint under a hand, and up to the first contact.

    Attributes:
        joint: its name.
        free: share of its range before a contact is deeper than at rest by over 1 mm; 1 where none is.
        against: name of the body that it then runs into, or nothing.
        reached: share of its range to which 20 N take it in 2 s, as the file is written.
    """

    joint: str
    free: float
    against: str
    reached: float

    @property
    def whole(self) -> bool:
        """True if it goes all of its range, touching nothing."""
        return self.free >= 1.0 and self.reached >= ALL


def joints_reach_full_range(package: Package, limit: float | None) -> Measurement:
    """KIN009: share of the joints that go all their range under 20 N without collision.

    For what came as a mesh. What families build is held to more, by the rows for reach and clearance.
    """
    assert limit is not None
    asset = package.asset
    if not asset.joints or is_from_family(asset):
        return not_applicable("it was built from numbers, and KIN001 holds it to more" if asset.joints else NO_JOINTS)
    if mujoco_load.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    found = travels(asset, package.mjcf)
    share = sum(t.whole for t in found) / len(found)
    short = [t for t in found if not t.whole] if share < limit else []
    return Measurement(share, tuple((f"joints/{t.joint}", _says(t)) for t in short))


def _says(travel: JointTravel) -> str:
    if travel.free < 1.0:
        return f"goes {travel.free:.0%} of its range, then runs into {travel.against}"
    return f"goes {travel.reached:.0%} of its range under 20 N"


def travels(asset: Asset, model: Path | Files, pushed: bool = True) -> tuple[JointTravel, ...]:
    """Every joint of an asset, in its order.

    Args:
        model: MJCF of the asset: its `model.xml` on disk, or its package in memory.
        pushed: also move each by force; else `reached` is as `free`.
    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    if isinstance(model, Files):
        meshes = {path: data for path, data in model.entries.items() if path != "model.xml"}
        spec = mujoco.MjSpec.from_string(model.entries["model.xml"].decode(), assets=meshes)
    else:
        spec = mujoco.MjSpec.from_file(str(model))
    remove_visuals(spec)
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    written = spec.compile()
    for pair in list(spec.excludes):
        spec.delete(pair)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    open_to_all = spec.compile()
    found = []
    for joint in asset.joints:
        free, against = _free(open_to_all, asset, joint)
        found.append(JointTravel(joint.name, free, against, _reached(written, asset, joint) if pushed else free))
    return tuple(found)


def _free(model: mujoco.MjModel, asset: Asset, joint: Joint) -> tuple[float, str]:
    """Share of the range before the first contact that rest does not have, and with what."""
    data = mujoco.MjData(model)
    number = int(model.joint(joint.name).id)
    moved = moved_by(model, number)
    _stand(model, data, {**open_before(asset, joint), joint.name: 0.0})
    rest = _depths(model, data, moved)
    end = open_end(joint)
    for i in range(1, POSES + 1):
        data.qpos[model.jnt_qposadr[number]] = end * i / POSES
        for pair, depth in sorted(_depths(model, data, moved).items()):
            if depth > rest.get(pair, 0.0) + BEYOND_M:
                other = next(g for g in pair if not moved[model.geom_bodyid[g]])
                return (i - 1) / POSES, str(model.body(int(model.geom_bodyid[other])).name)
    return 1.0, ""


def _depths(model: mujoco.MjModel, data: mujoco.MjData, moved: npt.NDArray[np.bool_]) -> dict[tuple[int, int], float]:
    """Depth of each penetrating pair of a moved and another geom, metres, > 0."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    geom, dist = data.contact.geom, data.contact.dist
    mine = moved[model.geom_bodyid[geom]]
    apart = (mine[:, 0] != mine[:, 1]) & (dist < 0) & (model.geom_bodyid[geom] > 0).all(axis=1)
    found: dict[tuple[int, int], float] = {}
    for row in np.flatnonzero(apart):
        pair = (int(geom[row, 0]), int(geom[row, 1]))
        found[pair] = max(found.get(pair, 0.0), -float(dist[row]))
    return found


def _reached(model: mujoco.MjModel, asset: Asset, joint: Joint) -> float:
    """Share of the range to which the force of a hand takes a joint, all others left alone."""
    data = mujoco.MjData(model)
    _stand(model, data, open_before(asset, joint))
    number = int(model.joint(joint.name).id)
    end = open_end(joint)
    turns = joint.kind is JointKind.HINGE
    effort = hand_effort(asset, joint) if turns or abs(end) > 0 else 0.0
    data.qfrc_applied[model.jnt_dofadr[number]] = math.copysign(effort, end)
    best = 0.0
    for _ in range(int(LONGEST_S / STEP_S / CHUNK)):
        mujoco.mj_step(model, data, nstep=CHUNK)
        best = max(best, float(data.qpos[model.jnt_qposadr[number]]) / end)
        if best >= ALL:
            break
    return best


def _stand(model: mujoco.MjModel, data: mujoco.MjData, pose: dict[str, float]) -> None:
    mujoco.mj_resetData(model, data)
    for name, value in pose.items():
        data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
