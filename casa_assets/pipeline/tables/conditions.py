"""Conditions on rows of the table of entries, such as `category=mug`, `size<=0.3` or `reason=FLT005`.

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
    from casa_assets.pipeline.tables.row import TableRow

# Field of a condition -> attributes of a TableRow that it is about.
WORDS: Mapping[str, str] = {
    "category": "category",
    "verdict": "status",
    "reason": "code",
    "decide": "decide",
    "source": "source",
    "licence": "licence",
    "author": "author",
    "split": "split",
    "producer": "producer",
    "id": "id",
}
NUMBERS: Mapping[str, tuple[str, ...]] = {
    "size": ("size_x_m", "size_y_m", "size_z_m"),
    "mass": ("mass_kg",),
    "faces": ("faces",),
    "colliders": ("colliders",),
    "warnings": ("warnings",),
}
# Field -> attribute that holds several words, each of which is compared beside that of the field.
LISTS: Mapping[str, str] = {"reason": "advice_codes", "decide": "decide"}
_COMPARE: Mapping[str, Callable[[Any, Any], bool]] = {
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
        if len(NUMBERS[name]) > 1 and compare in ("=", "!="):
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
    if name in LISTS and (odd := [value for value in values if not re.fullmatch(r"[A-Za-z0-9_]+", value)]):
        raise BadCondition(f"--where {text!r}: {odd[0]!r} is no {name}; {GRAMMAR}")
    return Condition(name, compare, values)


def _number(text: str, said: str) -> float:
    try:
        number = float(said)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadCondition(f"--where {text!r}: {said!r} is no number; {GRAMMAR}")
    return number


def with_default(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """The conditions, and one that leaves rejected inputs out unless a condition is about these."""
    if any(one.field in OF_REJECTED for one in conditions):
        return tuple(conditions)
    return (*conditions, Condition("verdict", "!=", (Decision.REJECTED.value,)))


def meets(row: TableRow, conditions: Sequence[Condition]) -> bool:
    """True if a row meets all conditions. A number that a row lacks meets none."""
    return all(_holds(row, one) for one in conditions)


def _holds(row: TableRow, one: Condition) -> bool:
    if one.field in NUMBERS:
        sides = [getattr(row, name) for name in NUMBERS[one.field]]
        compare, bound = _COMPARE[one.compare], one.values[0]
        # The longest side is over a bound if any side is.
        several = any if one.compare in (">", ">=") else all
        return None not in sides and several(compare(side, bound) for side in sides)
    words = {getattr(row, WORDS[one.field])}
    if one.field in LISTS:
        words = {*words, *getattr(row, LISTS[one.field]).split()}
    return words.isdisjoint(one.values) is (one.compare == "!=")
