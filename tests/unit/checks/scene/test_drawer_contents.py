"""What lies in a drawer goes along with it: in checks, and in the named poses of both formats."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.scene.forms import formats_agree
from casa_assets.checks.scene.opening import joints_open_without_collision
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.scene import Resting, Scene
from tests.support.asset.cupboard import cupboard
from tests.support.kitchen.rooms import at, block, in_all_forms, room, subject

LIMIT = 0.001
IN_DRAWER = Resting(placement="thing_0", link="drawer", region="drawer_int")


def filled(height: float, resting: Resting | None = IN_DRAWER) -> Scene:
    """A cupboard with a box of that height on the floor of its drawer, which is 0.445 m above the ground."""
    box = block("box", (0.1, 0.1, height), Base.FREE, "carton")
    scene = room((cupboard(), at(0.0, 0.0, 0.0)), (box, at(0.1, 0.0, 0.4452)))
    placements = tuple(p.replace(resting=resting) if p.name == "thing_1" else p for p in scene.placements)
    return scene.replace(placements=placements)


@pytest.mark.parametrize(
    ("height", "resting", "clash"),
    [(0.05, IN_DRAWER, False), (0.05, None, True), (0.2, IN_DRAWER, True)],
)
def test_drawer_opens_with_what_fits_in_it(height: float, resting: Resting | None, clash: bool, tmp_path: Path) -> None:
    found = joints_open_without_collision(subject(filled(height, resting), tmp_path), LIMIT)
    told = [message for pointer, message in found.problems if pointer == "joints/thing_0__drawer_slide"]
    assert bool(told) == clash
    if resting and clash:
        assert "thing_1" in told[0]


def test_it_is_in_the_open_drawer_of_the_open_pose(tmp_path: Path) -> None:
    files = in_all_forms(filled(0.05), tmp_path)
    model = mujoco.MjModel.from_xml_path(str(files.scene_subject.mjcf))
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_kinematics(model, data)
    before = data.body("thing_1").xpos.copy()
    mujoco.mj_resetDataKeyframe(model, data, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "open"))
    mujoco.mj_kinematics(model, data)
    assert data.body("thing_1").xpos - before == pytest.approx([0.0, -0.28, 0.0], abs=1e-6)
    assert formats_agree(files, 0.0).problems == ()


def test_an_object_stays_closed_where_the_kitchen_is_open(tmp_path: Path) -> None:
    scene = room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard().replace(id="small_cupboard"), at(1.5, 0.0, 0.0)))
    on_top = Resting(placement="thing_0", link=cupboard().root.name, region="top")
    kept = tuple(p.replace(resting=on_top) if p.name == "thing_1" else p for p in scene.placements)
    files = in_all_forms(scene.replace(placements=kept), tmp_path)
    model = mujoco.MjModel.from_xml_path(str(files.scene_subject.mjcf))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "open"))
    assert data.joint("thing_0__drawer_slide").qpos[0] > 0.2
    assert data.joint("thing_1__drawer_slide").qpos[0] == 0.0
    assert formats_agree(files, 0.0).problems == ()


def test_all_links_of_an_object_go_along_with_the_drawer(tmp_path: Path) -> None:
    jar = cupboard().replace(id="small_cupboard", base=Base.FREE)
    scene = room((cupboard(), at(0.0, 0.0, 0.0)), (jar, at(1.5, 0.0, 0.0)))
    kept = tuple(p.replace(resting=IN_DRAWER) if p.name == "thing_1" else p for p in scene.placements)
    files = in_all_forms(scene.replace(placements=kept), tmp_path)
    model = mujoco.MjModel.from_xml_path(str(files.scene_subject.mjcf))
    data, places = mujoco.MjData(model), {}
    for pose in ("closed", "open"):
        mujoco.mj_resetDataKeyframe(model, data, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, pose))
        mujoco.mj_kinematics(model, data)
        places[pose] = data.body("thing_1__drawer").xpos.copy()
    assert places["open"] - places["closed"] == pytest.approx([0.0, -0.28, 0.0], abs=1e-6)
    assert formats_agree(files, 0.0).problems == ()
