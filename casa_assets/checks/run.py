"""Run the rows of the table that fit a subject, and gather a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from casa_assets.checks.check import Check, Measurement, not_run
from casa_assets.checks.readers.mujoco_load import native_warnings
from casa_assets.checks.table import TABLE
from casa_assets.core.rounding import significant
from casa_assets.model.issue import CheckResult, Issue, Report, Status

# Shared and never written to: what is waived where nothing is.
NOTHING: Mapping[str, str] = {}


def run(
    subject: object,
    name: str,
    limits: Mapping[str, float],
    waived: Mapping[str, str] = NOTHING,
    table: Iterable[Check] = TABLE,
) -> Report:
    """Report of every check whose subject type is that of `subject`.

    Args:
        subject: an Asset, a Package, ... as the rows name it.
        name: id that the report carries.
        limits: key to number, as registry/limits.yaml has it.
        waived: code -> reason of the checks that are not run on this subject; they stand in the report as not run.
        table: rows to run.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    results: list[CheckResult] = []
    issues: list[Issue] = []
    for check in table:
        if not isinstance(subject, check.subject):
            continue
        limit = None if check.limit is None else limits[check.limit]
        if check.code in waived:
            results.append(_result(check, not_run(waived[check.code]), limit, waived=True))
            continue
        # Whatever else MuJoCo warns of, while it simulates or reads a file once more, leaves no log behind.
        with native_warnings():
            found = check.function(subject, limit, *(limits[key] for key in check.others))
        results.append(_result(check, found, limit))
        issues += [Issue(code=check.code, severity=check.severity, pointer=p, message=s) for p, s in found.problems]
    return Report(subject=name, results=tuple(results), issues=tuple(issues))


def report_not_run(
    kinds: tuple[type, ...],
    name: str,
    limits: Mapping[str, float],
    reason: str,
    waived: Mapping[str, str] = NOTHING,
    table: Iterable[Check] = TABLE,
) -> Report:
    """Report of checks that could not be run, all for one reason.

    Args:
        kinds: types of subjects. reason: a part of a sentence. The others are as for `run`.
    """
    rows = [check for check in table if check.subject in kinds]
    results = tuple(
        _result(
            check,
            not_run(waived.get(check.code, reason)),
            None if check.limit is None else limits[check.limit],
            check.code in waived,
        )
        for check in rows
    )
    return Report(subject=name, results=results)


def _result(check: Check, found: Measurement, limit: float | None, waived: bool = False) -> CheckResult:
    return CheckResult(
        code=check.code,
        status=found.status or (Status.FAILED if found.problems else Status.PASSED),
        severity=check.severity,
        reason=found.reason,
        waived=waived,
        number=_rounded(found.number),
        limit=limit,
        unit=check.unit,
    )


def _rounded(number: float | None) -> float | None:
    """Six digits: more would carry the noise of the machine's arithmetic into the library."""
    return None if number is None else significant(number, 6)
