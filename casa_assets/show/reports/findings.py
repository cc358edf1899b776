"""Findings of a report on a library in numbers, also compared with an earlier run: content of report.json and page."""

from __future__ import annotations

import json
import os
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from casa_assets import registry
from casa_assets.core.numeric import significant
from casa_assets.errors import OutputError
from casa_assets.library import library_report
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import CERTIFICATE, REFUSAL, suffix_of
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.library_report import LibraryReport
from casa_assets.model.issue import Decision, Tally
from casa_assets.model.registry.category import Category, Portion, SizeRange
from casa_assets.show.page.page_template import Words
from casa_assets.show.reports.gate import Condition, Outcome, judge

UNITS = {"size": "m", "mass": "kg"}  # of quantities that are compared with the registry: longest side, mass
# From the worst to the best.
RANKS = (Decision.REJECTED, Decision.REVIEW, Decision.ACCEPTED)
REPORT = "report.json"
# Of the form of report.json, see docs/reference/report.md; raised where a reader of an older one would go wrong.
SCHEMA_VERSION = 1
# An asset that was made as large as is usual at most may be larger by what float32 rounds off.
TOLERANCE = 1.001


@dataclass(frozen=True)
class Outlier:
    """An asset outside the usual range. factor: how many times `over` the highest, or under the lowest usual value."""

    id: str
    value: float
    factor: float
    over: bool


@dataclass(frozen=True)
class PriorFit:
    """Assets of a category, or of a portion (`apple, half`), against its usual range; the farthest outliers first."""

    name: str
    quantity: str
    usual: SizeRange
    count: int
    outliers: tuple[Outlier, ...]


def fits(entries: Iterable[Entry], categories: Mapping[str, Category]) -> list[PriorFit]:
    """Every known category that accepted assets are of, those with most outliers first, then those with most assets."""
    groups: dict[tuple[str, str], list[Entry]] = {}
    for entry in entries:
        if entry.accepted and entry.category in categories:
            groups.setdefault((entry.category, entry.portion), []).append(entry)
    found = []
    for (name, portion), members in groups.items():
        usual = categories[name].usual(Portion(portion) if portion else None)
        title = f"{name}, {portion}" if portion else name
        sizes = {entry.id: max(entry.summary.extents) if entry.summary else 0.0 for entry in members}
        masses = {entry.id: entry.summary.mass if entry.summary else 0.0 for entry in members}
        found.append(PriorFit(title, "size", usual.longest_m, len(members), _outliers(sizes, usual.longest_m)))
        found.append(PriorFit(title, "mass", usual.mass_kg, len(members), _outliers(masses, usual.mass_kg)))
    return sorted(found, key=lambda fit: (-len(fit.outliers), -fit.count, fit.name, fit.quantity))


def _outliers(values: Mapping[str, float], usual: SizeRange) -> tuple[Outlier, ...]:
    found = [
        Outlier(name, significant(value, 6), significant(factor, 6), value > usual.high)
        for name, value in values.items()
        if value > 0 and (factor := max(value / usual.high, usual.low / value)) > TOLERANCE
    ]
    return tuple(sorted(found, key=lambda one: (-one.factor, one.id)))


def outlying(found: Iterable[PriorFit], quantity: str) -> list[str]:
    """Ids of all outliers of a quantity, sorted."""
    return sorted(outlier.id for fit in found if fit.quantity == quantity for outlier in fit.outliers)


def codes_of(entry: Entry) -> tuple[str, ...]:
    """Return the code for which an entry was rejected, or the codes of its advice."""
    if entry.accepted:
        return entry.advice
    return (entry.code,) if entry.code else ()


class Change(StrEnum):
    """Change of an input since the earlier run, in the order in which they are listed; of no change there is none."""

    WORSE = "worse"
    BETTER = "better"
    APPEARED = "appeared"
    GONE = "gone"


@dataclass(frozen=True)
class Standing:
    """Outcome of one input in one run; its folder in its library, and codes of its rejection or of its advice."""

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
    """The standings of one run of the library at `root`, sorted by id, and its HTML report, if there is one."""

    name: str
    root: Path
    page: Path | None
    standings: tuple[Standing, ...]


@dataclass(frozen=True)
class Difference:
    """An input that does better or worse, is new or gone. before, now: its standings, None if not in that run."""

    change: Change
    before: Standing | None
    now: Standing | None

    @property
    def id(self) -> str:
        """Of its entry now, else of the one before."""
        return next(one.id for one in (self.now, self.before) if one is not None)


