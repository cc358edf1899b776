"""All pages come from one frame, escape what they show, and are made anew where a template changes."""

from __future__ import annotations

from pathlib import Path

import jinja2
import pytest
from lxml import html

from casa_assets.articulate.run import review_page
from casa_assets.cache import cache_key
from casa_assets.cache.cache_key import reach
from casa_assets.library.library import Library
from casa_assets.show.view import review
from casa_assets.show.page import kitchen_report, page_template
from casa_assets.show.page.page_template import Words
from casa_assets.show.reports import catalogue, findings, home, kitchens, library_page
from casa_assets.show.view import server

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
APPLE = catalogue.DrawnCategory("apple", HOSTILE, (0.15, 0.2), (0.07, 0.08), (900, 1000), (1, 1))


def pages() -> dict[str, str]:
    row = kitchens.SceneRow("galley__rustic", "galley", "rustic")
    found = findings.Findings(HOSTILE, ".", (), (), None)
    return {
        "library": library_page.render(found, Words({}, {}), []),
        "kitchens": kitchens.index_page([kitchens.SceneCard(row, 1, 1)], HOSTILE),
        "catalogue": catalogue.page([], [APPLE], {}),
        "review": review.render_page([], {}, HOSTILE),
        "articulated": review_page.render_page(Library(Path("nowhere")), [], HOSTILE, title=HOSTILE),
    }


def test_a_page_is_for_phones_too_names_its_version_and_fetches_nothing(subtests: pytest.Subtests) -> None:
    for name, text in pages().items():
        with subtests.test(name=name):
            tree = html.document_fromstring(text)
            assert tree.xpath("//meta[@name='viewport']/@content") == ["width=device-width, initial-scale=1"]
            assert tree.xpath("//meta[@name='color-scheme']/@content") == ["light dark"]
            assert "default-src 'none'" in tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
            assert tree.xpath("//footer")[0].text_content().startswith("casa-assets ")
            assert len(tree.xpath("//h1")) == 1
            assert HOSTILE not in text
            assert "prefers-color-scheme: dark" in tree.xpath("//style")[0].text_content()


def reached_by(name: str) -> set[str]:
    """Templates that the module of a page reaches, as its cache key counts them."""
    package = Path(cache_key.__file__).parents[1]
    paths = [package / path for path in reach(PAGES[name].__name__).data]
    return {path.relative_to(FOLDER).as_posix() for path in paths if path.is_relative_to(FOLDER)}


def test_a_changed_template_makes_a_page_anew() -> None:
    reached = {name: reached_by(name) for name in PAGES}
    assert [name for name in PAGES if not {name, *FRAME} <= reached[name]] == []
    assert {"browse/browse.html", "browse/browse.js"} <= reached["kitchens/index.html"]
    assert "browse/browse.html" not in reached["catalogue/catalogue.html"]
    known = set().union(*reached.values())
    assert {path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*") if path.is_file()} == known


def test_a_value_that_is_not_given_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError):
        page_template.render_template("kitchens/index.html", title="Kitchens")
