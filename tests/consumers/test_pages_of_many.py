"""Pages of many rows in a real browser: search, filters, order, details, keys, addresses, no request elsewhere."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from PIL import Image

from casa_assets.families.build import FamilyRequest
from casa_assets.model.registry.rows import Surface
from casa_assets.show.page.page_template import models_of, write_models
from casa_assets.show.reports import catalogue, home, kitchens, library_page
from casa_assets.show.reports.catalogue import member_row
from casa_assets.show.view import review as review_page
from tests.consumers.test_review_keys import reviewed_page
from tests.support.library.built_libraries import keep
from tests.support.program.browser import Browser, Page
from tests.unit.library.test_alike import FIRST, LARGE, OTHER
from tests.unit.show.reports.test_kitchen_pages import kitchen_page, scene
from tests.unit.show.reports.test_library_page import CASES, entry, refused
from tests.unit.show.reports.test_page_template import APPLE

pytestmark = pytest.mark.consumers
ROWS = "#list .id"
READY = "#list .line, #list .tile-card"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page about three assets and three rejected inputs, beside an earlier run without the last asset."""
    root = keep(tmp_path_factory.mktemp("pages") / "library", [FIRST, OTHER])
    earlier = library_page.write(root, root.parent / "earlier.html").json
    keep(root, [LARGE])
    for code, message in CASES:
        refused(root, code, message)
    page = root / "report.html"
    assert list(write_models(root, page, 1))[-1] == (3, 3)
    return library_page.write(root, page, earlier, models=models_of(page)).page


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("scenes")
    for i in range(600):
        scene(out, ("galley", "l_small", "u_large")[i % 3], f"style_{i:03}")
    scene(out, "galley", "rustic", surfaces={"floor": "oak_ebony"})
    return kitchens.write(out)[0]


def opened(browser: Browser, page: Path, hash_: str = "", width: int = 1280, dark: bool = False) -> Page:
    shown = browser.open(f"{page.absolute().as_uri()}{hash_}", width=width, dark=dark)
    shown.wait(READY)
    return shown


def address(page: Page) -> str:
    return str(page.evaluate("location.hash"))


# Words of tables, captions and lists of facts that are broken over two lines; numbers and verdicts that are cut.
FAULTS = r"""(() => {
  document.querySelectorAll("details").forEach(box => { box.open = true; });
  const broken = [], range = document.createRange();
  for (const cell of document.querySelectorAll("td, th, dt, dd, figcaption")) {
    const texts = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
      for (const word of texts.currentNode.data.matchAll(/[\p{L}\p{N}_]+/gu)) {
        range.setStart(texts.currentNode, word.index);
        range.setEnd(texts.currentNode, word.index + word[0].length);
        if (new Set([...range.getClientRects()].map(box => Math.round(box.top))).size > 1) { broken.push(word[0]); }
      }
    }
  }
  const cut = [...document.querySelectorAll(".line .number, .line .verdict, .tile strong")]
    .filter(e => e.checkVisibility() && e.scrollWidth > e.clientWidth + 1)
    .concat([...document.querySelectorAll(".line")].filter(e => e.scrollHeight > e.clientHeight + 1));
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  return { broken, cut: cut.map(e => e.textContent), wide };
})()"""


