"""A whole kitchen in programs that others wrote, each in an environment of its own, and in our oldest MuJoCo."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import pytest

from casa_assets.layouts.run import scene_folders
from casa_assets.layouts.run.recipe import SceneRecipe
from tests.consumers.old_mujoco_load import is_parallel
from tests.consumers.test_old_mujoco import VERSIONS, told
from tests.support.library.libraries import ROOT
from tests.support.program.environments import found_by

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("scenes")
    made = scene_folders.build_one(SceneRecipe("l_small", "coastal"), out, drawn=False)
    assert made.folder, made.message
    return Path(made.folder)


@pytest.fixture(scope="module")
def model(kitchen: Path) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(kitchen / "scene.xml"))


@pytest.fixture(scope="module")
def robosuite(kitchen: Path) -> Any:
    return found_by("robosuite", "robosuite_kitchen.py", kitchen, "main_drawers__drawer0_slidejoint")


@pytest.fixture(scope="module")
def newton(kitchen: Path) -> Any:
    return found_by("newton", "newton_kitchen.py", kitchen / "scene_nested.usda", 50)


def joints(model: mujoco.MjModel) -> dict[str, int]:
    free = mujoco.mjtJoint.mjJNT_FREE
    return {model.joint(i).name: i for i in range(model.njnt) if model.jnt_type[i] != free}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("file", "merged"), [("scene.xml", False), ("scene_light.xml", True)])
def test_an_old_mujoco_loads_it_in_silence_and_it_stands_still(
    file: str, merged: bool, version: str, kitchen: Path, model: mujoco.MjModel
) -> None:
    """The light form keeps the bodies that have joints; what is fixed to them is theirs, but in 3.3.1."""
    (found,) = told(version, [kitchen / file], settle=500, watch=1000)
    assert (found.get("error"), found["warnings"], found["troubles"]) == (None, [], 0)
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    kept = [name for name in bodies if model.body(name).jntnum[0] or not merged]
    assert [name for name in found["bodies"] if name in kept or version != "3.3.1"] == kept
    assert set(found["bodies"]) <= set(bodies)
    assert found["joints"] == sorted(model.joint(i).name for i in range(model.njnt))
    assert found["keys"] == ["start", "closed", "open"]
    assert found["parallel_lights"] == [model.light(i).name for i in range(model.nlight) if is_parallel(model, i)]
    assert {name: way for name, way in found["moved"].items() if way > 0.0003} == {}
    assert {name: way for name, way in found["outside"].items() if way > 1e-5} == {}


def test_all_of_it_is_there_in_robosuite(robosuite: Any, model: mujoco.MjModel) -> None:
    assert (robosuite["robosuite"], robosuite["mujoco"]) == ("1.5.2", "3.3.7")
    assert {model.body(i).name for i in range(1, model.nbody)} <= set(robosuite["bodies"])
    assert robosuite["joints"] == sorted(joints(model))


def test_a_robot_of_robosuite_stands_before_the_sink_for_200_control_steps(robosuite: Any, kitchen: Path) -> None:
    parking = json.loads((kitchen / "scene.json").read_text(encoding="utf-8"))["parking"]
    spots = [(at["shut"]["x"], at["shut"]["y"]) for at in parking.values() if at["shut"]]
    assert tuple(robosuite["stands"][:2]) in [pytest.approx(spot, abs=1e-6) for spot in spots]
    assert (robosuite["finite"], robosuite["warnings"], robosuite["touching"]) == (True, [], [])
    assert robosuite["moved_m"] < 0.001


def test_in_robosuite_what_is_shut_stays_shut_and_a_drawer_is_pulled(robosuite: Any) -> None:
    # Keys and a toaster's lever yield under their own weight by some tenths of a millimetre.
    assert {name: way for name, way in robosuite["crept"].items() if abs(way) > 0.001} == {}
    assert robosuite["drawer"]["joint_m"] == pytest.approx(-0.15, abs=0.005)
    assert robosuite["drawer"]["moved_m"] == pytest.approx(0.15, abs=0.005)


def test_bodies_and_joints_of_newton_are_ours(newton: Any, model: mujoco.MjModel) -> None:
    assert newton["newton"] == "1.8.0"
    masses = sorted(float(m) for m in model.body_mass[1:])
    assert sorted(newton["masses"].values()) == pytest.approx(masses, rel=1e-5)
    kinds = {"PRISMATIC": mujoco.mjtJoint.mjJNT_SLIDE, "REVOLUTE": mujoco.mjtJoint.mjJNT_HINGE}
    kinds["FREE"] = mujoco.mjtJoint.mjJNT_FREE
    assert {k: newton["kinds"][k] for k in kinds} == {k: int((model.jnt_type == v).sum()) for k, v in kinds.items()}


def test_bodies_of_newton_are_where_ours_are(newton: Any, model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for path, pose in newton["bodies"].items():
        _, _, placement, *links = path.split("/")
        name = placement if links == ["object"] else f"{placement}__{links[-1]}"
        assert pose[:3] == pytest.approx(data.body(name).xpos, abs=1e-4), path
    depths = {path.count("/") for path in newton["bodies"]}
    assert max(depths) > 4, "no body is below another"
    # Nothing explodes.
    assert newton["finite"]
    body, way = newton["farthest"]
    assert way < 0.005, f"{body} went {way} m"
    assert max(newton["crept"].values()) < 0.002


@pytest.mark.parametrize("camera", ["overview", "at_sink"])
def test_blender_draws_what_our_cameras_see(camera: str, kitchen: Path) -> None:
    picture = ROOT / "out" / "consumers" / f"blender_{camera}.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    found = found_by("blender", "blender_kitchen.py", kitchen / "scene.usda", camera, picture)
    assert found["blender"].startswith("5.0.")
    assert (found["missing"], found["bare"]) == ([], [])
    pictures = {path.name for path in (kitchen.parent / "assets" / "textures").glob("*.png")}
    assert pictures <= set(found["pictures"])
    assert {"overview", "at_sink", "at_stove"} <= set(found["cameras"])
    assert "sun" in found["lights"]
    assert min(found["from_all_sides"]) > 0.1
    assert max(found["black"], found["white"]) < 0.01
    assert found["colors"] > 300
    assert 60 < found["mean"] < 200
