"""What checks find: issues, results with their numbers, and the report of one subject."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import StringConstraints

from casa_assets.model.record import Record

Code = Annotated[str, StringConstraints(pattern=r"^[A-Z]{3}[0-9]{3}$")]


class Severity(StrEnum):
    """An error keeps a subject out of the library; a warning is recorded with it."""

    ERROR = "error"
    WARNING = "warning"


class Issue(Record):
    """One fault.

    Attributes:
        code: of the check or rejection, such as `AST002`.
        severity: error or warning.
        pointer: where in the subject, such as `links/base/inertial`.
        says: what is wrong and what to do, one sentence.
    """

    code: Code
    severity: Severity
    pointer: str = ""
    says: str


class CheckResult(Record):
    """Outcome of one check on one subject; present whether it passed or not.

    Attributes:
        code: of the check.
        passed: no problem was found.
        number: what was measured (the worst value where there are several), or None.
        limit: what it was held against, as registry/limits.yaml has it, or None.
        unit: of number and limit, such as `m` or `kg/m^3`; empty for counts and ratios.
    """

    code: Code
    passed: bool
    number: float | None = None
    limit: float | None = None
    unit: str = ""


class Report(Record):
    """All that was checked on one subject, and all that was found.

    Attributes:
        subject: id of the asset or scene.
        results: one per check that ran, in table order.
        issues: every fault, in table order.
    """

    subject: str
    results: tuple[CheckResult, ...] = ()
    issues: tuple[Issue, ...] = ()

    @property
    def errors(self) -> tuple[Issue, ...]:
        """Issues that keep the subject out."""
        return tuple(i for i in self.issues if i.severity is Severity.ERROR)

    @property
    def passed(self) -> bool:
        """No error was found (warnings may have been)."""
        return not self.errors

    def __add__(self, other: Report) -> Report:
        """Both reports about the same subject, in order."""
        return Report(subject=self.subject, results=self.results + other.results, issues=self.issues + other.issues)
