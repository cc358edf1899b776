"""The environment of `examples/kitchen_env.py`: what a learner sees, does and is told.

This file also runs it as a learner would and prints what came of it as JSON, in a process of its own, because MuJoCo
chooses how it draws while it is imported.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import casa_assets as casa
from examples.kitchen_env import START_MICROWAVE, KitchenEnv
from tests.support.library.libraries import ROOT

PRESS = START_MICROWAVE._replace(plan="one_wall_small")
DRAWER = "main_drawers__drawer2_slidejoint"
PULL = PRESS._replace(
    fixture="main_drawers", state="drawer2_slidejoint", value="open", target="main_drawers__drawer2_handle"
)


def walk(env: KitchenEnv, seed: int) -> list[float]:
    env.action_space.seed(seed)
    observation, _ = env.reset(seed=seed)
    found = observation.tolist()
    for _ in range(20):
        observation, reward, *_ = env.step(env.action_space.sample())
        found += [*observation.tolist(), reward]
    return found


def press(env: KitchenEnv) -> dict[str, Any]:
    observation, info = env.reset(seed=3)
    found: dict[str, Any] = {"before": info["states"]["microwave"]["power"], "rewards": []}
    for _ in range(40):
        observation, reward, terminated, _, info = env.step(np.clip(-20 * observation[:3], -1, 1))
        found["rewards"].append(reward)
        if terminated:
            break
    return {**found, "success": info["is_success"], "after": info["states"]["microwave"]}


def pulled(env: KitchenEnv) -> list[bool]:
    """Whether a drawer that has to be opened is open, before and after it is put at the end of its way."""
    env.task = PULL
    env.reset(seed=0)
    found = [env.step(np.zeros(3, np.float32))[2]]
    env.data.joint(DRAWER).qpos[0] = max(env.model.joint(DRAWER).range, key=abs)
    mujoco.mj_forward(env.model, env.data)
    return [*found, env.step(np.zeros(3, np.float32))[2]]


def painted() -> dict[str, float]:
    """Mean difference from the first picture, of 255: with another seed, and with the first one again."""
    env = KitchenEnv(PRESS, render_mode="rgb_array")
    env.choices = {"counter": casa.surfaces()["counter"][:3]}
    shots = {}
    for name, seed in (("first", 0), ("other", 2), ("again", 0)):
        env.reset(seed=seed)
        env.data.qpos[-3:] = (0.0, 0.0, 5.0)  # out of the picture
        mujoco.mj_forward(env.model, env.data)
        shots[name] = env.render().astype(float)
    return {name: float(np.abs(shots[name] - shots["first"]).mean()) for name in ("other", "again")}


def main() -> None:
    gymnasium.register("Kitchen-v0", entry_point=KitchenEnv, max_episode_steps=200)
    made = gymnasium.make("Kitchen-v0", task=PRESS, detail="light", render_mode="rgb_array").unwrapped
    assert isinstance(made, KitchenEnv)
    light = KitchenEnv(PRESS, "light")
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        check_env(made)
    found = {
        "warnings": [str(warning.message) for warning in warned],
        "walks": [walk(light, 5), walk(light, 6), walk(light, 5), walk(made, 5)],
        "press": press(light),
        "drawer": pulled(light),
        "pictures": painted(),
    }
    print(json.dumps(found))


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    backend = os.environ.get("MUJOCO_GL", "egl")
    environment = {**os.environ, "MUJOCO_GL": backend, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    done = subprocess.run(
        [sys.executable, __file__], cwd=ROOT, env=environment, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def test_a_seed_decides_all_and_gymnasium_finds_no_fault(found: dict[str, Any]) -> None:
    assert found["warnings"] == []
    first, other, again, elsewhere = found["walks"]
    assert first == again == elsewhere != other
    assert found["pictures"]["again"] == 0.0
    assert found["pictures"]["other"] > 1.0


def test_a_button_is_pressed_and_a_drawer_is_open_when_it_is_out(found: dict[str, Any]) -> None:
    press = found["press"]
    assert (press["before"], press["success"], press["after"]["power"]) == ("off", True, "on")
    *on_the_way, last = press["rewards"]
    assert on_the_way == sorted(on_the_way), "nearer is better"
    assert max(on_the_way) < 0 < last
    assert found["drawer"] == [False, True]


if __name__ == "__main__":
    main()
