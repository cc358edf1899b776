"""The report of one kitchen as a page: pictures, verdict, every check with its number, design, tasks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from casa_assets.core.numeric import significant
from casa_assets.model.issue import CheckResult, Severity, Status, tally
from casa_assets.show.page.page_template import ModelFiles, render_template

# Name of a number in report.json -> what it is called on the page, and its unit.
SIZES = {
    "colliders": ("collision shapes", ""),
    "hulls": ("collision hulls", ""),
    "nv": ("degrees of freedom", ""),
    "texture_mb": ("texture memory", "MB"),
    "load_ms": ("time to load", "ms"),
    "real_time_factor": ("simulation speed", "times real time"),
    "steps_per_s": ("simulation steps", "per second"),
    "check_s": ("time of the checks", "s"),
}
DESIGN = "Rules of kitchen design. They are advice: a kitchen passes whether it follows them or not."
ACCESS = "Rules for people in wheelchairs (2010 ADA Standards). They are advice too."
SMALL_M = 0.1  # lengths below are shown in millimetres
LEAST_SHOWN = 0.001


class Marked(NamedTuple):
    """Text of a cell in the colour of a verdict. kind: `passed`, `failed`, `advice` or `none`."""

    kind: str
    text: str


class Row(NamedTuple):
    """A check, rule or task: its name in words, its code, words on it, what was measured and the limit."""

    title: str
    code: str
    about: str
    number: str
    limit: str


class Group(NamedTuple):
    """Rows of which the same became. mark: what. is_open: they are shown without a click."""

    mark: Marked
    rows: tuple[Row, ...]
    is_open: bool


Cells = tuple[str | Marked, ...]


def page(
    facts: Mapping[str, Any],
    report: Mapping[str, Any],
    explained: Mapping[str, str],
    model: ModelFiles | None = None,
    picture: str = "overview.png",
) -> str:
    """HTML of the page, from scene.json and report.json; the picture is shown until the model is loaded."""
    results = [CheckResult.model_validate(result) for result in report["results"]]
    joints = sum(len(f["joints"]) for f in facts["fixtures"])
    grade, checks = report["grade"], tally(results)
    verb = "is" if checks.advice == 1 else "are"
    word = "passed" if report["passed"] else "failed"
    marks = {Severity.ERROR: Marked("failed", "error"), Severity.WARNING: Marked("advice", "advice")}
    sizes = []
    for name, value in {**report.get("holds", {}), **report.get("speed", {})}.items():
        label, unit = SIZES.get(name, (name.replace("_", " "), ""))
        sizes.append((label, quantity(value, unit)))
    return render_template(
        "kitchens/report.html",
        title=facts["id"],
        model=model,
        picture=picture,
        verdict=Marked(word, word),
        summary=f"{len(facts['fixtures'])} fixtures, {joints} joints; {facts['generator']}",
        faults=[(i["code"], marks[i["severity"]], i["pointer"], i["message"]) for i in report["issues"]],
        passed=f"{checks} passed" + (f"; {checks.advice} of the others {verb} advice" if checks.advice else ""),
        checks=_checks(results, explained),
        sizes=sizes,
        robots=[_robot(name, counts) for name, counts in report.get("robots", {}).items()],
        tasks=_tasks(report["tasks"]),
        rules=[
            ("Design", DESIGN, grade["score"], _rules(grade["design"])),
            ("Access", ACCESS, grade["access_score"], _rules(grade["access"])),
        ],
    )


def _robot(name: str, counts: Mapping[str, Any]) -> Cells:
    """A robot with the number of joints that it reaches and opens, the median of its margins, and joints not tried."""
    margin = "" if counts["margin"] is None else f"{counts['margin']:.0%}"
    reached, followed = (f"{counts[what]} of {counts['joints']}" for what in ("reached", "followed"))
    return name, reached, followed, margin, str(counts["without_parking"])


def _checks(results: Sequence[CheckResult], explained: Mapping[str, str]) -> list[Group]:
    """Results by what became of them, what has to be looked at first; the rest is folded."""
    groups = {
        Marked("failed", "failed"): [r for r in results if r.status is Status.FAILED and not _is_advice(r)],
        Marked("advice", "advice"): [r for r in results if _is_advice(r)],
        Marked("advice", "not run"): [r for r in results if r.status is Status.NOT_RUN],
        Marked("passed", "passed"): [r for r in results if r.passed],
        Marked("none", "not applicable"): [r for r in results if r.status is Status.NOT_APPLICABLE],
    }
    is_folded = (Status.PASSED, Status.NOT_APPLICABLE)
    return [
        Group(mark, tuple(_check(r, explained) for r in some), is_open=some[0].status not in is_folded)
        for mark, some in groups.items()
        if some
    ]


def _is_advice(result: CheckResult) -> bool:
    """A failed warning: it does not keep the kitchen from passing."""
    return result.status is Status.FAILED and result.severity is Severity.WARNING


def _check(result: CheckResult, explained: Mapping[str, str]) -> Row:
    title, _, about = explained.get(result.code, "").partition(": ")
    if result.reason:
        about = f"{_sentence(result.reason)}. {about}"
    number, limit = _compared(result.number, result.limit, result.unit)
    return Row(title, result.code, about, number, limit)


def _tasks(tasks: Sequence[Mapping[str, Any]]) -> list[Group]:
    """Tasks that the kitchen lacks something for, then the others, the ones with least room for their objects first."""
    lacking = [task for task in tasks if task.get("wants")]
    others = [task for task in tasks if not task.get("wants")]
    others.sort(key=lambda task: 2.0 if task.get("rate") is None else task["rate"])
    groups = ((Marked("advice", "not supported"), lacking), (Marked("passed", "supported"), others))
    return [Group(mark, tuple(map(_task, some)), is_open=some is lacking) for mark, some in groups if some]


def _task(task: Mapping[str, Any]) -> Row:
    name = str(task["task"])
    words = re.sub(r"\bcab\b", "cabinet", name.replace("_", " ")).replace("pnp", "pick and place:")
    about = task.get("wants") or ", ".join(task.get("fixtures", ())).replace("_", " ")
    rate = "" if task.get("rate") is None else quantity(100.0 * task["rate"], "%")
    return Row(_sentence(words), name, about, rate, "")


def _rules(findings: Sequence[Mapping[str, Any]]) -> list[Group]:
    """Rules of design by whether they are followed; those that are not come first, the rest is folded."""
    groups: dict[Marked, list[Row]] = {
        Marked("advice", "not followed"): [],
        Marked("none", "not counted, because the plan is compact"): [],
        Marked("passed", "followed"): [],
        Marked("none", "not applicable"): [],
    }
    missed, waived, followed, others = groups.values()
    for found in findings:
        rows = {True: followed, False: missed, None: others}[found["passed"]]
        (waived if found["waived"] else rows).append(_rule(found))
    return [Group(mark, tuple(rows), is_open=rows is missed) for mark, rows in groups.items() if rows]


def _rule(found: Mapping[str, Any]) -> Row:
    number, limit = _compared(found["number"], found["limit"], found["unit"])
    bound = f"{'at most' if found['most'] else 'at least'} {limit}"
    return Row(_sentence(found["title"]), found["rule"], "", number, bound)


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]


def _compared(number: float | None, limit: float | None, unit: str) -> tuple[str, str]:
    """A number and its limit in the same unit: small lengths in millimetres, shares in per cent."""
    scale = 1.0
    if unit == "m" and max(abs(number or 0.0), abs(limit or 0.0)) < SMALL_M:
        scale, unit = 1000.0, "mm"
    elif unit == "" and limit is not None and 0.0 < limit < 1.0:  # the limit of a share of something, not of a count
        scale, unit = 100.0, "%"
    first, second = ("" if value is None else quantity(scale * value, unit) for value in (number, limit))
    return first, second


def quantity(value: float, unit: str = "") -> str:
    """A number as people read it, with three digits; no line breaks before its unit."""
    if 0.0 < abs(value) < LEAST_SHOWN:
        digits = f"below {LEAST_SHOWN:g}"
    else:
        digits = f"{value:,.0f}" if abs(value) >= 1000.0 else f"{significant(value, 3):.10g}"
    return f"{digits}\u00a0{unit.replace('^2', '²').replace('^3', '³')}".rstrip()
