"""Runs the rows of the table that fit a subject and gathers a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from casa_assets.checks.check import Check
from casa_assets.checks.readers.mujoco_load import heard
from casa_assets.checks.table import TABLE
from casa_assets.model.issue import CheckResult, Issue, Report


def run(
    subject: object,
    name: str,
    limits: Mapping[str, float],
    waived: frozenset[str] = frozenset(),
    table: Iterable[Check] = TABLE,
) -> Report:
    """Report of every check whose subject type is that of `subject`.

    Args:
        subject: an Asset, a Package, ... as the rows name it.
        name: id that the report carries.
        limits: key to number, as registry/limits.yaml has it.
        waived: codes that are not run on this subject.
        table: rows to run.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    results: list[CheckResult] = []
    issues: list[Issue] = []
    for check in table:
        if not isinstance(subject, check.subject) or check.code in waived:
            continue
        limit = None if check.limit is None else limits[check.limit]
        # Whatever else MuJoCo warns of, while it simulates or reads a file once more, leaves no log behind.
        with heard():
            found = check.function(subject, limit)
        results.append(
            CheckResult(
                code=check.code, passed=not found.problems, number=_rounded(found.number), limit=limit, unit=check.unit
            )
        )
        issues += [Issue(code=check.code, severity=check.severity, pointer=p, says=s) for p, s in found.problems]
    return Report(subject=name, results=tuple(results), issues=tuple(issues))


def _rounded(number: float | None) -> float | None:
    """Six digits: more would carry the noise of the machine's arithmetic into the library."""
    return None if number is None else float(f"{number:.6g}")
