"""The report on a library as one HTML page that opens from disk and needs no network."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from casa_assets.core.rounding import significant
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status, Tally, tally
from casa_assets.pipeline.library.entry_files import PICTURE
from casa_assets.pipeline.library.library import CERTIFICATE
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.page_template import relative_link, render_template

NO_SECTION = Markup()
MAX_LISTED = 200  # findings of one check on the library as a whole; the others are counted
# Status of a check -> what the script of the page knows it by.
STATUS_NUMBERS = {Status.FAILED: 0, Status.PASSED: 1, Status.NOT_APPLICABLE: 2, Status.NOT_RUN: 3}


@dataclass(frozen=True)
class AssetRow:
    """One accepted asset.

    Attributes:
        entry: with the results of its checks.
        folder: of the asset, POSIX, relative to the page.
        looks: what its pictures look like to a model, a sentence; empty where nobody looked.
        thumbnail: WebP, empty where there is no picture.
    """

    entry: Entry
    folder: str
    looks: str = ""
    thumbnail: bytes = b""


@dataclass(frozen=True)
class RejectedRow:
    """One input that was not accepted.

    Attributes:
        entry: with the results of its checks, of which the failed ones are shown.
        meaning: what its code stands for, one line.
        reason: what was wrong with this input. fix: what to do about it.
        thumbnail: WebP of the raw model, empty where it could not be drawn.
    """

    entry: Entry
    meaning: str
    reason: str
    fix: str
    thumbnail: bytes = b""


def render_page(
    accepted: Sequence[AssetRow],
    rejected: Sequence[RejectedRow],
    title: str,
    explanations: Mapping[str, str],
    library_section: Markup = NO_SECTION,
) -> str:
    """The page: assets by id, rejected inputs by path; the same records give the same page.

    Args:
        title: heading, plain text.
        explanations: code of a check -> its title and what is tested.
        library_section: HTML of the section on all assets together, see `render_library_section`.
    """
    accepted = sorted(accepted, key=lambda row: row.entry.id)
    rejected = sorted(rejected, key=lambda row: (row.entry.source_path, row.entry.code))
    entries, refused = [row.entry for row in accepted], [row.entry for row in rejected]
    results = [result for entry in (*entries, *refused) for result in entry.results]
    checks = sorted({(result.code, result.unit) for result in results})
    number = {check: i for i, check in enumerate(checks)}
    advice = {result.code for result in results if result.severity is Severity.WARNING}
    data = {
        "checks": [[code, unit, explanations.get(code, ""), code in advice] for code, unit in checks],
        "assets": [_asset(row, number) for row in accepted],
        "rejects": [_reject(row, number) for row in rejected],
    }
    return render_template(
        "library.html",
        title=title,
        tiles=_tiles(entries, refused),
        whole=library_section,
        data=data,
        style="library.css",
        script="library.js",
    )


def _tiles(accepted: Sequence[Entry], rejected: Sequence[Entry]) -> list[dict[str, str]]:
    """The numbers at the top, which are readable without scripts too."""
    warned = sum(1 for e in accepted if e.warnings)
    checks = tally(result for e in accepted for result in e.results)
    read = len(accepted) + len(rejected)
    unsure = sum(1 for e in accepted if e.to_decide)
    good = len(accepted) - unsure
    share = f"{100.0 * good / read:.3g} % of {read:,} inputs" if read else "nothing was read"
    reasons = len({e.code for e in rejected})
    mass_kg = sum(e.summary.mass for e in accepted if e.summary)
    tiles = [
        ("accepted", "Accepted", f"{good:,}", share),
        (
            "review",
            "In review",
            f"{unsure:,}",
            "for you to decide, in review.csv" if unsure else "nothing to decide",
        ),
        ("rejected", "Rejected", f"{len(rejected):,}", f"for {_count(reasons, 'reason')}"),
        ("warned", "With warnings", f"{warned:,}", _count(sum(len(e.warnings) for e in accepted), "warning")),
        ("checks", "Checks passed", f"{checks.passed:,}", _applying(checks)),
        ("categories", "Categories", f"{len({e.category for e in accepted}):,}", _largest(accepted)),
        ("mass", "Total mass", f"{mass_kg:.4g} kg", "of all assets"),
    ]
    return [dict(zip(("key", "label", "value", "note"), tile, strict=True)) for tile in tiles]


def _applying(checks: Tally) -> str:
    """Note beside the number of checks that passed."""
    return f"of {checks.applying:,} that apply" + (f", {checks.not_run:,} not run" if checks.not_run else "")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def _largest(entries: Sequence[Entry]) -> str:
    """The category with most assets, the first by name where several have as many."""
    counts = Counter(e.category for e in entries)
    if not counts:
        return "none"
    name, number = min(counts.items(), key=lambda item: (-item[1], item[0]))
    return f"most: {name} ({number:,})"


def _asset(row: AssetRow, number: Mapping[tuple[str, str], int]) -> dict[str, Any]:
    entry = row.entry
    assert entry.summary is not None, "accepted entries have one"
    files = (
        ("MJCF", "model.xml"),
        ("scene", "scene.xml"),
        ("USD", f"usd/{entry.id}.usda"),
        ("certificate", CERTIFICATE),
    )
    return {
        "id": entry.id,
        "category": entry.category,
        "size": [round(100.0 * side, 3) for side in entry.summary.extents],
        "mass": _short(entry.summary.mass),
        "colliders": entry.summary.colliders,
        "hull": entry.summary.hull_vertices,
        "faces": entry.summary.faces,
        "source": entry.source,
        "path": entry.source_path,
        "licence": entry.licence,
        "author": entry.author,
        "title": entry.title,
        "uri": entry.uri,
        "decide": list(entry.to_decide),
        "warnings": [[i.code, i.pointer, i.message] for i in entry.warnings],
        "results": [
            [number[r.code, r.unit], STATUS_NUMBERS[r.status], _short(r.number), _short(r.limit), r.reason]
            for r in entry.results
        ],
        "looks": row.looks,
        "guesses": [[g.subject, g.value, _short(g.confidence), g.reason] for g in entry.guesses],
        "files": [[label, relative_link(f"{row.folder}/{path}")] for label, path in files],
        "large": relative_link(f"{row.folder}/{PICTURE}"),
        "thumb": _data_uri(row.thumbnail),
    }


def _reject(row: RejectedRow, number: Mapping[tuple[str, str], int]) -> dict[str, Any]:
    entry = row.entry
    return {
        "path": entry.source_path,
        "source": entry.source,
        "code": entry.code,
        "meaning": row.meaning,
        "reason": row.reason,
        "fix": row.fix,
        "category": entry.category,
        "failed": [
            [number[r.code, r.unit], _short(r.number), _short(r.limit)]
            for r in entry.results
            if r.status is Status.FAILED
        ],
        "thumb": _data_uri(row.thumbnail),
    }


def _data_uri(webp: bytes) -> str:
    return f"data:image/webp;base64,{base64.b64encode(webp).decode('ascii')}" if webp else ""


def _short(number: float | None) -> float | None:
    """Round to six digits, which are enough to read and keep the page small."""
    return None if number is None else significant(number, 6)


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
            "library_section.html",
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
