"""The report on a library as one HTML page that opens from disk and needs no network, and the rows that it lists.

Up to MAX_WHOLE inputs all of it stands in the page, so that it can be sent to somebody as one file. Of more inputs,
pictures are those in the folders of the library, and details leave out what passed; of more than MAX_ROWS the page
lists the ones that should be looked at first, and the JSON file beside it has all.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from casa_assets.core.rounding import significant
from casa_assets.model.issue import CheckResult, Decision, Issue, Report, Severity, Status, Tally
from casa_assets.pipeline.ingest.refused_rows import NAME as ROWS
from casa_assets.pipeline.library.entry_files import PICTURE
from casa_assets.pipeline.library.library import CERTIFICATE, REFUSAL
from casa_assets.pipeline.reports.comparison import Change, Difference
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.findings import (
    Compared,
    Findings,
    PriorFit,
    Quantity,
    Totals,
    by_verdict,
    codes_of,
    cost,
    counts,
    outlying,
    reasons,
    stage_times,
    tail_words,
)
from casa_assets.pipeline.reports.page_template import MAX_ROWS, Words, relative_link, render_template
from casa_assets.pipeline.viewer.page_models import PageModels

MAX_WHOLE = 400
NO_SECTION = Markup()
MAX_LISTED = 200  # findings of one check on the library as a whole, inputs of one change; the others are counted
# A code of advice that at least this share of so many assets have tells nothing of one of them.
COMMON_SHARE, COMMON_FROM = 0.75, 8
MAX_OUTLIERS = 8  # of one category and quantity that are named on the page; report.json names all
CHANGE_TITLES = {
    Change.WORSE: "Worse",
    Change.BETTER: "Better",
    Change.APPEARED: "Appeared",
    Change.GONE: "Gone",
}
# Status of a check -> what the script of the page knows it by; a failed warning is advice.
STATUS_NUMBERS = {Status.FAILED: 0, Status.PASSED: 1, Status.NOT_APPLICABLE: 2, Status.NOT_RUN: 3}
ADVICE_NUMBER = 4
# Files of an asset that the page links to, relative to its folder.
FILES = (("MJCF", "model.xml"), ("scene", "scene.xml"), ("USD", "usd/{id}.usda"), ("certificate", CERTIFICATE))
# Values of a row, in their order; what the words mean stands in docs/reference/report.md.
FIELDS = (
    "id",
    "verdict",
    "category",
    "title",
    "source",
    "path",
    "licence",
    "author",
    "size",
    "mass",
    "colliders",
    "faces",
    "passed",
    "applying",
    "codes",
    "decide",
    "outlier",
    "change",
    "folder",
)


@dataclass(frozen=True)
class Lists:
    """What the script of the page lists: for each entry one item in each of them.

    Attributes:
        rows: values of FIELDS. details: see `details_of`. pictures: data URIs, empty for none; None: the page shows
            those in the folders of the library.
    """

    rows: Sequence[Any]
    details: Sequence[Any]
    pictures: Sequence[str] | None


def render(
    found: Findings, words: Words, links: Mapping[str, str], lists: Lists, models: PageModels | None = None
) -> str:
    """The page; the same findings give the same page.

    Args:
        links: id -> path to what an earlier run has of it. lists: of the entries that the page lists.
        models: where the models of its assets are.
    """
    whole, totals = found.whole, found.totals
    quiet = quiet_codes(found.entries, words)
    loud = sum(any(code not in quiet for code in entry.advice) for entry in found.entries if entry.accepted)
    ids = [entry.id for entry in found.entries]
    spent = cost(found.costs, ids)
    data = {
        "fields": FIELDS,
        "rows": lists.rows,
        "details": lists.details,
        "pictures": lists.pictures,
        "picture": PICTURE,
        "models": models.data if models else None,
        "quiet": sorted(quiet),
        "meanings": {code: words.meaning(code) for code in totals.codes},
        "checks": words.explanations,
    }
    return render_template(
        "library/page.html",
        title=found.library,
        listed=len(lists.rows),
        count=totals.entries,
        tiles=_tiles(totals, counts(totals, found.fits, found.compared) | {"advice": loud}),
        conditions=[(f"{one.mark} {one}", one.holds) for one in found.outcomes],
        groups=_groups(totals),
        reasons=_reasons(totals, words),
        cost=spent,
        tail_words=tail_words(spent["inputs"]) if spent else "",
        times=stage_times(found.seconds, ids),
        whole=render_library_section(whole.report, words.explanations, whole.weights) if whole else NO_SECTION,
        fits=[_fit(fit) for fit in found.fits],
        compared=_changes(found.compared, links) if found.compared else None,
        data=data,
        styles=("browse/browse.css", "library/page.css"),
        scripts=("browse/browse.js", "library/page.js", *(("model/model.js",) if models else ())),
    )


def quiet_codes(entries: Sequence[Entry], words: Words) -> frozenset[str]:
    """Codes of advice that the list does not mark, because nobody has to act on them or nearly all assets have them.

    The details of an asset name them all the same.
    """
    advised = [entry.advice for entry in entries if entry.accepted]
    counted = Counter(code for codes in advised for code in codes)
    most = COMMON_SHARE * max(len(advised), COMMON_FROM)
    return frozenset(code for code, count in counted.items() if count >= most or words.needs_nothing(code))


# Numbers --------------------------------------------------------------------------------------------------------------


def _fit(fit: PriorFit) -> dict[str, Any]:
    """A row of the table of sizes and masses against the usual ones."""
    low, high = (f"{significant(value, 3):.10g}" for value in (fit.usual.low, fit.usual.high))
    return {
        "name": fit.name,
        "quantity": fit.quantity.value,
        "usual": f"{low} to {high} {fit.quantity.unit}",
        "count": fit.count,
        "outlying": len(fit.outliers),
        "outliers": [
            {"id": o.id, "times": f"{o.factor:.3g} times {'over' if o.is_over else 'under'}"}
            for o in fit.outliers[:MAX_OUTLIERS]
        ],
    }


def _groups(totals: Totals) -> list[tuple[str, list[dict[str, Any]]]]:
    """Heading, and counts by verdict with a link to what is counted, of categories and of sources."""
    found = []
    for heading, key, group in (("Category", "category", totals.categories), ("Source", "source", totals.sources)):
        rows = by_verdict(group)
        found.append((heading, [{**row, "link": f"#{urlencode({key: row['name']})}"} for row in rows]))
    return found


def _reasons(totals: Totals, words: Words) -> list[dict[str, Any]]:
    """Reasons with links to the entries that have them."""
    rows = reasons(totals, words)
    for row in rows:
        row["link"] = "#" + urlencode({"decide" if row["verdict"] == "review" else "reason": row["reason"]})
    return rows


def _tiles(totals: Totals, shown: Mapping[str, int]) -> list[dict[str, str]]:
    """The numbers at the top, which are readable without scripts too; those with a filter lead to what they count."""
    good, read, unsure = shown[Decision.ACCEPTED], shown["entries"], shown[Decision.REVIEW]
    share = f"{100.0 * good / read:.3g} % of {read:,} inputs" if read else "nothing was read"
    refusals = sum(verdict == "rejected" for verdict, _ in totals.reasons)
    odd = shown["size-outliers"] + shown["mass-outliers"]
    assets = {name: n for name, by in totals.categories.items() if (n := by.total() - by[Decision.REJECTED])}
    decided = "to be decided" if unsure else "nothing to decide"
    others = totals.advised - shown["advice"]
    routine = f"{others:,} others have routine notes" if others else "to look at"
    tiles = [
        ("accepted", "Accepted", good, share, "#verdict=accepted"),
        ("review", "In review", unsure, decided, "#verdict=review"),
        ("rejected", "Rejected", shown["rejected"], f"for {_count(refusals, 'reason')}", "#verdict=rejected"),
        ("advised", "With advice", shown["advice"], routine, "#advice=yes"),
        ("odd", "Unusual", odd, "outside the usual size or mass", "#outlier=size&outlier=mass"),
        ("checks", "Checks passed", totals.checks.passed, _applying(totals.checks), ""),
        ("categories", "Categories", len(assets), _largest(assets), "#tab=numbers"),
    ]
    return [
        {"key": key if value else "zero", "label": label, "value": f"{value:,}", "note": note, "link": link}
        for key, label, value, note, link in tiles
    ]


def _applying(checks: Tally) -> str:
    """Note beside the number of checks that passed."""
    return f"of {checks.applying:,} that apply" + (f", {checks.not_run:,} not run" if checks.not_run else "")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def _largest(assets: Mapping[str, int]) -> str:
    """The category with most assets, the first by name where several have as many."""
    if not assets:
        return "none"
    name, number = min(assets.items(), key=lambda item: (-item[1], item[0]))
    return f"most: {name} ({number:,})"


# Changes and checks of all together -----------------------------------------------------------------------------------


def _changes(compared: Compared, links: Mapping[str, str]) -> dict[str, Any]:
    """What changed since an earlier run, as the template shows it."""
    kinds = []
    for change, title in CHANGE_TITLES.items():
        members = [one for one in compared.differences if one.change is change]
        kinds.append(
            {
                "change": change.value,
                "title": title,
                "count": len(members),
                "rows": [_change(one, links.get(one.id, "")) for one in members[:MAX_LISTED]],
            }
        )
    return {"name": compared.name, "kinds": kinds}


def _change(one: Difference, link: str) -> dict[str, Any]:
    path, _, row = link.partition("#")
    return {
        "id": one.id,
        "is_here": one.now is not None,
        "before": one.before.in_words if one.before else "was not there",
        "now": one.now.in_words if one.now else "is not there",
        "link": (relative_link(path) + (f"#{row}" if row else "")) if link else "",
    }


def render_library_section(report: Report | None, explanations: Mapping[str, str], weights: str = "") -> Markup:
    """HTML of the section on the checks of all assets together; empty where no check of the library as a whole has run.

    Args:
        report: on the library. explanations: code of a check -> its title and what is tested.
        weights: name of the CLIP weights that looked at the pictures; empty where none did.
    """
    if report is None or not report.results:
        return NO_SECTION
    return Markup(  # noqa: S704  the template has escaped every value
        render_template(
            "library/section.html",
            seen=f"pictures looked at by CLIP with {weights}" if weights else "nobody looked at the pictures",
            rows=[
                _library_check(r, [i for i in report.issues if i.code == r.code], explanations) for r in report.results
            ],
            most=MAX_LISTED,
        )
    )


def _library_check(result: CheckResult, issues: Sequence[Issue], explanations: Mapping[str, str]) -> dict[str, Any]:
    state = {
        Status.PASSED: "passed",
        Status.FAILED: f"{len(issues)} found",
        Status.NOT_APPLICABLE: f"does not apply: {result.reason}",
        Status.NOT_RUN: f"not run: {result.reason}",
    }[result.status]
    return {
        "code": result.code,
        "why": explanations.get(result.code, ""),
        "kind": {Status.PASSED: "good", Status.NOT_APPLICABLE: "small"}.get(result.status, "warn-text"),
        "state": state,
        "number": "" if result.number is None else f", measured {result.number:.3g}",
        "limit": "" if result.limit is None else f", limit {result.limit:g}",
        "issues": issues,
    }


# Rows -----------------------------------------------------------------------------------------------------------------


def listed(found: Findings, words: Words, most: int = MAX_ROWS) -> list[Entry]:
    """The entries that the page lists, in their order: all, or of many those that should be looked at first."""
    if len(found.entries) <= most:
        return list(found.entries)
    quiet = quiet_codes(found.entries, words)
    odd = {name for quantity in Quantity for name in outlying(found.fits, quantity)}

    def rank(entry: Entry) -> int:
        """As the script of the page orders its rows."""
        if entry.decision is not Decision.ACCEPTED:
            return 0 if entry.decision is Decision.REJECTED else 1
        return 2 if entry.id in odd else 3 if any(code not in quiet for code in entry.advice) else 4

    chosen = sorted(range(len(found.entries)), key=lambda place: rank(found.entries[place]))[:most]
    return [found.entries[place] for place in sorted(chosen)]


def rows_of(entries: Sequence[Entry], found: Findings) -> list[list[Any]]:
    """Values of FIELDS of entries; size in centimetres, mass in kg, None for a rejected input.

    `codes` are what it was rejected for, or the advice that it has; `decide` what a person has to decide.
    """
    odd = {quantity.value: frozenset(outlying(found.fits, quantity)) for quantity in Quantity}
    differences = found.compared.differences if found.compared else ()
    changes = {one.now.id: one.change.value for one in differences if one.now is not None}

    def row(entry: Entry) -> list[Any]:
        summary = entry.summary
        return [
            entry.id,
            entry.decision.value,
            entry.category,
            entry.title,
            entry.source,
            entry.source_path,
            entry.licence,
            entry.author,
            [round(100.0 * side, 3) for side in summary.extents] if summary else None,
            _short(summary.mass) if summary else None,
            summary.colliders if summary else None,
            summary.faces if summary else None,
            entry.checks.passed,
            entry.checks.applying,
            list(codes_of(entry)),
            sorted(set(entry.to_decide)),
            [name for name, ids in odd.items() if entry.id in ids],
            changes.get(entry.id, ""),
            relative_link(entry.path if found.root == "." else f"{found.root}/{entry.path}"),
        ]

    return [row(entry) for entry in entries]


def details_of(
    entry: Entry, words: Words, looks: str, seconds: Mapping[str, float], is_brief: bool = False
) -> dict[str, Any]:
    """What the page tells of an entry that is opened; the entry has the results of its checks.

    Args:
        looks: what its pictures look like to a model, a sentence; empty where nobody looked.
        seconds: that it took to make, by stage. is_brief: leave out what passed or does not apply.
    """
    shown = [r for r in entry.results if not is_brief or r.status in (Status.FAILED, Status.NOT_RUN)]
    told: dict[str, Any] = {
        "results": [[r.code, _status_number(r), _short(r.number), _short(r.limit), r.unit, r.reason] for r in shown],
        "seconds": {stage: _short(value) for stage, value in seconds.items()},
    }
    if entry.decision is Decision.REJECTED:
        told["reason"], told["fix"] = words.reason_and_fix(entry)
        # Refused rows of a manifest share one file and have no folder.
        told["files"] = [] if entry.path.endswith(f"/{ROWS}") else [["reason", relative_link(REFUSAL)]]
        return told
    return told | {
        "hull": entry.summary.hull_vertices if entry.summary else 0,
        "uri": entry.uri,
        "prompt": entry.prompt,
        "generator": entry.generator,
        "looks": looks,
        "warnings": [[issue.code, issue.pointer, issue.message] for issue in entry.warnings],
        "guesses": [[g.subject, g.value, _short(g.confidence), g.reason] for g in entry.guesses],
        "files": [[label, relative_link(path.format(id=entry.id))] for label, path in FILES],
    }


def _status_number(result: CheckResult) -> int:
    is_advice = result.status is Status.FAILED and result.severity is Severity.WARNING
    return ADVICE_NUMBER if is_advice else STATUS_NUMBERS[result.status]


def data_uri(webp: bytes) -> str:
    """A picture as text that a page can show; empty for none."""
    return f"data:image/webp;base64,{base64.b64encode(webp).decode('ascii')}" if webp else ""


def _short(number: float | None) -> float | None:
    """Round to six digits, which are enough to read and keep the page small."""
    return None if number is None else significant(number, 6)
