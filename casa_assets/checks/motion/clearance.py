"""Find moving parts that run into other parts of the asset over their range (KIN005)."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.motion.motion_model import MotionModel, motion_model_of, open_before, open_end
from casa_assets.checks.motion.simulation import box_around, geom_boxes, set_joints
from casa_assets.checks.motion.sweep import Penetration, SweepResult, moved_by, sweep
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Mask
from casa_assets.model.asset.asset import Asset, Joint

# Step while another part stands open: only the two moved parts can meet in a new way. They are large, so that steps may
# be wider than `sweep.STEP_M`.
PAIR_STEP_M = 0.025


def moving_parts_keep_clear(package: Package, limit: float) -> Measurement:
    """KIN005: deepest contact of a part over any joint's range, alone and with each other joint open; metres."""
    motion = motion_model_of(package)
    if isinstance(motion, Measurement):
        return motion
    problems = []
    worst = 0.0
    for joint in package.asset.joints:
        contact, open_joint = _deepest_contact(motion, package.asset, joint)
        worst = max(worst, contact.depth)
        if contact.depth > limit:
            while_open = f" while {open_joint} stands open" if open_joint else ""
            depth = f"sinks {contact.depth:.4f} m into"
            message = f"{contact.geom1} {depth} {contact.geom2}{while_open}; make room between them"
            problems.append((f"joints/{joint.name}", message))
    return Measurement(worst, tuple(problems))


def _deepest_contact(motion: MotionModel, asset: Asset, joint: Joint) -> tuple[Penetration, str]:
    """The deepest contact over all sweeps of a joint, and the other joint that was open in it, or an empty name."""
    model, joint_id = motion.with_margins, motion.joint_id(joint.name)
    data = mujoco.MjData(model)
    positions = open_before(asset, joint)
    set_joints(model, data, positions)
    moved, everything = moved_by(model, joint_id), np.ones(model.nbody, dtype=bool)
    alone = sweep(model, data, joint_id, everything)
    worst, open_joint = alone.worst, ""
    for other, with_other in _other_joints(asset, joint, positions):
        moved_by_other = moved_by(model, motion.joint_id(other.name))
        set_joints(model, data, with_other)
        # What carries this joint along takes it away from the rest.
        if moved_by_other[model.jnt_bodyid[joint_id]]:
            continue
        # What it carries, such as a latch, changes the outline of its own part, which is then swept against everything.
        carried = bool(moved[moved_by_other].any())
        if not carried and _stays_outside(model, data, alone, moved_by_other):
            continue
        contact = sweep(model, data, joint_id, everything if carried else moved_by_other, PAIR_STEP_M).worst
        if contact.depth > worst.depth:
            worst, open_joint = contact, other.name
    return worst, open_joint


def _other_joints(asset: Asset, joint: Joint, positions: dict[str, float]) -> Iterator[tuple[Joint, dict[str, float]]]:
    """Each joint that may be open while this one moves, and the positions of all those then open: rad or m."""
    for other in asset.joints:
        before = open_before(asset, other)
        # What needs this joint open cannot be out while it moves.
        if other.name != joint.name and other.name not in positions and joint.name not in before:
            yield other, {**positions, **before, other.name: open_end(other)}


def _stays_outside(model: mujoco.MjModel, data: mujoco.MjData, swept: SweepResult, bodies: Mask) -> bool:
    """True if bodies lie outside the box that a joint's part passes through."""
    mujoco.mj_kinematics(model, data)
    lower, upper = box_around(geom_boxes(model, data, np.flatnonzero(bodies[model.geom_bodyid])))
    return bool((lower > swept.bounds[1]).any() or (upper < swept.bounds[0]).any())
