"""Moves each joint of an asset through its range and looks for parts that run into each other."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.readers import mujoco_load

STEPS = 24


def deepest(scene: Path) -> dict[str, float]:
    """Joint name -> deepest penetration between bodies of the asset, metres, over its range with all others at zero.

    Contacts that the model excludes do not count, nor do those with the floor. Empty where the scene does not compile.
    """
    model = mujoco_load.load(scene).model
    if model is None:
        return {}
    found: dict[str, float] = {}
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            continue
        found[model.joint(joint).name] = 0.0
        low, high = model.jnt_range[joint]
        for value in np.linspace(low, high, STEPS):
            mujoco.mj_resetData(model, data)
            data.qpos[model.jnt_qposadr[joint]] = value
            mujoco.mj_forward(model, data)
            found[model.joint(joint).name] = max(found[model.joint(joint).name], _inside(model, data))
    return found


def _inside(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Deepest contact between two bodies neither of which is the world."""
    depth = 0.0
    for contact in data.contact:
        if all(model.geom_bodyid[g] != 0 for g in contact.geom):
            depth = max(depth, -float(contact.dist))
    return depth
