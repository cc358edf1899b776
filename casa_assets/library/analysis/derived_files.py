"""Write what is derived from the entries of a library: attribution, review, and the checks on all together."""

from __future__ import annotations

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.library import attribution, refused_rows, review
from casa_assets.library import library as disk
from casa_assets.library.analysis import clip, library_report
from casa_assets.library.table.entry_table import EntryTable

# What `write_reports` writes, and what it reads beside the entries.
DERIVED = (attribution.NAME, review.NAME, library_report.NAME, f"{disk.REJECTED}/{refused_rows.NAME}")


def write_reports(library: disk.Library, weights: str = "", table: EntryTable | None = None) -> None:
    """Rewrite the files derived from the entries: the attribution file, and the reports on all entries together.

    If all of them are as they were written for the same entries, they are kept.

    Args:
        table: the entries as they were before the run; None: they are read.
    """
    if table is None or not table.is_current():
        table = EntryTable(library)
    made_by = digest_of(key_of(write_reports), weights)
    if table.has_reports(made_by, DERIVED):
        return
    attribution.write(library, table.entries)
    review.write(library, table.entries)
    library_report.compare_library(library, table, clip.load_clip(weights) if weights else None)
    table.keep_reports(made_by, DERIVED)
