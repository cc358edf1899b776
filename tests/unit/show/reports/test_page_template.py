"""All pages come from one frame, escape what they show, and are made anew where a template changes."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from lxml import html

from casa_assets.articulate.run import review_page
from casa_assets.cache import cache_key
from casa_assets.cache.cache_key import reach
from casa_assets.library import attribution
from casa_assets.library.entry import Entry
from casa_assets.library.library import Library
from casa_assets.show.page import kitchen_report, page_template
from casa_assets.show.page.page_template import Words
from casa_assets.show.reports import catalogue, findings, home, kitchens, library_page
from casa_assets.show.view import review, server

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
APPLE = catalogue.category_row("apple", HOSTILE, (0.15, 0.2), (0.07, 0.08), (900, 1000), (1, 1))


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


def entry(**changes: str) -> Entry:
    words = {f.name: "" for f in dataclasses.fields(Entry)}
    words |= {"id": "mug_0123456789", "category": "mug", "sha256": "ab" * 32, "licence": "CC0-1.0", **changes}
    return Entry(**{**words, "accepted": True, "summary": None, "warnings": (), "results": (), "guesses": ()})  # type: ignore[arg-type]


def unescaped(line: str) -> str:
    """A line without its code spans and without what is escaped: what Markdown would act on."""
    return re.sub(r"\\.", "", re.sub(r"`[^`]*`", "", line))


def test_no_field_is_markup(subtests: pytest.Subtests) -> None:
    for words in OF_STRANGERS:
        for field in FIELDS:
            with subtests.test(field=field, words=words):
                lines = attribution.text([entry(**{field: words})]).splitlines()
                (line,) = [one for one in lines if one.startswith("- ")]
                headings = [one for one in lines if one.startswith("#")]
                assert len(headings) == 2
                for one in (line.removeprefix("- "), headings[1].removeprefix("## ")):
                    assert not set(unescaped(one)) & set("<>[]|*_~`&!#@\\"), one
                    assert "://" not in unescaped(one)
                    assert "www." not in unescaped(one)
                    assert one.isprintable()
