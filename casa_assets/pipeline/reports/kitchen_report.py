"""The report of one kitchen as a page: pictures, verdict, every check with its number, design, tasks."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from typing import Any

from casa_assets.model.issue import CheckResult, Severity, Status, tally

CHECKED = ("code", "verdict", "number", "limit", "what is tested, and what to do")
RULES = ("rule", "what", "number", "limit", "verdict")
ADVICE = "Advice: a kitchen passes whether it follows a rule or not; together they make the score."
STYLE = """
:root { color-scheme: light dark; font-family: system-ui, sans-serif; }
body { margin: 2rem auto; max-width: 1200px; padding: 0 1rem; }
img { max-width: 100%; border-radius: 8px; }
.two { display: grid; grid-template-columns: 3fr 2fr; gap: 18px; align-items: start; }
table { border-collapse: collapse; width: 100%; margin: 1rem 0 2rem; font-size: .9rem; }
td, th { text-align: left; padding: 4px 8px; border-bottom: 1px solid #8884; vertical-align: top; }
.passed { color: #1a7f37; } .failed { color: #cf222e; } .advice { color: #9a6700; } .none { color: #888; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
"""


def page(facts: Mapping[str, Any], report: Mapping[str, Any], explained: Mapping[str, str]) -> str:
    """HTML.

    Args:
        facts: content of scene.json. report: content of report.json.
        explained: code of a check -> its title and what is tested.
    """
    results = [CheckResult.model_validate(result) for result in report["results"]]
    passed = bool(report["passed"])
    joints = sum(len(f["joints"]) for f in facts["fixtures"])
    grade = report["grade"]
    verdict = _mark(passed, "passed" if passed else "failed")
    head = (
        f"<h1>{_text(facts['id'])} {verdict}</h1>"
        f"<p>{len(facts['fixtures'])} fixtures, {joints} joints; design {grade['score']:.0f} of 100, "
        f"access {grade['access_score']:.0f} of 100; {_text(facts['generator'])}</p>"
        "<div class='two'><img src='overview.png' alt='overview'>"
        "<img src='floor_map.png' alt='floor with parking places'></div>"
    )
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>{_text(facts['id'])}</title>"
        f"<style>{STYLE}</style>"
        f"{head}{_faults(report['issues'])}"
        f"<h2>Checks</h2><p>{tally(results)} passed.</p>"
        f"{_table(CHECKED, (_check(result, explained) for result in results))}"
        f"<h2>Budget</h2>{_budget(report)}"
        f"<h2>Tasks</h2>{_table(('task', 'fixtures', 'acceptance of placements'), map(_task, report['tasks']))}"
        f"<h2>Design</h2><p>{ADVICE}</p>{_table(RULES, map(_rule, grade['design']))}"
        f"<h2>Access</h2><p>{ADVICE}</p>{_table(RULES, map(_rule, grade['access']))}</html>\n"
    )


def _budget(report: Mapping[str, Any]) -> str:
    """What the model holds, and how fast it was on the machine of the check."""
    told = {**report.get("holds", {}), **report.get("speed", {})}
    if not told:
        return "<p>It does not load.</p>"
    return _table(("what", "number"), ((name.replace("_", " "), f"{value:g}") for name, value in told.items()))


def _faults(issues: list[Mapping[str, Any]]) -> str:
    if not issues:
        return ""
    rows = ((i["code"], _severity(i["severity"]), i["pointer"], i["message"]) for i in issues)
    return f"<h2>What was found</h2>{_table(('code', 'severity', 'where', 'what'), rows)}"


def _severity(word: str) -> str:
    return _mark(False, word) if word == Severity.ERROR else _Markup(f"<span class='advice'>{_text(word)}</span>")


def _check(result: CheckResult, explained: Mapping[str, str]) -> tuple[str, ...]:
    number = "" if result.number is None else f"{result.number:g} {result.unit}"
    limit = "" if result.limit is None else f"{result.limit:g} {result.unit}"
    return result.code, _verdict(result), number, limit, explained.get(result.code, "")


def _verdict(result: CheckResult) -> str:
    """A failed warning is advice: it does not keep the kitchen from passing."""
    if result.status is Status.NOT_APPLICABLE:
        return _Markup(f"<span class='none'>does not apply: {_text(result.reason)}</span>")
    if result.status is Status.NOT_RUN:
        return _Markup(f"<span class='advice'>not run: {_text(result.reason)}</span>")
    if result.status is Status.FAILED and result.severity is Severity.WARNING:
        return _Markup("<span class='advice'>advice</span>")
    return _mark(result.passed, result.status.value)


def _task(task: Mapping[str, Any]) -> tuple[str, ...]:
    rate = task.get("rate")
    return str(task["task"]), ", ".join(task.get("fixtures", ())), "" if rate is None else f"{rate:.0%}"


def _rule(found: Mapping[str, Any]) -> tuple[str, ...]:
    verdict = {True: "followed", False: "not followed", None: "does not apply"}[found["passed"]]
    if found["waived"]:
        verdict = "not counted: compact plan"
    number = "" if found["number"] is None else f"{found['number']:g} {found['unit']}"
    limit = f"{'at most' if found['most'] else 'at least'} {found['limit']:g} {found['unit']}"
    kind = "passed" if found["passed"] else "none" if found["passed"] is None or found["waived"] else "advice"
    mark = _Markup(f"<span class='{kind}'>{verdict}</span>")
    return found["rule"], found["title"], number, limit, mark


class _Markup(str):
    """HTML of our own; every other text is escaped before it comes into a cell."""

    __slots__ = ()


def _mark(good: bool, word: str) -> str:
    return _Markup(f"<span class='{'passed' if good else 'failed'}'>{_text(word)}</span>")


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    cells = "".join(
        "<tr>" + "".join(f"<td>{c if isinstance(c, _Markup) else _text(c)}</td>" for c in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{''.join(f'<th>{h}</th>' for h in head)}</tr>{cells}</table>"


def _text(value: object) -> str:
    return html.escape(str(value))
