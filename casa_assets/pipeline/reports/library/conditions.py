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
# Counts of which there is a rate.
RATES = ("accepted", "review", "rejected", "advice")
OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
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
    def needs_baseline(self) -> bool:
        """It is about what changed since an earlier run."""
        return self.name in CHANGES


@dataclass(frozen=True)
class Outcome:
    """A condition with what was measured. holds: it does, so the build fails."""

    condition: Condition
    measured: float
    holds: bool

    def __str__(self) -> str:
        """Such as `rejected-rate>5% (0.0833)`."""
        return f"{self.condition.text} ({self.measured:.4g})"


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
    found = []
    for condition in conditions:
        name = condition.name.removesuffix("-rate")
        number: float = counts[name] if name in counts else codes.get(name, 0)
        if name != condition.name:
            number = number / counts["entries"] if counts["entries"] else 0.0
        found.append(Outcome(condition, number, OPERATORS[condition.compare](number, condition.bound)))
    return tuple(found)
