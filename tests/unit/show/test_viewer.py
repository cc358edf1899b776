"""The viewer of pages: its bundle is that of its sources; models come out of their files, and are made once."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
import shutil
from pathlib import Path

import pytest
from lxml import html

from casa_assets.formats.gltf import asset_glb
from casa_assets.library.library import Library
from casa_assets.show import page as viewer
from casa_assets.show.page.page_template import (
    MADE_BY,
    folder_of,
    model_script,
    models_of,
    viewer_name,
    viewer_script,
    write_models,
)
from casa_assets.show.reports.library_page import write
from tests.support.asset.assets import rigid_mug
from tests.support.library.built_libraries import keep, loose_and_fixed

BUNDLE = Path(viewer.__file__).parent / "bundle"


def test_the_bundle_is_built_from_the_sources_beside_it() -> None:
    """The first line of the bundle has the digest of its sources, see build.mjs; `./dev viewer` builds it anew."""
    names = ["build.mjs", "package-lock.json", "package.json", *(f"src/{p.name}" for p in sorted(BUNDLE.glob("src/*")))]
    digest = hashlib.sha256(b"".join(n.encode() + b"\0" + (BUNDLE / n).read_bytes() + b"\0" for n in names)).hexdigest()
    first = viewer_script().split(b"\n", 1)[0].decode()
    assert digest in first, "the sources of the viewer have changed since: ./dev viewer"


def test_the_lock_names_no_registry() -> None:
    text = (BUNDLE / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in text
    packages = json.loads(text)["packages"]
    wanted = json.loads((BUNDLE / "package.json").read_text(encoding="utf-8"))
    for name, version in (wanted["dependencies"] | wanted["devDependencies"]).items():
        assert packages[f"node_modules/{name}"]["version"] == version
        assert packages[f"node_modules/{name}"]["integrity"]


def test_the_bundle_names_no_address_that_it_would_load() -> None:
    """Namespaces of XML are names and not loaded; three.js names its own pages in warnings."""
    found = set(re.findall(rb"https?://[^\s\"'`)]+", viewer_script()))
    assert {url for url in found if not re.search(rb"w3\.org|threejs\.org|github\.com", url)} == set()


def test_a_model_comes_out_as_it_went_in() -> None:
    glb = asset_glb(rigid_mug())
    script = model_script("mug_0123456789", glb)
    assert script == model_script("mug_0123456789", glb)
    match = re.fullmatch(rb'casaModel\("mug_0123456789","([A-Za-z0-9+/=]+)"\);\n', script)
    assert match is not None
    assert gzip.decompress(base64.b64decode(match[1])) == glb


of_reports = pytest.mark.content("code", "show.reports", keep=0)


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return keep(tmp_path / "lib", loose_and_fixed())


@of_reports
def test_models_are_made_once_and_follow_their_assets_and_the_code(library: Path) -> None:
    page, models = library / "report.html", folder_of(library / "report.html")
    names = {folder.name for folder in Library(library).accepted()}
    assert list(write_models(library, page, jobs=1)) == [(done, len(names)) for done in range(len(names) + 1)]
    assert {path.name for path in models.iterdir()} == {MADE_BY, viewer_name(), *(f"{name}.glb.js" for name in names)}
    times = {path.name: path.stat().st_mtime_ns for path in models.iterdir()}
    assert list(write_models(library, page, jobs=1)) == [(len(names), len(names))]
    assert {path.name: path.stat().st_mtime_ns for path in models.iterdir()} == times
    corrected, gone = list(Library(library).accepted())[:2]
    before = {path.name: path.read_bytes() for path in models.iterdir()}
    (models / f"{corrected.name}.glb.js").write_bytes(b"as it was")
    (corrected / "asset.json").touch()
    list(write_models(library, page, jobs=1))
    assert {path.name: path.read_bytes() for path in models.iterdir()} == before, "an asset was written again"
    (models / MADE_BY).write_text("another version", encoding="utf-8")
    (models / "viewer_0.js").write_text("of another version", encoding="utf-8")
    for path in models.glob("*.glb.js"):
        path.write_bytes(b"of another version")
    list(write_models(library, page, jobs=1))
    assert {path.name: path.read_bytes() for path in models.iterdir()} == before, "other code had made them"
    shutil.rmtree(gone)
    list(write_models(library, page, jobs=1))
    assert not (models / f"{gone.name}.glb.js").exists()


@of_reports
def test_the_page_is_told_where_they_are(library: Path) -> None:
    page = library / "report.html"

    viewer = f"./report_models/{viewer_name()}"
    files = {"folder": "./report_models", "suffix": ".glb.js", "viewer": viewer}
    for models, told in ((None, None), (models_of(page), files)):
        write(library, page, models=models)
        text = page.read_text(encoding="utf-8")
        (data,) = html.fromstring(text).xpath("//script[@id='data']/text()")
        assert json.loads(data)["models"] == told
        assert ("popUpModel" in text) == (models is not None)
