"""Parks a PandaOmron of robosuite before the sink of a kitchen of ours, then pulls a drawer. Prints one JSON object.

    python robosuite_kitchen.py FOLDER DRAWER

Runs in robosuite's own environment. FOLDER holds scene.xml and scene.json; DRAWER is a joint. robosuite's classes take
scene.xml as it is: they read its bodies, assets and exclusions, and leave out its options, keyframes and texts.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import robosuite
from robosuite.environments.manipulation.manipulation_env import ManipulationEnv
from robosuite.models.arenas import Arena
from robosuite.models.tasks import ManipulationTask

STEPS, CONTROL_HZ = 200, 20
# How far the drawer is pulled, metres.
PULL_M = 0.15


class Kitchen(ManipulationEnv):
    """A kitchen without a task."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
        sink = next(f["name"] for f in facts["fixtures"] if f["category"] == "sink")
        self.parking = facts["parking"][sink]["shut"]
        super().__init__(
            robots="PandaOmron",
            has_renderer=False,
            has_offscreen_renderer=False,
            use_camera_obs=False,
            render_camera="overview",
            control_freq=CONTROL_HZ,
            horizon=100_000,
            ignore_done=True,
            initialization_noise=None,
        )

    def _load_model(self) -> None:
        super()._load_model()
        arena = Arena(str(self.folder / "scene.xml"))
        self.robots[0].robot_model.set_base_xpos((self.parking["x"], self.parking["y"], 0.0))
        self.robots[0].robot_model.set_base_ori((0.0, 0.0, self.parking["yaw"]))
        self.model = ManipulationTask(arena, [self.robots[0].robot_model])

    def reward(self, action: Any = None) -> float:
        """Nothing is to be done here."""
        return 0.0


def positions(model: mujoco.MjModel, data: mujoco.MjData, mine: bool) -> dict[str, float]:
    names = {model.joint(i).name: i for i in range(model.njnt) if model.jnt_type[i] >= int(mujoco.mjtJoint.mjJNT_SLIDE)}
    own = ("robot0_", "mobilebase0_", "gripper0_")
    picked = {name: i for name, i in names.items() if name.startswith(own) == mine}
    return {name: float(data.qpos[model.jnt_qposadr[i]]) for name, i in picked.items()}


def base(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    return data.body("mobilebase0_base").xpos.copy()


def between(model: mujoco.MjModel, data: mujoco.MjData) -> list[str]:
    """Pairs of bodies, one of the robot and one not, that touch; its wheels may stand on the floor."""
    own = ("robot0_", "mobilebase0_", "gripper0_")
    found = set()
    for pair in data.contact.geom:
        names = [model.body(model.geom_bodyid[g]).name for g in pair]
        if sum(name.startswith(own) for name in names) == 1 and "floor" not in names:
            found.add(" ".join(sorted(names)))
    return sorted(found)


def main() -> None:
    folder, drawer = Path(sys.argv[1]), sys.argv[2]
    said: list[str] = []
    mujoco.set_mju_user_warning(said.append)
    env = Kitchen(folder)
    env.reset()
    model, data = env.sim.model._model, env.sim.data._data
    first, stood = positions(model, data, False), base(model, data)
    finite = True
    for _ in range(STEPS):
        env.step(np.zeros(env.action_dim))
        finite &= bool(np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all())
    later = positions(model, data, False)
    found = {
        "robosuite": robosuite.__version__,
        "mujoco": mujoco.__version__,
        "bodies": [model.body(i).name for i in range(1, model.nbody)],
        "joints": sorted(first),
        "finite": finite,
        "stands": base(model, data).tolist(),
        "moved_m": float(np.linalg.norm(base(model, data) - stood)),
        "crept": {name: later[name] - first[name] for name in first if abs(later[name] - first[name]) > 1e-4},
        "touching": between(model, data),
    }
    found["drawer"] = pulled(env, drawer)
    found["warnings"] = said + [str(i) for i, w in enumerate(data.warning) if w.number]
    print(json.dumps(found))


def pulled(env: Kitchen, drawer: str) -> dict[str, float]:
    """Sets a drawer open, steps on, and tells where its body and its joint then are."""
    model, data = env.sim.model._model, env.sim.data._data
    joint = model.joint(drawer)
    body = int(joint.bodyid[0])
    shut = data.xpos[body].copy()
    # A drawer of ours opens towards the front, which may be either end of its range.
    data.qpos[joint.qposadr[0]] = PULL_M if joint.range[1] > PULL_M else -PULL_M
    for _ in range(CONTROL_HZ // 2):
        env.step(np.zeros(env.action_dim))
    return {"joint_m": float(data.qpos[joint.qposadr[0]]), "moved_m": float(np.linalg.norm(data.xpos[body] - shut))}


if __name__ == "__main__":
    main()
