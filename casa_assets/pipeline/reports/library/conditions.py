"""Conditions on a report that fail a build, such as `rejected-rate>5%`, `worse` or `FLT005`.

    CONDITION  = NAME [ OPERATOR NUMBER [ "%" ] ]
    NAME       = a count, a count followed by "-rate", or the code of a check or of a rejection
    OPERATOR   = ">" | ">=" | "<" | "<="

A name alone means that there is one at least. A rate is a share of all entries, 0 to 1 or with a percent sign.
"""

from __future__ import annotations

import difflib
import operator
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from casa_assets.errors import CasaError

# Counts of a report, in the order in which they are told.
COUNTS = ("entries", "accepted", "review", "rejected", "advice", "not-run", "size-outliers", "mass-outliers")
# Counts beside an earlier run.
CHANGES = ("better", "worse", "appeared", "gone")
# Counts of entries, of which there is a rate.
RATES = ("accepted", "review", "rejected", "advice")
OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
# Operator of a condition that fails a build -> what stands before its number where it is told what is allowed.
_ALLOWED: Mapping[str, str] = {">": "", ">=": "less than ", "<": "at least ", "<=": "more than "}
_FORM = re.compile(r"\s*([A-Za-z][A-Za-z0-9-]*)\s*(?:(>=|<=|>|<)\s*([0-9]*\.?[0-9]+)\s*(%?))?\s*")
GRAMMAR = (
    "write NAME, or NAME followed by >, >=, < or <= and a number; NAME is one of "
    f"{', '.join((*COUNTS, *CHANGES))}, one of "
    f"{', '.join(f'{name}-rate' for name in RATES)} (0 to 1, or with %), or a code such as FLT005"
)


class BadCondition(CasaError):
    """A condition that is not of the grammar."""


@dataclass(frozen=True)
class Condition:
    """One condition.

    Attributes:
        text: as it was written. name: what is counted. compare: a key of OPERATORS. bound: what it is held against.
    """

    text: str
    name: str
    compare: str
    bound: float

    @property
    def is_rate(self) -> bool:
        """It is about a share of all entries."""
        return self.name.endswith("-rate")

    @property
    def needs_baseline(self) -> bool:
        """It is about what changed since an earlier run."""
        return self.name in CHANGES


@dataclass(frozen=True)
class Outcome:
    """A condition with what was measured.

    Attributes:
        holds: the condition is true, so the build fails. total: entries of the report.
    """

    condition: Condition
    measured: float
    holds: bool
    total: int

    @property
    def mark(self) -> str:
        """`FAIL` where the condition holds, else `PASS`."""
        return "FAIL" if self.holds else "PASS"

    def __str__(self) -> str:
        """Such as `rejected: 2 of 61, allowed 0`, or `rejected-rate: 3.3 % of 61, allowed 5 %`."""
        name, of = self.condition.name, f" of {self.total}"
        measured, bound = (
            f"{100 * value:.3g} %" if self.condition.is_rate else f"{value:g}"
            for value in (self.measured, self.condition.bound)
        )
        if name in COUNTS and name not in RATES:
            of = ""
        return f"{name}: {measured}{of}, allowed {_ALLOWED[self.condition.compare]}{bound}"


def parse(text: str, codes: Collection[str]) -> Condition:
    """The condition that a text states.

    Args:
        codes: of all checks and rejections.
    Raises:
        BadCondition: it is not of the grammar, or no count and no code is called so.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise BadCondition(f"--fail-on {text!r} is no condition; {GRAMMAR}")
    name, compare, number, percent = found.groups()
    rate = name.removesuffix("-rate") if name.endswith("-rate") else ""
    if (rate and rate not in RATES) or not (rate or name in COUNTS or name in CHANGES or name in codes):
        known = (*COUNTS, *CHANGES, *(f"{one}-rate" for one in RATES), *codes)
        near = difflib.get_close_matches(name, sorted(known), n=3, cutoff=0.5)
        hint = f" (did you mean {', '.join(near)}?)" if near else ""
        raise BadCondition(f"--fail-on {text!r}: nothing is called {name!r}{hint}; {GRAMMAR}")
    if percent and not rate:
        raise BadCondition(f"--fail-on {text!r}: {name} is a count, and % belongs to a rate; {GRAMMAR}")
    bound = float(number or 0) / (100 if percent else 1)
    if rate and bound > 1:
        raise BadCondition(f"--fail-on {text!r}: a rate is 0 to 1, or 0% to 100%; {GRAMMAR}")
    return Condition(text.strip(), name, compare or ">", bound)


def judge(conditions: Sequence[Condition], counts: Mapping[str, int], codes: Mapping[str, int]) -> tuple[Outcome, ...]:
    """Each condition with what was measured.

    Args:
        counts: of COUNTS, and of CHANGES where there is an earlier run. codes: how many entries have each code.
    """
    found, total = [], counts["entries"]
    for condition in conditions:
        name = condition.name.removesuffix("-rate")
        number: float = counts[name] if name in counts else codes.get(name, 0)
        if condition.is_rate:
            number = number / total if total else 0.0
        found.append(Outcome(condition, number, OPERATORS[condition.compare](number, condition.bound), total))
    return tuple(found)
