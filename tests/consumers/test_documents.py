"""Every code block of README.md and docs/, run page by page in a separate folder, as a reader would."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from pathlib import Path

import mujoco
import pytest
import yaml
from lxml import etree
from pxr import Usd, UsdGeom

from tests.support.program.documents import ROOT, SAVED, Block, blocks, pages, shell

SCENE = "corridor__coastal"
DOOR = "microwave__microjoint"


def _stands_in_a_kitchen(place: Path) -> None:
    """Assert what the page promises of its kitchen, which has passed every check; place: folder of the page."""
    folder = place / "out" / "theirs"
    scene = folder / "scenes" / SCENE
    facts = json.loads((scene / "scene.json").read_text(encoding="utf-8"))
    fixture = next(row for row in facts["fixtures"] if row["name"] == "microwave")
    assert (fixture["family"], fixture["category"], fixture["base"]) == ("library", "microwave", "fixed")
    assert "microjoint" in fixture["joints"]
    assert any(task["afforded"] for task in facts["tasks"].values() if DOOR in task["joints"])
    model = mujoco.MjModel.from_xml_path(str(scene / "scene.xml"))
    assert model.joint(DOOR).id >= 0
    joint = model.joint(model.body("tea").jntadr[0])
    assert joint.type[0] == mujoco.mjtJoint.mjJNT_FREE  # it can be taken
    stage = Usd.Stage.Open(str(scene / "scene.usda"))
    assert {"tea", "microwave"} <= {prim.GetName() for prim in stage.Traverse()}
    # The pack needs neither library nor project.
    elsewhere = place / "out" / "unpacked"
    with zipfile.ZipFile(folder / "corridor.zip") as archive:
        archive.extractall(elsewhere)
    model = mujoco.MjModel.from_xml_path(str(elsewhere / SCENE / "scene.xml"))
    assert model.joint(DOOR).id >= 0
    makers = (elsewhere / SCENE / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert all(mesh in makers for mesh in ("microwave.obj", "teapot.glb", "oven.glb"))
    assert "wall_oven_fitted_" in makers  # the others fit as they are


pytestmark = pytest.mark.consumers
RUN = [p for p in pages() if any(b.language in ("sh", "python") and not b.reason for b in blocks(p))]


@pytest.mark.parametrize("page", RUN)
def test_page(page: str, tmp_path: Path, samples: Path) -> None:
    place = tmp_path / "place"
    shutil.copytree(samples, place)
    before = {p.name for p in place.iterdir()}
    for block in blocks(page):
        if block.reason:
            continue
        if name := SAVED.match(block.code):
            (place / name[1]).parent.mkdir(parents=True, exist_ok=True)
            # A reader saves it, or adds it to what is there.
            with (place / name[1]).open("a", encoding="utf-8") as file:
                file.write(block.code)
        elif block.language == "python":
            (place / "script.py").write_text(block.code, encoding="utf-8")
            done = shell("python script.py", place)
            assert done.returncode == 0, f"{block}\n{done.stderr[-3000:]}"
        elif block.language == "sh":
            _lines(block, place)
    assert {p.name for p in place.iterdir()} - before <= {"out", "script.py"}
    if page in JUDGED:
        JUDGED[page](place)


def _lines(block: Block, place: Path) -> None:
    """Each command by itself; its comment says so where it ends with another code than 0."""
    for line in block.code.replace("\\\n", " ").splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        done = shell(line, place)
        match = re.search(r"# exit (\d)", line)
        expected = int(match[1]) if match else 0
        assert done.returncode == expected, f"{block}: {line}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


def _stands_upright(place: Path) -> None:
    """The mug of the USD stage on that page is on 0.9 m and has the size that its certificate states."""
    path = place / "out" / "table.usda"
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert str(stage.GetDefaultPrim().GetPath()) == "/World"
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    box = cache.ComputeWorldBound(stage.GetPrimAtPath("/World/mug")).ComputeAlignedRange()
    size = [box.GetMax()[i] - box.GetMin()[i] for i in range(3)]
    assert abs(box.GetMin()[2] - 0.9) < 1e-3
    (certificate,) = (path.parent / "library" / "mug").glob("*/asset.json")
    stated = json.loads(certificate.read_text(encoding="utf-8"))["certificate"]["summary"]["extents"]
    assert size == pytest.approx(stated, abs=1e-3)
    assert 0.09 < size[2] < 0.11  # 97 mm high: upright, and in metres


def _gates_a_pull_request(place: Path) -> None:
    """The commands of the workflow that the page names, in a repository with one good and one broken mesh."""
    repository = place / "out" / "repository"
    for name, wanted in (("mug.obj", 0), ("banana.glb", 1)):
        (repository / "meshes").mkdir(parents=True, exist_ok=True)
        shutil.copy(place / "examples" / "meshes" / name, repository / "meshes")
        workflow = yaml.safe_load((ROOT / "examples" / "workflows" / "assets.yml").read_text(encoding="utf-8"))
        steps = [step["run"] for step in workflow["jobs"]["assets"]["steps"] if step.get("name") in ("ingest", "gate")]
        codes = [shell(step, repository).returncode for step in steps]
        assert codes == [0, wanted], name
    failed = etree.parse(repository / "out" / "assets.xml").xpath("//testcase[failure]/@name")
    assert failed == ["rejected-rate>5%"]
    assert json.loads((repository / "out" / "assets.sarif").read_text(encoding="utf-8"))["version"] == "2.1.0"


# What pages leave is looked at here, so that no other test makes it again.
JUDGED = {
    "docs/howto/meshes/mesh.md": _stands_upright,
    "docs/howto/use/gate.md": _gates_a_pull_request,
    "docs/howto/kitchens/own_assets.md": _stands_in_a_kitchen,
}
