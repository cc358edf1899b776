"""Compile a written asset for motion checks, with every pair of its parts able to touch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.asset.built import NO_COMPILE, NO_JOINTS, NOT_BUILT, is_fixture_like
from casa_assets.checks.check import Measurement, not_applicable, not_run
from casa_assets.checks.motion.collision_only import remove_visuals
from casa_assets.checks.motion.sweep import with_margins
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mujoco_load
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.pose import Pose

STEP_S = 0.002
KEPT = 4


@dataclass(frozen=True)
class MotionModel:
    """An asset's model made ready.

    Attributes:
        model: parents may touch their children, excludes are gone: the reference loader drops them, so parts have to
            clear each other by their form.
        free: the same with no contact at all.
        near: the same as `model`, but reports what comes near; for looking, not for stepping.
        address, dof: joint name -> index in qpos and in qvel.
    """

    model: mujoco.MjModel
    free: mujoco.MjModel
    near: mujoco.MjModel
    address: dict[str, int]
    dof: dict[str, int]

    def number(self, joint: str) -> int:
        """Index of a joint in the models. Raises KeyError."""
        return int(self.model.joint(joint).id)


def motion_model_of(package: Package) -> MotionModel | None:
    """The models of a built package with joints; None where it has none or does not compile."""
    if not package.asset.joints or not is_fixture_like(package.asset) or mujoco_load.load_mjcf(package.mjcf).error:
        return None
    return _movable(package.mjcf, package.asset.digest)


def why_no_motion_model(package: Package) -> Measurement:
    """Reason why a package has no motion model: no joints to check, or it does not compile."""
    if not is_fixture_like(package.asset):
        return not_applicable(NOT_BUILT)
    return not_run(NO_COMPILE) if package.asset.joints else not_applicable(NO_JOINTS)


@lru_cache(maxsize=KEPT)
def _movable(path: Path, digest: str) -> MotionModel:
    assert digest
    spec = mujoco.MjSpec.from_file(str(path))
    for pair in list(spec.excludes):
        spec.delete(pair)
    remove_visuals(spec)
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    model = spec.compile()
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    free = spec.compile()
    names = [model.joint(i).name for i in range(model.njnt)]
    return MotionModel(
        model,
        free,
        with_margins(model),
        {n: int(model.jnt_qposadr[i]) for i, n in enumerate(names)},
        {n: int(model.jnt_dofadr[i]) for i, n in enumerate(names)},
    )


def open_end(joint: Joint) -> float:
    """The end of a joint's range that is farther from zero, rad or m."""
    return max(joint.range, key=abs)


def lever(asset: Asset, joint: Joint) -> float:
    """Distance from a hinge's axis to the middle of the collider that a hand takes, metres; 1 for a slide.

    Where a joint names no grip the middle of the moved link's shapes is taken.
    """
    if joint.kind is JointKind.SLIDE:
        return 1.0
    arm = np.array(_grip_point(asset, joint)) - np.array(joint.anchor)
    axis = np.array(joint.axis)
    return float(np.linalg.norm(arm - axis * float(arm @ axis)))


def _grip_point(asset: Asset, joint: Joint) -> npt.NDArray[np.float64]:
    for link, pose in carried(asset, joint.child):
        for collider in asset.link(link).colliders:
            if collider.name == joint.grip:
                point: npt.NDArray[np.float64] = pose.apply(np.array([collider.pose.position]))[0]
                return point
    places = [c.pose.position for c in asset.link(joint.child).colliders]
    return np.mean(places, axis=0) if places else np.array(asset.link(joint.child).inertial.center_of_mass)


def carried(asset: Asset, link: str) -> list[tuple[str, Pose]]:
    """A link and what it carries without a joint, with poses in its frame."""
    out = [(link, Pose())]
    for other in asset.links:
        if other.parent == link and asset.joint_of(other.name) is None:
            out += [(name, other.pose @ pose) for name, pose in carried(asset, other.name)]
    return out


def open_before(asset: Asset, joint: Joint) -> dict[str, float]:
    """Joints that have to stand open for this one to move, and where: rad or m."""
    joints = {j.name: j for j in asset.joints}
    stands: dict[str, float] = {}
    before = joint.behind
    while before is not None and before not in stands:
        stands[before] = open_end(joints[before])
        before = joints[before].behind
    return stands
