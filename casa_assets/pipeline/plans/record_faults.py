"""Faults of single values of a plan: unknown keys, wrong types, values out of bounds, unknown kinds, missing keys.

They are what the records of plans refuse. A correction is offered if a known name is near, or if a number is beyond a
bound; all else is told with what was expected.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.registry.document import KeyPath
from casa_assets.model.registry.fields import expected_one_of, fields_at
from casa_assets.pipeline.plans.fault import Fault, Mend, removed, renamed, replaced, value_at
from casa_assets.pipeline.plans.names import nearest, spelt
from casa_assets.registry.edit import flow_text
from casa_assets.registry.kitchens import LIKE

# Added to a bound that is itself not allowed, metres or degrees.
BEYOND_BOUND = 0.01
# A number that is further beyond a bound than this share of it was meant in another way, such as in centimetres.
MOST_BEYOND = 0.25
# Least similarity of a misspelt key: `over` is no misspelling of `oven`.
NEAR_KEY = 0.8
# What is expected, by the type of an error of pydantic, where its own words name Python's types.
EXPECTED = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dict_type": "a mapping of keys to values",
    "float_parsing": "a number without a unit (lengths in metres)",
    "float_type": "a number without a unit (lengths in metres)",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "list_type": "a list",
    "model_attributes_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "string_pattern_mismatch": "a name of small letters, digits and single underscores that begins with a letter",
    "too_long": "at most {max_length} of them",
    "too_short": "at least {min_length} of them",
    "tuple_type": "a list",
}


def record_faults(plan: Any, stem: str) -> list[Fault]:
    """What the records of plans refuse, each value once, in the order of the file.

    Args:
        plan: value of the file. stem: the plan's id.
    """
    if not isinstance(plan, dict):
        return [Fault((), "the keys of a plan: title, walls, runs and others", type(plan).__name__, None)]
    if "id" in plan:
        return [Fault(("id",), "no id: a plan is called as its file is", repr(plan["id"]), _out(("id",)))]
    try:
        Plan.model_validate({**plan, "id": stem})
    except ValidationError as error:
        groups: dict[KeyPath, list[Any]] = {}
        for one in error.errors():
            groups.setdefault(written_at(plan, one["loc"]), []).append(one)
        own = {at: errors for at, errors in groups.items() if not _follows(plan, at, errors, groups)} or groups
        return [_fault(plan, at, errors) for at, errors in own.items()]
    return []


def _follows(plan: dict[str, Any], at: KeyPath, errors: list[Any], groups: Mapping[KeyPath, Any]) -> bool:
    """True if only other faults are the reason: too few rows since some are wrong, ids of units made of a wrong one."""
    types = {one["type"] for one in errors}
    if types == {"too_short"}:
        return any(other[: len(at)] == at != other for other in groups)
    return types == {"string_pattern_mismatch"} and at[-1] != "id" and all(one["loc"][-1] == "id" for one in errors)


def written_at(plan: Mapping[str, Any], loc: Sequence[str | int]) -> KeyPath:
    """Pointer into the file of a place in the record: rows may be written by id, units in short forms."""
    at: list[str | int] = []
    here: Any = plan
    for n, step in enumerate(loc):
        if isinstance(here, dict) and isinstance(step, int) and step < len(here):
            step = list(here)[step]
        elif n > 3 and loc[0] == "runs" and loc[2] in ("base", "upper") and len(at) == 4:
            return _in_unit(at, here, step)
        in_list = isinstance(here, list) and isinstance(step, int) and step < len(here)
        if in_list or (isinstance(here, dict) and step in here):
            here = here[step]
        elif isinstance(here, dict) and isinstance(step, str) and re.fullmatch(r"[a-z_]+", step):
            return (*at, step)  # what is missing
        else:
            break
        at.append(step)
    return tuple(at)


def _in_unit(at: list[str | int], unit: Any, field: str | int) -> KeyPath:
    """Pointer of a field of a unit: `- doors`, `- doors: 0.6`, `- doors: {width: 0.6}`."""
    if not isinstance(unit, dict) or len(unit) != 1:
        return (*at, field) if isinstance(unit, dict) and field in unit else tuple(at)
    kind, inner = next(iter(unit.items()))
    return (*at, kind, field) if isinstance(inner, dict) and field in inner else (*at, kind)


def _fault(plan: dict[str, Any], at: KeyPath, errors: list[Any]) -> Fault:
    """The fault of a value, of all that was said of it."""
    got = value_at(plan, at)
    for find in (_unknown_key, _choice, _bound):
        fault = find(plan, at, got, errors)
        if fault is not None:
            return fault
    # Of the branches of a union, the one that says more than a type counts.
    first = next((e for e in errors if not e["type"].endswith("_type")), errors[0])
    if first["type"] == "missing":
        return Fault(at, f"{at[-1]!r}, which is missing", "nothing", None)
    mend = None
    if first["type"] == "string_pattern_mismatch":
        is_key = got is None and at[-1] == "id"  # the id is the key of the row
        at, got = (at[:-1], at[-2]) if is_key else (at, got)
        name = spelt(str(got))
        edit = renamed(at, name) if is_key else replaced(at, name)
        mend = Mend(f"Write {name}.", (edit,)) if name[:1].isalpha() else None
    said = str(first["msg"]).removeprefix("Input should be ").removeprefix("Value error, ")
    known = EXPECTED.get(first["type"])
    expected = said if known is None else known.format(**first.get("ctx", {}))
    return Fault(at, expected, flow_text(got)[:80], mend)


def _unknown_key(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Fault | None:
    one = next((e for e in errors if e["type"] == "extra_forbidden"), None)
    if one is None:
        return None
    known = [name for name in fields_at(Plan, one["loc"][:-1]) if name != "id" or len(at) > 1]
    key, beside = str(one["loc"][-1]), value_at(plan, at[:-1])
    # A plan that is like another has all keys of that one beside its own.
    given = beside if isinstance(beside, dict) and len(at) > 1 else {}
    near = nearest(key, [name for name in known if name not in given], NEAR_KEY)
    mend = None if near is None else Mend(f"Call {key!r} {near!r}.", (renamed(at, near),))
    return Fault(at, expected_one_of([*known, LIKE] if len(at) == 1 else known, key), repr(key), mend)


def _choice(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Fault | None:
    """A word that is none of a list."""
    one = next((e for e in errors if e["type"] in ("enum", "literal_error")), None)
    if one is None:
        return None
    known = re.findall(r"'([^']+)'", one["ctx"]["expected"])
    said = str(one["input"])
    near = nearest(said, known)
    is_key = at[-1] == said and got != said  # the kind of a unit that is written `- doors: 0.6`
    edit = None if near is None else renamed(at, near) if is_key else replaced(at, near)
    return Fault(at, expected_one_of(known, said), repr(said), Mend(f"Write {near}.", (edit,)) if edit else None)


def _bound(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Fault | None:
    """A number beyond a bound."""
    if not isinstance(got, int | float) or isinstance(got, bool):
        return None
    for one in errors:
        for name, step in (("ge", 0), ("gt", BEYOND_BOUND), ("le", 0), ("lt", -BEYOND_BOUND)):
            if name in one.get("ctx", {}):
                value = one["ctx"][name] + step
                expected = str(one["msg"]).removeprefix("Input should be ")
                is_near = abs(got - value) <= MOST_BEYOND * max(abs(value), 1.0)
                mend = Mend(f"Write {value:g}.", (replaced(at, value),)) if is_near else None
                return Fault(at, expected, f"{got:g}", mend)
    return None


def _out(at: KeyPath) -> Mend:
    return Mend(f"Take out {flow_text(at[-1])}.", (removed(at),))
