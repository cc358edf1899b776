"""Files of an entry: a stranger's library is read inside its own folders alone; an asset is its JSON and its files."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.addons.robocasa.run import export
from casa_assets.errors import OutputError
from casa_assets.library.entry_files import asset_from_manifest, checked_model, file_inside, manifest_of, read_asset
from casa_assets.library.library import Library
from casa_assets.library.pairs import read_rows
from casa_assets.library.search import search_by_words
from casa_assets.model.asset.asset import Asset
from casa_assets.show.reports.library_page import write as write_report
from casa_assets.show.reports.pictures import models
from tests.support.asset.assets import EVERY, textured_box
from tests.support.asset.packages import written
from tests.support.library.built_libraries import keep
from tests.support.library.libraries import edited

BAD_NAMES = ["../../secret", "/etc/passwd", "meshes/../../../secret", "", "a\0b", "..\\secret", "meshes", "gone", 3]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("made") / "library", [textured_box()])


@pytest.fixture
def entry(made: Path, tmp_path: Path) -> Path:
    """The folder of an asset in a copy of the library; two folders above it lies a file called `secret`."""
    shutil.copytree(made, tmp_path / "library")
    (tmp_path / "library" / "secret").write_text("v 0 0 0\n", encoding="ascii")
    (folder,) = Library(tmp_path / "library").accepted()
    return folder


@pytest.mark.parametrize("name", BAD_NAMES)
def test_a_mesh_out_of_the_folder_is_told_with_file_and_place(entry: Path, name: object) -> None:
    with edited(entry / "asset.json") as data:
        data["asset"]["links"][0]["visuals"][0]["mesh"]["obj"] = name
    with pytest.raises(OutputError, match="asset/links/0/visuals/0/mesh/obj") as error:
        read_asset(entry)
    assert error.value.path == str(entry / "asset.json")


def test_an_export_reads_nothing_from_elsewhere(entry: Path, tmp_path: Path) -> None:
    assert isinstance(read_asset(entry), Asset)
    with edited(entry / "asset.json") as data:
        data["asset"]["materials"][0]["base_color_texture"]["png"] = "../../secret"
    place = r"asset/materials/0/base_color_texture/png: '\.\./\.\./secret' leaves the folder of the asset"
    with pytest.raises(OutputError, match=place):
        list(export(tmp_path / "library", tmp_path / "out"))
    assert not (tmp_path / "out").exists()


LINKS: tuple[tuple[str, Callable[[Path], object]], ...] = (
    ("meshes/*", lambda library: [read_asset(folder) for folder in Library(library).accepted()]),
    ("meshes/*", lambda library: list(models([library]))),
    ("asset.json", lambda library: write_report(library, library.parent / "report.html")),
    ("preview.png", lambda library: write_report(library, library.parent / "report.html")),
    ("asset.json", lambda library: search_by_words("box", Library(library), 3)),
    ("asset.json", lambda library: list(read_rows(Library(library)))),
)


@pytest.mark.parametrize(("name", "read"), LINKS)
def test_links_that_leave_the_folder_are_not_followed(entry: Path, name: str, read: Callable[[Path], object]) -> None:
    path = next(entry.glob(name))
    path.unlink()
    path.symlink_to(entry.parent.parent / "secret")
    with pytest.raises(OutputError, match="is a link that leaves the folder"):
        read(entry.parent.parent)


def test_a_pipe_is_no_file_and_a_picture_that_is_none_is_told(entry: Path, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="no regular file"):
        file_inside(tmp_path, "pipe", tmp_path / "asset.json", "files/0")
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


def test_round_trip(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for make in EVERY:
        with subtests.test(make=make.__name__):
            tmp_path = tmp_path_factory.mktemp("case")
            asset = make()
            package = written(asset, tmp_path)
            text = json.dumps(manifest_of(asset))
            back = asset_from_manifest(json.loads(text), package.root)
            again = asset_from_manifest(json.loads(json.dumps(manifest_of(back))), package.root)
            assert back.digest == again.digest, "files hold float32, so a second trip through them changes nothing"
            assert "base64" not in text, "meshes and pictures are files"


def test_a_missing_file_and_damaged_data_are_errors(tmp_path: Path) -> None:
    package, data = written(textured_box(), tmp_path), manifest_of(textured_box())
    for change in ({"links": None}, {"links": [{}]}, {"materials": 3}, {"surprise": 1}):
        with pytest.raises(OutputError, match="damaged"):
            asset_from_manifest({**data, **change}, package.root)
    for path in ("meshes/*.obj", "usd/textures/*.png"):
        file = next(package.root.glob(path))
        kept = file.read_bytes()
        file.unlink()
        with pytest.raises(OutputError, match="damaged"):
            asset_from_manifest(data, package.root)
        file.write_bytes(kept)
