"""Write the report on a library: one HTML page that opens from disk without a network, a JSON file, and files for CI.

Up to MAX_WHOLE inputs, the page contains everything, so that it can be sent to somebody as one file. With more inputs,
it shows the pictures in the folders of the library and leaves out details of checks that passed. With more than
MAX_ROWS, it lists those that most need a look, and the JSON file next to it has all.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from casa_assets.checks.library import in_words
from casa_assets.core.numeric import significant
from casa_assets.core.system import replace_file
from casa_assets.library import library_report
from casa_assets.library.entry import ROWS_NAME as ROWS
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import CERTIFICATE, PICTURE, REFUSAL
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.model.issue import CheckResult, Decision, Issue, Report, Severity, Status
from casa_assets.runs.outcome import writing
from casa_assets.show.page.page_template import MAX_ROWS, PageModels, Words, all_words, relative_link, render_template
from casa_assets.show.reports import findings, gate
from casa_assets.show.reports.findings import UNITS, Change, Compared, Difference, Findings, PriorFit, Totals, codes_of
from casa_assets.show.reports.gate import Condition, Outcome

MAX_WHOLE = 400
NO_SECTION = Markup()
MAX_LISTED = 200  # findings of one check on the library as a whole, inputs of one change; the others are counted
# A code of advice that at least this share of at least this many assets have says nothing of one of them.
COMMON_SHARE, COMMON_FROM = 0.75, 8
MAX_OUTLIERS = 8  # of one category and quantity that are named on the page; report.json names all
# Status of a check -> what the script of the page knows it by; a failed warning is advice.
STATUS_NUMBERS = {Status.FAILED: 0, Status.PASSED: 1, Status.NOT_APPLICABLE: 2, Status.NOT_RUN: 3}
ADVICE_NUMBER = 4
# Files of an asset that the page links to, relative to its folder.
FILES = (("MJCF", "model.xml"), ("scene", "scene.xml"), ("USD", "usd/{id}.usda"), ("certificate", CERTIFICATE))


@dataclass(frozen=True)
class WrittenReport:
    """A report that was written. page, json: its files. outcomes: of the conditions that were set."""

    page: Path
    json: Path
    outcomes: tuple[Outcome, ...] = ()


def write(
    root: Path,
    target: Path,
    baseline: Path | None = None,
    conditions: Sequence[Condition] = (),
    models: PageModels | None = None,
    junit: Path | None = None,
    sarif: Path | None = None,
) -> WrittenReport:
    """Write the page for the library at `root` to `target`, a JSON file of that name next to it, and files for CI.

    Raises:
        OutputError: an entry of the library is damaged, the page cannot be written, or there is no such earlier run.
    """
    before = findings.read_run(baseline) if baseline is not None else None
    table = EntryTable(Library(root))
    entries = sorted(table.entries, key=lambda e: (not e.accepted, e.category if e.accepted else e.source_path, e.id))
    found, words = findings.findings_of(root, target, entries, before, conditions), all_words()
    is_brief, shown = len(found.entries) > MAX_WHOLE, listed(found, words)
    pictures = None if is_brief else table.thumbnails(shown)
    rows = rows_of(table.with_results(shown), found, words, pictures, is_brief)
    links = {}
    if before is not None and found.compared is not None:
        changed = ((one.id, one.before) for one in found.compared.differences)
        link = partial(findings.link_before, before, page=target)
        links = {name: link(standing) for name, standing in changed if standing is not None}
    page, json_path = render(found, words, rows, links, models), target.with_suffix(".json")
    texts = {target: page, json_path: json.dumps(findings.content(found, words), sort_keys=True, indent=1) + "\n"}
    if junit is not None:
        texts[junit] = gate.junit(found)
    if sarif is not None:
        texts[sarif] = gate.sarif(found, words)
    for path, text in texts.items():
        with writing(path.parent):
            replace_file(path, text.encode())
    return WrittenReport(target, json_path, tuple(found.outcomes))


def render(
    found: Findings,
    words: Words,
    rows: Sequence[dict[str, Any]],
    links: Mapping[str, str] | None = None,
    models: PageModels | None = None,
) -> str:
    """The page; `rows`: see `rows_of`; `links`: id -> path to what an earlier run has of it."""
    whole, totals = found.whole, found.totals
    quiet = quiet_codes(found.entries, words)
    loud = sum(any(code not in quiet for code in entry.advice) for entry in found.entries if entry.accepted)
    data = {
        "rows": rows,
        "picture": PICTURE,
        "models": models.data if models else None,
        "quiet": sorted(quiet),
        "meanings": {code: words.meaning(code) for code in totals.codes},
        "checks": words.explanations,
    }
    return render_template(
        "library/page.html",
        title=found.library,
        listed=len(rows),
        count=totals.entries,
        tiles=_tiles(totals, findings.counts(totals, found.fits, found.compared) | {"advice": loud}),
        conditions=[(f"{one.mark} {one}", one.holds) for one in found.outcomes],
        groups=[("Category", _counted("category", totals.categories)), ("Source", _counted("source", totals.sources))],
        reasons=[
            row | {"link": "#" + urlencode({"decide" if row["verdict"] == "review" else "reason": row["reason"]})}
            for row in findings.reasons(totals, words)
        ],
        whole=render_library_section(whole.report, words.explanations, whole.weights) if whole else NO_SECTION,
        fits=[_fit(fit) for fit in found.fits],
        compared=_changes(found.compared, links or {}) if found.compared else None,
        data=data,
        styles=("browse/browse.css", "library/page.css"),
        scripts=("browse/browse.js", "library/page.js", *(("model/model.js",) if models else ())),
    )


def quiet_codes(entries: Sequence[Entry], words: Words) -> frozenset[str]:
    """Codes of advice that the list does not mark: nobody has to act on them, or nearly all assets have them."""
    advised = [entry.advice for entry in entries if entry.accepted]
    counted = Counter(code for codes in advised for code in codes)
    most = COMMON_SHARE * max(len(advised), COMMON_FROM)
    return frozenset(code for code, count in counted.items() if count >= most or words.needs_nothing(code))


def _fit(fit: PriorFit) -> dict[str, Any]:
    low, high = (f"{significant(value, 3):.10g}" for value in (fit.usual.low, fit.usual.high))
    return {
        "name": fit.name,
        "quantity": fit.quantity,
        "usual": f"{low} to {high} {UNITS[fit.quantity]}",
        "count": fit.count,
        "outlying": len(fit.outliers),
        "outliers": [
            {"id": o.id, "times": f"{o.factor:.3g} times {'over' if o.over else 'under'}"}
            for o in fit.outliers[:MAX_OUTLIERS]
        ],
    }


def _counted(key: str, groups: Mapping[str, Mapping[Decision, int]]) -> list[dict[str, Any]]:
    return [{**row, "link": f"#{urlencode({key: row['name']})}"} for row in findings.by_verdict(groups)]


def _tiles(totals: Totals, shown: Mapping[str, int]) -> list[dict[str, str]]:
    """The numbers at the top, which are readable without scripts too; those with a filter lead to what they count."""
    good, read, unsure = shown[Decision.ACCEPTED], shown["entries"], shown[Decision.REVIEW]
    share = f"{100.0 * good / read:.3g} % of {read:,} inputs" if read else "nothing was read"
    refusals = sum(verdict == "rejected" for verdict, _ in totals.reasons)
    odd = shown["size-outliers"] + shown["mass-outliers"]
    assets = {name: n for name, by in totals.categories.items() if (n := by.total() - by[Decision.REJECTED])}
    decided = "to be decided" if unsure else "nothing to decide"
    largest = min(assets.items(), key=lambda item: (-item[1], item[0]), default=None)
    others, checks = totals.advised - shown["advice"], totals.checks
    routine = f"{others:,} others have routine notes" if others else "to look at"
    plural = "" if refusals == 1 else "s"
    not_run = f", {checks.not_run:,} not run" if checks.not_run else ""
    most = f"most: {largest[0]} ({largest[1]:,})" if largest else "none"
    tiles = [
        ("accepted", "Accepted", good, share, "#verdict=accepted"),
        ("review", "In review", unsure, decided, "#verdict=review"),
        ("rejected", "Rejected", shown["rejected"], f"for {refusals:,} reason{plural}", "#verdict=rejected"),
        ("advised", "With advice", shown["advice"], routine, "#advice=yes"),
        ("odd", "Unusual", odd, "outside the usual size or mass", "#outlier=size&outlier=mass"),
        ("checks", "Checks passed", checks.passed, f"of {checks.applying:,} that apply{not_run}", ""),
        ("categories", "Categories", len(assets), most, "#tab=numbers"),
    ]
    return [
        {"key": key if value else "zero", "label": label, "value": f"{value:,}", "note": note, "link": link}
        for key, label, value, note, link in tiles
    ]


def _changes(compared: Compared, links: Mapping[str, str]) -> dict[str, Any]:
    kinds = []
    for change in Change:
        members = [one for one in compared.differences if one.change is change]
        rows = [_change(one, links.get(one.id, "")) for one in members[:MAX_LISTED]]
        kinds.append({"change": change, "title": change.capitalize(), "count": len(members), "rows": rows})
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
    """HTML of the checks of the library as a whole, empty if none has run; `weights`: of CLIP, if it was used."""
    if report is None or not report.results:
        return NO_SECTION
    return Markup(  # noqa: S704  the template has escaped every value
        render_template(
            "library/section.html",
            seen=f"pictures looked at by CLIP with {weights}" if weights else "nobody looked at the pictures",
            rows=[_library_check(result, report.issues, explanations) for result in report.results],
            most=MAX_LISTED,
        )
    )


def _library_check(result: CheckResult, found: Sequence[Issue], explanations: Mapping[str, str]) -> dict[str, Any]:
    issues = [issue for issue in found if issue.code == result.code]
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


def listed(found: Findings, words: Words) -> list[Entry]:
    """The entries that the page lists, in their order: all, or of many those that should be looked at first."""
    if len(found.entries) <= MAX_ROWS:
        return list(found.entries)
    quiet = quiet_codes(found.entries, words)
    odd = {name for quantity in UNITS for name in findings.outlying(found.fits, quantity)}

    def rank(entry: Entry) -> int:
        """As the script of the page orders its rows."""
        if entry.decision is not Decision.ACCEPTED:
            return 0 if entry.decision is Decision.REJECTED else 1
        return 2 if entry.id in odd else 3 if any(code not in quiet for code in entry.advice) else 4

    chosen = sorted(range(len(found.entries)), key=lambda place: rank(found.entries[place]))[:MAX_ROWS]
    return [found.entries[place] for place in sorted(chosen)]


def rows_of(
    entries: Iterable[Entry],
    found: Findings,
    words: Words,
    pictures: Mapping[str, bytes] | None = None,
    is_brief: bool = False,
) -> list[dict[str, Any]]:
    """Rows as the script of the page reads them, see docs/reference/report.md; sizes in centimetres, masses in kg.

    Args:
        pictures: small ones by `Entry.path`; None: the page shows those in the library.
        is_brief: leave out checks that passed or do not apply.
    """
    odd = {quantity: frozenset(findings.outlying(found.fits, quantity)) for quantity in UNITS}
    differences = found.compared.differences if found.compared else ()
    changes = {one.now.id: one.change.value for one in differences if one.now is not None}
    rows = []
    for entry in entries:
        row = _row(entry, found.root) | {
            "outlier": [name for name, ids in odd.items() if entry.id in ids],
            "change": changes.get(entry.id, ""),
            "more": _details(entry, found, words, is_brief),
        }
        if pictures is not None:
            webp = pictures.get(entry.path, b"")
            row["thumb"] = f"data:image/webp;base64,{base64.b64encode(webp).decode('ascii')}" if webp else ""
        rows.append(row)
    return rows


def _row(entry: Entry, root: str) -> dict[str, Any]:
    summary = entry.summary
    return {
        "id": entry.id,
        "verdict": entry.decision.value,
        "category": entry.category,
        "title": entry.title,
        "source": entry.source,
        "path": entry.source_path,
        "licence": entry.licence,
        "author": entry.author,
        "size": [round(100.0 * side, 3) for side in summary.extents] if summary else None,
        "mass": _short(summary.mass) if summary else None,
        "colliders": summary.colliders if summary else None,
        "faces": summary.faces if summary else None,
        "passed": entry.checks.passed,
        "applying": entry.checks.applying,
        "codes": list(codes_of(entry)),
        "decide": sorted(set(entry.to_decide)),
        "folder": relative_link(entry.path if root == "." else f"{root}/{entry.path}"),
    }


def _details(entry: Entry, found: Findings, words: Words, is_brief: bool) -> dict[str, Any]:
    is_left_out = {Status.PASSED, Status.NOT_APPLICABLE} if is_brief else set()
    shown = [result for result in entry.results if result.status not in is_left_out]
    results = []
    for r in shown:
        is_advice = r.status is Status.FAILED and r.severity is Severity.WARNING
        number = ADVICE_NUMBER if is_advice else STATUS_NUMBERS[r.status]
        results.append([r.code, number, _short(r.number), _short(r.limit), r.unit, r.reason])
    if entry.decision is Decision.REJECTED:
        reason, fix = words.reason_and_fix(entry)
        # Refused rows of a manifest share one file and have no folder.
        files = [] if entry.path.endswith(f"/{ROWS}") else [["reason", relative_link(REFUSAL)]]
        return {"results": results, "reason": reason, "fix": fix, "files": files}
    seen = found.whole.seen.get(entry.id) if found.whole else None
    return {
        "results": results,
        "hull": entry.summary.hull_vertices if entry.summary else 0,
        "uri": entry.uri,
        "prompt": entry.prompt,
        "generator": entry.generator,
        # In words, what CLIP sees in the pictures of an asset; empty if its present version was not looked at.
        "looks": in_words(library_report.likeness_of(entry.id, seen)) if seen and seen.content == entry.digest else "",
        "warnings": [[issue.code, issue.pointer, issue.message] for issue in entry.warnings],
        "guesses": [[g.subject, g.value, _short(g.confidence), g.reason] for g in entry.guesses],
        "files": [[label, relative_link(path.format(id=entry.id))] for label, path in FILES],
    }


def _short(number: float | None) -> float | None:
    """Six digits, which are enough to read and keep the page small."""
    return None if number is None else significant(number, 6)