@pytest.fixture(scope="module")
def kinds(library: Path, rooms: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Address of a page of every kind, with the longest words that it has."""
    folder = tmp_path_factory.mktemp("kinds")
    shutil.copytree(library.parent, folder / "library")
    shots = ("closed.webp", "open.webp", "on.webp")
    preset = member_row(FamilyRequest("hob", preset="gas"), shots, 9.5, (0.5, 0.5, 0.1))
    explained = {"NKB004": "Work aisle: Fronts that face each other are at least 1.067 m apart; move the rows apart."}
    pages = {
        "kitchen": kitchen_page(explained),
        "catalogue": catalogue.page([preset], [APPLE], {Surface.WALL: ["brick_red_running_bond"]}),
        "review": review_page.render_page([entry(word="the usual size of its category")], {}, "Review"),
    }
    for name in (*shots, "textures/brick_red_running_bond.webp"):
        (folder / name).parent.mkdir(exist_ok=True)
        Image.new("RGB", (320, 320)).save(folder / name)
    for name, text in pages.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")
    found = {name: folder / f"{name}.html" for name in pages} | {"home": home.write(folder), "kitchens": rooms}
    (folder / "articulated").mkdir()
    found["articulated"] = reviewed_page(folder / "articulated")
    states = {"list": "", "numbers": "#tab=numbers", "changes": "#tab=changes", "details": f"#{FIRST.id}"}
    of_library = {f"library, {name}": library.absolute().as_uri() + hash_ for name, hash_ in states.items()}
    return {name: path.absolute().as_uri() for name, path in found.items()} | of_library


@pytest.mark.parametrize("width", [1280, 390])
def test_no_page_scrolls_sideways_or_breaks_a_word_of_a_table(
    browser: Browser, kinds: dict[str, str], width: int
) -> None:
    faults = {}
    for name, address in kinds.items():
        page = browser.open(address, width=width, touch=width < 640)
        faults[name] = page.evaluate(FAULTS)
        if name == "home":
            page.assert_clean()
    assert {name: f for name, f in faults.items() if f["broken"] or f["cut"] or f["wide"] > 0} == {}


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (1280, True), (390, False), (390, True)])
def test_a_report_is_clean_on_any_screen(browser: Browser, library: Path, width: int, dark: bool) -> None:
    page = opened(browser, library, f"#{FIRST.id}", width, dark)
    page.wait("#detail")
    page.assert_clean()
    assert page.fits
    page.press("Escape")
    if width > 900:
        page.click("#tab-numbers")
        page.wait("#panel-numbers table")
        page.assert_clean()
    assert page.fits


def test_a_report_is_searched_filtered_and_sorted(browser: Browser, library: Path) -> None:
    page = opened(browser, library)
    assert len(page.texts(ROWS)) == 6
    page.fill("#search", "flt005")
    assert page.texts(ROWS) == ["FLT005.glb"]
    assert address(page) == "#q=flt005"
    page.press("Escape", "#search")
    assert len(page.texts(ROWS)) == 6
    page.click('#facets button[data-place="verdict=rejected"]')
    assert len(page.texts(ROWS)) == 3
    assert address(page) == "#verdict=rejected"
    page.click("#chips button")
    page.click('#heads [data-key="size"]')
    assert address(page) == "#sort=-size"
    assert page.texts(ROWS)[0] == LARGE.id
    page.assert_clean(is_accessible=False)


def test_a_report_goes_by_keys(browser: Browser, library: Path) -> None:
    page = opened(browser, library)
    for key in ("j", "j", "Enter"):
        page.press(key)
    page.wait("#detail")
    second = page.texts(ROWS)[1]
    assert page.texts("#detail-title") == [second]
    page.press("k")
    assert page.texts("#detail-title") == page.texts(ROWS)[:1]
    page.press("Escape")
    assert page.texts("#detail") == []
    page.press("/")
    assert page.evaluate("document.activeElement.id") == "search"


def test_an_address_brings_a_state_back_and_a_row_opens_by_a_click_and_in_3d(browser: Browser, library: Path) -> None:
    for hash_, count in ((f"#{OTHER.id}", 6), (f"#q=mug&verdict=accepted&id={OTHER.id}", 3)):
        page = opened(browser, library, hash_)
        page.wait("#detail-body .facts")
        assert page.texts("#detail-title") == [OTHER.id]
        assert len(page.texts(ROWS)) == count
        page.click("#close")
        assert OTHER.id not in address(page)
    page = opened(browser, library)
    page.click("#list .line:has(.badge.accepted) >> nth=0")
    page.wait("#detail .model-popup")
    page.click("#detail .model-popup")
    page.wait(".cv[data-state=ready]")
    page.assert_clean()
    page.press("Escape")
    assert page.texts(".model-dialog") == []
    assert page.texts("#detail-title") != []  # the key closed the model alone


def test_a_page_of_many_shows_the_pictures_of_the_library(
    browser: Browser, library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = shutil.copytree(library.parent, tmp_path / "library")
    monkeypatch.setattr(library_page, "MAX_WHOLE", 1)
    page = opened(browser, library_page.write(root, root / "report.html").page)
    assert len(page.texts(ROWS)) == 6
    page.click("#list .line >> nth=0")
    page.wait("#detail-body .facts")
    page.assert_clean()
    assert page.evaluate("document.querySelector('#detail-body img').naturalWidth") > 0
    page.press("Escape")
    assert page.evaluate("document.querySelector('#list img').naturalWidth") > 0


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, True)])
def test_a_kitchen_is_found_among_many(browser: Browser, rooms: Path, width: int, dark: bool) -> None:
    page = opened(browser, rooms, "", width, dark)
    page.wait("text=601 of 601")
    assert len(page.texts(ROWS)) < 100
    page.fill("#search", "oak ebony")
    page.wait("text=1 of 601")
    assert page.texts(ROWS) == ["galley, rustic"]
    page.click("#list .tile-card >> nth=0")
    page.wait("#detail .facts")
    assert address(page) == "#q=oak+ebony&id=galley__rustic"
    page.assert_clean()
    assert page.fits
