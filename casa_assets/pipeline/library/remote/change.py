"""What a push or a pull did with one entry or book, and what a whole one may remove."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Literal

from casa_assets.errors import OutputError
from casa_assets.pipeline.library.identity import suffix_of


class Extra(Enum):
    """What becomes of entries that only the side has that is written to."""

    REFUSE = "refuse"  # they end the run before anything is written
    REMOVE = "remove"
    KEEP = "keep"


@dataclass(frozen=True)
class Change:
    """One entry or book is done with.

    Attributes:
        kind: copied, kept (was there already), removed, or failed, and then message says why.
        path: folder of the entry, or file, relative to the library. total: entries of the run.
        bytes_copied: as far as they had to be.
    """

    kind: Literal["copied", "kept", "removed", "failed"]
    path: str
    total: int
    bytes_copied: int = 0
    message: str = ""


def superseded(extra: Iterable[str], other: Iterable[str]) -> set[str]:
    """Those of the entries on one side alone in whose place the other side has one of the same producer and input.

    Args:
        extra, other: paths of entries.
    """
    known = {suffix_of(path.rpartition("/")[2]) for path in other}
    return {path for path in extra if suffix_of(path.rpartition("/")[2]) in known}


def check_extra(place: str, other: str, paths: Iterable[str]) -> None:
    """Raise OutputError where one side has entries that are neither on the other side nor superseded there."""
    if found := sorted(paths):
        count = f"{len(found)} entries" if len(found) > 1 else "an entry"
        message = f"has {count} that {other} lacks, such as {found[0]}"
        raise OutputError(place, f"{message}; copy the other way first, or remove what is lacking there with --delete")


def check_failed(place: str, changes: Iterable[Change]) -> None:
    """Raise OutputError where some entries could not be copied."""
    if failed := [change for change in changes if change.kind == "failed"]:
        few = "\n".join(f"  {change.message}" for change in failed[:3])
        raise OutputError(place, f"{len(failed)} of {failed[0].total} entries could not be copied:\n{few}")
