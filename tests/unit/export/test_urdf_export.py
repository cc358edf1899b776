"""A library or a kitchen becomes URDF whole or not at all, read back and compared."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets import export
from casa_assets.checks.package.parity import asset_differences
from casa_assets.errors import OutputError
from casa_assets.export import URDF, ExportResult, export_assets, export_scenes
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import resolve
from casa_assets.library import library as disk
from casa_assets.model.kitchen.scene import Scene
from tests.support.kitchen.scenes import corner
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import differences, tree


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


def test_every_asset_is_there_and_listed(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = list(export_assets(URDF, library, out))
    assert sorted(one.id for one in done) == sorted(asset.id for asset in loose_and_fixed())
    assert all(one.total == len(done) for one in done)
    rows = {row["id"]: row for row in json.loads((out / "urdf_export.json").read_text())["assets"]}
    for asset in loose_and_fixed():
        assert asset_differences(out / rows[asset.id]["urdf"], asset) == []
        assert rows[asset.id]["mass_kg"] == pytest.approx(asset.mass)
    assert {path.name for path in out.iterdir()} == {"assets", "urdf_export.json", "README.md", "ATTRIBUTION.md"}
    assert all(asset.id in (out / "ATTRIBUTION.md").read_text() for asset in loose_and_fixed())


def test_the_same_library_gives_the_same_bytes(library: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        list(export_assets(URDF, library, tmp_path / name))
    assert differences(tmp_path / "a", tmp_path / "b") == []


def test_a_changed_file_stops_it_and_the_earlier_export_stays(library: Path, tmp_path: Path) -> None:
    copy, out = Path(shutil.copytree(library, tmp_path / "lib")), tmp_path / "out"
    list(export_assets(URDF, copy, out))
    before = tree(out)
    (copy / "mug" / "mug_0123456789" / "model.xml").write_text("<mujoco/>")
    with pytest.raises(OutputError, match=r"model\.xml: was changed"):
        list(export_assets(URDF, copy, out))
    assert tree(out) == before


def test_what_is_not_an_export_is_left_alone(library: Path, tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.png").write_bytes(b"cat")
    with pytest.raises(OutputError, match="neither empty nor an earlier export"):
        list(export_assets(URDF, library, tmp_path / "photos"))
    with pytest.raises(OutputError, match="one inside the other"):
        list(export_assets(URDF, library, library / "urdf"))
    with pytest.raises(OutputError, match="holds no accepted asset"):
        list(export_assets(URDF, tmp_path / "photos", tmp_path / "out"))


def test_an_asset_that_reads_back_otherwise_is_refused(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A writer that puts the door elsewhere: that asset is left out, and why is told."""
    write = disk.write_files

    def spoil(folder: Path, files: object) -> None:
        write(folder, files)  # type: ignore[arg-type]
        for path in folder.glob("microwave*.urdf"):
            path.write_text(path.read_text().replace('xyz="-0.24 ', 'xyz="-0.25 '))

    monkeypatch.setattr(disk, "write_files", spoil)
    done = {one.id: one for one in export_assets(URDF, library, tmp_path / "out")}
    refused = done["microwave_0123456789"]
    assert refused.file == ""
    assert "bodies/door/position" in refused.message
    assert not (tmp_path / "out" / "assets" / "microwave_0123456789").exists()
    assert sum(bool(one.file) for one in done.values()) == len(done) - 1


def built(recipe: SceneRecipe, cache: Path) -> tuple[KitchenRequest, Scene]:
    return resolve(recipe), corner().replace(id=recipe.scene_id)


def in_this_process(work: Callable[[SceneRecipe], ExportResult], recipes: list[SceneRecipe], *_: object) -> object:
    """As run_batch, one after the other."""
    return list(enumerate(map(work, recipes)))


def test_who_made_the_assets_of_kitchens_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export, "build_scene", built)
    monkeypatch.setattr(export, "run_batch", in_this_process)
    ids = ["l_small__coastal", "l_small__rustic"]
    assert [one.id for one in export_scenes(URDF, ids, tmp_path / "out", 1)] == ids
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("scenes", "urdf_export.json", "README.md", "ATTRIBUTION.md")
    }
    lines = (tmp_path / "out" / "ATTRIBUTION.md").read_text().splitlines()
    assert all(f"`{name}`" in lines[2] for name in ids)
    told = {line.split("`")[1]: line for line in lines if line.startswith("- ")}
    assert told.keys() == {asset.id for asset in corner().assets}
    assert sum(line.startswith("- ") for line in lines) == len(told)
    for asset in corner().assets:
        assert f"## {asset.provenance.licence}" in lines
        assert asset.provenance.title in told[asset.id]
        assert f"by {asset.provenance.author}" in told[asset.id] or not asset.provenance.author
