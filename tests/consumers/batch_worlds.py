"""Steps kitchens side by side in an engine and in MuJoCo, and prints how far they differ as one JSON object.

    python batch_worlds.py ENGINE STEPS PACKAGES FOLDER ...

PACKAGES is the folder that the engine is installed in, an environment of its own, which is looked at after ours. Each
FOLDER holds `scene_batch.xml`. One joint of each kitchen is pulled, everything else is left
alone; at last the second kitchen is reset.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import casa_assets as casa

PULL_N, TURN_NM = 20.0, 6.0


def main() -> None:
    engine, steps, packages, *folders = sys.argv[1:]
    sys.path.append(packages)
    # MJX is a part of the package mujoco.
    mujoco.__path__.append(str(Path(packages) / "mujoco"))
    theirs = casa.batch(folders, engine=engine, device="cpu")  # type: ignore[call-overload]
    # Where cylinders had to become boxes, MuJoCo steps the same boxes.
    ours = [mujoco.MjData(kitchen.model) for kitchen in theirs.kitchens]
    pulled = [a_joint(kitchen) for kitchen in theirs.kitchens]
    forces = np.zeros((len(ours), theirs.kitchens[0].model.nv))
    for world, (kitchen, data) in enumerate(zip(theirs.kitchens, ours, strict=True)):
        data.qpos[:] = kitchen.rows.qpos[0]
        joint = kitchen.joints[pulled[world]]
        low, high = kitchen.model.jnt_range[joint]
        force = PULL_N if kitchen.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE else TURN_NM
        forces[world, kitchen.model.jnt_dofadr[joint]] = force if abs(high) > abs(low) else -force
        data.qfrc_applied[:] = forces[world]
    push(engine, theirs, forces)
    theirs.step(int(steps))
    found = theirs.qpos
    for kitchen, data in zip(theirs.kitchens, ours, strict=True):
        mujoco.mj_step(kitchen.model, data, nstep=int(steps))
    told = {
        kitchen.id: compared(kitchen, data, row, pulled[world])
        for world, (kitchen, data, row) in enumerate(zip(theirs.kitchens, ours, found, strict=True))
    }
    theirs.reset([1])
    again, begun = theirs.qpos, theirs.kitchens[1].rows.qpos[0]
    reset = {"begun": float(np.abs(again[1] - begun).max()), "others": float(np.abs(again[0] - found[0]).max())}
    sizes = {"ngeom": theirs.kitchens[0].model.ngeom, "bytes_per_world": theirs.engine.bytes_per_world}
    print(json.dumps({**sizes, "kitchens": told, "reset": reset}))


def a_joint(kitchen: casa.BatchKitchen) -> str:
    """The drawer of a kitchen that opens farthest, or its door."""
    model = kitchen.model
    kinds = {name: int(model.jnt_type[joint]) for name, joint in kitchen.joints.items()}
    fixed = {name for name, joint in kitchen.joints.items() if model.jnt_limited[joint] and "__" in name}
    for kind in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE):
        found = {name for name in fixed if kinds[name] == kind}
        if found:
            return max(sorted(found), key=lambda name: float(np.abs(model.jnt_range[kitchen.joints[name]]).max()))
    raise AssertionError(f"{kitchen.id}: nothing opens")


def push(engine: str, batch: casa.Batch[Any], forces: np.ndarray) -> None:
    """Apply forces to the joints of each world, as each engine wants them."""
    if engine == "mujoco_warp":
        batch.engine.data.qfrc_applied.assign(forces.astype(np.float32))
    elif engine == "mjx":
        import jax.numpy as jp

        batch.engine.data = batch.engine.data.replace(qfrc_applied=jp.asarray(forces, dtype=jp.float32))
    else:
        batch.engine.control.joint_f.assign(forces.astype(np.float32).ravel())


def compared(kitchen: casa.BatchKitchen, data: mujoco.MjData, row: np.ndarray, pulled: str) -> dict[str, Any]:
    """How far a joint was pulled, m or rad, and how far positions of the kitchen's joints differ."""
    off = {}
    for name, joint in kitchen.joints.items():
        first = int(kitchen.model.jnt_qposadr[joint])
        width = 3 if kitchen.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE else 1
        off[name] = float(np.abs(row[first : first + width] - data.qpos[first : first + width]).max())
    at = kitchen.address(pulled)
    worst = max(off, key=lambda name: off[name])
    way = float(data.qpos[at] - kitchen.rows.qpos[0, at])
    return {"pulled": pulled, "way": way, "off": off[pulled], "worst": worst, "worst_off": off[worst]}


if __name__ == "__main__":
    main()
