"""Where the parts of a plan stand in its file, and the edits that change them, whatever form they are written in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, count
from typing import Any

from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.units import Unit
from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.fault import added, removed, replaced, value_at
from casa_assets.registry.edit import Edit, EditKind


def row_at(plan: Any, table: str, name: str) -> KeyPath:
    """Pointer of the row of that id, in a mapping of ids or a list."""
    rows = plan.get(table)
    if isinstance(rows, list):
        found = [k for k, row in enumerate(rows) if isinstance(row, dict) and row.get("id") == name]
        return (table, found[0]) if found else (table,)
    return (table, name)


def key_edit(plan: Any, row: KeyPath, key: str, value: Any) -> Edit:
    """Set a key of a row, which may not have it yet."""
    here = value_at(plan, row)
    return replaced((*row, key), value) if isinstance(here, dict) and key in here else added((*row, key), value)


def unit_at(plan: Any, run: str, row: str, index: int) -> KeyPath:
    """Pointer of a unit."""
    return (*row_at(plan, "runs", run), row, index)


def place_of(plan: Plan, name: str) -> tuple[str, str, int] | None:
    """Run, row (`base` or `upper`) and number of a unit; None of what the layout adds."""
    for run in plan.runs:
        rows: tuple[tuple[str, Sequence[Unit]], ...] = (("base", run.base), ("upper", run.upper))
        for row, units in rows:
            for k, unit in enumerate(units):
                if unit.id == name:
                    return run.id, row, k
    return None


def unit_edit(plan: Any, at: KeyPath, key: str, value: Any) -> Edit:
    """Set a field of a unit that is written `- doors`, `- doors: 0.6` or `- doors: {width: 0.6}`."""
    unit = value_at(plan, at)
    if not isinstance(unit, dict):
        return replaced(at, {unit: value if key == "width" else {key: value}})
    kind, inner = next(iter(unit.items()))
    if len(unit) > 1:  # with all its fields in full
        return key_edit(plan, at, key, value)
    if isinstance(inner, dict):
        return key_edit(plan, (*at, kind), key, value)
    if key == "width":
        return replaced((*at, kind), value)
    both = {key: value} if inner is None else {"width": inner, key: value}
    return replaced((*at, kind), both)


def without_key(plan: Any, at: KeyPath, key: str) -> Edit:
    """Take a field of a unit out that it has, such as its width, so that it has its usual one."""
    unit = value_at(plan, at)
    kind, inner = next(iter(unit.items()))
    if len(unit) > 1:
        return removed((*at, key))
    return removed((*at, kind, key)) if isinstance(inner, dict) and len(inner) > 1 else replaced(at, kind)


def inserted(at: KeyPath, unit: Any) -> Edit:
    """The edit that puts a unit before the one at a pointer."""
    return Edit(EditKind.INSERT, at, unit)


def with_unit(plan: Any, run: str, row: str, index: int, unit: Any) -> Edit:
    """Put a unit into a row, which may not be there yet."""
    at = row_at(plan, "runs", run)
    units = value_at(plan, (*at, row))
    return inserted((*at, row, index), unit) if isinstance(units, list) and units else key_edit(plan, at, row, [unit])


def with_row(plan: Any, table: str, row: Mapping[str, Any]) -> Edit:
    """Add a row with an `id` to a table that is written by ids, or as a list, or not yet."""
    rows = plan.get(table)
    if isinstance(rows, list):
        return appended(plan, table, dict(row))
    names = rows or {}
    spare = (f"{row['id']}_{k}" for k in count(2))
    name = next(n for n in chain([row["id"]], spare) if n not in names)
    value = {key: told for key, told in row.items() if key != "id"}
    return added((table, name), value) if rows else key_edit(plan, (), table, {name: value})


def appended(plan: Any, table: str, row: Any) -> Edit:
    """Put a row at the end of a table that is a list, and may not be there yet."""
    rows: Sequence[Any] | None = plan.get(table)
    return Edit(EditKind.INSERT, (table, len(rows)), row) if rows else key_edit(plan, (), table, [row])
