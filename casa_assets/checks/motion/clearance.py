"""Find moving parts that run into other parts of the asset over their range (KIN005)."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.motion.motion_model import (
    MotionModel,
    motion_model_of,
    open_before,
    open_end,
    why_no_motion_model,
)
from casa_assets.checks.motion.sweep import Penetration, SweepResult, bounds_of, moved_by, sweep
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Mask
from casa_assets.model.asset.asset import Asset, Joint

# With another part open only the two moved parts can meet in a new way; they are large, and steps may be wider.
PAIR_STEP_M = 0.025


def moving_parts_keep_clear(package: Package, limit: float | None) -> Measurement:
    """KIN005: deepest contact of a part over any joint's range, alone and beside each open joint; metres."""
    assert limit is not None
    ready, asset = motion_model_of(package), package.asset
    if ready is None:
        return why_no_motion_model(package)
    problems = []
    worst = 0.0
    for joint in asset.joints:
        meeting, beside = _deepest(ready, asset, joint)
        worst = max(worst, meeting.depth)
        if meeting.depth > limit:
            while_ = f" while {beside} stands open" if beside else ""
            message = f"{meeting.one} sinks {meeting.depth:.4f} m into {meeting.other}{while_}; make room between them"
            problems.append((f"joints/{joint.name}", message))
    return Measurement(worst, tuple(problems))


def _deepest(ready: MotionModel, asset: Asset, joint: Joint) -> tuple[Penetration, str]:
    """The deepest meeting over all sweeps of a joint, and the other joint that stood open, or nothing."""
    model, number = ready.near, ready.number(joint.name)
    data = mujoco.MjData(model)
    base = open_before(asset, joint)
    _stand(ready, data, base)
    own, everything = moved_by(model, number), np.ones(model.nbody, dtype=bool)
    alone = sweep(model, data, number, everything)
    worst, beside = alone.worst, ""
    for other, setting in _others(asset, joint, base):
        theirs = moved_by(model, ready.number(other.name))
        _stand(ready, data, setting)
        # What carries this joint along takes it away from the rest. What it carries, a latch, changes its own outline.
        if theirs[model.jnt_bodyid[number]]:
            continue
        carried = bool(own[theirs].any())
        if not carried and _apart(model, data, alone, theirs):
            continue
        meeting = sweep(model, data, number, everything if carried else theirs, PAIR_STEP_M).worst
        if meeting.depth > worst.depth:
            worst, beside = meeting, other.name
    return worst, beside


def _others(asset: Asset, joint: Joint, base: dict[str, float]) -> Iterator[tuple[Joint, dict[str, float]]]:
    """Each joint that may stand open while this one moves, and all that then stands open: rad or m."""
    for other in asset.joints:
        behind = open_before(asset, other)
        # What needs this joint open cannot be out while it moves.
        if other.name != joint.name and other.name not in base and joint.name not in behind:
            yield other, {**base, **behind, other.name: open_end(other)}


def _apart(model: mujoco.MjModel, data: mujoco.MjData, alone: SweepResult, theirs: Mask) -> bool:
    """True if what stands open lies outside all that the joint's part passes."""
    mujoco.mj_kinematics(model, data)
    low, high = bounds_of(model, data, np.flatnonzero(theirs[model.geom_bodyid]))
    return bool((low > alone.bounds[1]).any() or (high < alone.bounds[0]).any())


def _stand(ready: MotionModel, data: mujoco.MjData, setting: dict[str, float]) -> None:
    data.qpos[:] = ready.near.qpos0
    for name, value in setting.items():
        data.qpos[ready.address[name]] = value
