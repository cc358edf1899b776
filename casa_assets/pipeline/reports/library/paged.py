"""The report on the rows of a table, however many there are: an overview, and pages that list some categories each.

    NAME.html  NAME.json            counts over everything, links to the pages
    NAME_pages/00000.html           a page as of a small library, with its rows in NAME_pages/00000_parts/

Rows are read twice, first to count them, then in the order of their categories to list them. No more than the rows of
one page are in memory at once.
"""

from __future__ import annotations

import json
import os
import posixpath
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path

from casa_assets import registry
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library.library import Library, exchange
from casa_assets.pipeline.reports import parts
from casa_assets.pipeline.reports.explanations import explanations
from casa_assets.pipeline.reports.library import page, priors, rows, summary
from casa_assets.pipeline.reports.library.conditions import Condition, judge
from casa_assets.pipeline.reports.library.written import WrittenReport, write_text
from casa_assets.pipeline.reports.page_template import relative_link
from casa_assets.pipeline.reports.parts import Part, chunks
from casa_assets.pipeline.tables import parquet
from casa_assets.pipeline.tables.row import TableRow

# Inputs that one page lists: a browser searches so many in a tenth of a second.
PAGE_ROWS = 20_000
# Of a library with more entries the report is in pages: a browser would load one list for seconds, and search slowly.
MOST_ENTRIES = 100_000


def write(tables: Path, target: Path, conditions: Sequence[Condition] = (), name: str = "") -> WrittenReport:
    """Write the report on the rows of a table.

    Args:
        tables: folder that `parquet.write_index` wrote. target: the overview, `<name>.html`.
        conditions: that are judged; none of them needs an earlier run. name: title; that of the folder by default.
    Raises:
        CasaError: pyarrow is not installed.
        OutputError: there is no table, it is damaged, or the pages cannot be written.
    """
    parquet.require_parquet()
    index = parquet.read_index(tables)
    known = registry.load()
    totals, fitting = summary.Totals(), priors.Fitting({**known.categories, **known.fixtures})
    for row in parquet.read_rows(tables, index):
        totals.add(row)
        fitting.add(row)
    fits = fitting.fits()
    outcomes = judge(conditions, summary.counts(totals, fits, None), summary.code_counts(totals))
    words = rows.Words(known.rejections, explanations())
    title = name or tables.resolve().name
    with writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
        pages = _write_pages(_Source(tables, index, totals), target, title, words)
        write_text(target, page.render_overview(title, totals, fits, words, pages, outcomes))
        parts.remove_parts(target)
        root = _relative(tables, target.parent)
        content = summary.numbers_of(title, root, totals, fits, words, outcomes) | {"tables": root, "entries": []}
        json_path = target.with_suffix(".json")
        write_text(json_path, json.dumps(content, sort_keys=True, indent=1) + "\n")
    return WrittenReport(target, json_path, outcomes)


def is_large(library: Library) -> bool:
    """True for a library of more entries than the report that holds all of them is made of."""
    return next(islice(chain(library.accepted(), library.refused()), MOST_ENTRIES, None), None) is not None


def write_library(library: Library, target: Path, conditions: Sequence[Condition] = ()) -> WrittenReport:
    """Write the report on one large library; its table is kept in its cache. Raises as `write` does."""
    tables = library.cache / "tables"
    parquet.write_index([library], tables)
    return write(tables, target, conditions, library.root.resolve().name)


@dataclass(frozen=True)
class _Source:
    tables: Path
    index: parquet.PartsIndex
    totals: summary.Totals

    def chunks(self) -> Iterator[list[TableRow]]:
        """The rows of one page after the other, by category."""
        stream = parquet.read_sorted(self.tables, self.index)
        for count in _page_sizes({name: by.total() for name, by in self.totals.categories.items()}):
            yield list(islice(stream, count))


def _page_sizes(categories: Mapping[str, int]) -> Iterator[int]:
    """Rows of each page: whole categories together, as many as fit; one that fits on no page has pages of its own."""
    held = 0
    for _, count in sorted(categories.items()):
        if held and held + count > PAGE_ROWS:
            yield held
            held = 0
        held += count
        while held > PAGE_ROWS:
            yield PAGE_ROWS
            held -= PAGE_ROWS
    if held:
        yield held


def _write_pages(source: _Source, target: Path, title: str, words: rows.Words) -> list[page.PagePart]:
    """Write all pages, put in place by one rename; those of an earlier report go."""
    folder = target.with_name(f"{target.stem}_pages")
    fresh = folder.with_name(f".{folder.name}.{os.getpid()}") / folder.name
    shutil.rmtree(fresh.parent, ignore_errors=True)
    made: list[page.PagePart] = []
    try:
        fresh.mkdir(parents=True)
        for number, members in enumerate(source.chunks()):
            path = fresh / f"{number:05}.html"
            first, last = members[0].category, members[-1].category
            heading = f"{title}: {first}" if first == last else f"{title}: {first} to {last}"
            _write_page(path, members, heading, _relative(source.tables, folder), words, f"../{target.name}")
            made.append(page.PagePart(relative_link(f"{folder.name}/{path.name}"), first, last, len(members)))
        exchange(fresh, folder)
    finally:
        shutil.rmtree(fresh.parent, ignore_errors=True)
    return made


def _write_page(
    path: Path, members: Sequence[TableRow], heading: str, root: str, words: rows.Words, overview: str
) -> None:
    known = registry.load()
    fits = priors.fits(members, {**known.categories, **known.fixtures})
    found = summary.Findings(heading, root, members, fits, None)
    of = {quantity: frozenset(priors.outlying(fits, quantity)) for quantity in priors.Quantity}
    context = rows.RowContext(".", of[priors.Quantity.SIZE], of[priors.Quantity.MASS])
    placed = (replace(row, path=posixpath.normpath(f"{root}/{row.library}/{row.path}")) for row in members)
    listed = [rows.brief_row_of(row, context) for row in placed]
    data = chain(
        [Part("numbers", 0, page.numbers(found))],
        (Part("rows", number, some) for number, some in enumerate(chunks(listed, rows.PART_SIZES["rows"]))),
    )
    parts.write_parts(path, data)
    folder = parts.folder_of(path).name
    path.write_text(page.render(found, words, {}, (), folder, is_brief=True, overview=overview), encoding="utf-8")


def _relative(path: Path, base: Path) -> str:
    return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()
