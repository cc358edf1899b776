"""A good and a bad example of a check: it is silent on the one, and speaks alone on the other."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from typing import TypeVar

from casa_assets.checks.table import TABLE
from casa_assets.model.issue import Report, Status
from casa_assets.registry import load

Value, Made = TypeVar("Value"), TypeVar("Made")
LIMITS = load().limits
ROWS = {check.code: check for check in TABLE}


def between(make: Callable[[Value], Made], good: Value, bad: Value) -> tuple[Callable[[], Made], Callable[[], Made]]:
    """Two examples that differ in one value, on either side of a limit."""
    return partial(make, good), partial(make, bad)


def check_examples(code: str, good: Report, bad: Report, along: Collection[str] = (), parted: bool = False) -> None:
    """Assert what the examples of a code are for.

    Args:
        along: codes that the bad example may trip too.
        parted: the limit of the check lies between the two numbers, which differ, if there are two.
    """
    row = ROWS[code]
    assert good.issues == ()
    assert (code, row.severity) in {(issue.code, issue.severity) for issue in bad.issues}
    failed = {result.code for result in bad.results if result.status is Status.FAILED}
    assert code in failed
    assert failed | {issue.code for issue in bad.issues} <= {code, *along}
    numbers = [{r.code: r.number for r in report.results}[code] for report in (good, bad)]
    if parted and row.limit is not None and None not in numbers:
        low, high = sorted(number for number in numbers if number is not None)
        assert low <= LIMITS[row.limit] <= high
        assert low < high
