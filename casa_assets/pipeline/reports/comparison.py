"""An earlier run beside this one: which inputs do better, which worse, which are new and which are gone."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from casa_assets.errors import OutputError
from casa_assets.model.issue import Decision
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.library.identity import suffix_of
from casa_assets.pipeline.reports.entry import Entry

# From the worst to the best.
RANKS = (Decision.REJECTED, Decision.REVIEW, Decision.ACCEPTED)
REPORT = "report.json"
# Of the form of report.json, see docs/reference/report.md; raised where a reader of an older one would go wrong.
SCHEMA_VERSION = 1


class Change(StrEnum):
    """How an input does beside the earlier run; one that does as before has none."""

    BETTER = "better"
    WORSE = "worse"
    APPEARED = "appeared"
    GONE = "gone"


@dataclass(frozen=True)
class Standing:
    """What became of one input in one run.

    Attributes:
        id, category: of the entry. path: of its folder, relative to its library.
        verdict: what became of it. codes: what it was rejected for, or the advice that it has, sorted.
        source_path: of the input.
    """

    id: str
    category: str
    path: str
    verdict: Decision
    codes: tuple[str, ...]
    source_path: str

    @property
    def in_words(self) -> str:
        """Such as `accepted, advice GEO004` or `rejected: FLT005`."""
        codes = ", ".join(self.codes)
        if self.verdict is Decision.REJECTED:
            return f"{self.verdict}: {codes}"
        return f"{self.verdict}, advice {codes}" if codes else f"{self.verdict}, no advice"


@dataclass(frozen=True)
class Run:
    """The standings of one run.

    Attributes:
        name: of the library. root: its folder. page: its report as a page, None where there is none.
        standings: of all entries, sorted by id.
    """

    name: str
    root: Path
    page: Path | None
    standings: tuple[Standing, ...]


@dataclass(frozen=True)
class Difference:
    """An input that does better or worse, is new or gone. before, now: its standings, None where it was not there."""

    change: Change
    before: Standing | None
    now: Standing | None

    @property
    def id(self) -> str:
        """Of its entry now, else of the one before."""
        found = self.now or self.before
        assert found is not None, "one of the two is there"
        return found.id


def standing_of(entry: Entry) -> Standing:
    """The standing of an entry of a library."""
    codes = {entry.code} if not entry.accepted else {issue.code for issue in entry.warnings}
    return Standing(
        entry.id, entry.category, entry.path, entry.decision, tuple(sorted(codes - {""})), entry.source_path
    )


def read_run(place: Path) -> Run:
    """An earlier run: the report.json that was written beside its page, or its library.

    Raises:
        OutputError: there is neither, or the file is damaged.
    """
    if place.is_file():
        return _run_of_report(place)
    library = disk.Library(place)
    found = EntryTable(library, read_only=True).entries if place.is_dir() else ()
    if not found:
        message = "is no earlier run; give a library, or the report.json that `casa-assets report` wrote"
        raise OutputError(str(place), message)
    page = place / "report.html"
    standings = tuple(sorted(map(standing_of, found), key=lambda one: one.id))
    return Run(place.resolve().name, place, page if page.is_file() else None, standings)


def _run_of_report(path: Path) -> Run:
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        form = data["schema_version"]
        if form != SCHEMA_VERSION:
            raise OutputError(
                str(path),
                f"is a report of schema version {form}, and this program reads {SCHEMA_VERSION}; give the library of "
                "that run, or make its report again",
            )
        standings = [_standing(row) for row in data["entries"]]
        name, root = str(data["library"]), path.parent / str(data["root"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        message = f"is no report of a library ({error}); give the {REPORT} that `casa-assets report` wrote"
        raise OutputError(str(path), message) from error
    page = path.with_suffix(".html")
    return Run(name, root, page if page.is_file() else None, tuple(sorted(standings, key=lambda one: one.id)))


def _standing(row: Mapping[str, Any]) -> Standing:
    return Standing(
        str(row["id"]),
        str(row["category"]),
        str(row["path"]),
        Decision(row["verdict"]),
        tuple(map(str, row["codes"])),
        str(row["source_path"]),
    )


def compare(before: Iterable[Standing], now: Iterable[Standing]) -> list[Difference]:
    """All that changed, worse ones first, each kind by id.

    Two entries are of the same input where their ids end in the same word (see `pipeline.library.identity`), under
    whatever category. An input does worse where its verdict is a lower one (rejected, review, accepted), or the same
    with advice that it did not have; and better the other way round. Another reason for a rejection changes nothing.
    """
    old, new = _by_input(before), _by_input(now)
    found = []
    for key in old.keys() | new.keys():
        change = _change(old.get(key), new.get(key))
        if change is not None:
            found.append(Difference(change, old.get(key), new.get(key)))
    order = [Change.WORSE, Change.BETTER, Change.APPEARED, Change.GONE]
    return sorted(found, key=lambda one: (order.index(one.change), one.id))


def _by_input(standings: Iterable[Standing]) -> dict[str, Standing]:
    found: dict[str, Standing] = {}
    for one in sorted(standings, key=lambda one: one.id):
        key = suffix_of(one.id)
        found[one.id if key in found else key] = one
    return found


def _change(before: Standing | None, now: Standing | None) -> Change | None:
    if before is None:
        return Change.APPEARED
    if now is None:
        return Change.GONE
    step = RANKS.index(now.verdict) - RANKS.index(before.verdict)
    if step == 0 and now.verdict is not Decision.REJECTED:
        new, gone = set(now.codes) - set(before.codes), set(before.codes) - set(now.codes)
        step = -1 if new else 1 if gone else 0
    return None if step == 0 else Change.BETTER if step > 0 else Change.WORSE


def link_before(run: Run, standing: Standing, page: Path) -> str:
    """Path from the folder of a page to what the earlier run has of an input, POSIX; empty where it is there no more.

    That is its row on the earlier page where that is another page, else its folder in the library.
    """
    if run.page is not None and run.page.resolve() != page.resolve():
        return f"{_relative(run.page, page)}#{standing.id}"
    folder = run.root / standing.path
    file = folder / (disk.REFUSAL if standing.verdict is Decision.REJECTED else disk.CERTIFICATE)
    return _relative(file, page) if file.is_file() else ""


def _relative(path: Path, page: Path) -> str:
    return Path(os.path.relpath(path, page.parent)).as_posix()
