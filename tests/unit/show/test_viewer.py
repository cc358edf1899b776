"""The viewer of pages: its bundle is that of its sources, and a model comes out of its script file as it went in."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from pathlib import Path

from casa_assets.formats.gltf import asset_glb
from casa_assets.show import page as viewer
from casa_assets.show.page.page_template import model_script, put_model, put_viewer, viewer_script
from tests.support.asset.assets import rigid_mug

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


def test_the_licence_of_what_is_inside_lies_beside_it() -> None:
    version = json.loads((BUNDLE / "package.json").read_text(encoding="utf-8"))["dependencies"]["three"]
    text = (BUNDLE / "LICENSES.txt").read_text(encoding="utf-8")
    assert f"three.js {version}" in text
    assert "MIT License" in text


def test_the_bundle_names_no_address_that_it_would_load() -> None:
    """Namespaces of XML are names and not loaded; three.js names its own pages in warnings."""
    found = set(re.findall(rb"https?://[^\s\"'`)]+", viewer_script()))
    assert {
        url for url in found if b"w3.org" not in url and b"threejs.org" not in url and b"github.com" not in url
    } == set()


def test_a_model_comes_out_as_it_went_in() -> None:
    glb = asset_glb(rigid_mug())
    script = model_script("mug_0123456789", glb)
    assert script == model_script("mug_0123456789", glb)
    match = re.fullmatch(rb'casaModel\("mug_0123456789","([A-Za-z0-9+/=]+)"\);\n', script)
    assert match is not None
    assert gzip.decompress(base64.b64decode(match[1])) == glb


def test_the_viewer_is_written_once(tmp_path: Path) -> None:
    name = put_viewer(tmp_path / "assets")
    written = tmp_path / "assets" / name
    assert written.read_bytes() == viewer_script()
    assert hashlib.sha256(viewer_script()).hexdigest()[:12] in name
    before = written.stat().st_mtime_ns
    assert put_viewer(tmp_path / "assets") == name
    assert written.stat().st_mtime_ns == before
    written.write_bytes(b"half")
    put_viewer(tmp_path / "assets")
    assert written.read_bytes() == viewer_script()
    assert put_model(tmp_path, "mug", b"glTF") == "mug.glb.js"
