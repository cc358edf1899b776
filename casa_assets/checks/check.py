"""The type of a row of the table of checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from casa_assets.model.issue import Severity


@dataclass(frozen=True)
class Measured:
    """What a check found.

    Attributes:
        number: the measured value, the worst where there are several; None where nothing is measured.
        problems: (pointer, says) for each fault; empty where the subject passes.
    """

    number: float | None = None
    problems: tuple[tuple[str, str], ...] = ()


# The limit is that of registry/limits.yaml, or None for a check that has none.
CheckFunction = Callable[[Any, float | None], Measured]


@dataclass(frozen=True)
class Check:
    """One row.

    Attributes:
        code: such as `AST002`; never reused.
        severity: an error keeps the asset out of the library.
        subject: type that the function takes.
        function: pure; looks, never changes.
        limit: key in registry/limits.yaml, or None.
        unit: of the number and the limit.
        why: one line, why it matters.
    """

    code: str
    severity: Severity
    subject: type
    function: CheckFunction
    limit: str | None
    unit: str
    why: str
