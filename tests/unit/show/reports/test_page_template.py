"""Pages: one frame, escaped words, templates in keys; the catalogue, the page about a folder, the viewer of models."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import hashlib
import itertools
import json
import re
import shutil
from pathlib import Path

import pytest
from lxml import html

from casa_assets import registry
from casa_assets.articulate.run import review_page
from casa_assets.cache import cache_key
from casa_assets.cache.cache_key import reach
from casa_assets.formats.gltf import asset_glb
from casa_assets.library import attribution
from casa_assets.library.library import Library
from casa_assets.show import page as viewer
from casa_assets.show.page import kitchen_report, page_template
from casa_assets.show.page.page_template import ModelFiles, Words, viewer_name, viewer_script, write_models
from casa_assets.show.reports import catalogue, findings, home, kitchens, library_page
from casa_assets.show.reports.library_page import write
from casa_assets.show.view import review, server
from tests.support.asset.assets import rigid_mug
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.unit.library.test_alike import FIRST, OTHER
from tests.unit.show.reports.test_kitchen_pages import scene
from tests.unit.show.reports.test_library_page import entry, refused

FOLDER = Path(page_template.__file__).parent / page_template.FOLDER
HOSTILE = "<script>alert(1)</script>"
PAGES = {
    "library/page.html": library_page,
    "library/section.html": library_page,
    "kitchens/report.html": kitchen_report,
    "kitchens/index.html": kitchens,
    "catalogue/catalogue.html": catalogue,
    "home/page.html": home,
    "articulate/review.html": review_page,
    "review/page.html": review,
    "view/page.html": server,
}
FRAME = {"frame/base.html", "frame/base.css", "frame/document.css"}
STRANGE = catalogue.category_row("apple", HOSTILE, (0.15, 0.2), (0.07, 0.08), (900, 1000), (1, 1))


def pages() -> dict[str, str]:
    row = kitchens.SceneRow("galley__rustic", "galley", "rustic")
    found = findings.Findings(HOSTILE, ".", (), (), None)
    return {
        "library": library_page.render(found, Words({}, {}), []),
        "kitchens": kitchens.index_page([kitchens.SceneCard(row, 1, 1)], HOSTILE),
        "catalogue": catalogue.page([], [STRANGE], {}),
        "review": review.render_page([], {}, HOSTILE),
        "articulated": review_page.render_page(Library(Path("nowhere")), [], HOSTILE, title=HOSTILE),
    }


def test_a_page_is_for_phones_too_names_its_version_and_fetches_nothing() -> None:
    for name, text in pages().items():
        tree = html.document_fromstring(text)
        assert tree.xpath("//meta[@name='viewport']/@content") == ["width=device-width, initial-scale=1"], name
        assert tree.xpath("//meta[@name='color-scheme']/@content") == ["light dark"]
        assert "default-src 'none'" in tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
        assert tree.xpath("//footer")[0].text_content().startswith("casa-assets ")
        assert len(tree.xpath("//h1")) == 1
        assert HOSTILE not in text, name
        assert "prefers-color-scheme: dark" in tree.xpath("//style")[0].text_content()


def test_a_changed_template_makes_a_page_again() -> None:
    """Templates that the module of a page reaches count in its cache key."""
    start = f"{FOLDER.relative_to(Path(cache_key.__file__).parents[1]).as_posix()}/"
    reached = {}
    for name, module in PAGES.items():
        paths = (Path(path).as_posix() for path in reach(module.__name__).data)
        reached[name] = {path.removeprefix(start) for path in paths if path.startswith(start)}
    assert [name for name in PAGES if not {name, *FRAME} <= reached[name]] == []
    assert {"browse/browse.html", "browse/browse.js"} <= reached["kitchens/index.html"]
    assert "browse/browse.html" not in reached["catalogue/catalogue.html"]
    known = set().union(*reached.values())
    assert {path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*") if path.is_file()} == known


OF_STRANGERS = (
    "![](https://evil.example/t.png)",
    "[free](javascript:alert(1))",
    "<img src=x onerror=alert(1)>",
    "<https://evil.example>",
    "a | b |\n| --- | --- |",
    "x\n\n# heading\n\n- item",
    "`code` **bold** _it_ ~~gone~~",
    "https://evil.example www.evil.example a@evil.example",
    "&lt;b&gt; \u202e \x1b[31m",
    "back\\slash \\[x](y)",
)
FIELDS = ("title", "author", "licence", "generator", "uri", "source_path", "id")


def test_no_field_is_markup_in_the_attribution() -> None:
    for words, field in itertools.product(OF_STRANGERS, FIELDS):
        text = attribution.text([dataclasses.replace(entry(), **{"licence": "CC0-1.0", field: words})])
        (line,) = [one for one in text.splitlines() if one.startswith("- ")]
        _, heading = [one for one in text.splitlines() if one.startswith("#")]
        for one in (line.removeprefix("- "), heading.removeprefix("## ")):
            # What Markdown would act on is in no code span, and not escaped.
            plain = re.sub(r"\\.", "", re.sub(r"`[^`]*`", "", one))
            assert not set(plain) & set("<>[]|*_~`&!#@\\"), one
            assert not any(mark in plain for mark in ("://", "www.")), one
            assert one.isprintable()


APPLE = catalogue.category_row("apple", "objects/apple.webp", (0.15, 0.21), (0.071, 0.08), (900, 1100), (1, 3))
MUG = catalogue.category_row("mug", "objects/mug.webp", (0.3,), (0.12,), (2000,), (8,))


def test_sizes_and_masses_stand_beside_the_usual_ones_with_their_source() -> None:
    apple = registry.load().categories["apple"]
    (article,) = html.document_fromstring(catalogue.page([], [APPLE], {})).xpath("//article")
    assert article.xpath(".//button") == []
    length, mass = [[cell.text_content() for cell in row.xpath("td")] for row in article.xpath("table//tr[td]")]
    assert length[:2] == ["longest side, cm", "7.1 to 8"]
    assert mass[:2] == ["mass, g", "150 to 210"]
    low, high, typical = (1000 * kg for kg in (apple.mass_kg.low, apple.mass_kg.high, apple.mass_kg.typical))
    assert mass[2] == f"{low:g} to {high:g}, typically {typical:g}"
    assert [length[3], mass[3]] == [catalogue.SOURCES[apple.basis.size], catalogue.SOURCES[apple.basis.mass]]
    assert "1000 faces, 2 collision shapes" in article.text_content(), "medians"
    image = article.xpath(".//img")[0]
    assert (image.get("loading"), image.get("src")) == ("lazy", "./objects/apple.webp")


def test_members_that_have_a_model_have_a_button_that_shows_it() -> None:
    files = tuple(ModelFiles(f"mug_{i}", f"models/mug_{i}.glb.js", "models/viewer.js") for i in range(2))
    tree = html.document_fromstring(catalogue.page([], [{**MUG, "models": files}], {}))
    buttons = tree.xpath("//article//button")
    assert [b.get("data-model") for b in buttons] == ["./models/mug_0.glb.js", "./models/mug_1.glb.js"]
    assert [b.get("aria-label") for b in buttons] == ["mug 1 in 3D", "mug 2 in 3D"]
    assert {b.get("data-viewer") for b in buttons} == {"./models/viewer.js"}


def home_of(out: Path) -> html.HtmlElement:
    return html.document_fromstring(home.write(out).read_text(encoding="utf-8"))


def test_what_is_there_is_shown_with_links_to_its_pages(tmp_path: Path) -> None:
    assert [h2.text_content() for h2 in home_of(tmp_path).xpath("//h2")] == ["What to try next"]
    root = keep(tmp_path / "library", [FIRST, OTHER])
    refused(root, "FLT005", "links: 2 large parts stand apart; give each object a file of its own")
    write(root, root / "report.html")
    galley = scene(tmp_path / "scenes", "galley", "rustic")
    for name in ("overview", "eye_open"):
        (galley / f"{name}.png").write_bytes(b"png")
    scene(tmp_path / "scenes", "l_small", "rustic")
    tree = home_of(tmp_path)
    links = set(tree.xpath("//main//a/@href"))
    assert {"./scenes/index.html#galley__rustic", f"./library/report.html#{FIRST.id}"} <= links
    assert "./scenes/galley__rustic/eye_open.png" in tree.xpath("//img/@src")
    text = " ".join(tree.xpath("//main")[0].text_content().split())
    assert "2 accepted, 1 rejected" in text
    assert "was rejected: FLT005" in text
    assert "Give each object a file of its own." in text
    assert "casa-assets scenes check galley__rustic" in text


def test_what_was_articulated_is_shown_with_its_joints(tmp_path: Path) -> None:
    root = keep(tmp_path / "articulated", [FIRST])
    path = root / "mug" / FIRST.id / "asset.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    data["certificate"]["producer"] = "articulate"
    path.write_text(json.dumps(data), encoding="utf-8")
    (path.parent / "strip.png").write_bytes(b"png")
    tree = home_of(tmp_path)
    assert [h2.text_content() for h2 in tree.xpath("//h2")] == ["Articulated", "What to try next"]
    assert tree.xpath("//img/@src") == [f"./articulated/mug/{FIRST.id}/strip.png"]
    assert "0 joints" in tree.xpath("//div[@class='wide']")[0].text_content()


BUNDLE = Path(viewer.__file__).parent / "bundle"


def test_the_bundle_is_built_from_the_sources_beside_it_and_loads_nothing() -> None:
    """The first line of the bundle has the digest of its sources, see build.mjs; `./dev viewer` builds it again."""
    names = ["build.mjs", "package-lock.json", "package.json", *(f"src/{p.name}" for p in sorted(BUNDLE.glob("src/*")))]
    digest = hashlib.sha256(b"".join(n.encode() + b"\0" + (BUNDLE / n).read_bytes() + b"\0" for n in names)).hexdigest()
    first = viewer_script().split(b"\n", 1)[0].decode()
    assert digest in first, "the sources of the viewer have changed since: ./dev viewer"
    # Namespaces of XML are names and not loaded; three.js names its own pages in warnings.
    found = set(re.findall(rb"https?://[^\s\"'`)]+", viewer_script()))
    assert {url for url in found if not re.search(rb"w3\.org|threejs\.org|github\.com", url)} == set()
    # The lock names no registry.
    text = (BUNDLE / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in text
    packages = json.loads(text)["packages"]
    wanted = json.loads((BUNDLE / "package.json").read_text(encoding="utf-8"))
    for name, version in (wanted["dependencies"] | wanted["devDependencies"]).items():
        assert packages[f"node_modules/{name}"]["version"] == version
        assert packages[f"node_modules/{name}"]["integrity"]


def test_a_model_comes_out_as_it_went_in() -> None:
    glb = asset_glb(rigid_mug())
    script = page_template.model_script("mug_0123456789", glb)
    assert script == page_template.model_script("mug_0123456789", glb)
    match = re.fullmatch(rb'casaModel\("mug_0123456789","([A-Za-z0-9+/=]+)"\);\n', script)
    assert gzip.decompress(base64.b64decode(match[1])) == glb


@pytest.mark.content("code", "show.reports", keep=0)
def test_models_are_made_once_and_follow_their_assets_and_the_code_and_the_page_knows_where(tmp_path: Path) -> None:
    library = keep(tmp_path / "lib", loose_and_fixed())
    page = library / "report.html"
    models = page_template.folder_of(page)
    names = {folder.name for folder in Library(library).accepted()}
    assert list(write_models(library, page, jobs=1)) == [(done, len(names)) for done in range(len(names) + 1)]
    made = {page_template.MADE_BY, viewer_name(), *(f"{name}.glb.js" for name in names)}
    assert {path.name for path in models.iterdir()} == made
    times = {path.name: path.stat().st_mtime_ns for path in models.iterdir()}
    assert list(write_models(library, page, jobs=1)) == [(len(names), len(names))]
    assert {path.name: path.stat().st_mtime_ns for path in models.iterdir()} == times
    corrected, gone = list(Library(library).accepted())[:2]
    before = {path.name: path.read_bytes() for path in models.iterdir()}
    (models / f"{corrected.name}.glb.js").write_bytes(b"as it was")
    (corrected / "asset.json").touch()
    list(write_models(library, page, jobs=1))
    assert {path.name: path.read_bytes() for path in models.iterdir()} == before, "an asset was written again"
    (models / page_template.MADE_BY).write_text("another version", encoding="utf-8")
    (models / "viewer_0.js").write_text("of another version", encoding="utf-8")
    for path in models.glob("*.glb.js"):
        path.write_bytes(b"of another version")
    list(write_models(library, page, jobs=1))
    assert {path.name: path.read_bytes() for path in models.iterdir()} == before, "other code had made them"
    shutil.rmtree(gone)
    list(write_models(library, page, jobs=1))
    assert not (models / f"{gone.name}.glb.js").exists()
    files = {"folder": "./report_models", "suffix": ".glb.js", "viewer": f"./report_models/{viewer_name()}"}
    for models, told in ((None, None), (page_template.models_of(page), files)):
        write(library, page, models=models)
        text = page.read_text(encoding="utf-8")
        (data,) = html.fromstring(text).xpath("//script[@id='data']/text()")
        assert json.loads(data)["models"] == told
        assert ("popUpModel" in text) == (models is not None)
