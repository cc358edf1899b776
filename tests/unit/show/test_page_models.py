"""Models of the assets of a library for its page: made once, told to the page, and gone with their assets."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from lxml import html

from casa_assets.library.library import Library
from casa_assets.show.page.page_models import MADE_BY, folder_of, models_of, write_models
from casa_assets.show.page.page_template import viewer_name
from casa_assets.show.reports.library_page import write
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import casa_here

pytestmark = pytest.mark.content("code", "show.reports", keep=0)


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return keep(tmp_path / "lib", loose_and_fixed())


def test_every_asset_has_a_model_that_is_made_once(library: Path) -> None:
    page = library / "report.html"
    names = {folder.name for folder in Library(library).accepted()}
    told = list(write_models(library, page, jobs=1))
    assert told == [(done, len(names)) for done in range(len(names) + 1)]
    models = folder_of(page)
    assert {path.name for path in models.iterdir()} == {MADE_BY, viewer_name(), *(f"{name}.glb.js" for name in names)}
    before = {path.name: path.stat().st_mtime_ns for path in models.iterdir()}
    assert list(write_models(library, page, jobs=1)) == [(len(names), len(names))]
    assert {path.name: path.stat().st_mtime_ns for path in models.iterdir()} == before


def test_the_model_of_an_asset_that_was_written_again_is_made_again(library: Path) -> None:
    page = library / "report.html"
    list(write_models(library, page, jobs=1))
    corrected = next(Library(library).accepted())
    model = folder_of(page) / f"{corrected.name}.glb.js"
    before = model.read_bytes()
    model.write_bytes(b"as it was")
    (corrected / "asset.json").touch()
    list(write_models(library, page, jobs=1))
    assert model.read_bytes() == before


def test_models_of_other_code_are_made_again(library: Path) -> None:
    page = library / "report.html"
    list(write_models(library, page, jobs=1))
    models = folder_of(page)
    before = {path.name: path.read_bytes() for path in models.iterdir()}
    (models / MADE_BY).write_text("another version", encoding="utf-8")
    (models / "viewer_0.js").write_text("of another version", encoding="utf-8")
    for path in models.glob("*.glb.js"):
        path.write_bytes(b"of another version")
    list(write_models(library, page, jobs=1))
    assert {path.name: path.read_bytes() for path in models.iterdir()} == before


def test_the_model_of_an_asset_that_is_gone_goes(library: Path) -> None:
    page = library / "report.html"
    list(write_models(library, page, jobs=1))
    gone = next(Library(library).accepted())
    shutil.rmtree(gone)
    list(write_models(library, page, jobs=1))
    assert not (folder_of(page) / f"{gone.name}.glb.js").exists()


def test_the_page_is_told_where_they_are(library: Path) -> None:
    page = library / "report.html"

    def data() -> dict[str, object]:
        (text,) = html.fromstring(page.read_text(encoding="utf-8")).xpath("//script[@id='data']/text()")
        found: dict[str, object] = json.loads(text)
        return found

    write(library, page)
    assert data()["models"] is None
    assert "popUpModel" not in page.read_text(encoding="utf-8")
    write(library, page, models=models_of(page))
    viewer = f"./report_models/{viewer_name()}"
    assert data()["models"] == {"folder": "./report_models", "suffix": ".glb.js", "viewer": viewer}
    assert "popUpModel" in page.read_text(encoding="utf-8")


def test_the_command_makes_them_on_request(library: Path) -> None:
    assert casa_here("report", "--library", library).returncode == 0
    assert not folder_of(library / "report.html").exists()
    assert casa_here("report", "--library", library, "--3d").returncode == 0
    assert len(list(folder_of(library / "report.html").glob("*.glb.js"))) == len(loose_and_fixed())
