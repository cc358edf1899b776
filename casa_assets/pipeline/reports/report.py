"""The report on a library, written from its entries and pictures: a page, the same as JSON, and files for CI."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.library.duplicates import in_words
from casa_assets.pipeline.dedup import library_report
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.library.run_times import read_costs, read_times
from casa_assets.pipeline.reports import findings, library_page
from casa_assets.pipeline.reports.comparison import Run, compare, link_before, read_run, standing_of
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.gate import Condition, Outcome, judge, junit, sarif
from casa_assets.pipeline.reports.page_template import Words, all_words
from casa_assets.pipeline.viewer.page_models import PageModels


@dataclass(frozen=True)
class CiFiles:
    """Files for continuous integration that are written beside a report; None for those that nobody asked for."""

    junit: Path | None = None
    sarif: Path | None = None

    def write(self, found: findings.Findings, words: Words) -> None:
        """Write them. Raises OutputError where a folder cannot be written to."""
        texts = ((self.junit, lambda: junit(found)), (self.sarif, lambda: sarif(found, words)))
        for path, text in texts:
            if path is not None:
                with writing(path.parent):
                    path.parent.mkdir(parents=True, exist_ok=True)
                    _write_text(path, text())


NO_CI_FILES = CiFiles()


@dataclass(frozen=True)
class WrittenReport:
    """A report that was written. page, json: its files. outcomes: of the conditions that were set."""

    page: Path
    json: Path
    outcomes: tuple[Outcome, ...] = ()


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
        target: the page, `<name>.html`.
        baseline: report.json or library of an earlier run. conditions: that are judged.
        models: where the page finds the models of its assets; None where there are none.
        ci_files: files for continuous integration that are written too.
    Raises:
        OutputError: an entry of the library is damaged, the page cannot be written, or there is no such earlier run.
    """
    before = read_run(baseline) if baseline is not None else None
    table = EntryTable(disk.Library(root))
    entries = sorted(table.entries, key=lambda e: (not e.accepted, e.category if e.accepted else e.source_path, e.id))
    found, words = _findings(root, target, entries, before, conditions), all_words()
    page = library_page.render(found, words, _links(found, before, target), _lists(table, found, words), models)
    json_path = target.with_suffix(".json")
    with writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
        _write_text(target, page)
        _write_text(json_path, json.dumps(findings.content(found, words), sort_keys=True, indent=1) + "\n")
    ci_files.write(found, words)
    return WrittenReport(target, json_path, tuple(found.outcomes))


def _findings(
    root: Path, target: Path, entries: Sequence[Entry], before: Run | None, conditions: Sequence[Condition]
) -> findings.Findings:
    records = registry.load()
    fits = findings.fits(entries, {**records.categories, **records.fixtures})
    compared = None
    if before is not None:
        compared = findings.Compared(before.name, tuple(compare(before.standings, map(standing_of, entries))))
    totals = findings.Totals(entries)
    return findings.Findings(
        root.resolve().name,
        Path(os.path.relpath(root, target.parent)).as_posix(),
        entries,
        fits,
        read_times(disk.Library(root)),
        library_report.read_library_report(root),
        compared,
        judge(conditions, findings.counts(totals, fits, compared), totals.codes),
        read_costs(disk.Library(root)),
    )


def _links(found: findings.Findings, before: Run | None, target: Path) -> dict[str, str]:
    """Id -> path from the page to what the earlier run has, of all that changed."""
    if before is None or found.compared is None:
        return {}
    told = found.compared.differences
    return {one.id: link_before(before, one.before, target) for one in told if one.before is not None}


def _lists(table: EntryTable, found: findings.Findings, words: Words) -> library_page.Lists:
    """Rows, details and pictures of what the page lists."""
    is_brief = len(found.entries) > library_page.MAX_WHOLE
    entries = library_page.listed(found, words)
    details = [
        library_page.details_of(entry, words, _look(entry, found), found.seconds.get(entry.id, {}), is_brief)
        for entry in table.with_results(entries)
    ]
    pictures = None
    if not is_brief:
        thumbnails = table.thumbnails(entries)
        pictures = [library_page.data_uri(thumbnails.get(entry.path, b"")) for entry in entries]
    return library_page.Lists(library_page.rows_of(entries, found), details, pictures)


def _look(entry: Entry, found: findings.Findings) -> str:
    """What the pictures of an asset look like to a model; empty where nobody has looked at it as it is now."""
    seen = found.whole.seen.get(entry.id) if found.whole else None
    if seen is None or seen.content != entry.digest:
        return ""
    return in_words(library_report.likeness_of(entry.id, seen))


def _write_text(target: Path, text: str) -> None:
    """Write a file by one rename."""
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(target)
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)
