"""From meshes to a checked kitchen: an articulated microwave and an ingested teapot stand in it, and go with it."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import mujoco
import pytest
from pxr import Usd

from tests.libraries import ROOT, casa, with_cache

pytestmark = pytest.mark.consumers
SCENE = "one_wall_small__lent"


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> Path:
    """A project with a library of two sample meshes, named by its style, and the kitchen, built and checked."""
    folder = tmp_path_factory.mktemp("lent")
    shutil.copytree(ROOT / "examples" / "appliances", folder / "meshes")
    _done("articulate", folder / "meshes" / "microwave.obj", "--out", folder / "library", "--jobs", 1)
    _done("ingest", ROOT / "examples" / "meshes" / "teapot.glb", "--out", folder / "library", "--jobs", 1)
    microwave, teapot = (next((folder / "library" / kind).iterdir()).name for kind in ("microwave", "teapot"))
    (folder / "casa.yaml").write_text("name: lent\nlibraries: [library]\n", encoding="utf-8")
    (folder / "styles").mkdir()
    style = (
        "like: modern_1\ntitle: Lent\n"
        f"models: {{microwave: 'library:{microwave}', kettle: {{preset: 'library:{teapot}', scale: 1.1}}}}\n"
    )
    (folder / "styles" / "lent.yaml").write_text(style, encoding="utf-8")
    with_cache(folder / "scenes", cache)
    _done("scenes", "check", SCENE, "--out", folder / "scenes", "--project", folder, "--no-3d", "--jobs", 1)
    return folder


def test_the_microwave_can_be_opened_as_those_of_families(place: Path) -> None:
    facts = json.loads((place / "scenes" / SCENE / "scene.json").read_text(encoding="utf-8"))
    fixture = next(row for row in facts["fixtures"] if row["name"] == "microwave")
    assert (fixture["family"], fixture["category"], fixture["base"]) == ("library", "microwave", "fixed")
    assert "microjoint" in fixture["joints"]
    doors = [task for task in facts["tasks"].values() if "microwave__microjoint" in task["joints"]]
    assert any(task["afforded"] for task in doors)


def test_both_formats_hold_them(place: Path) -> None:
    folder = place / "scenes" / SCENE
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    assert model.joint("microwave__microjoint").id >= 0
    joint = model.joint(model.body("kettle").jntadr[0])
    assert joint.type[0] == mujoco.mjtJoint.mjJNT_FREE  # it can be taken
    stage = Usd.Stage.Open(str(folder / "scene.usda"))
    names = {prim.GetName() for prim in stage.Traverse()}
    assert {"kettle", "microwave"} <= names


def test_a_pack_of_it_needs_neither_library_nor_project(place: Path, tmp_path: Path) -> None:
    packed = tmp_path / "lent.zip"
    scenes = place / "scenes"
    _done("scenes", "pack", SCENE, "--zip", "--scenes-folder", scenes, "--out", packed, "--project", place)
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / SCENE / "scene.xml"))
    assert model.joint("microwave__microjoint").id >= 0
    makers = (tmp_path / SCENE / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert "microwave.obj" in makers
    assert "teapot_fitted_" in makers


def _done(*words: object) -> None:
    done = casa(*words)
    assert done.returncode == 0, done.stdout + done.stderr
