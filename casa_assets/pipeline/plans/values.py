"""Mend values that a plan's records refuse: numbers as text, values out of bounds, words that are none of a list."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.fault import Fault, Mend, added, removed, renamed, replaced, value_at
from casa_assets.pipeline.plans.file_units import other_unit
from casa_assets.pipeline.plans.words import length_of, meant, plausible, spelt
from casa_assets.registry.edit import Edit, edited_value, flow_text

# Table of registry/plan_words.yaml for the words of a field.
TABLES = {
    "heading": "headings",
    "hinge": "sides",
    "end": "sides",
    "side": "island_sides",
    "shape": "column_shapes",
    "kind": "openings",
    "base": "corner_kinds",
    "upper": "corner_kinds",
}
DEFAULTS: Mapping[str, Any] = {
    "aisle": 1.2, "count": 2, "height": 1.12, "from_wall": 0.4, "heading": "right", "kind": "window", "end": "right",
    "depth": 0.3, "at": 1.0,
}  # fmt: skip
# What is beyond its bound by a smaller share is a little too large, and not in another unit.
OTHER_UNIT = 1.2
LIMITS = {"greater_than": "gt", "greater_than_equal": "ge", "less_than": "lt", "less_than_equal": "le"}


def value_faults(plan: dict[str, Any], stem: str) -> list[Fault]:
    """What the records of a plan refuse, each value once; first lengths that are all in centimetres or millimetres."""
    if (found := other_unit(plan)) is not None:
        return [found]
    try:
        Plan.model_validate({**plan, "id": stem})
    except ValidationError as error:
        groups: dict[KeyPath, list[Any]] = {}
        for one in error.errors():
            groups.setdefault(written_at(plan, one["loc"]), []).append(one)
        return [_fault(plan, at, errors) for at, errors in groups.items()]
    return []


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
        return tuple(at)
    kind, inner = next(iter(unit.items()))
    return (*at, kind, field) if isinstance(inner, dict) and field in inner else (*at, kind)


def _fault(plan: dict[str, Any], at: KeyPath, errors: list[Any]) -> Fault:
    """The fault of a value with all that was said of it; of the branches of a union, the one with a mend counts."""
    if at[-1:] == ("id",) and value_at(plan, at) is None and isinstance(at[-2], str):  # the id is the key of the row
        at = at[:-1]
        name = spelt(str(at[-1]))
        name = name if name[:1].isalpha() else f"n{name}"
        return Fault(at, "small letters, numbers and _", repr(at[-1]), Mend(f"Call it {name}.", (renamed(at, name),)))
    got = value_at(plan, at)
    first = next((e for e in errors if e["type"] not in ("string_type", "float_type")), errors[0])
    expected = str(first["msg"]).removeprefix("Input should be ").removeprefix("Value error, ")
    if first["type"] == "missing":
        return Fault(at, expected, "nothing", _missing(plan, at))
    for mend in (_heading, _number, _flag, _choice, _shape, _name, _rule):
        found = mend(plan, at, got, errors)
        if found is not None:
            return Fault(at, expected, flow_text(got)[:80], found)
    return Fault(at, expected, flow_text(got)[:80], _taken_out(plan, at))


def _put(sentence: str, *edits: Edit) -> Mend:
    return Mend(sentence, edits)


def _heading(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    """A heading of less than 0 or of 360 degrees or more."""
    number = got if isinstance(got, int | float) else length_of(got) if isinstance(got, str) else None
    if at[-1] != "heading" or number is None or isinstance(got, bool) or number % 360 == got:
        return None
    return _put(f"Write {flow_text(number % 360)}.", replaced(at, number % 360))


def _number(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    """A number that is text, in other units, or out of bounds."""
    wants = {"float_type", "float_parsing", "int_type", "int_parsing", "int_from_float", *LIMITS}
    if not wants & {e["type"] for e in errors} or isinstance(got, bool):
        return None
    if isinstance(got, list) and len(got) == 1:
        return _put(f"Write {flow_text(got[0])}.", replaced(at, got[0]))
    number = length_of(got) if isinstance(got, str) else got
    if not isinstance(number, int | float):
        return None
    low, high = _bounds(at, errors)
    whole = any(e["type"].startswith("int") for e in errors)
    fits = number
    if not low <= number <= high:
        # What is no length, such as a share or an angle, has no other unit.
        as_length = (
            plausible(number, low, high)
            if number > OTHER_UNIT * high and high <= 20 and not whole and at[-1] != "at"
            else None
        )
        if as_length is not None and _is_refused(plan, at, as_length):
            as_length = None
        fits = as_length if as_length is not None else min(max(number, low), high)
    if whole:
        fits = round(fits)
    return _put(f"Write {flow_text(fits)}.", replaced(at, fits)) if fits != got else None


def _is_refused(plan: dict[str, Any], at: KeyPath, value: float) -> bool:
    """True if the records of a plan would not take another value there either."""
    try:
        Plan.model_validate({**edited_value(plan, replaced(at, value)), "id": "plan"})
    except ValidationError as error:
        return any(written_at(plan, one["loc"]) == at for one in error.errors())
    return False


def _bounds(at: KeyPath, errors: list[Any]) -> tuple[float, float]:
    low, high = -1e9, 1e9
    for one in errors:
        context = one.get("ctx", {})
        low = max(low, context.get("ge", low), context["gt"] + 0.01 if "gt" in context else low)
        high = min(high, context.get("le", high), context["lt"] - 0.01 if "lt" in context else high)
    known = {
        "width": (0.02, 6.0),
        "length": (0.3, 20.0),
        "height": (0.1, 3.4),
        "sill": (0.0, 1.8),
        "start": (0, 20),
        "end": (0, 20),
    }
    usual = (
        known.get(str(at[-1]), (0.0, 20.0)) if at[0] != "openings" or at[-1] not in ("width", "height") else (0.4, 2.4)
    )
    return (max(low, usual[0]), min(high, usual[1])) if low == -1e9 or high == 1e9 else (low, high)


def _flag(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    if not any(e["type"].startswith("bool") for e in errors):
        return None
    value = spelt(str(got)) not in ("no", "none", "false", "off", "0", "closed", "null", "")
    return _put(f"Write {flow_text(value)}.", replaced(at, value))


def _choice(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    one = next((e for e in errors if e["type"] in ("enum", "literal_error")), None)
    if one is None:
        return None
    known = re.findall(r"'([^']+)'", one["ctx"]["expected"])
    name = meant(str(got), known, TABLES.get(str(at[-1]), ""), 0.5)
    if name is None and at[-1] in ("hinge", "upper", "base"):
        return _put(f"Take out '{at[-1]}'.", removed(at))
    name = name or known[0]
    return _put(f"Write {name}.", replaced(at, name))


def _shape(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    """A list where one thing is wanted, or one thing where a list is."""
    types = {e["type"] for e in errors}
    if (
        types & {"tuple_type", "list_type"}
        and not isinstance(got, list | dict)
        and not types & {"float_type", "float_parsing"}
    ):
        return _put("Write it as a list.", replaced(at, [got]))
    if (
        types & {"too_long", "missing", "tuple_type"}
        and isinstance(got, list)
        and got
        and at[-1] not in ("base", "upper")
    ):
        numbers: list[Any] = [length_of(x) if isinstance(x, str) else x for x in got]
        if all(isinstance(x, int | float) for x in numbers):
            pair = [min(numbers), max(numbers)]
            return _put(f"Write {flow_text(pair)}, the least and the greatest.", replaced(at, pair))
    return None


def _name(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    """A name that is spelt as names are not."""
    if not any(e["type"] in ("string_pattern_mismatch", "string_type") for e in errors):
        return None
    if at and at[-1] == "title":
        return _put("Write the title as text.", replaced(at, str(got)))
    if got is None or isinstance(got, dict | list):
        return None
    name = spelt(str(got))
    name = name if name[:1].isalpha() else f"n{name}"
    return _put(f"Write {name}.", replaced(at, name)) if name != got else None


def _rule(plan: dict[str, Any], at: KeyPath, got: Any, errors: list[Any]) -> Mend | None:
    """What a record says of several of its fields at once."""
    said = next((e["msg"] for e in errors if e["type"] == "value_error"), "")
    if "at` or `over" in said and isinstance(got, dict):
        if "at" in got and "over" in got:
            return _put("Take out 'at'.", removed((*at, "at")))
        middle = 1.0
        return _put(f"Add `at: {middle:g}`.", added((*at, "at"), middle))
    if "needs a `depth`" in said:
        return _put(f"Add `depth: {DEFAULTS['depth']}`.", added((*at, "depth"), DEFAULTS["depth"]))
    if "has a `depth`" in said:
        return _put("Take out 'depth'.", removed((*at, "depth")))
    if "leads to a `closet`" in said:
        return _put("Take out 'closet'.", removed((*at, "closet")))
    if "minimum width" in said:
        width = got["width"] if isinstance(got, dict) and "width" in got else got
        inner = (*at, "width") if isinstance(got, dict) and "width" in got else at
        if isinstance(width, dict):
            key = next(iter(got))
            inner, width = (*at, key), got[key]
        if isinstance(width, list):
            return _put(f"Write {flow_text(sorted(width))}.", replaced(inner, sorted(width)))
    if "low <= default" in said and isinstance(got, list):
        low, middle, high = sorted(got)
        return _put(f"Write {flow_text([middle, low, high])}.", replaced(at, [middle, low, high]))
    return None


def _missing(plan: dict[str, Any], at: KeyPath) -> Mend | None:
    key = str(at[-1])
    if key in DEFAULTS:
        return _put(f"Add `{key}: {DEFAULTS[key]}`.", added(at, DEFAULTS[key]))
    if key in ("wall", "on", "run"):
        table = {"wall": "walls", "on": "", "run": "runs"}[key]
        rows = plan.get(table)
        names = list(rows) if isinstance(rows, dict) else [r.get("id") for r in rows or () if isinstance(r, dict)]
        if names:
            return _put(f"Add `{key}: {names[0]}`.", added(at, names[0]))
    return _put(f"Take out {flow_text(at[-2])}.", removed(at[:-1])) if len(at) == 3 else None


def _taken_out(plan: dict[str, Any], at: KeyPath) -> Mend | None:
    if not at or at in (("walls",), ("runs",)):
        return None
    if isinstance(at[-1], str) and spelt(at[-1]) != at[-1] and spelt(at[-1])[:1].isalpha():
        return _put(f"Call it {spelt(at[-1])}.", renamed(at, spelt(at[-1])))
    return _put(f"Take out {flow_text(at[-1])}.", removed(at))
