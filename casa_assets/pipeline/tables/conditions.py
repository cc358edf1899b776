"""Conditions on rows of the table of entries, such as `category=mug`, `size<=0.3` or `reason=FLT005`.

    CONDITION  = FIELD OPERATOR VALUE [ "," VALUE ... ]
    OPERATOR   = "=" | "!=" | ">" | ">=" | "<" | "<="

Values of words are compared as they are written; several are alternatives. Each condition is told to SQLite and to
Arrow in their own terms, so that only what fits is ever read.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Any

from casa_assets.errors import CasaError
from casa_assets.model.issue import Decision

if TYPE_CHECKING:
    from pyarrow.compute import Expression

# Field of a condition -> columns that it is about.
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
# Column of several words -> whether a word of it is looked for beside the column of the field.
LISTS: Mapping[str, str] = {"reason": "advice", "decide": "decide"}
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


def to_sql(conditions: Sequence[Condition]) -> tuple[str, list[str | float]]:
    """The conditions as an expression of SQL with question marks, and the values in their places."""
    parts: list[str] = []
    values: list[str | float] = []
    for one in conditions:
        if one.field in NUMBERS:
            sides = [f"{column} {one.compare} ?" for column in NUMBERS[one.field]]
            parts.append(f"({(' OR ' if _is_any(one) else ' AND ').join(sides)})")
            values += one.values * len(sides)
            continue
        column, several = WORDS[one.field], LISTS.get(one.field)
        sides = []
        for value in one.values:
            if column != several:
                sides.append(f"{column} = ?")
                values.append(value)
            if several is not None:
                sides.append(f"instr(' ' || {several} || ' ', ?) > 0")
                values.append(f" {value} ")
        parts.append(f"{'NOT ' if one.compare == '!=' else ''}({' OR '.join(sides)})")
    return " AND ".join(parts) or "1", values


def to_arrow(conditions: Sequence[Condition]) -> Expression | None:
    """The conditions as an expression of Arrow; None where there is none."""
    found = [_arrow(one) for one in conditions]
    return reduce(lambda a, b: a & b, found) if found else None


def _arrow(one: Condition) -> Expression:
    import pyarrow.compute as pc

    if one.field in NUMBERS:
        sides = [_compared(pc.field(column), one.compare, one.values[0]) for column in NUMBERS[one.field]]
        return reduce((lambda a, b: a | b) if _is_any(one) else (lambda a, b: a & b), sides)
    options = list(_alternatives(one))
    found = reduce(lambda a, b: a | b, options)
    return ~found if one.compare == "!=" else found


def _alternatives(one: Condition) -> Iterator[Expression]:
    import pyarrow.compute as pc

    column, several = WORDS[one.field], LISTS.get(one.field)
    if column != several:
        yield pc.field(column).isin(list(one.values))
    if several is not None:
        words = "|".join(map(str, one.values))
        yield pc.match_substring_regex(pc.field(several), f"(^| )({words})( |$)")


def _compared(field: Any, compare: str, value: str | float) -> Expression:
    expression: Expression = {
        "=": field == value,
        "!=": field != value,
        ">": field > value,
        ">=": field >= value,
        "<": field < value,
        "<=": field <= value,
    }[compare]
    return expression


def _is_any(one: Condition) -> bool:
    """True where one of several columns is enough: the longest side is over a bound if any side is."""
    return one.compare in (">", ">=")
