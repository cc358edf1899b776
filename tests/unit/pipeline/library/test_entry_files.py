"""A library of a stranger: what its files name is read inside its own folders alone, and the place is told."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.model.asset.asset import Asset
from casa_assets.pipeline.dedup.pairs import read_rows
from casa_assets.pipeline.dedup.search import search_by_words
from casa_assets.pipeline.export.robocasa import export
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import checked_model, file_inside
from casa_assets.pipeline.reports.library_page import write as write_report
from casa_assets.pipeline.reports.pictures import models
from tests.assets import textured_box
from tests.built_libraries import keep

BAD_NAMES = ["../../secret", "/etc/passwd", "meshes/../../../secret", "", "a\0b", "..\\secret", "meshes", "gone", 3]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("made") / "library", [textured_box()])


@pytest.fixture
def entry(made: Path, tmp_path: Path) -> Path:
    """The folder of an asset in a copy of the library; two folders above it lies a file called `secret`."""
    shutil.copytree(made, tmp_path / "library")
    (tmp_path / "library" / "secret").write_text("v 0 0 0\n", encoding="ascii")
    (folder,) = disk.Library(tmp_path / "library").accepted()
    return folder


def edit(folder: Path, change: Callable[[dict[str, object]], None]) -> None:
    path = folder / "asset.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data["asset"])
    path.write_text(json.dumps(data), encoding="utf-8")


@pytest.mark.parametrize("name", BAD_NAMES)
def test_a_mesh_out_of_the_folder_is_told_with_file_and_place(entry: Path, name: object) -> None:
    edit(entry, lambda asset: asset["links"][0]["visuals"][0]["mesh"].update(obj=name))  # type: ignore[index]
    with pytest.raises(OutputError, match="asset/links/0/visuals/0/mesh/obj") as error:
        disk.read_asset(entry)
    assert error.value.path == str(entry / "asset.json")


def test_a_picture_out_of_the_folder_is_told(entry: Path) -> None:
    def change(asset: dict[str, object]) -> None:
        next(m for m in asset["materials"] if m["base_color_texture"])["base_color_texture"]["png"] = "../../secret"  # type: ignore[attr-defined]

    edit(entry, change)
    with pytest.raises(
        OutputError, match=r"asset/materials/0/base_color_texture/png: '\.\./\.\./secret' leaves the folder"
    ):
        disk.read_asset(entry)


def a_link(entry: Path, name: str) -> None:
    (entry / name).unlink()
    (entry / name).symlink_to(entry.parent.parent / "secret")


def test_links_that_leave_the_folder_are_not_followed(entry: Path, tmp_path: Path) -> None:
    mesh = next((entry / "meshes").iterdir())
    a_link(entry, mesh.relative_to(entry).as_posix())
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        disk.read_asset(entry)
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        list(models([tmp_path / "library"]))


@pytest.mark.parametrize("name", ["asset.json", "preview.png"])
def test_the_report_follows_no_link_either(entry: Path, tmp_path: Path, name: str) -> None:
    a_link(entry, name)
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        write_report(tmp_path / "library", tmp_path / "report.html")


def test_search_and_export_follow_no_link_either(entry: Path, tmp_path: Path) -> None:
    a_link(entry, "asset.json")
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        search_by_words("box", disk.Library(tmp_path / "library"), 3)
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        list(read_rows(disk.Library(tmp_path / "library")))


def test_a_picture_that_is_none_is_told(entry: Path, tmp_path: Path) -> None:
    (entry / "preview.png").write_bytes(b"root:x:0:0")
    with pytest.raises(OutputError, match=r"preview\.png.*is no picture"):
        write_report(tmp_path / "library", tmp_path / "report.html")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('file="meshes/', 'file="../../meshes/', "leaves the folder of the asset"),
        ('<compiler angle="radian"', '<compiler meshdir="/etc" angle="radian"', "compiler/meshdir"),
        ("<asset>", '<include file="/etc/passwd"/><asset>', "includes another file"),
        ("<asset>", "<asset", "cannot be read"),
    ],
)
def test_a_model_loads_nothing_from_elsewhere(entry: Path, old: str, new: str, message: str) -> None:
    assert checked_model(entry / "model.xml") == entry / "model.xml"
    text = (entry / "model.xml").read_text(encoding="utf-8")
    assert old in text
    (entry / "model.xml").write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(OutputError, match=message):
        list(models([entry]))


def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="no regular file"):
        file_inside(tmp_path, "pipe", tmp_path / "asset.json", "files/0")


def test_an_export_reads_nothing_from_elsewhere(entry: Path, tmp_path: Path) -> None:
    edit(entry, lambda asset: asset["links"][0]["visuals"][0]["mesh"].update(obj="../../secret"))  # type: ignore[index]
    with pytest.raises(OutputError, match="leaves the folder of the asset"):
        list(export(tmp_path / "library", tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_what_lies_inside_is_read(entry: Path) -> None:
    assert isinstance(disk.read_asset(entry), Asset)
