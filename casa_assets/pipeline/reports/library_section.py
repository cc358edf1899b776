"""Render the section of a library's report on the checks of all assets together, and what they found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from casa_assets.model.issue import CheckResult, Issue, Report, Status
from casa_assets.pipeline.reports.page_template import render_template

# More than so many findings of one check are counted, not listed.
MAX_LISTED = 200


def section(report: Report | None, why: Mapping[str, str], weights: str = "") -> Markup:
    """HTML of the section; empty where no check of the library as a whole has run.

    Args:
        report: on the library. why: code of a check to its title and what is tested.
        weights: name of the CLIP weights that looked at the pictures; empty where none did.
    """
    if report is None or not report.results:
        return Markup()
    return Markup(  # noqa: S704  the template has escaped every value
        render_template(
            "library_section.html",
            seen=f"pictures looked at by CLIP with {weights}" if weights else "nobody looked at the pictures",
            rows=[_row(r, [i for i in report.issues if i.code == r.code], why) for r in report.results],
            most=MAX_LISTED,
        )
    )


def _row(result: CheckResult, issues: Sequence[Issue], why: Mapping[str, str]) -> dict[str, Any]:
    state = {
        Status.PASSED: "passed",
        Status.FAILED: f"{len(issues)} found",
        Status.NOT_APPLICABLE: f"does not apply: {result.reason}",
        Status.NOT_RUN: f"not run: {result.reason}",
    }[result.status]
    return {
        "code": result.code,
        "why": why.get(result.code, ""),
        "kind": {Status.PASSED: "good", Status.NOT_APPLICABLE: "small"}.get(result.status, "warn-text"),
        "state": state,
        "number": "" if result.number is None else f", measured {result.number:.3g}",
        "limit": "" if result.limit is None else f", limit {result.limit:g}",
        "issues": issues,
    }