@dataclass(frozen=True)
class Compared:
    """An earlier run and what changed since. name: of it. differences: worse ones first."""

    name: str
    differences: tuple[Difference, ...]

    @property
    def counts(self) -> dict[str, int]:
        """How many of each kind."""
        return {change.value: sum(one.change is change for one in self.differences) for change in Change}


class Totals:
    """Counts of entries.

    Attributes:
        advised: how many have advice. codes: of rejections and of advice. checks: of the accepted ones.
        reasons: by verdict (`rejected`, `review`, `advice`) and reason. categories, sources: by name and verdict.
    """

    def __init__(self, entries: Iterable[Entry]) -> None:
        self.entries = self.advised = 0
        self.verdicts: Counter[Decision] = Counter()
        self.codes: Counter[str] = Counter()
        self.reasons: Counter[tuple[str, str]] = Counter()
        self.categories: dict[str, Counter[Decision]] = defaultdict(Counter)
        self.sources: dict[str, Counter[Decision]] = defaultdict(Counter)
        self.checks = Tally()
        for entry in entries:
            self._add(entry)

    def _add(self, entry: Entry) -> None:
        decision, codes = entry.decision, codes_of(entry)
        self.entries += 1
        self.verdicts[decision] += 1
        self.codes.update(codes)
        self.categories[entry.category][decision] += 1
        self.sources[entry.source][decision] += 1
        self.reasons.update(("review", subject) for subject in set(entry.to_decide))
        if decision is Decision.REJECTED:
            self.reasons[("rejected", entry.code)] += 1
            return
        self.advised += bool(codes)
        self.reasons.update(("advice", code) for code in codes)
        more, sums = entry.checks, self.checks
        self.checks = Tally(sums.passed + more.passed, sums.failed + more.failed, sums.not_run + more.not_run)


@dataclass(frozen=True)
class Findings:
    """Content of a report.

    Attributes:
        root: folder of the library relative to that of the report, POSIX. whole: checks on all assets together.
        compared: with the earlier run, if there is one. outcomes: of the conditions that were set.
    """

    library: str
    root: str
    entries: Sequence[Entry]
    fits: Sequence[PriorFit]
    whole: LibraryReport | None
    compared: Compared | None = None
    outcomes: Sequence[Outcome] = ()

    @cached_property
    def totals(self) -> Totals:
        """Counts of the entries."""
        return Totals(self.entries)


def findings_of(
    root: Path, target: Path, entries: Sequence[Entry], before: Run | None, conditions: Sequence[Condition]
) -> Findings:
    """Return the findings of a report at `target` on the entries of the library at `root`."""
    records = registry.load()
    fitting = fits(entries, {**records.categories, **records.fixtures})
    compared = None
    if before is not None:
        compared = Compared(before.name, tuple(compare(before.standings, map(standing_of, entries))))
    totals = Totals(entries)
    return Findings(
        root.resolve().name,
        Path(os.path.relpath(root, target.parent)).as_posix(),
        entries,
        fitting,
        library_report.read_library_report(root),
        compared,
        judge(conditions, counts(totals, fitting, compared), totals.codes),
    )


def counts(totals: Totals, fits: Sequence[PriorFit], compared: Compared | None) -> dict[str, int]:
    """Counts by the names that conditions use; those of changes where there is an earlier run."""
    found = {
        "entries": totals.entries,
        **{decision.value: totals.verdicts[decision] for decision in Decision},
        "advice": totals.advised,
        "not-run": totals.checks.not_run,
        **{f"{quantity}-outliers": len(outlying(fits, quantity)) for quantity in UNITS},
    }
    return found | (compared.counts if compared else {})


def by_verdict(groups: Mapping[str, Mapping[Decision, int]]) -> list[dict[str, Any]]:
    """Groups such as categories, and of each how many there are of each verdict; the largest first."""
    rows = [{"name": name, **{d.value: verdicts.get(d, 0) for d in Decision}} for name, verdicts in groups.items()]
    return sorted(rows, key=lambda row: (-sum(row[d.value] for d in Decision), row["name"]))


def reasons(totals: Totals, words: Words) -> list[dict[str, Any]]:
    """Every reason for a rejection, a review or advice, with what it means and how many entries have it."""
    order = ("rejected", "review", "advice")
    rows = sorted(totals.reasons.items(), key=lambda item: (order.index(item[0][0]), -item[1], item[0][1]))
    return [
        {"verdict": verdict, "reason": reason, "meaning": words.meaning(reason), "count": count}
        for (verdict, reason), count in rows
    ]


