"""The HTML report of a library, from its entries and pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.library.duplicates import in_words
from casa_assets.checks.table import explained
from casa_assets.model.registry.rows import Rejection
from casa_assets.pipeline.dedup import library_report
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import PICTURE
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.reports import html_report, library_section
from casa_assets.pipeline.reports.entry import Entry

# What to do where a reason says nothing about it.
DEFAULT_ADVICE = "Look at the picture and the numbers, and mend the mesh."


def write(root: Path, target: Path) -> Path:
    """Write the page for the library at `root` to `target`, by one rename; returns the target.

    Raises:
        OutputError: an entry of the library is damaged, or the page cannot be written.
    """
    table = EntryTable(disk.Library(root), with_results=True)
    thumbnails = table.thumbnails()
    told = library_report.read_library_report(root)
    accepted = [
        _accepted(e, root, target.parent, told, thumbnails.get(e.path, b"")) for e in table.entries if e.accepted
    ]
    known = registry.load()
    why = explained(known.limits)
    refused = [_refused(e, known.rejections, why, thumbnails.get(e.path, b"")) for e in table.entries if not e.accepted]
    on_all = library_section.section(told.report, why, told.weights) if told else html_report.NO_SECTION
    page = html_report.render_page(accepted, refused, root.resolve().name, why, on_all)
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


def _accepted(
    entry: Entry, root: Path, page: Path, told: library_report.LibraryReport | None, thumbnail: bytes
) -> html_report.AssetRow:
    assert entry.summary is not None, "accepted entries have one"
    folder = root / entry.path
    seen = told.seen.get(entry.id) if told else None
    files = (
        ("MJCF", "model.xml"),
        ("scene", "scene.xml"),
        ("USD", f"usd/{entry.id}.usda"),
        ("certificate", disk.CERTIFICATE),
    )
    return html_report.AssetRow(
        id=entry.id,
        category=entry.category,
        folder=Path(os.path.relpath(folder, page)).as_posix(),
        files=files,
        extents_m=entry.summary.extents,
        mass_kg=entry.summary.mass,
        colliders=entry.summary.colliders,
        hull_max_vertices=entry.summary.hull_vertices,
        faces=entry.summary.faces,
        source=entry.source,
        source_path=entry.source_path,
        licence=entry.licence,
        author=entry.author,
        title=entry.title,
        uri=entry.uri,
        warnings=entry.warnings,
        results=entry.results,
        guesses=entry.guesses,
        looks=in_words(library_report.likeness_of(entry.id, seen)) if seen and seen.content == entry.digest else "",
        thumbnail=thumbnail,
        preview_path=PICTURE,
    )


def _refused(
    entry: Entry, rejections: Mapping[str, Rejection], why: Mapping[str, str], thumbnail: bytes
) -> html_report.RejectedRow:
    """The row of a rejected input; `rejections` and `why` are meanings by code, of reasons and of checks."""
    known = rejections.get(entry.code)
    # The message of a check ends with what to do.
    fault, _, mend = entry.message.partition("; ")
    return html_report.RejectedRow(
        path=entry.source_path,
        source=entry.source,
        code=entry.code,
        meaning=known.meaning if known else why.get(entry.code, ""),
        reason=entry.message if known or not mend else f"{fault}.",
        mend=known.mend if known else f"{mend[:1].upper()}{mend[1:]}." if mend else DEFAULT_ADVICE,
        category=entry.category,
        results=entry.results,
        thumbnail=thumbnail,
    )
