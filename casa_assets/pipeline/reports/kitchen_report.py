"""The report of one kitchen as a page: pictures, verdict, every check with its number, design, tasks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from casa_assets.model.issue import CheckResult, Severity, Status, Tally, tally
from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.pipeline.viewer.model_files import ModelFiles


class Marked(NamedTuple):
    """Text of a cell in the colour of a verdict. kind: `passed`, `failed`, `advice` or `none`."""

    kind: str
    text: str


Cells = tuple[str | Marked, ...]


def page(
    facts: Mapping[str, Any],
    report: Mapping[str, Any],
    explained: Mapping[str, str],
    model: ModelFiles | None = None,
    picture: str = "overview.png",
) -> str:
    """HTML of the page.

    Args:
        facts: content of scene.json. report: content of report.json.
        explained: code of a check -> its title and what is tested. model: what it shows in 3D, None where nothing is.
        picture: name of the file that is shown until the model is loaded.
    """
    results = [CheckResult.model_validate(result) for result in report["results"]]
    joints = sum(len(f["joints"]) for f in facts["fixtures"])
    grade = report["grade"]
    return render_template(
        "kitchens/report.html",
        title=facts["id"],
        model=model,
        picture=picture,
        verdict=_passed_or_failed(bool(report["passed"])),
        summary=(
            f"{len(facts['fixtures'])} fixtures, {joints} joints; design {grade['score']:.0f} of 100, "
            f"access {grade['access_score']:.0f} of 100; {facts['generator']}"
        ),
        faults=[(i["code"], _severity(i["severity"]), i["pointer"], i["message"]) for i in report["issues"]],
        passed=_counts(tally(results)),
        checks=[_check(result, explained) for result in results],
        budget=_budget(report),
        robots=[_robot(name, counts) for name, counts in report.get("robots", {}).items()],
        tasks=[_task(task) for task in report["tasks"]],
        design=[_rule(rule) for rule in grade["design"]],
        access=[_rule(rule) for rule in grade["access"]],
    )


def _counts(checks: Tally) -> str:
    """Such as `74 of 76 that apply passed; advice on 2 of the others`: advice keeps no kitchen from passing."""
    told = f"{checks} passed"
    return (
        f"{told}; {checks.advice} of the others {'is' if checks.advice == 1 else 'are'} advice"
        if checks.advice
        else told
    )


def _budget(report: Mapping[str, Any]) -> list[Cells]:
    """Number of bodies and the like in the model, and how fast it ran on the machine of the check."""
    numbers = {**report.get("holds", {}), **report.get("speed", {})}
    return [(name.replace("_", " "), f"{value:g}") for name, value in numbers.items()]


def _robot(name: str, counts: Mapping[str, Any]) -> Cells:
    """A robot with the number of joints that it reaches and opens, the median of its margins, and joints not tried."""
    margin = "" if counts["margin"] is None else f"{counts['margin']:.0%}"
    reached, followed = (f"{counts[what]} of {counts['joints']}" for what in ("reached", "followed"))
    return name, reached, followed, margin, str(counts["without_parking"])


def _severity(word: str) -> Marked:
    return Marked("failed", word) if word == Severity.ERROR else Marked("advice", "advice")


def _check(result: CheckResult, explained: Mapping[str, str]) -> Cells:
    number = "" if result.number is None else f"{result.number:g} {result.unit}"
    limit = "" if result.limit is None else f"{result.limit:g} {result.unit}"
    return result.code, _verdict(result), number, limit, explained.get(result.code, "")


def _verdict(result: CheckResult) -> Marked:
    """Status of a check. A failed warning is advice: it does not keep the kitchen from passing."""
    if result.status is Status.NOT_APPLICABLE:
        return Marked("none", f"does not apply: {result.reason}")
    if result.status is Status.NOT_RUN:
        return Marked("advice", f"not run: {result.reason}")
    if result.status is Status.FAILED and result.severity is Severity.WARNING:
        return Marked("advice", "advice")
    return _passed_or_failed(result.passed)


def _passed_or_failed(passed: bool) -> Marked:
    word = "passed" if passed else "failed"
    return Marked(word, word)


def _task(task: Mapping[str, Any]) -> Cells:
    rate = task.get("rate")
    return str(task["task"]), ", ".join(task.get("fixtures", ())), "" if rate is None else f"{rate:.0%}"


def _rule(found: Mapping[str, Any]) -> Cells:
    verdict = {True: "followed", False: "not followed", None: "does not apply"}[found["passed"]]
    if found["waived"]:
        verdict = "not counted: compact plan"
    number = "" if found["number"] is None else f"{found['number']:g} {found['unit']}"
    limit = f"{'at most' if found['most'] else 'at least'} {found['limit']:g} {found['unit']}"
    kind = "passed" if found["passed"] else "none" if found["passed"] is None or found["waived"] else "advice"
    return found["rule"], found["title"], number, limit, Marked(kind, verdict)
