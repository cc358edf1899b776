"""The part of the report on a library as a whole: the checks on all assets together, and what they found."""

from __future__ import annotations

import html as markup
from collections.abc import Mapping, Sequence

from casa_assets.model.issue import CheckResult, Issue, Report, Status

# More than so many findings of one check are counted, not listed.
MAX_LISTED = 200


def section(report: Report | None, why: Mapping[str, str], weights: str = "") -> str:
    """HTML of the section; empty where nobody looked at the library as a whole.

    Args:
        report: on the library. why: code of a check to one line that says what it is for.
        weights: name of those of CLIP that looked at the pictures, or empty.
    """
    if report is None or not report.results:
        return ""
    rows = "\n".join(_row(r, [i for i in report.issues if i.code == r.code], why) for r in report.results)
    seen = f"pictures looked at by CLIP with {markup.escape(weights)}" if weights else "nobody looked at the pictures"
    return (
        f'<section class="whole" aria-labelledby="on-all"><h2 id="on-all">The library as a whole ({seen})</h2>\n'
        f"{rows}\n</section>"
    )


def _row(result: CheckResult, issues: Sequence[Issue], why: Mapping[str, str]) -> str:
    number = "" if result.number is None else f", measured {result.number:.3g}"
    limit = "" if result.limit is None else f", limit {result.limit:g}"
    state = {
        Status.PASSED: "passed",
        Status.FAILED: f"{len(issues)} found",
        Status.NOT_APPLICABLE: f"does not apply: {result.reason}",
        Status.NOT_RUN: f"not run: {result.reason}",
    }[result.status]
    kind = {Status.PASSED: "good", Status.NOT_APPLICABLE: "small"}.get(result.status, "warn-text")
    said = markup.escape(why.get(result.code, ""))
    head = f'<b>{result.code}</b> {said} <em class="{kind}">{markup.escape(state)}</em>{number}{limit}'
    if not issues:
        return f"<p>{head}</p>"
    lines = "".join(f"<li>{_line(issue)}</li>" for issue in issues[:MAX_LISTED])
    more = f"<li>and {len(issues) - MAX_LISTED} more</li>" if len(issues) > MAX_LISTED else ""
    return f"<details open><summary>{head}</summary><ul>{lines}{more}</ul></details>"


def _line(issue: Issue) -> str:
    place = f"<b>{markup.escape(issue.pointer)}</b> " if issue.pointer else ""
    return place + markup.escape(issue.message)
