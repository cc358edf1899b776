"""Reads MJCF files in the MuJoCo that runs this, and prints a JSON object per file of what came of it.

    python old_mujoco_load.py SETTLE WATCH FILE...

Needs mujoco and numpy alone. A model is put into its first keyframe, if it has one, and stepped SETTLE times until
things have settled, and then WATCH times while they are watched.
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path

import mujoco
import numpy as np


def main() -> None:
    settle, watch = map(int, sys.argv[1:3])
    for path in sys.argv[3:]:
        print(json.dumps(told(Path(path), settle, watch)), flush=True)


def told(path: Path, settle: int, watch: int) -> dict[str, object]:
    said: list[str] = []
    mujoco.set_mju_user_warning(said.append)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            model = mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            return {"mujoco": mujoco.__version__, "file": str(path), "error": str(error)}
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    mujoco.mj_step(model, data, nstep=settle)
    before = data.xpos.copy()
    mujoco.mj_step(model, data, nstep=watch)
    names = [model.body(i).name for i in range(model.nbody)]
    went = np.linalg.norm(data.xpos - before, axis=1)
    return {
        "mujoco": mujoco.__version__,
        "file": str(path),
        "warnings": said + [str(w.message) for w in caught],
        "troubles": sum(int(w.number) for w in data.warning),
        "bodies": names[1:],
        "joints": sorted(model.joint(i).name for i in range(model.njnt)),
        "parallel_lights": [model.light(i).name for i in range(model.nlight) if is_parallel(model, i)],
        "keys": [model.key(i).name for i in range(model.nkey)],
        "masses": {name: float(m) for name, m in zip(names[1:], model.body_mass[1:], strict=True) if name},
        "moved": {name: float(m) for name, m in zip(names, went, strict=True) if name},
        "outside": outside(model, data),
    }


def is_parallel(model: mujoco.MjModel, light: int) -> bool:
    """Whether a light comes from one direction; 3.3.1 has a flag for it, later ones a type."""
    if hasattr(model, "light_type"):
        return bool(model.light_type[light] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    return bool(model.light_directional[light])


def outside(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """How far hinges and slides are out of their range, rad or m."""
    found = {}
    for i in range(model.njnt):
        if model.jnt_type[i] in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE) and model.jnt_limited[i]:
            at, (low, high) = data.qpos[model.jnt_qposadr[i]], model.jnt_range[i]
            found[model.joint(i).name] = float(max(low - at, at - high, 0.0))
    return found


if __name__ == "__main__":
    main()