def content(found: Findings, words: Words) -> dict[str, Any]:
    """Return the content of report.json as plain data."""
    return {
        "schema_version": SCHEMA_VERSION,
        "library": found.library,
        "root": found.root,
        "counts": counts(found.totals, found.fits, found.compared),
        "categories": by_verdict(found.totals.categories),
        "sources": by_verdict(found.totals.sources),
        "reasons": reasons(found.totals, words),
        "priors": [
            {
                "category": fit.name,
                "quantity": fit.quantity,
                "unit": UNITS[fit.quantity],
                "usual": [fit.usual.low, fit.usual.typical, fit.usual.high],
                "count": fit.count,
                "outliers": list(map(asdict, fit.outliers)),
            }
            for fit in found.fits
        ],
        "library_checks": found.whole.report.model_dump(mode="json") if found.whole else None,
        "baseline": _baseline(found.compared) if found.compared else None,
        "conditions": [
            {"condition": one.condition.text, "measured": significant(one.measured, 6), "holds": one.holds}
            for one in found.outcomes
        ],
        "entries": list(map(_entry, found.entries)),
    }


def _baseline(compared: Compared) -> dict[str, Any]:
    differences = []
    for one in compared.differences:
        before, now = (standing.in_words if standing else None for standing in (one.before, one.now))
        differences.append({"change": one.change.value, "id": one.id, "before": before, "now": now})
    return {"library": compared.name, "counts": compared.counts, "differences": differences}


def _entry(entry: Entry) -> dict[str, Any]:
    return {
        "id": entry.id,
        "category": entry.category,
        "verdict": entry.decision.value,
        "codes": list(codes_of(entry)),
        "decide": sorted(set(entry.to_decide)),
        "source": entry.source,
        "source_path": entry.source_path,
        "path": entry.path,
        "size_m": list(entry.summary.extents) if entry.summary else None,
        "mass_kg": entry.summary.mass if entry.summary else None,
        "checks": {name: getattr(entry.checks, name) for name in ("passed", "applying", "not_run", "advice")},
    }


def standing_of(entry: Entry) -> Standing:
    """The standing of an entry of a library."""
    codes = {entry.code} if not entry.accepted else {issue.code for issue in entry.warnings}
    found = tuple(sorted(codes - {""}))
    return Standing(entry.id, entry.category, entry.path, entry.decision, found, entry.source_path)


def read_run(place: Path) -> Run:
    """An earlier run: the report.json that was written next to its page, or its library. Raises OutputError."""
    if place.is_file():
        return _run_of_report(place)
    library = Library(place)
    found = EntryTable(library, read_only=True).entries if place.is_dir() else ()
    if not found:
        message = "is no earlier run; give a library, or the report.json that `casa-assets report` wrote"
        raise OutputError(str(place), message)
    return _run(place.resolve().name, place, place / "report.html", map(standing_of, found))


def _run(name: str, root: Path, page: Path, standings: Iterable[Standing]) -> Run:
    return Run(name, root, page if page.is_file() else None, tuple(sorted(standings, key=lambda one: one.id)))


def _run_of_report(path: Path) -> Run:
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        form = data["schema_version"]
        if form != SCHEMA_VERSION:
            message = f"is a report of schema version {form}, and this program reads {SCHEMA_VERSION}; "
            raise OutputError(str(path), f"{message}give the library of that run, or make its report again")
        standings = TypeAdapter(tuple[Standing, ...]).validate_python(data["entries"])
        name, root = str(data["library"]), path.parent / str(data["root"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        message = f"is no report of a library ({error}); give the {REPORT} that `casa-assets report` wrote"
        raise OutputError(str(path), message) from error
    return _run(name, root, path.with_suffix(".html"), standings)


def compare(before: Iterable[Standing], now: Iterable[Standing]) -> list[Difference]:
    """All that changed, worse ones first, each kind by id; entries whose ids end in the same word are of one input.

    It does worse where its verdict is a lower one (rejected, review, accepted), or the same with advice that it did not
    have; and better the other way round. Another reason for a rejection changes nothing.
    """
    old, new = _by_input(before), _by_input(now)
    pairs = [(old.get(key), new.get(key)) for key in old.keys() | new.keys()]
    found = [Difference(change, *pair) for pair in pairs if (change := _change(*pair)) is not None]
    return sorted(found, key=lambda one: (list(Change).index(one.change), one.id))


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
    """Path from the folder of a page to an input's row on the page of the earlier run, else its file in the library."""
    if run.page is not None and run.page.resolve() != page.resolve():
        return f"{_relative(run.page, page)}#{standing.id}"
    folder = run.root / standing.path
    file = folder / (REFUSAL if standing.verdict is Decision.REJECTED else CERTIFICATE)
    return _relative(file, page) if file.is_file() else ""


def _relative(path: Path, page: Path) -> str:
    return Path(os.path.relpath(path, page.parent)).as_posix()
