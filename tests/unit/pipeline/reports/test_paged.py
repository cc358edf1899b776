"""The report on very many entries: an overview, and pages that list all of them, once each."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import lxml.html
import pytest

from benchmarks.books import synthetic_entries
from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.reports.library import paged, priors, rows, summary
from casa_assets.pipeline.reports.library.comparison import read_run
from casa_assets.pipeline.reports.library.conditions import parse
from casa_assets.pipeline.tables import parquet
from tests.assets import ball, rigid_mug
from tests.built_libraries import keep

pytestmark = pytest.mark.content("code", "pipeline.reports", keep=0)

COUNT = 4_000


@pytest.fixture
def tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A table of two libraries; pages are small."""
    monkeypatch.setattr(paged, "PAGE_ROWS", 500)
    places = [Library(tmp_path / name) for name in ("one", "two")]
    seeds = {place.root: seed for seed, place in enumerate(places)}
    parquet.write_index(
        places, tmp_path / "tables", entries_of=lambda library: synthetic_entries(COUNT // 2, seeds[library.root])
    )
    return tmp_path / "tables"


def listed(page: Path) -> list[dict[str, Any]]:
    """The rows that a page loads."""
    facts = json.loads(lxml.html.parse(str(page)).getroot().get_element_by_id("data").text_content())
    found: list[dict[str, Any]] = []
    for number in range(-(-facts["count"] // facts["sizes"]["rows"])):
        text = (page.parent / facts["folder"] / f"rows_{number}.js").read_text(encoding="utf-8")
        values = json.loads(text[len(f'casaPart("rows",{number},') : -len(");\n")])
        found += [dict(zip(facts["fields"], one, strict=True)) for one in values]
    assert len(found) == facts["count"]
    return found


def test_the_pages_list_every_input_once(tables: Path, tmp_path: Path) -> None:
    written = paged.write(tables, tmp_path / "report.html", [parse("rejected-rate>99%", ())])
    assert not written.outcomes[0].holds
    document = lxml.html.parse(str(written.page)).getroot()
    links = [str(one) for one in document.xpath("//section[h2='Pages']//a/@href")]
    pages = [tmp_path / link for link in links]
    assert pages == sorted((tmp_path / "report_pages").glob("*.html"))
    assert len(pages) > 4
    entries = [entry for seed in (0, 1) for entry in synthetic_entries(COUNT // 2, seed)]
    found = [row for page in pages for row in listed(page)]
    assert sorted(row["id"] for row in found) == sorted(entry.id for entry in entries)
    assert all(len(listed(page)) <= 500 for page in pages)
    one = next(entry for entry in synthetic_entries(COUNT // 2, 1) if not entry.accepted)
    row = next(row for row in found if row["id"] == one.id)
    assert (row["verdict"], row["codes"], row["message"]) == ("rejected", [one.code], one.message)
    assert (tmp_path / "report_pages" / row["folder"]).resolve() == tmp_path / "two" / one.path


def test_the_numbers_are_those_of_all_entries(tables: Path, tmp_path: Path) -> None:
    written = paged.write(tables, tmp_path / "report.html")
    told = json.loads(written.json.read_text(encoding="utf-8"))
    entries = [entry for seed in (0, 1) for entry in synthetic_entries(COUNT // 2, seed)]
    records = registry.load()
    fits = priors.fits(entries, {**records.categories, **records.fixtures})
    whole = summary.numbers_of(
        "tables", "tables", summary.Totals(entries), fits, rows.Words(records.rejections, {}), ()
    )
    for name in ("counts", "categories", "sources", "priors"):
        assert told[name] == json.loads(json.dumps(whole[name])), name
    assert [(row["reason"], row["count"]) for row in told["reasons"]] == [
        (row["reason"], row["count"]) for row in whole["reasons"]
    ]
    assert sum(row["accepted"] + row["review"] + row["rejected"] for row in told["categories"]) == COUNT
    with pytest.raises(OutputError, match="names no entries; give the library of that run"):
        read_run(written.json)


def test_a_category_leads_to_its_page(tables: Path, tmp_path: Path) -> None:
    written = paged.write(tables, tmp_path / "report.html")
    document = lxml.html.parse(str(written.page)).getroot()
    links = document.xpath("//section[h2='Category']//a")
    assert len(links) == len({entry.category for seed in (0, 1) for entry in synthetic_entries(COUNT // 2, seed)})
    for link in links:
        page, _, words = str(link.get("href")).partition("#")
        assert words == f"category={link.text}"
        assert link.text in {row["category"] for row in listed(tmp_path / page)}


def test_same_table_same_bytes(tables: Path, tmp_path: Path) -> None:
    def content() -> dict[Path, bytes]:
        return {p: p.read_bytes() for p in tmp_path.glob("report*/**/*") if p.is_file()}

    paged.write(tables, tmp_path / "report.html")
    first = content()
    paged.write(tables, tmp_path / "report.html")
    assert content() == first
    assert not list(tmp_path.glob(".report*"))


def test_a_large_library_has_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = Library(keep(tmp_path / "library", [rigid_mug(), ball()]))
    assert not paged.is_large(library)
    monkeypatch.setattr(paged, "MOST_ENTRIES", 1)
    assert paged.is_large(library)
    written = paged.write_library(library, library.root / "report.html")
    (page,) = (library.root / "report_pages").glob("*.html")
    assert {row["id"] for row in listed(page)} == {rigid_mug().id, ball().id}
    for row in listed(page):
        assert (page.parent / row["folder"] / "asset.json").is_file()
    assert re.search(r"<h1>\s*library\s*</h1>", written.page.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("counts", "sizes"),
    [
        ([3, 3, 3], [9]),
        ([6, 5, 4], [6, 9]),
        ([25, 1], [10, 10, 6]),
        ([10, 10], [10, 10]),
        ([], []),
        ([4, 16, 1], [4, 10, 7]),
    ],
)
def test_categories_are_kept_together(counts: list[int], sizes: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paged, "PAGE_ROWS", 10)
    assert list(paged._page_sizes({f"kind_{i}": count for i, count in enumerate(counts)})) == sizes
