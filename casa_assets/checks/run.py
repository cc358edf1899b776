"""Run the rows of the table that fit a subject, and gather a report."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext

from casa_assets.checks.check import Check, Measurement, not_run
from casa_assets.core.numeric import significant
from casa_assets.model.issue import CheckResult, Issue, Report, Status

# What is waived where nothing is; shared and never written to.
NO_WAIVERS: Mapping[str, str] = {}


def run(
    subject: object,
    name: str,
    limits: Mapping[str, float],
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] | None = None,
) -> Report:
    """Report of every check whose subject type is that of `subject`.

    Args:
        subject: an Asset, a Package, ... as the rows name it.
        name: id that the report carries.
        limits: key to number, as registry/limits.yaml has it.
        waived: code -> reason of the checks that are not run on this subject; the report lists them as not run.
        table: rows to run; None: all. The rows of libraries alone need neither MuJoCo nor USD, which take a second
            to import.
    Raises:
        KeyError: a row names a limit that the registry does not have.
    """
    results: list[CheckResult] = []
    issues: list[Issue] = []
    for check in _rows(table):
        if not isinstance(subject, check.subject):
            continue
        limit = None if check.limit is None else limits[check.limit]
        if check.code in waived:
            results.append(_result(check, not_run(waived[check.code], waived=True), limit))
            continue
        with _mujoco_warnings():
            measured = check.run(subject, limits)
        results.append(_result(check, measured, limit))
        issues += [Issue(code=check.code, severity=check.severity, pointer=p, message=s) for p, s in measured.problems]
    return Report(subject=name, results=tuple(results), issues=tuple(issues))


def report_not_run(
    kinds: tuple[type, ...],
    name: str,
    limits: Mapping[str, float],
    reason: str,
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] | None = None,
) -> Report:
    """Report of checks that could not be run, all for one reason.

    Args:
        kinds: types of subjects. reason: a part of a sentence. The others are as for `run`.
    """
    rows = [check for check in _rows(table) if check.subject in kinds]
    results = tuple(
        _result(
            check,
            not_run(waived.get(check.code, reason), waived=check.code in waived),
            None if check.limit is None else limits[check.limit],
        )
        for check in rows
    )
    return Report(subject=name, results=results)


def load_table() -> Iterable[Check]:
    """Every check there is; the first call imports them all, which takes a quarter of a second."""
    from casa_assets.checks.table.table import TABLE

    return TABLE


def _rows(table: Iterable[Check] | None) -> Iterable[Check]:
    return load_table() if table is None else table


def _mujoco_warnings() -> AbstractContextManager[object]:
    """Listens to MuJoCo, whose warnings while it simulates or reads a file again would else be written to a log.

    Where no row has imported MuJoCo, none will be warned by it.
    """
    if "mujoco" not in sys.modules:
        return nullcontext()
    from casa_assets.checks.readers.mujoco_facts import native_warnings

    return native_warnings()


def _result(check: Check, measured: Measurement, limit: float | None) -> CheckResult:
    return CheckResult(
        code=check.code,
        status=measured.status or (Status.FAILED if measured.problems else Status.PASSED),
        severity=check.severity,
        reason=measured.reason,
        waived=measured.waived,
        # More than six digits would carry the noise of the machine's arithmetic into the library.
        number=None if measured.number is None else significant(measured.number, 6),
        limit=limit,
        unit=check.unit,
    )
