"""Conditions on entries, such as `category=mug`, `size<=0.3` or `reason=FLT005`.

    CONDITION  = FIELD OPERATOR VALUE [ "," VALUE ... ]
    OPERATOR   = "=" | "!=" | ">" | ">=" | "<" | "<="

Values of words are compared as they are written; several are alternatives.
"""

from __future__ import annotations

import difflib
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from casa_assets.errors import CasaError
from casa_assets.model.issue import Decision

if TYPE_CHECKING:
    from casa_assets.library.entry import Entry

# Field of a condition -> the words of an entry that it is about.
WORDS: Mapping[str, Callable[[Entry], Sequence[str]]] = {
    "category": lambda entry: (entry.category,),
    "verdict": lambda entry: (entry.decision.value,),
    "reason": lambda entry: (entry.code, *entry.advice),
    "decide": lambda entry: entry.to_decide,
    "source": lambda entry: (entry.source,),
    "licence": lambda entry: (entry.licence,),
    "author": lambda entry: (entry.author,),
    "split": lambda entry: (entry.split,),
    "producer": lambda entry: (entry.producer,),
    "id": lambda entry: (entry.id,),
}
# Field of a condition -> the number of an entry that it is about; None where it has none.
NUMBERS: Mapping[str, Callable[[Entry], float | None]] = {
    "size": lambda entry: max(entry.summary.extents) if entry.summary else None,
    "mass": lambda entry: entry.summary.mass if entry.summary else None,
    "faces": lambda entry: entry.summary.faces if entry.summary else None,
    "colliders": lambda entry: entry.summary.colliders if entry.summary else None,
    "warnings": lambda entry: len(entry.warnings),
}
# Fields whose values are codes or subjects, and have no blanks.
CODES = frozenset({"reason", "decide"})
COMPARE: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
}
# Fields whose conditions look among rejected inputs, too; all others are about assets.
OF_REJECTED = frozenset({"verdict", "reason", "id"})
_FORM = re.compile(r"\s*([a-z]+)\s*(!=|>=|<=|=|>|<)\s*(.*\S)\s*", re.DOTALL)
GRAMMAR = (
    f"write a field, =, !=, >, >=, < or <=, and a value; fields of words are {', '.join(WORDS)} (values after commas "
    f"are alternatives), of numbers {', '.join(NUMBERS)} (size: longest side in metres, mass in kg)"
)


class BadCondition(CasaError):
    """A condition that is not of the grammar."""


@dataclass(frozen=True)
class Condition:
    """One condition. field: of WORDS or NUMBERS. compare: the operator. values: text, or one number."""

    field: str
    compare: str
    values: tuple[str | float, ...]


def parse(text: str) -> Condition:
    """The condition that a text states. Raises BadCondition."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise BadCondition(f"--where {text!r} is no condition; {GRAMMAR}")
    name, compare, said = found.groups()
    if name in NUMBERS:
        if name == "size" and compare in ("=", "!="):
            raise BadCondition(f"--where {text!r}: {name} is compared with >, >=, < or <=; {GRAMMAR}")
        return Condition(name, compare, (_number(text, said),))
    if name not in WORDS:
        near = difflib.get_close_matches(name, [*WORDS, *NUMBERS], n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise BadCondition(f"--where {text!r}: no field is called {name!r}{hint}; {GRAMMAR}")
    if compare not in ("=", "!="):
        raise BadCondition(f"--where {text!r}: {name} is a word, and is compared with = or !=; {GRAMMAR}")
    values = tuple(value.strip() for value in said.split(","))
    if name == "verdict" and (wrong := set(values) - set(Decision)):
        raise BadCondition(f"--where {text!r}: {min(wrong)!r} is no verdict; they are {', '.join(Decision)}")
    if name in CODES and (odd := [value for value in values if not re.fullmatch(r"[A-Za-z0-9_]+", value)]):
        raise BadCondition(f"--where {text!r}: {odd[0]!r} is no {name}; {GRAMMAR}")
    return Condition(name, compare, values)


def _number(text: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadCondition(f"--where {text!r}: {value!r} is no number; {GRAMMAR}")
    return number


def with_default(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """The conditions, and one that leaves rejected inputs out unless a condition is about these."""
    if any(one.field in OF_REJECTED for one in conditions):
        return tuple(conditions)
    return (*conditions, Condition("verdict", "!=", (Decision.REJECTED.value,)))


def meets(entry: Entry, conditions: Sequence[Condition]) -> bool:
    """True if an entry meets all conditions. A number that an entry lacks meets none."""
    return all(_holds(entry, one) for one in conditions)


def _holds(entry: Entry, one: Condition) -> bool:
    if one.field in NUMBERS:
        number = NUMBERS[one.field](entry)
        return number is not None and COMPARE[one.compare](number, one.values[0])
    return set(WORDS[one.field](entry)).isdisjoint(one.values) is (one.compare == "!=")
