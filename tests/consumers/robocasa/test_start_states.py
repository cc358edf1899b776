"""Start states in RoboCasa itself: a kitchen that is lived in is reset to each of them, and tasks begin in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.library.libraries import casa
from tests.support.program.environments import printed, rows_of

pytestmark = pytest.mark.consumers
KITCHEN = "one_wall_small__rustic__o16"
COUNT, THINGS = 3, 6
# Each state is simulated for 2 s as RoboCasa has the kitchen; then two environments begin in one, and in any.
SCRIPT = """
import json, sys
sys.path.insert(0, FOLDER)
import mujoco, numpy as np, robocasa, robosuite
import casa_kitchens
casa_kitchens.patch_robosuite()
[name] = casa_kitchens.register()
states = casa_kitchens.start_states(name)
options = dict(robots="PandaOmron", layout_and_style_ids=casa_kitchens.layout_and_style_ids(name), seed=0,
               has_renderer=False, has_offscreen_renderer=False, use_camera_obs=False)
env = robosuite.make("Kitchen", **options)
env.reset()
model, data = env.sim.model._model, env.sim.data._data
loose = [i for i in range(model.nbody) if model.body(i).name.startswith("object_")]
for number in range(len(states["qpos"])):
    casa_kitchens.reset_to(env, number)
    mujoco.mj_forward(model, data)
    deep, before = -float(data.contact.dist.min(initial=0)), data.xpos[loose].copy()
    axis = env.sim.data.get_site_xpos("mobilebase0_center")[:2]
    parked = float(np.abs(axis - states["base"][number][:2]).max())
    mujoco.mj_step(model, data, nstep=round(2 / model.opt.timestep))
    moved = float(np.linalg.norm(data.xpos[loose] - before, axis=1).max())
    print(json.dumps(["state", deep, moved, parked]))
env.close()
joints = [joint for joint in states["joints"] if joint["name"].startswith("object_")]
for begun in (1, "random"):
    casa_kitchens.begin_with(begun)
    env = robosuite.make("NavigateKitchen", **options)
    env.reset()
    places = [env.sim.data.get_joint_qpos(j["name"])[:3] for j in joints]
    far = [max(float(abs(p - row[j["address"]:j["address"] + 3]).max()) for p, j in zip(places, joints))
           for row in states["qpos"]]
    print(json.dumps(["begun", str(begun), far]))
    env.close()
"""


def test_each_state_is_at_rest_in_robocasa_too_and_an_environment_begins_in_the_one_asked_for(tmp_path: Path) -> None:
    scenes, out = tmp_path / "scenes", tmp_path / "out"
    asked = ("--count", COUNT, "--objects", THINGS, "--jobs", 1)
    for words in (
        ("scenes", "states", KITCHEN, *asked, "--out", scenes),
        ("export", "robocasa", "--scenes", KITCHEN, "--states", scenes, "--out", out),
    ):
        done = casa(*words)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    (tmp_path / "script.py").write_text(SCRIPT.replace("FOLDER", repr(str(out))), encoding="utf-8")
    rows = rows_of(printed("robocasa", str(tmp_path / "script.py"), timeout_s=1800), '["')
    found = [row[1:] for row in rows if row[0] == "state"]
    assert len(found) == COUNT
    for deep, moved, parked in found:
        assert deep <= 0.001
        assert moved <= 0.005
        assert parked <= 0.001
    begun = {row[1]: row[2] for row in rows if row[0] == "begun"}
    for state, far in begun.items():
        nearest = min(range(COUNT), key=lambda k: far[k])
        assert far[nearest] <= 0.005
        assert sorted(far)[1] > 0.05
        assert state == "random" or nearest == int(state)
    assert set(begun) == {"1", "random"}
