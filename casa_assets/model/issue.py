"""The files of a subject, its issues, the results of checks with their numbers, and the report of all."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from typing import Annotated, Self

from pydantic import Field, StringConstraints, field_validator, model_validator

from casa_assets.model.record import Record

# Of the warning that a person has to decide something; its pointer says what.
REVIEW_CODE = "REV001"
# Of the warning that something which the file states was overruled; a person is asked, and need not answer.
ASKED_CODE = "REV003"

Code = Annotated[str, StringConstraints(pattern=r"^[A-Z]{3}[0-9]{3}$")]


class Severity(StrEnum):
    """An error keeps a subject out of the library; a warning is recorded with it."""

    ERROR = "error"
    WARNING = "warning"


class Decision(StrEnum):
    """Verdict on an input.

    REVIEW: an asset was made, but one of its properties was decided on weak evidence, and a person has to confirm it.
    """

    ACCEPTED = "accepted"
    REVIEW = "review"
    REJECTED = "rejected"


class Issue(Record):
    """One fault.

    Attributes:
        code: of the check or rejection, such as `AST002`. severity: error or warning.
        pointer: location in the subject, such as `links/base/inertial`.
        message: the fault and its remedy, one sentence.
    """

    code: Code
    severity: Severity
    pointer: str = ""
    message: str


class Status(StrEnum):
    """Outcome of a check on one subject: passed, failed, not applicable or not run.

    NOT_APPLICABLE: the subject has no part of the kind that the check is about, such as a joint.
    NOT_RUN: the check applies, but nothing was measured: a file cannot be read, a tool is missing, or it is waived.
    """

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not_applicable"
    NOT_RUN = "not_run"


class CheckResult(Record):
    """Outcome of one check on one subject; present whether it passed or not, ran or not.

    Attributes:
        code: of the check. status: outcome.
        severity: of the check; a failed error keeps the subject out of the library, a failed warning is advice.
        reason: why it does not apply or was not run, as a clause; empty if it passed or failed.
        waived: it was not run, which does not count against the subject: registry/waivers.yaml waives it, or it needs
            an optional dependency that is not installed.
        number: measured value (the worst one if there are several), or None.
        limit: limit for the value, from registry/limits.yaml, or None.
        unit: unit of number and limit, such as `m` or `kg/m^3`; empty for counts and ratios.
    """

    code: Code
    status: Status
    severity: Severity = Severity.ERROR
    reason: str = ""
    waived: bool = False
    number: float | None = None
    limit: float | None = None
    unit: str = ""

    @property
    def passed(self) -> bool:
        """True if it applies, was run and found no problem."""
        return self.status is Status.PASSED

    @property
    def applies(self) -> bool:
        """True if the subject has something that the check is about, whether the check was run or not."""
        return self.status is not Status.NOT_APPLICABLE

    @model_validator(mode="after")
    def _has_a_reason(self) -> Self:
        unmeasured = self.status in (Status.NOT_APPLICABLE, Status.NOT_RUN)
        if unmeasured != bool(self.reason):
            raise ValueError("a reason belongs to what does not apply or was not run, and to nothing else")
        if self.waived and self.status is not Status.NOT_RUN:
            raise ValueError("what is waived is not run")
        return self


@dataclass(frozen=True)
class Tally:
    """Counts of checks by status; `advice`: of failed ones of severity warning."""

    passed: int = 0
    failed: int = 0
    not_run: int = 0
    not_applicable: int = 0
    advice: int = 0

    @property
    def applying(self) -> int:
        """Number of checks that apply."""
        return self.passed + self.failed + self.not_run

    def __str__(self) -> str:
        """Text such as `74 of 74 that apply`, followed by the number of checks that were not run, if any."""
        counts = f"{self.passed:,} of {self.applying:,} that apply"
        return f"{counts}, {self.not_run:,} not run" if self.not_run else counts


def tally(results: Iterable[CheckResult]) -> Tally:
    """Counts of results by status."""
    found = list(results)
    advice = sum(r.status is Status.FAILED and r.severity is Severity.WARNING for r in found)
    return Tally(**{status.value: sum(r.status is status for r in found) for status in Status}, advice=advice)


def subjects_to_decide(issues: Iterable[Issue]) -> tuple[str, ...]:
    """Return the properties that a person has to decide, according to warnings, such as `scale`."""
    return tuple(issue.pointer for issue in issues if issue.code == REVIEW_CODE)


class Report(Record):
    """All results and issues of the checks on one subject.

    Attributes:
        subject: id of the asset or scene.
        results: one per check of this subject, in table order, including those that do not apply or were not run.
        issues: every fault, in table order.
    """

    subject: str
    results: tuple[CheckResult, ...] = ()
    issues: tuple[Issue, ...] = ()

    @property
    def errors(self) -> tuple[Issue, ...]:
        """Errors that keep the subject out of the library; if no check failed, the error checks that were not run.

        If an error was found, checks that could not run are not reported, since they usually have the same cause (such
        as a file that does not compile). If no error was found, an error check that should have run and did not is
        itself an error, unless it is waived.
        """
        found = tuple(i for i in self.issues if i.severity is Severity.ERROR)
        unrun = (r for r in self.results if r.status is Status.NOT_RUN and not r.waived)
        return found or tuple(
            Issue(code=r.code, severity=r.severity, message=f"was not run: {r.reason}")
            for r in unrun
            if r.severity is Severity.ERROR
        )

    @property
    def passed(self) -> bool:
        """True if every check of severity error that applies was run, or is waived, and found no error."""
        return not self.errors

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Properties that a person has to decide, such as `scale`."""
        return subjects_to_decide(self.issues)

    @property
    def tally(self) -> Tally:
        """Counts of the results by status."""
        return tally(self.results)

    def __add__(self, other: Report) -> Report:
        """Both reports about the same subject, in order."""
        return Report(subject=self.subject, results=self.results + other.results, issues=self.issues + other.issues)


