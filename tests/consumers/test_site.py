"""The site of docs/: every link leads somewhere, and no page asks another machine for anything."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import html

from tests.support.library.libraries import ran
from tests.support.program.browser import Browser
from tests.support.program.documents import ROOT, pages

pytestmark = pytest.mark.consumers
MKDOCS = ROOT / ".venv-docs" / "bin" / "mkdocs"
# Attributes by which a page loads a file; those of <a> and <form> are followed by the reader alone.
LOADS = {
    **dict.fromkeys(("audio", "embed", "iframe", "img", "script", "source", "video"), "src"),
    **dict.fromkeys(("link", "use"), "href"),
    "object": "data",
}
ELSEWHERE = re.compile(r"^(\w+:)?//|^(http|https|ftp|ws|wss):", re.IGNORECASE)
URL = re.compile(r"url\(\s*[\"']?([^\"')]+)|@import\s+[\"']([^\"']+)")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built where warnings are errors: dead links and anchors, pages that no menu names."""
    folder = tmp_path_factory.mktemp("site")
    assert MKDOCS.is_file(), "./dev docs makes .venv-docs"
    ran(MKDOCS, "build", "--strict", "--config-file", ROOT / "mkdocs.yml", "--site-dir", folder, cwd=ROOT)
    return folder


def loaded(page: Path) -> Iterator[str]:
    """Addresses that a browser fetches by itself when it opens a page."""
    root = html.fromstring(page.read_bytes())
    for element in root.iter(*LOADS):
        address = element.get(LOADS[element.tag])
        if address and not (element.tag == "link" and element.get("rel") in ("canonical", "next", "prev")):
            yield address
        yield from (part.split()[0] for part in (element.get("srcset") or "").split(",") if part.strip())
    for style in root.iter("style"):
        yield from addresses(style.text or "")
    yield from (a for element in root.iter() if element.get("style") for a in addresses(element.get("style")))


def addresses(css: str) -> list[str]:
    return [first or second for first, second in URL.findall(css)]


def test_what_pages_load_is_there_and_not_elsewhere(site: Path) -> None:
    for page in sorted(site.rglob("*.html")):
        for address in loaded(page):
            assert not ELSEWHERE.match(address), page
            path = address.partition("?")[0].partition("#")[0]
            # 404.html is served for any address, and names files from the root.
            is_there = path.startswith("data:") or (page.parent / path).exists()
            assert is_there or page.name == "404.html", f"{page}: {address}"
    for sheet in sorted(site.rglob("*.css")):
        assert [a for a in addresses(sheet.read_text(encoding="utf-8")) if ELSEWHERE.match(a)] == [], sheet


def test_every_page_is_in_the_site_with_docstrings_and_files_of_the_root(site: Path) -> None:
    written = [page for page in pages() if page.startswith("docs/")]
    assert len(written) > 20
    assert [p for p in written if not (site / p.removeprefix("docs/")).with_suffix(".html").is_file()] == []
    api = (site / "reference" / "api.html").read_text(encoding="utf-8")
    assert 'id="casa_assets.api.assets.load"' in api
    built = (site / "explanation" / "how_it_is_built.html").read_text(encoding="utf-8")
    assert "How casa_assets is built" in built


@pytest.mark.parametrize("dark", [False, True])
def test_it_is_searched_without_a_server(site: Path, browser: Browser, dark: bool) -> None:
    page = browser.open(site / "index.html", dark=dark)
    page.click("input.md-search__input")
    page.wait("text=Type to start searching")  # the index is read
    page.fill("input.md-search__input", "parking place")
    page.press("End", "input.md-search__input")  # it searches when a key is let go
    page.wait(".md-search-result__item a")
    found = page.evaluate("[...document.querySelectorAll('.md-search-result__item a')].map(a => a.href)")
    assert any("scene_json.html" in address for address in found), found
    page.click(".md-search-result__item a")
    page.wait("h1")
    page.assert_clean(is_accessible=False)
