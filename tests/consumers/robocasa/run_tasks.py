"""Runs RoboCasa's atomic tasks on exported kitchens and prints one line of JSON for each.

    python run_tasks.py EXPORT JOBS

JOBS: a file of JSON rows {"task", "kitchen", "seed", "roll"}. Each is made by `robosuite.make`, reset and moved to its
goal; with `roll` it is then reset again and the robot gets 5 s of random actions. Prints each row again with `error`
(empty where nothing is amiss), the task in words and seconds. Runs in RoboCasa's own environment, RoboCasa as it is.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
import robosuite
from drivers import DRIVERS

CONTROL_HZ = 20
ROLL_S = 5.0
SETTLE_STEPS = 8  # of 0.05 s
MAX_ATTEMPTS = 40
# An object or door that is faster than this after random actions has exploded.
MAX_SPEED_M_S, MAX_SPIN_RAD_S = 15.0, 150.0


def why(error: Exception) -> str:
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


def registered(export: str) -> Any:
    """The module of an export's kitchens, once robosuite is patched and objects and kitchens are registered."""
    sys.path.insert(0, export)
    import casa_kitchens
    import casa_objects

    casa_kitchens.patch_robosuite()
    assert "casa" in casa_objects.register()
    casa_kitchens.register()
    return casa_kitchens


def make(job: dict[str, Any], kitchens: Any) -> Any:
    return robosuite.make(
        job["task"],
        robots="PandaOmron",
        layout_and_style_ids=kitchens.layout_and_style_ids(*(job.get("kitchens") or [job["kitchen"]])),
        obj_registries=("casa",),
        seed=job["seed"],
        control_freq=CONTROL_HZ,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
    )


def touching(env: Any) -> str:
    model, data = env.sim.model, env.sim.data
    robot = (env.robots[0].robot_model.naming_prefix, "mobilebase0_", "gripper0_")
    for contact in data.contact[: data.ncon]:
        names = [model.geom_id2name(g) or "" for g in (contact.geom1, contact.geom2)]
        if len({name.startswith(robot) for name in names}) == 2 and contact.dist < 0.0:
            return ", ".join(names)
    return ""


def engine_warnings(env: Any) -> str:
    import mujoco

    found = env.sim.data.warning
    return ", ".join(f"{mujoco.mjtWarning(k).name} x{found[k].number}" for k in range(len(found)) if found[k].number)


def drive(env: Any, task: str) -> str:
    if env._check_success():
        return "is at its goal after the reset"
    start, attempts = env.sim.get_state(), 0
    for _ in itertools.islice(DRIVERS[task](env), MAX_ATTEMPTS):
        attempts += 1
        env.sim.forward()
        env.update_state()  # what a hand held there would latch, such as a lever on a spring
        for _ in range(SETTLE_STEPS):
            env.step(np.zeros(env.action_dim))
        if env._check_success():
            return ""
        env.sim.set_state(start)
        env.sim.forward()
    return f"did not reach its goal in {attempts} attempts"


def roll(env: Any, seed: int) -> str:
    """5 s of random actions; what is wrong, or empty."""
    rng = np.random.default_rng(seed)
    low, high = env.action_spec
    for _ in range(int(ROLL_S * CONTROL_HZ)):
        env.step(rng.uniform(low, high))
    model, data = env.sim.model, env.sim.data
    if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
        return "is not finite after random actions"
    for index in range(model.njnt):
        name = model.joint_id2name(index)
        speed = np.atleast_1d(data.get_joint_qvel(name))
        limits = np.full(speed.shape, MAX_SPIN_RAD_S if model.jnt_type[index] == 3 else MAX_SPEED_M_S)
        if len(speed) == 6:
            limits[3:] = MAX_SPIN_RAD_S
        if (np.abs(speed) > limits).any():
            return f"{name} moves at {np.abs(speed).max():.0f} after random actions"
    return ""


def run(job: dict[str, Any], kitchens: Any) -> dict[str, Any]:
    began = time.perf_counter()
    faults: list[str] = []
    answer: dict[str, Any] = {**job, "language": ""}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            env = make(job, kitchens)
            env.reset()
        answer["language"] = env.get_ep_meta()["lang"]
        if touched := touching(env):
            faults.append(f"reset: the robot touches {touched}")
        if missed := drive(env, job["task"]):
            faults.append(f"drive: {missed}")
        if job["roll"]:
            env.reset()
            faults += [f"roll: {fault}" for fault in [roll(env, job["seed"])] if fault]
        if told := engine_warnings(env):
            faults.append(f"warnings: {told}")
        env.close()
    except Exception as error:  # noqa: BLE001 - each task answers for itself
        faults.append(why(error))
        answer["trace"] = traceback.format_exc()[-3000:]
    return {**answer, "error": "; ".join(faults), "seconds": round(time.perf_counter() - began, 2)}


def main() -> None:
    jobs = json.loads(Path(sys.argv[2]).read_text(encoding="utf-8"))
    kitchens = registered(sys.argv[1])
    for job in jobs:
        with contextlib.redirect_stdout(io.StringIO()):
            answer = run(job, kitchens)
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
