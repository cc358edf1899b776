"""Find the outcome of an earlier run for an input under the same cache key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from pathlib import Path
from types import MappingProxyType

from casa_assets.errors import OutputError
from casa_assets.ingest import rejection_codes
from casa_assets.model.issue import Severity
from casa_assets.pipeline.dedup.deduplicator import NEAR_DUPLICATE_CODE
from casa_assets.pipeline.ingest.job import Outcome
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import file_inside
from casa_assets.pipeline.reports.entry import Entry

# Codes of refusals whose reason is the run (its limits, the machine, a bug) and not the input; the next run tries the
# input again.
RETRIED_CODES = frozenset(
    {
        "RUN001",  # timeout
        "RUN002",  # out of memory
        "RUN003",  # a native library crashed
        "RUN004",  # the program failed
        "RUN005",  # the file changed while it was being read
        "RUN008",  # the work made no progress
        rejection_codes.TOO_LARGE,
        rejection_codes.STORE_FAILED,
    }
)
NOTHING_KNOWN: Mapping[Path, Entry] = MappingProxyType({})


def cached_outcome(
    entries: Sequence[Path],
    asset_id: str | None,
    cache_key: str,
    known: Mapping[Path, Entry] = NOTHING_KNOWN,
    retried: Set[str] = RETRIED_CODES,
) -> tuple[Path, Outcome] | None:
    """The entry of an earlier run under the same key and what it says; None if the input must be processed.

    Args:
        entries: folders of all that the producer made of the same bytes. cache_key: of this run.
        asset_id: of this run; None where it is known only once the work is done.
        known: entries that were read already, by their folder: their files are not opened again.
        retried: codes of refusals whose input is tried again.
    """
    for folder in entries:
        if asset_id not in (None, folder.name):
            continue  # made under another category
        entry = known.get(folder)
        try:
            if entry is not None and entry.code != NEAR_DUPLICATE_CODE:
                outcome = _of_entry(entry, cache_key, retried)
            else:  # of a copy only the file tells which asset it is a copy of, and that may be gone
                is_refused = folder.parent.name == disk.REJECTED
                outcome = _refused(folder, cache_key, retried) if is_refused else _accepted(folder, cache_key)
        except OutputError:
            continue  # damaged: it is made anew
        if outcome is not None:
            return folder, outcome
    return None


def _of_entry(entry: Entry, cache_key: str, retried: Set[str]) -> Outcome | None:
    if entry.cache_key != cache_key or entry.code in retried or not entry.is_whole:
        return None
    return Outcome(entry.accepted, entry.code, entry.message, entry.warnings)


def _accepted(folder: Path, cache_key: str) -> Outcome | None:
    certificate = disk.read_certificate(folder)
    if certificate.cache_key != cache_key or not disk.is_whole(folder, certificate):
        return None
    return Outcome(True, warnings=tuple(i for i in certificate.report.issues if i.severity is Severity.WARNING))


def _refused(folder: Path, cache_key: str, retried: Set[str]) -> Outcome | None:
    refusal = disk.read_refusal(folder)
    if refusal.cache_key != cache_key or refusal.code in retried:
        return None
    if refusal.twin and not _is_in_library(folder, refusal.twin):
        return None  # the asset that it was a copy of is gone
    return Outcome(False, refusal.code, refusal.message)


def _is_in_library(folder: Path, twin: str) -> bool:
    """True if the asset that an input is a copy of is still in the library."""
    try:
        file_inside(folder.parent.parent, f"{twin}/{disk.CERTIFICATE}", folder / disk.REFUSAL, "twin")
    except OutputError:
        return False
    return True
