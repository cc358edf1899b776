"""Resuming: the outcome that a library holds for an input from an earlier run with the same recipe."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.model.issue import Severity
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.entry_files import file_inside
from casa_assets.pipeline.job import Outcome

# Reasons that lie in a run (its limits, the machine, a bug) and not in the input: the next run tries again.
PASSING = frozenset({"RUN001", "RUN002", "RUN003", "RUN004", "RUN005", "RUN008", "SRC015"})


def cached_outcome(entries: Sequence[Path], asset_id: str, mark: str) -> Outcome | None:
    """The outcome of an earlier run with the same recipe, None where the input is due.

    Args:
        entries: folders of all that was made from the same bytes. mark: the recipe of this run.
    """
    if len(entries) != 1 or entries[0].name != asset_id:
        return None  # made under another category, or a run was killed between two moves
    (folder,) = entries
    try:
        return _refused(folder, mark) if folder.parent.name == disk.REJECTED else _accepted(folder, mark)
    except OutputError:
        return None  # damaged: it is made anew


def _accepted(folder: Path, mark: str) -> Outcome | None:
    certificate = disk.read_certificate(folder)
    if certificate.recipe != mark:
        return None
    return Outcome(True, warnings=tuple(i for i in certificate.report.issues if i.severity is Severity.WARNING))


def _refused(folder: Path, mark: str) -> Outcome | None:
    refusal = disk.read_refusal(folder)
    if refusal.recipe != mark or refusal.code in PASSING:
        return None
    if refusal.twin and not _stands(folder, refusal.twin):
        return None  # what it was a copy of is gone
    return Outcome(False, refusal.code, refusal.says)


def _stands(folder: Path, copy_of: str) -> bool:
    """Whether the asset that an input is a copy of is still in the library."""
    try:
        file_inside(folder.parent.parent, f"{copy_of}/{disk.CERTIFICATE}", folder / disk.REFUSAL, "twin")
    except OutputError:
        return False
    return True
