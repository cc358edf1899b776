"""Compile a written asset for motion checks, with every pair of its parts able to touch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.check import (
    NO_COMPILE,
    NO_JOINTS,
    NOT_BUILT,
    Measurement,
    is_fixture_like,
    not_applicable,
    not_run,
)
from casa_assets.checks.motion.simulation import collision_spec
from casa_assets.checks.motion.sweep import with_margins
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind
from casa_assets.model.files import Files
from casa_assets.model.pose import Pose

STEP_S = 0.002
CACHED_MODELS = 4


@dataclass(frozen=True)
class MotionModel:
    """An asset's file compiled for motion checks.

    Attributes:
        model: parents may touch their children, and excludes are gone: the reference loader drops them, so the shapes
            themselves have to clear each other.
        contactless: the same with no contact at all.
        with_margins: the same as `model`, but reports what comes near; for looking, not for stepping.
        address, dof: joint name -> index in qpos and in qvel.
    """

    model: mujoco.MjModel
    contactless: mujoco.MjModel
    with_margins: mujoco.MjModel
    address: dict[str, int]
    dof: dict[str, int]

    def joint_id(self, joint: str) -> int:
        """Index of a joint in the models. Raises KeyError."""
        return int(self.model.joint(joint).id)


def motion_model_of(package: Package) -> MotionModel | Measurement:
    """The models of a built package with joints, or the result of a check that cannot have them."""
    if not is_fixture_like(package.asset):
        return not_applicable(NOT_BUILT)
    if not package.asset.joints:
        return not_applicable(NO_JOINTS)
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return not_run(NO_COMPILE)
    return _compile(package.mjcf, package.asset.digest)


@lru_cache(maxsize=CACHED_MODELS)
def _compile(path: Path, digest: str) -> MotionModel:
    assert digest, "names the content of the file in the cache"
    spec = motion_spec(path)
    for pair in list(spec.excludes):
        spec.delete(pair)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    model = spec.compile()
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    names = [model.joint(i).name for i in range(model.njnt)]
    return MotionModel(
        model,
        contactless=spec.compile(),
        with_margins=with_margins(model),
        address={name: int(model.jnt_qposadr[i]) for i, name in enumerate(names)},
        dof={name: int(model.jnt_dofadr[i]) for i, name in enumerate(names)},
    )


def motion_spec(mjcf: Path | Files) -> mujoco.MjSpec:
    """Specification of an MJCF file without visuals, with the step and the integrator of motion checks."""
    spec = collision_spec(mjcf)
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec


def open_end(joint: Joint) -> float:
    """The end of a joint's range that is farther from zero, rad or m."""
    return max(joint.range, key=abs)


def lever_arm(asset: Asset, joint: Joint) -> float:
    """Distance from a hinge's axis to the middle of the collider that a hand takes, metres; 1 for a slide.

    Where a joint names no grip the middle of the moved link's shapes is taken.
    """
    if joint.kind is JointKind.SLIDE:
        return 1.0
    link, grip = grip_of(asset, joint)
    child = asset.link(joint.child)
    if grip is not None:
        point = dict(_rigid_group(asset, joint.child))[link].apply(_middle(grip)[None])[0]
    elif child.colliders:
        point = np.mean([_middle(c) for c in child.colliders], axis=0)
    else:
        point = np.array(child.inertial.center_of_mass)
    arm, axis = point - np.array(joint.anchor), np.array(joint.axis)
    return float(np.linalg.norm(arm - axis * float(arm @ axis)))


def grip_of(asset: Asset, joint: Joint) -> tuple[str, Collider | None]:
    """The link and the collider that a hand takes to move a joint; ("", None) if the joint moves no such collider."""
    for link, _ in _rigid_group(asset, joint.child):
        for collider in asset.link(link).colliders:
            if collider.name == joint.grip:
                return link, collider
    return "", None


def _middle(collider: Collider) -> Floats:
    """(3,) middle of a collider in the frame of its link; a hull may be far from the origin of its frame."""
    middle: Floats = shape_bounds(collider.shape, collider.pose).mean(axis=0)
    return middle


def _rigid_group(asset: Asset, link: str) -> list[tuple[str, Pose]]:
    """A link and what it carries without a joint, with poses in its frame."""
    group = [(link, Pose())]
    for other in asset.links:
        if other.parent == link and asset.joint_of(other.name) is None:
            group += [(name, other.pose @ pose) for name, pose in _rigid_group(asset, other.name)]
    return group


def open_before(asset: Asset, joint: Joint) -> dict[str, float]:
    """Joints that have to be open for this one to move, and their positions: rad or m."""
    joints = {j.name: j for j in asset.joints}
    positions: dict[str, float] = {}
    before = joint.behind
    while before is not None and before not in positions:
        positions[before] = open_end(joints[before])
        before = joints[before].behind
    return positions
