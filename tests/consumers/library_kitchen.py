"""What docs/howto/kitchens/own_assets.md leaves: a kitchen in which meshes of others stand, and its pack."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import mujoco
from pxr import Usd

SCENE = "corridor__coastal"
DOOR = "microwave__microjoint"


def judge(place: Path) -> None:
    """Assert what the page promises of its kitchen, which has passed every check; place: folder of the page."""
    folder = place / "out" / "theirs"
    scene = folder / "scenes" / SCENE
    _can_be_used_as_those_of_families(json.loads((scene / "scene.json").read_text(encoding="utf-8")))
    model = mujoco.MjModel.from_xml_path(str(scene / "scene.xml"))
    assert model.joint(DOOR).id >= 0
    joint = model.joint(model.body("tea").jntadr[0])
    assert joint.type[0] == mujoco.mjtJoint.mjJNT_FREE  # it can be taken
    stage = Usd.Stage.Open(str(scene / "scene.usda"))
    assert {"tea", "microwave"} <= {prim.GetName() for prim in stage.Traverse()}
    _needs_neither_library_nor_project(folder / "corridor.zip", place / "out" / "unpacked")


def _can_be_used_as_those_of_families(facts: dict[str, object]) -> None:
    fixtures, tasks = facts["fixtures"], facts["tasks"]
    assert isinstance(fixtures, list)
    assert isinstance(tasks, dict)
    fixture = next(row for row in fixtures if row["name"] == "microwave")
    assert (fixture["family"], fixture["category"], fixture["base"]) == ("library", "microwave", "fixed")
    assert "microjoint" in fixture["joints"]
    doors = [task for task in tasks.values() if DOOR in task["joints"]]
    assert any(task["afforded"] for task in doors)


def _needs_neither_library_nor_project(pack: Path, elsewhere: Path) -> None:
    with zipfile.ZipFile(pack) as archive:
        archive.extractall(elsewhere)
    model = mujoco.MjModel.from_xml_path(str(elsewhere / SCENE / "scene.xml"))
    assert model.joint(DOOR).id >= 0
    makers = (elsewhere / SCENE / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert all(mesh in makers for mesh in ("microwave.obj", "teapot.glb", "oven.glb"))
    assert "wall_oven_fitted_" in makers  # the others fit as they are
