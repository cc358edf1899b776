"""The report on a library, written from its entries and pictures: a page, and the same as JSON beside it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.checks.library.duplicates import in_words
from casa_assets.pipeline.dedup import library_report
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.reports import parts
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.explanations import explanations
from casa_assets.pipeline.reports.library import page, priors, rows, summary
from casa_assets.pipeline.reports.library.ci_files import NO_CI_FILES, CiFiles
from casa_assets.pipeline.reports.library.comparison import Run, compare, link_before, read_run, standing_of
from casa_assets.pipeline.reports.library.conditions import Condition, judge
from casa_assets.pipeline.reports.library.models import PageModels
from casa_assets.pipeline.reports.library.written import WrittenReport, write_text
from casa_assets.pipeline.reports.parts import Part, chunks


def write(
    root: Path,
    target: Path,
    baseline: Path | None = None,
    conditions: Sequence[Condition] = (),
    models: PageModels | None = None,
    ci_files: CiFiles = NO_CI_FILES,
) -> WrittenReport:
    """Write the page for the library at `root` to `target`, and a JSON file of that name beside it.

    Args:
        target: the page, `<name>.html`; of a large library the data goes to the folder `<name>_parts` beside it.
        baseline: report.json or library of an earlier run. conditions: that are judged.
        models: where the page finds the models of its assets; None where there are none.
        ci_files: files for continuous integration that are written too.
    Raises:
        OutputError: an entry of the library is damaged, the page cannot be written, or there is no such earlier run.
    """
    before = read_run(baseline) if baseline is not None else None
    table = EntryTable(disk.Library(root))
    entries = sorted(table.entries, key=lambda e: (not e.accepted, e.category, e.id) if e.accepted else _refused_key(e))
    found = _findings(root, target, entries, before, conditions)
    words = rows.Words(registry.load().rejections, explanations())
    links = _links(found, before, target)
    made = _Maker(table, entries, found, words, rows.RowContext(found.root, *_outliers(found), _changes(found)))
    is_inline = len(entries) <= parts.MAX_INLINE
    with writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
        if is_inline:
            write_text(target, page.render(found, words, links, tuple(made.parts()), models=models))
            parts.remove_parts(target)
        else:
            parts.write_parts(target, made.parts())
            write_text(target, page.render(found, words, links, (), parts.folder_of(target).name, models))
        json_path = target.with_suffix(".json")
        write_text(json_path, json.dumps(summary.content(found, words), sort_keys=True, indent=1) + "\n")
    ci_files.write(found, words)
    return WrittenReport(target, json_path, tuple(found.outcomes))


def _refused_key(entry: Entry) -> tuple[bool, str, str]:
    return True, entry.source_path, entry.id


def _findings(
    root: Path, target: Path, entries: Sequence[Entry], before: Run | None, conditions: Sequence[Condition]
) -> summary.Findings:
    records = registry.load()
    fits = priors.fits(entries, {**records.categories, **records.fixtures})
    compared = None
    if before is not None:
        compared = summary.Compared(before.name, tuple(compare(before.standings, map(standing_of, entries))))
    totals = summary.Totals(entries)
    outcomes = judge(conditions, summary.counts(totals, fits, compared), summary.code_counts(totals))
    return summary.Findings(
        root.resolve().name,
        Path(os.path.relpath(root, target.parent)).as_posix(),
        entries,
        fits,
        library_report.read_library_report(root),
        compared,
        outcomes,
    )


def _outliers(found: summary.Findings) -> tuple[frozenset[str], frozenset[str]]:
    of = {quantity: frozenset(priors.outlying(found.fits, quantity)) for quantity in priors.Quantity}
    return of[priors.Quantity.SIZE], of[priors.Quantity.MASS]


def _changes(found: summary.Findings) -> dict[str, str]:
    """Id -> how an entry does beside the earlier run."""
    differences = found.compared.differences if found.compared else ()
    return {one.now.id: one.change.value for one in differences if one.now is not None}


def _links(found: summary.Findings, before: Run | None, target: Path) -> dict[str, str]:
    """Id -> path from the page to what the earlier run has, of all that changed."""
    if before is None or found.compared is None:
        return {}
    told = found.compared.differences
    return {one.id: link_before(before, one.before, target) for one in told if one.before is not None}


@dataclass(frozen=True)
class _Maker:
    """Makes the parts of a page one after the other, so that details and pictures never lie in memory together."""

    table: EntryTable
    entries: Sequence[Entry]
    found: summary.Findings
    words: rows.Words
    context: rows.RowContext

    def parts(self) -> Iterator[Part]:
        """All of them."""
        yield Part("numbers", 0, page.numbers(self.found))
        kinds = {"rows": self._rows, "details": self._details, "pictures": self._pictures}
        for kind, make in kinds.items():
            for number, members in enumerate(chunks(self.entries, rows.PART_SIZES[kind])):
                yield Part(kind, number, make(members))

    def _rows(self, members: Sequence[Entry]) -> list[Any]:
        return [rows.row_of(entry, self.context) for entry in members]

    def _details(self, members: Sequence[Entry]) -> list[Any]:
        return [rows.details_of(entry, self.words, self._look(entry)) for entry in self.table.with_results(members)]

    def _pictures(self, members: Sequence[Entry]) -> list[Any]:
        thumbnails = self.table.thumbnails(members)
        return [rows.data_uri(thumbnails.get(entry.path, b"")) for entry in members]

    def _look(self, entry: Entry) -> str:
        """What the pictures of an asset look like to a model; empty where nobody has looked at it as it is now."""
        seen = self.found.whole.seen.get(entry.id) if self.found.whole else None
        if seen is None or seen.content != entry.digest:
            return ""
        return in_words(library_report.likeness_of(entry.id, seen))
