"""One file of a kitchen: it loads where nothing else is, states the same facts, and is the same bytes each time."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import mujoco
import pytest
from pxr import Usd, UsdUtils
from typer.testing import CliRunner

from casa_assets.checks.package.usd import validator_findings
from casa_assets.checks.readers import usd_facts
from casa_assets.cli.verbs.scenes import app
from casa_assets.errors import OutputError
from casa_assets.layouts.run.pack import ALIGNMENT, PackKind, members_of, pack_scene
from casa_assets.layouts.run.recipe import SceneResult

pytestmark = pytest.mark.content("code", "layouts.run", keep=0)

SCENE = "one_wall_small__coastal"
Checked = tuple[Path, SceneResult]
Packs = dict[PackKind, Path]
ENTRY_HEADER = 30


@pytest.fixture(scope="module")
def packs(checked_kitchen: Checked, tmp_path_factory: pytest.TempPathFactory) -> Packs:
    folder = tmp_path_factory.mktemp("packs")
    return {kind: pack_scene(SCENE, checked_kitchen[0], kind, folder / f"kitchen.{kind}").file for kind in PackKind}


@pytest.fixture
def usdz(packs: Packs) -> Path:
    return packs[PackKind.USDZ]


@pytest.fixture(scope="module")
def unpacked(packs: Packs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the kitchen, unzipped where nothing else is."""
    folder = tmp_path_factory.mktemp("elsewhere")
    with zipfile.ZipFile(packs[PackKind.ZIP]) as archive:
        archive.extractall(folder)
    assert [path.name for path in folder.iterdir()] == [SCENE]
    return folder / SCENE


def facts(stage: Usd.Stage) -> dict[str, Any]:
    return usd_facts.facts_of_scene_stage(usd_facts.StageReading(stage, scene=True))


def test_a_zip_says_the_same_where_nothing_else_is(unpacked: Path, checked_kitchen: Checked) -> None:
    original = checked_kitchen[0] / SCENE
    for file in ("scene.xml", "scene_light.xml"):
        here, there = (mujoco.MjModel.from_xml_path(str(folder / file)) for folder in (original, unpacked))
        assert there.names == here.names
        for field in ("body_mass", "geom_size", "geom_pos", "jnt_range", "key_qpos", "mesh_vert", "tex_data"):
            assert (getattr(there, field) == getattr(here, field)).all(), field
    for file in ("scene.usda", "scene_nested.usda"):
        assert facts(Usd.Stage.Open(str(unpacked / file))) == facts(Usd.Stage.Open(str(original / file)))
        layers, pictures, unresolved = UsdUtils.ComputeAllDependencies(str(unpacked / file))
        assert (unresolved, bool(pictures)) == ([], True)
        assert all(Path(path).is_relative_to(unpacked) for path in (*pictures, *(layer.realPath for layer in layers)))
    assert json.loads((unpacked / "scene.json").read_text(encoding="utf-8"))["id"] == SCENE
    machines = [json.loads(p.read_text(encoding="utf-8")) for p in (unpacked / "assets/behavior").glob("*.json")]
    assert machines
    assert all(machine["behavior"]["variables"] for machine in machines)
    makers = (unpacked / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert "## Apache-2.0" in makers
    assert "- `dishwasher_" in makers
    compile((unpacked / "isaac_lab.py").read_text(encoding="utf-8"), "isaac_lab.py", "exec")


def test_a_usdz_opens_with_all_that_it_names(usdz: Path, checked_kitchen: Checked) -> None:
    stage = Usd.Stage.Open(str(usdz))
    assert stage.GetCompositionErrors() == []
    assert facts(stage) == facts(Usd.Stage.Open(str(checked_kitchen[0] / SCENE / "scene.usda")))
    nested = Usd.Stage.Open(f"{usdz}[scene_nested.usda]")
    assert nested.GetPrimAtPath("/World/main_dishwasher/object/door")
    layers, pictures, unresolved = UsdUtils.ComputeAllDependencies(str(usdz))
    assert (unresolved, bool(pictures)) == ([], True)
    assert all(layer.realPath.startswith(str(usdz)) for layer in layers)
    assert all(str(picture).startswith(f"{usdz}[") for picture in pictures)


def test_a_usdz_is_stored_plainly_at_multiples_of_64_bytes(usdz: Path) -> None:
    assert validator_findings(Usd.Stage.Open(str(usdz))) == []
    data = usdz.read_bytes()
    with zipfile.ZipFile(usdz) as archive:
        entries = archive.infolist()
    assert entries[0].filename == "scene.usda"
    for entry in entries:
        head = entry.header_offset
        name, extra = (int.from_bytes(data[head + i : head + i + 2], "little") for i in (26, 28))
        begin = head + ENTRY_HEADER + name + extra
        assert begin % ALIGNMENT == 0, entry.filename
        assert entry.compress_type == zipfile.ZIP_STORED
        assert entry.compress_size == entry.file_size


class TestPack:
    def test_same_scene_is_same_bytes(self, checked_kitchen: Checked, packs: Packs, tmp_path: Path) -> None:
        for kind, file in packs.items():
            again = pack_scene(SCENE, checked_kitchen[0], kind, tmp_path / kind / "again")
            assert again.file.read_bytes() == file.read_bytes(), kind
            assert not again.built
            assert [path.name for path in again.file.parent.iterdir()] == ["again"]

    def test_what_is_missing_or_no_file_is_told(self, checked_kitchen: Checked, tmp_path: Path) -> None:
        with pytest.raises(OutputError, match="name a file"):
            pack_scene(SCENE, checked_kitchen[0], PackKind.ZIP, tmp_path)
        shutil.copytree(checked_kitchen[0], tmp_path / "scenes", ignore=shutil.ignore_patterns(".casa"))
        picture = next((tmp_path / "scenes/assets/textures").glob("*_color_*.png"))
        picture.unlink()
        with pytest.raises(OutputError, match=f"{picture.name}.*--force"):
            members_of(tmp_path / "scenes" / SCENE)

    def test_verb_tells_what_it_wrote(self, checked_kitchen: Checked, packs: Packs, tmp_path: Path) -> None:
        command = ["pack", SCENE, "--zip", "--scenes-folder", str(checked_kitchen[0]), "--out", str(tmp_path / "k")]
        told = CliRunner().invoke(app, [*command, "--json"])
        assert told.exit_code == 0, told.output
        row = json.loads(told.stdout)
        assert (row["id"], row["kind"], row["built"]) == (SCENE, "zip", False)
        assert row["bytes"] == packs[PackKind.ZIP].stat().st_size == (tmp_path / "k.zip").stat().st_size
        assert list(tmp_path.iterdir()) == [tmp_path / "k.zip"], "the suffix is added"
        assert CliRunner().invoke(app, ["pack", SCENE]).exit_code == 2
