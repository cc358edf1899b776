"""Steps batch forms of kitchens with mujoco_warp on the CPU, and prints what came of it as one JSON object.

    python warp_kitchen.py STEPS FOLDER ...

Runs in an environment of its own. Each folder holds `scene_batch.xml` and `batch.json`. A drawer is pulled in both
engines from the same state, and everything else is left alone.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp

# Steps in MuJoCo after which everything sleeps.
SETTLE = 250
PULL_N = 20.0


def main() -> None:
    warp.config.quiet = True
    warp.init()
    steps = int(sys.argv[1])
    with warp.ScopedDevice("cpu"):
        told = {Path(folder).name: stepped(Path(folder), steps) for folder in sys.argv[2:]}
    print(json.dumps(told))


def stepped(folder: Path, steps: int) -> dict[str, Any]:
    sizes = json.loads((folder / "batch.json").read_text())["engine"]
    model = mujoco.MjModel.from_xml_path(str(folder / "scene_batch.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_step(model, data, nstep=SETTLE)
    device_model = mjw.put_model(model)
    limits = {name: sizes[name] for name in ("nconmax", "njmax", "nccdmax")}
    worlds = mjw.put_data(model, data, nworld=1, nvmax=min(sizes["nvmax"], model.nv), **limits)
    asleep = int((worlds.tree_asleep.numpy() >= 0).sum())
    pulled = next(
        number
        for number in range(model.njnt)
        if model.jnt_type[number] == mujoco.mjtJoint.mjJNT_SLIDE and model.body_rootid[model.jnt_bodyid[number]] != 0
    )
    dof = int(model.jnt_dofadr[pulled])
    low, high = model.jnt_range[pulled]
    data.qfrc_applied[dof] = PULL_N if abs(high) > abs(low) else -PULL_N
    worlds.qfrc_applied.assign(np.array([data.qfrc_applied], dtype=np.float32))
    contacts = rows = 0
    for _ in range(steps):
        mjw.step(device_model, worlds)
        contacts = max(contacts, int(worlds.nacon.numpy()[0]))
        rows = max(rows, int(worlds.nefc.numpy()[0]))
    mujoco.mj_step(model, data, nstep=steps)
    qpos = worlds.qpos.numpy()[0]
    return {
        "pairs": len(device_model.nxn_geom_pair_filtered),
        "trees": int(model.ntree),
        "asleep": asleep,
        "way": float(data.qpos[model.jnt_qposadr[pulled]]),
        "off": float(np.abs(qpos - data.qpos).max()),
        "contacts": contacts,
        "rows": rows,
        "limits": limits,
    }


if __name__ == "__main__":
    main()
