"""Whether moving parts keep clear of everything else of the asset, over their whole range."""

from __future__ import annotations

import mujoco
import numpy as np

from casa_assets.checks.check import Measured
from casa_assets.checks.motion import Movable, far, movable, opened
from casa_assets.checks.package import Package
from casa_assets.model.asset import Asset, Joint

STEPS = 20  # poses over a range, both ends included
FINE = 8  # more of them between two poses where something is near


def keeps_clear(package: Package, limit: float | None) -> Measured:
    """No part runs into another over any joint's range, alone and with each other joint open; metres of the worst."""
    assert limit is not None
    ready, asset = movable(package), package.asset
    if ready is None:
        return Measured()
    problems = []
    worst = 0.0
    for joint in asset.joints:
        depth, others, meets = _deepest(ready, asset, joint, limit)
        worst = max(worst, depth)
        if depth > limit:
            beside = f" while {', '.join(sorted(others))} stand open" if others else ""
            problems.append((f"joints/{joint.name}", f"{meets[0]} sinks {depth:.4f} m into {meets[1]}{beside}"))
    return Measured(worst, tuple(problems))


def _deepest(
    ready: Movable, asset: Asset, joint: Joint, limit: float
) -> tuple[float, dict[str, float], tuple[str, str]]:
    """The deepest meeting over all sweeps of a joint: metres, the joints that stood open, and what met."""
    base = opened(asset, joint)
    settings = [base]
    for other in asset.joints:
        waits = other.behind is not None and other.behind not in base
        if other.name == joint.name or other.name in base or waits or joint.name in opened(asset, other):
            continue
        settings.append({**base, other.name: far(other)})
    worst: tuple[float, dict[str, float], tuple[str, str]] = (0.0, {}, ("", ""))
    data = mujoco.MjData(ready.model)
    for setting in settings:
        depth, meets = _sweep(ready, data, joint, setting, limit)
        if depth > worst[0]:
            worst = (depth, {k: v for k, v in setting.items() if k not in base}, meets)
    return worst


def _sweep(
    ready: Movable, data: mujoco.MjData, joint: Joint, setting: dict[str, float], limit: float
) -> tuple[float, tuple[str, str]]:
    model = ready.model
    data.qpos[:] = model.qpos0
    for name, value in setting.items():
        data.qpos[ready.address[name]] = value
    at = ready.address[joint.name]
    worst, meets = 0.0, ("", "")
    # What stood open before it moves meets nothing through this joint's fault: only its own motion counts.
    moved = _subtree(model, int(model.joint(joint.name).bodyid[0]))
    for value in np.linspace(joint.range[0], joint.range[1], STEPS):
        data.qpos[at] = value
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        for i in range(data.ncon):
            contact = data.contact[i]
            if -contact.dist <= max(worst, 0.0):
                continue
            one, two = (int(model.geom_bodyid[g]) for g in contact.geom)
            if (one in moved) == (two in moved):
                continue
            worst = -float(contact.dist)
            meets = (model.geom(contact.geom[0]).name, model.geom(contact.geom[1]).name)
            if worst > 20 * limit:
                return worst, meets
    return worst, meets


def _subtree(model: mujoco.MjModel, body: int) -> set[int]:
    found = {body}
    for other in range(body + 1, model.nbody):
        if int(model.body_parentid[other]) in found:
            found.add(other)
    return found
