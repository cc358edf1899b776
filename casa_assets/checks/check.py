"""The row type of the table of checks, and the result of a check function."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from casa_assets.model.issue import Severity, Status


@dataclass(frozen=True)
class Measurement:
    """Result of a check function: a number with its problems, or the reason why there is none.

    Attributes:
        number: the measured value, the worst where there are several.
        problems: (pointer, message) for each fault; empty where the subject passes.
        status: NOT_APPLICABLE or NOT_RUN where nothing was measured, PASSED where all was well and there is no number
            to tell; None where the problems decide.
        reason: why it does not apply or was not run.
    """

    number: float | None = None
    problems: tuple[tuple[str, str], ...] = ()
    status: Status | None = None
    reason: str = ""

    def __post_init__(self) -> None:
        """A check that measured nothing and found nothing has to say what that means: it is no pass by silence."""
        if self.status is None:
            assert self.number is not None or self.problems, "say clean, not_applicable or not_run"
        else:
            assert self.number is None, "a number belongs to what was measured"
            assert not self.problems, "problems belong to what was measured"


def no_fault() -> Measurement:
    """Result of a subject that was looked at and has no fault, where there is no number to tell."""
    return Measurement(status=Status.PASSED)


def not_applicable(reason: str) -> Measurement:
    """The subject has nothing of the kind that the check is about; `reason` is a part of a sentence."""
    return Measurement(status=Status.NOT_APPLICABLE, reason=reason)


def not_run(reason: str) -> Measurement:
    """The check applies, but could not look; `reason` is a part of a sentence that says why."""
    return Measurement(status=Status.NOT_RUN, reason=reason)


def largest(numbers: Iterable[float], problems: tuple[tuple[str, str], ...], otherwise: str) -> Measurement:
    """The largest number with its problems; not applicable, for the reason `otherwise`, where there is none."""
    found = list(numbers)
    return Measurement(max(found), problems) if found else not_applicable(otherwise)


def least(numbers: Iterable[float], problems: tuple[tuple[str, str], ...], otherwise: str) -> Measurement:
    """The least number with its problems; not applicable, for the reason `otherwise`, where there is none."""
    found = list(numbers)
    return Measurement(min(found), problems) if found else not_applicable(otherwise)


# (subject, limit, others...): the limits are those of registry/limits.yaml; None for a check that has none.
CheckFunction = Callable[..., Measurement]


@dataclass(frozen=True)
class Check:
    """One row.

    Attributes:
        code: such as `AST002`; never reused.
        title: two to five words that name what is tested.
        severity: an error keeps the asset out of the library; a warning is advice.
        subject: type that the function takes.
        function: pure; looks, never changes.
        limit: key in registry/limits.yaml of what the number is held against, or None.
        unit: of the number and the limit.
        description: one sentence: what is measured, against which limit, and what to do where it fails. `{limit}` and
            `{mm}` (a thousand times the limit) stand for the number, the keys of `others` for theirs.
        others: keys of further limits, which the function takes after the first one, in this order.
    """

    code: str
    title: str
    severity: Severity
    subject: type
    function: CheckFunction
    limit: str | None
    unit: str
    description: str
    others: tuple[str, ...] = ()

    def describe(self, limits: Mapping[str, float]) -> str:
        """The description with its numbers. Raises KeyError where `limits` lacks one."""
        told = {key: limits[key] for key in self.others}
        if self.limit is not None:
            value = limits[self.limit]
            told |= {"limit": value, "mm": 1e3 * value, "mm2": 1e6 * value}
        return self.description.format(**told)


def required_limit(limit: float | None) -> float:
    """The limit of a check whose row in the table names one."""
    assert limit is not None, "the row of this check names a limit"
    return limit
