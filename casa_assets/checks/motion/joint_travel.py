"""Find joints of articulated meshes that do not reach all of their range (KIN009)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.asset.applicability import NO_COMPILE, NO_JOINTS, is_from_family
from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.motion.hand_force import hand_effort, push
from casa_assets.checks.motion.motion_model import motion_spec, open_before, open_end
from casa_assets.checks.motion.simulation import find_contacts, set_joints
from casa_assets.checks.motion.sweep import moved_by
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.core.typing import Mask
from casa_assets.model.asset.asset import Asset, Joint
from casa_assets.model.files import Files

# A contact counts where it is this much deeper than that of the same two shapes at rest. Our choice: what soft contacts
# forgive.
EXTRA_DEPTH_M = 0.001
# Share of its range that counts as all of it, as reach_share in registry/limits.yaml.
FULL_SHARE = 0.95
# Poses of a sweep: enough for a corner of a door of 0.6 m to go 20 mm between two.
POSES = 48


@dataclass(frozen=True)
class JointTravel:
    """Travel of one joint under a hand, and up to the first contact.

    Attributes:
        joint: its name.
        free_share: share of its range before a contact is deeper than at rest by over 1 mm; 1 if no contact is.
        blocked_by: name of the body that it then runs into, or empty.
        pushed_share: share of its range to which 20 N take it in 2 s, with the model as the file is written.
    """

    joint: str
    free_share: float
    blocked_by: str
    pushed_share: float

    @property
    def is_full(self) -> bool:
        """True if it goes all of its range, touching nothing."""
        return self.free_share >= 1.0 and self.pushed_share >= FULL_SHARE

    @property
    def message(self) -> str:
        """How far it goes, in words that follow its name."""
        if self.free_share < 1.0:
            return f"goes {self.free_share:.0%} of its range, then runs into {self.blocked_by}"
        return f"goes {self.pushed_share:.0%} of its range under 20 N"


def joints_reach_full_range(package: Package, limit: float) -> Measurement:
    """KIN009: share of the joints that move over their full range under 20 N without collision.

    Only for assets from meshes. Those that families build have to meet stricter limits, of the checks of reach and
    clearance.
    """
    asset = package.asset
    if not asset.joints or is_from_family(asset):
        return not_applicable("it was built from numbers, and KIN001 holds it to more" if asset.joints else NO_JOINTS)
    if mujoco_load.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    travels = joint_travels(asset, package.mjcf)
    share = sum(t.is_full for t in travels) / len(travels)
    short = [t for t in travels if not t.is_full] if share < limit else []
    return Measurement(share, tuple((f"joints/{t.joint}", t.message) for t in short))


def joint_travels(asset: Asset, model: Path | Files, pushed: bool = True) -> tuple[JointTravel, ...]:
    """Travel of every joint of an asset, in its order.

    Args:
        model: MJCF of the asset: its `model.xml` on disk, or its package in memory.
        pushed: also move each by force; else `pushed_share` is as `free_share`.
    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    spec = motion_spec(model)
    as_written = spec.compile()
    for pair in list(spec.excludes):
        spec.delete(pair)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    all_pairs = spec.compile()
    travels = []
    for joint in asset.joints:
        free, blocked_by = _free_share(all_pairs, asset, joint)
        travels.append(
            JointTravel(joint.name, free, blocked_by, _pushed_share(as_written, asset, joint) if pushed else free)
        )
    return tuple(travels)


def _free_share(model: mujoco.MjModel, asset: Asset, joint: Joint) -> tuple[float, str]:
    """Share of the range before the first contact that is not there at rest, and the name of the other body."""
    data = mujoco.MjData(model)
    joint_id = int(model.joint(joint.name).id)
    moved = moved_by(model, joint_id)
    set_joints(model, data, open_before(asset, joint))
    at_rest = _depths(model, data, moved)
    end = open_end(joint)
    for i in range(1, POSES + 1):
        data.qpos[model.jnt_qposadr[joint_id]] = end * i / POSES
        for pair, depth in sorted(_depths(model, data, moved).items()):
            if depth > at_rest.get(pair, 0.0) + EXTRA_DEPTH_M:
                other = next(g for g in pair if not moved[model.geom_bodyid[g]])
                return (i - 1) / POSES, str(model.body(int(model.geom_bodyid[other])).name)
    return 1.0, ""


def _depths(model: mujoco.MjModel, data: mujoco.MjData, moved: Mask) -> dict[tuple[int, int], float]:
    """Depth of each penetrating pair of a moved and another geom, metres, > 0."""
    find_contacts(model, data)
    geoms, distances = data.contact.geom, data.contact.dist
    bodies = model.geom_bodyid[geoms]
    counted = (moved[bodies[:, 0]] != moved[bodies[:, 1]]) & (distances < 0) & (bodies > 0).all(axis=1)
    depths: dict[tuple[int, int], float] = {}
    for row in np.flatnonzero(counted):
        pair = (int(geoms[row, 0]), int(geoms[row, 1]))
        depths[pair] = max(depths.get(pair, 0.0), -float(distances[row]))
    return depths


def _pushed_share(model: mujoco.MjModel, asset: Asset, joint: Joint) -> float:
    """Share of the range to which the force of a hand takes a joint, all others left alone."""
    data = mujoco.MjData(model)
    set_joints(model, data, open_before(asset, joint))
    joint_id, end = int(model.joint(joint.name).id), open_end(joint)
    data.qfrc_applied[model.jnt_dofadr[joint_id]] = math.copysign(hand_effort(asset, joint), end)
    return push(data, int(model.jnt_qposadr[joint_id]), 0.0, end, FULL_SHARE)
