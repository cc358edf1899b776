"""The HTML report of a library, from its entries and pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.library.duplicates import in_words
from casa_assets.checks.table.table import explained
from casa_assets.model.registry.rows import Rejection
from casa_assets.pipeline.dedup import library_report
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.reports import html_report
from casa_assets.pipeline.reports.entry import Entry

# What to do where a reason says nothing about it.
DEFAULT_ADVICE = "Look at the picture and the numbers, and fix the mesh."


def write(root: Path, target: Path) -> Path:
    """Write the page for the library at `root` to `target`, by one rename; returns the target.

    Raises:
        OutputError: an entry of the library is damaged, or the page cannot be written.
    """
    table = EntryTable(disk.Library(root), with_results=True)
    thumbnails = table.thumbnails()
    whole = library_report.read_library_report(root)
    records = registry.load()
    explanations = explained(records.limits)
    accepted = [
        html_report.AssetRow(
            entry,
            folder=Path(os.path.relpath(root / entry.path, target.parent)).as_posix(),
            looks=_look(entry, whole),
            thumbnail=thumbnails.get(entry.path, b""),
        )
        for entry in table.entries
        if entry.accepted
    ]
    rejected = [
        _rejected(entry, records.rejections, explanations, thumbnails.get(entry.path, b""))
        for entry in table.entries
        if not entry.accepted
    ]
    section = (
        html_report.render_library_section(whole.report, explanations, whole.weights)
        if whole
        else html_report.NO_SECTION
    )
    page = html_report.render_page(accepted, rejected, root.resolve().name, explanations, section)
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    with writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            fresh.write_text(page, encoding="utf-8")
            fresh.replace(target)
        finally:
            with suppress(OSError):
                fresh.unlink(missing_ok=True)
    return target


def _look(entry: Entry, whole: library_report.LibraryReport | None) -> str:
    """What the pictures of an asset look like to a model; empty where nobody has looked at it as it is now."""
    seen = whole.seen.get(entry.id) if whole else None
    if seen is None or seen.content != entry.digest:
        return ""
    return in_words(library_report.likeness_of(entry.id, seen))


def _rejected(
    entry: Entry, rejections: Mapping[str, Rejection], explanations: Mapping[str, str], thumbnail: bytes
) -> html_report.RejectedRow:
    """The row of a rejected input.

    Args:
        rejections: reasons by code. explanations: code of a check -> its title and what is tested.
    """
    rejection = rejections.get(entry.code)
    # The message of a check ends with what to do.
    fault, _, fix = entry.message.partition("; ")
    return html_report.RejectedRow(
        entry,
        meaning=rejection.meaning if rejection else explanations.get(entry.code, ""),
        reason=entry.message if rejection or not fix else f"{fault}.",
        fix=rejection.remedy if rejection else f"{fix[:1].upper()}{fix[1:]}." if fix else DEFAULT_ADVICE,
        thumbnail=thumbnail,
    )