class Files(Record):
    """An immutable set of files.

    Attributes:
        entries: path -> content; paths are relative, POSIX, ASCII, without `..`, and differ by more than case.
    """

    entries: dict[str, bytes] = Field(default_factory=dict)

    @field_validator("entries")
    @classmethod
    def _safe(cls, entries: dict[str, bytes]) -> dict[str, bytes]:
        seen: dict[str, str] = {}
        for path in entries:
            pure = PurePosixPath(path)
            if not path or pure.is_absolute() or ".." in pure.parts or str(pure) != path or "\\" in path or path == ".":
                raise ValueError(f"{path!r} is not a plain relative path")
            if not path.isascii() or not path.isprintable() or any(c in path for c in '<>:"|?* '):
                raise ValueError(f"{path!r} would not be legal on every file system")
            twin = seen.setdefault(path.lower(), path)
            if twin != path:
                raise ValueError(f"{path!r} and {twin!r} differ only in case")
        return dict(sorted(entries.items()))

    @classmethod
    def of(cls, entries: Mapping[str, bytes]) -> Self:
        """Files from a mapping."""
        return cls(entries=dict(entries))

    def __or__(self, other: Files) -> Files:
        """Union. Raises ValueError if both have a path with different bytes."""
        clash = [p for p in self.entries.keys() & other.entries.keys() if self.entries[p] != other.entries[p]]
        if clash:
            raise ValueError(f"two contents for {sorted(clash)[0]!r}")
        return Files(entries={**self.entries, **other.entries})

    def under(self, folder: str) -> Files:
        """Copy with `folder/` in front of each path."""
        return Files(entries={f"{folder}/{path}": data for path, data in self.entries.items()})

    def sums(self) -> dict[str, str]:
        """Path to sha256 of the content, sorted by path."""
        return {path: hashlib.sha256(data).hexdigest() for path, data in self.entries.items()}
