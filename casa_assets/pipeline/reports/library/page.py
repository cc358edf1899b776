"""The report on a library as an HTML page that opens from disk and needs no network."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from casa_assets.model.issue import CheckResult, Decision, Issue, Report, Status, Tally
from casa_assets.pipeline.library.entry_files import PICTURE
from casa_assets.pipeline.library.library import REFUSAL
from casa_assets.pipeline.reports.entry import Reported
from casa_assets.pipeline.reports.library.comparison import Change, Difference
from casa_assets.pipeline.reports.library.conditions import Outcome
from casa_assets.pipeline.reports.library.models import PageModels
from casa_assets.pipeline.reports.library.priors import PriorFit
from casa_assets.pipeline.reports.library.rows import BRIEF_FIELDS, FIELDS, FILES, PART_SIZES, Words
from casa_assets.pipeline.reports.library.summary import (
    Compared,
    Findings,
    Totals,
    by_verdict,
    code_counts,
    counts,
    reasons,
)
from casa_assets.pipeline.reports.page_template import relative_link, render_template
from casa_assets.pipeline.reports.parts import Part

NO_SECTION = Markup()
MAX_LISTED = 200  # findings of one check on the library as a whole, inputs of one change; the others are counted
# A code of advice that at least this share of so many assets have tells nothing of one of them.
COMMON_SHARE, COMMON_FROM = 0.75, 8
MAX_OUTLIERS = 40  # of one category and quantity that are named on the page; report.json names all
CHANGE_TITLES = {
    Change.WORSE: "Worse",
    Change.BETTER: "Better",
    Change.APPEARED: "Appeared",
    Change.GONE: "Gone",
}


def render(
    found: Findings,
    words: Words,
    links: Mapping[str, str],
    inside: Sequence[Part],
    folder: str = "",
    models: PageModels | None = None,
    is_brief: bool = False,
    overview: str = "",
) -> str:
    """The page; the same findings give the same page.

    Args:
        links: id -> path to what an earlier run has of it. inside: parts of the data that stand in the page itself.
        folder: of the script files with the other parts, beside the page. models: where the models of its assets are.
        is_brief: rows hold all that is told of an entry, and pictures are those in the folders of entries.
        overview: path to the page that this one is a part of; empty where it is whole.
    """
    whole, totals = found.whole, found.totals
    quiet = quiet_codes(found.entries, words)
    loud = sum(any(code not in quiet for code in entry.advice) for entry in found.entries if entry.accepted)
    sizes = {kind: size for kind, size in PART_SIZES.items() if kind == "rows" or not is_brief}
    data = {
        "count": len(found.entries),
        "fields": [*FIELDS, *(BRIEF_FIELDS if is_brief else ())],
        "folder": relative_link(folder) if folder else "",
        "sizes": sizes,
        "picture": PICTURE,
        "files": FILES,
        "refusal": REFUSAL,
        "remedies": {code: words.rejections[code].remedy for code in totals.codes if code in words.rejections},
        "models": models.data if models else None,
        "quiet": sorted(quiet),
        "meanings": {code: words.meaning(code) for code in code_counts(totals)},
        "checks": words.explanations,
    }
    return render_template(
        "library/page.html",
        title=found.library,
        overview=relative_link(overview) if overview else "",
        tiles=_tiles(totals, counts(totals, found.fits, found.compared) | {"advice": loud}),
        conditions=[(f"{one.mark} {one}", one.holds) for one in found.outcomes],
        groups=_groups(totals),
        reasons=_reasons(totals, words),
        whole=render_library_section(whole.report, words.explanations, whole.weights) if whole else NO_SECTION,
        compared=_changes(found.compared, links) if found.compared else None,
        data=data,
        inside=inside,
        styles=("browse/browse.css", "library/page.css"),
        scripts=("browse/browse.js", "library/page.js", *(("model/model.js",) if models else ())),
    )


def quiet_codes(entries: Sequence[Reported], words: Words) -> frozenset[str]:
    """Codes of advice that the list does not mark, because nobody has to act on them or nearly all assets have them.

    The details of an asset name them all the same.
    """
    advised = [entry.advice for entry in entries if entry.accepted]
    counted = Counter(code for codes in advised for code in codes)
    most = COMMON_SHARE * max(len(advised), COMMON_FROM)
    return frozenset(code for code, count in counted.items() if count >= most or words.needs_nothing(code))


@dataclass(frozen=True)
class PagePart:
    """One of the pages of a large report. link: to it. first, last: categories. rows: how many it lists."""

    link: str
    first: str
    last: str
    rows: int


def render_overview(
    name: str,
    totals: Totals,
    fits: Sequence[PriorFit],
    words: Words,
    pages: Sequence[PagePart],
    outcomes: Sequence[Outcome] = (),
) -> str:
    """The page that leads to the pages of a large report, and has the numbers over all of them.

    Args:
        pages: in the order of their categories. outcomes: of the conditions that were set.
    """
    return render_template(
        "library/overview.html",
        title=name,
        tiles=[{**tile, "link": ""} for tile in _tiles(totals, counts(totals, fits, None))],
        conditions=[(f"{one.mark} {one}", one.holds) for one in outcomes],
        groups=_groups(totals, pages),
        reasons=[{**row, "link": ""} for row in _reasons(totals, words)],
        pages=pages,
        styles=("browse/browse.css", "library/page.css"),
    )


def numbers(found: Findings) -> list[Any]:
    """What the charts of sizes and masses are drawn from, one item for each."""
    return [_chart(fit) for fit in found.fits]


def _chart(fit: PriorFit) -> dict[str, Any]:
    return {
        "name": fit.name,
        "quantity": fit.quantity.value,
        "usual": [fit.low, fit.typical, fit.high],
        "marks": [round(mark, 4) for mark in fit.marks],
        "count": fit.count,
        "steps": fit.steps,
        "outliers": [[o.id, o.value, o.factor, o.is_over] for o in fit.outliers[:MAX_OUTLIERS]],
        "outlying": len(fit.outliers),
    }


def _groups(totals: Totals, pages: Sequence[PagePart] | None = None) -> list[tuple[str, list[dict[str, Any]]]]:
    """Heading, and counts by verdict with a link to what is counted, of categories and of sources.

    Args:
        pages: of a large report; None: all is listed on this page.
    """
    found = []
    for heading, key, group in (("Category", "category", totals.categories), ("Source", "source", totals.sources)):
        rows = by_verdict(group)
        for row in rows:
            words = urlencode({key: row["name"]})
            if pages is None:
                row["link"] = f"#{words}"
            else:
                links = [page.link for page in pages if page.first <= row["name"] <= page.last]
                row["link"] = f"{links[0]}#{words}" if key == "category" and links else ""
        found.append((heading, rows))
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
    tiles = [
        ("accepted", "Accepted", f"{good:,}", share, "#verdict=accepted"),
        (
            "review",
            "In review",
            f"{unsure:,}",
            "to be decided" if unsure else "nothing to decide",
            "#verdict=review",
        ),
        ("rejected", "Rejected", f"{shown['rejected']:,}", f"for {_count(refusals, 'reason')}", "#verdict=rejected"),
        (
            "advised",
            "With advice",
            f"{shown['advice']:,}",
            _other_advice(totals.advised - shown["advice"]),
            "#advice=yes",
        ),
        ("odd", "Unusual", f"{odd:,}", "outside the usual size or mass", "#outlier=size&outlier=mass"),
        ("checks", "Checks passed", f"{totals.checks.passed:,}", _applying(totals.checks), ""),
        ("categories", "Categories", f"{len(assets):,}", _largest(assets), "#tab=numbers"),
    ]
    return [
        {"key": key if value != "0" else "zero", "label": label, "value": value, "note": note, "link": link}
        for key, label, value, note, link in tiles
    ]


def _other_advice(others: int) -> str:
    """Note beside the number of assets with advice to act on."""
    return f"{others:,} others have routine notes" if others else "to look at"


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
