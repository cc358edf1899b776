"""Reads a kitchen in the oldest MuJoCo that we support, lets it stand, and prints what came of it as one JSON object.

    python mujoco337_kitchen.py scene.xml

Needs mujoco and numpy alone.
"""

from __future__ import annotations

import json
import sys
import warnings

import mujoco
import numpy as np

# Steps until things have settled, and then while they are watched.
SETTLE, WATCH = 500, 1000


def main() -> None:
    """Read, settle, watch, tell."""
    said: list[str] = []
    mujoco.set_mju_user_warning(said.append)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = mujoco.MjModel.from_xml_path(sys.argv[1])
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, nstep=SETTLE)
    stood = data.xpos.copy()
    mujoco.mj_step(model, data, nstep=WATCH)
    went = np.linalg.norm(data.xpos - stood, axis=1)
    found = {
        "mujoco": mujoco.__version__,
        "warnings": said + [str(w.message) for w in caught],
        "troubles": sum(int(w.number) for w in data.warning),
        "bodies": [model.body(i).name for i in range(1, model.nbody)],
        "joints": sorted(model.joint(i).name for i in range(model.njnt)),
        "keys": [model.key(i).name for i in range(model.nkey)],
        "farthest": [model.body(int(went.argmax())).name, float(went.max())],
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
