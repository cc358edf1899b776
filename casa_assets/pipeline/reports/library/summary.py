"""What a report says of a library in numbers: the content of report.json, and of the page that shows it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from casa_assets.core.rounding import significant
from casa_assets.model.issue import Decision, Tally
from casa_assets.pipeline.dedup.library_report import LibraryReport
from casa_assets.pipeline.reports.entry import Reported
from casa_assets.pipeline.reports.library.comparison import SCHEMA_VERSION, Change, Difference
from casa_assets.pipeline.reports.library.conditions import Outcome
from casa_assets.pipeline.reports.library.priors import PriorFit, Quantity, outlying
from casa_assets.pipeline.reports.library.rows import Words, codes_of


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
    """Counts of entries, which are taken one after the other and not kept.

    Attributes:
        entries: how many. verdicts: by verdict. advised: with advice. advice: warnings of all of them.
        codes: of rejections and of advice. reasons: by verdict (`rejected`, `review`, `advice`) and reason.
        categories, sources: by name and verdict. checks: of the accepted ones.
    """

    def __init__(self, entries: Iterable[Reported] = ()) -> None:
        self.entries = self.advised = self.advice = 0
        self.verdicts: Counter[Decision] = Counter()
        self.codes: Counter[str] = Counter()
        self.reasons: Counter[tuple[str, str]] = Counter()
        self.categories: dict[str, Counter[Decision]] = {}
        self.sources: dict[str, Counter[Decision]] = {}
        self.checks = Tally()
        for entry in entries:
            self.add(entry)

    def add(self, entry: Reported) -> None:
        """Count one more."""
        decision, codes = entry.decision, codes_of(entry)
        self.entries += 1
        self.verdicts[decision] += 1
        self.codes.update(codes)
        self.categories.setdefault(entry.category, Counter())[decision] += 1
        self.sources.setdefault(entry.source, Counter())[decision] += 1
        self.reasons.update(("review", subject) for subject in set(entry.to_decide))
        if decision is Decision.REJECTED:
            self.reasons[("rejected", entry.code)] += 1
            return
        self.advised += bool(codes)
        self.advice += entry.warning_count
        self.reasons.update(("advice", code) for code in codes)
        more, sums = entry.checks, self.checks
        self.checks = Tally(sums.passed + more.passed, sums.failed + more.failed, sums.not_run + more.not_run)


@dataclass(frozen=True)
class Findings:
    """All that a report tells.

    Attributes:
        library: name of it. root: its folder relative to that of the report, POSIX. entries: of it.
        fits: sizes and masses against the usual ones. whole: checks on all assets together.
        compared: None where there is no earlier run. outcomes: of the conditions that were set.
    """

    library: str
    root: str
    entries: Sequence[Reported]
    fits: Sequence[PriorFit]
    whole: LibraryReport | None
    compared: Compared | None = None
    outcomes: Sequence[Outcome] = ()

    @cached_property
    def totals(self) -> Totals:
        """Counts of the entries."""
        return Totals(self.entries)


def counts(totals: Totals, fits: Sequence[PriorFit], compared: Compared | None) -> dict[str, int]:
    """Counts by the names that conditions use; those of changes where there is an earlier run."""
    found = {
        "entries": totals.entries,
        **{decision.value: totals.verdicts[decision] for decision in Decision},
        "advice": totals.advised,
        "not-run": totals.checks.not_run,
        "size-outliers": len(outlying(fits, Quantity.SIZE)),
        "mass-outliers": len(outlying(fits, Quantity.MASS)),
    }
    return found | (compared.counts if compared else {})


def code_counts(totals: Totals) -> dict[str, int]:
    """Code -> how many entries were rejected for it, or have it as advice, the most frequent first."""
    return dict(sorted(totals.codes.items(), key=lambda item: (-item[1], item[0])))


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
    """What stands in report.json; plain data."""
    return {
        **numbers_of(found.library, found.root, found.totals, found.fits, words, found.outcomes, found.compared),
        "library_checks": found.whole.report.model_dump(mode="json") if found.whole else None,
        "entries": list(map(_entry, found.entries)),
    }


def numbers_of(
    library: str,
    root: str,
    totals: Totals,
    fits: Sequence[PriorFit],
    words: Words,
    outcomes: Sequence[Outcome],
    compared: Compared | None = None,
) -> dict[str, Any]:
    """What report.json says of all entries together; plain data. See Findings."""
    return {
        "schema_version": SCHEMA_VERSION,
        "library": library,
        "root": root,
        "counts": counts(totals, fits, compared),
        "categories": by_verdict(totals.categories),
        "sources": by_verdict(totals.sources),
        "reasons": reasons(totals, words),
        "priors": [_prior(fit) for fit in fits],
        "baseline": _baseline(compared) if compared else None,
        "conditions": [
            {"condition": one.condition.text, "measured": significant(one.measured, 6), "holds": one.holds}
            for one in outcomes
        ],
    }


def _prior(fit: PriorFit) -> dict[str, Any]:
    return {
        "category": fit.name,
        "quantity": fit.quantity.value,
        "unit": "m" if fit.quantity is Quantity.SIZE else "kg",
        "usual": [fit.low, fit.typical, fit.high],
        "count": fit.count,
        "outliers": [{"id": o.id, "value": o.value, "factor": o.factor, "over": o.is_over} for o in fit.outliers],
    }


def _baseline(compared: Compared) -> dict[str, Any]:
    return {
        "library": compared.name,
        "counts": compared.counts,
        "differences": [
            {
                "change": one.change.value,
                "id": one.id,
                "before": one.before.in_words if one.before else None,
                "now": one.now.in_words if one.now else None,
            }
            for one in compared.differences
        ],
    }


def _entry(entry: Reported) -> dict[str, Any]:
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
        "checks": {
            "passed": entry.checks.passed,
            "applying": entry.checks.applying,
            "not_run": entry.checks.not_run,
            "advice": entry.checks.advice,
        },
    }
