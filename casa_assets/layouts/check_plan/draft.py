"""A plan that is looked at: as its file has it, as a record, and on paper, without the code that builds kitchens."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from casa_assets.layouts.check_plan.edit import Edit, Mend, edited_value, flow_text, insert, put, remove, value_at
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.order.room_shell import CASING_WIDTH_M, casing_width
from casa_assets.layouts.order.trim import CORNICE_DEPTH_M, FLAT_PROFILE
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.clearances import Leaf, leaves_of
from casa_assets.layouts.plan.room import WallHole, WallLine, build_room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot, place_runs
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import BaseKind, Plan, UpperKind
from casa_assets.model.kitchen.style import LIBRARY, Style
from casa_assets.model.record import Vec2
from casa_assets.model.registry.document import KeyPath
from casa_assets.projects import read_once
from casa_assets.registry.read import names_in, read_table_file, read_topmost
from casa_assets.registry.tables import load_roles

# Of openings: what is free beside their holes; what a sill stands out, reaches beyond its hole, and takes up below it;
# what remains of the wall beside a door, and beside a window, whose sill reaches beyond its casing.
CASING_M, CASING_PLAY_M, SILL_M, SILL_BESIDE_M, SILL_UNDER_M = 0.08, 0.001, 0.05, 0.1, 0.05
FROM_END_M, WINDOW_FROM_END_M, ON_FLOOR_M = 0.05, 0.13, 0.05
CLASH_M = 0.01  # by which rows, tables and openings may overlap
Presets = Mapping[str, Mapping[str, Any]]


@read_once
def family_sizes() -> Mapping[str, Mapping[str, Any]]:
    """Rows of registry/family_sizes.yaml. Raises RegistryError."""
    rows: Mapping[str, Mapping[str, Any]] = read_topmost("family_sizes.yaml").value
    return rows


def bounds_of(family: str, side: str) -> tuple[float, float] | None:
    """Return the bounds of `width` or `height` that a family can be built in, in metres, or None if unknown."""
    found = family_sizes().get(family, {}).get(side)
    return (float(found[0]), float(found[1])) if found else None


class PresetSizes(dict[str, Presets]):
    """Properties of presets that layouts need, by family; a family is read when it is first asked for."""

    def __missing__(self, name: str) -> Presets:
        self[name] = _presets_of(name)
        return self[name]

    def __contains__(self, name: object) -> bool:
        return name in family_sizes() or name == LIBRARY or name in names_in("families")

    def __iter__(self) -> Iterator[str]:
        return iter(sorted({*family_sizes(), *names_in("families")}))


def _presets_of(name: str) -> Presets:
    if name == LIBRARY:
        from casa_assets.layouts.run.library_assets import LibraryPresets  # loads what reads meshes

        return LibraryPresets()
    if name not in family_sizes():
        from casa_assets.registry.families import family  # loads the code of all families

        return {k: p.model_dump(mode="json") for k, p in family(name).presets.items()}
    defaults = family_sizes()[name]["defaults"]
    rows = read_table_file(f"families/{name}.yaml").value["presets"]
    return {preset: {**defaults, **(row or {})} for preset, row in rows.items()}


@dataclass(frozen=True)
class Draft:
    """A plan that may not fit: its value as the file has it, its record, and the style that it is tried with."""

    raw: Any
    plan: Plan
    style: Style

    @classmethod
    def of(cls, raw: Any, stem: str, style: Style) -> Draft:
        """The draft of a value. Raises ValidationError."""
        return cls(raw, Plan.model_validate({**raw, "id": stem}), style)

    def after(self, edits: Sequence[Edit]) -> Draft:
        """Return the plan after edits.

        Raises ValidationError: the result is not a valid plan. KeyError, IndexError, TypeError: an edit's pointer does
        not fit the plan.
        """
        value = self.raw
        for edit in edits:
            value = edited_value(value, edit)
        return Draft.of(value, self.plan.id, self.style)

    # Where parts of the plan are in its file, and edits of them, whatever form they are written in.

    def at(self, pointer: Sequence[str | int]) -> Any:
        """Return the value at a pointer, or None if it has no value."""
        return value_at(self.raw, pointer)

    def row(self, table: str, name: str) -> KeyPath:
        """Pointer of the row of that id, in a mapping of ids or a list."""
        rows = self.raw.get(table)
        if isinstance(rows, list):
            found = [k for k, row in enumerate(rows) if isinstance(row, dict) and row.get("id") == name]
            return (table, found[0]) if found else (table,)
        return (table, name)

    def unit(self, run: str, row: str, index: int) -> KeyPath:
        """Pointer of a unit of a row, `base` or `upper`."""
        return (*self.row("runs", run), row, index)

    def place(self, name: str) -> tuple[str, str, int] | None:
        """Run, row and number of a unit; None of what the layout adds."""
        rows = ((r.id, row, units) for r in self.plan.runs for row, units in (("base", r.base), ("upper", r.upper)))
        return next(((run, row, k) for run, row, units in rows for k, u in enumerate(units) if u.id == name), None)

    def in_unit(self, at: KeyPath, key: str, value: Any) -> Edit:
        """Set a field of a unit that is written `- doors`, `- doors: 0.6` or `- doors: {width: 0.6}`."""
        unit = self.at(at)
        if not isinstance(unit, dict):
            return put(at, {unit: value if key == "width" else {key: value}})
        kind, inner = next(iter(unit.items()))
        if len(unit) > 1:  # with all its fields in full
            return put((*at, key), value)
        if isinstance(inner, dict):
            return put((*at, kind, key), value)
        both = {key: value} if inner is None else {"width": inner, key: value}
        return put((*at, kind), value if key == "width" else both)

    def unit_with(self, at: KeyPath, name: str, key: str, value: Any) -> Mend:
        """The mend that sets a field of a unit called `name`."""
        return Mend(f"Write `{key}: {flow_text(value)}` for {name}.", (self.in_unit(at, key, value),))

    def without(self, at: KeyPath, key: str) -> Edit:
        """Take a field of a unit out that it has, such as its width, so that it has its usual one."""
        unit = self.at(at)
        kind, inner = next(iter(unit.items()))
        if len(unit) > 1:
            return remove((*at, key))
        is_one = not isinstance(inner, dict) or len(inner) == 1
        return put(at, kind) if is_one else remove((*at, kind, key))

    def with_item(self, at: KeyPath, item: Any, index: int | None = None) -> Edit:
        """Put an item into a list that may not be there yet, at its end or before the one of a number."""
        items = self.at(at)
        if not isinstance(items, list) or not items:
            return put(at, [item])
        return insert((*at, len(items) if index is None else index), item)

    @cached_property
    def models(self) -> StyleModels:
        """The style's models."""
        return StyleModels(self.style, PresetSizes(), load_roles(), self.plan.height)

    @cached_property
    def kitchen(self) -> KitchenRequest:
        """The kitchen in metres. Raises PlanConflict or UnknownId."""
        return request_kitchen(self.plan, self.style, PresetSizes(), roles=load_roles())

    def lines(self) -> dict[str, RunLine]:
        """All runs in the room, whether or not their units fit; islands before the middle of a run."""
        runs = [r.replace(faces=r.faces.replace(in_front_of=None)) if r.faces else r for r in self.plan.runs]
        plan, lengths = self.plan.replace(runs=tuple(runs)), self.plan.defaults
        return place_runs(plan, build_room(plan, lengths), lengths, self.models)

    @cached_property
    def slots(self) -> list[UnitSlot]:
        """Those of all runs, without gaps."""
        rows = self.kitchen.slots.values()
        return [s for row in rows for s in row if s.kind not in (BaseKind.GAP, UpperKind.GAP)]

    @cached_property
    def leaves(self) -> list[Leaf]:
        """Everything that opens, with its way."""
        return list(leaves_of(self.kitchen.slots, self.kitchen.holes, self.models))

    @cached_property
    def solids(self) -> dict[str, tuple[Vec2, ...]]:
        """Return the outlines of rows of units with their overhang, and of columns, which block the floor. Metres."""
        rows = {name: self.row_outline(name) for name in self.kitchen.lines}
        columns = {c.column.id: c.outline for c in self.kitchen.room.columns}
        return {name: outline for name, outline in rows.items() if outline} | columns

    def row_outline(self, name: str, inset: float = 0.0) -> tuple[Vec2, ...]:
        """Return the corners of a run's floor units with their overhang, in metres; empty if it has no floor units."""
        row, line = [s for s in self.slots if s.line.id == name and not s.is_upper], self.kitchen.lines[name]
        if not row:
            return ()
        left, right = min(s.left for s in row) + inset, max(s.right for s in row) - inset
        back, front = (0.0 if line.at_wall else -line.run.overhang) + inset, line.depth - inset
        return line.frame.rectangle(left, right, back, front)

    def pointer(self, name: str) -> KeyPath:
        """Where a part of that name is written; its run for a unit that the layout adds."""
        for table in ("openings", "worktop_items", "wall_items", "floor_items", "tables", "columns", "runs"):
            if any(row.id == name for row in getattr(self.plan, table)):
                return (*self.row(table, name), *(("on",) if table == "worktop_items" else ()))
        place = self.place(name)
        slot = next((s for s in self.slots if s.name == name), None)
        return self.unit(*place) if place else self.row("runs", slot.line.id) if slot else (name,)

    def stretches(self, wall: WallLine, low: float, high: float, niche: bool = False) -> list[tuple[float, float]]:
        """Stretches of a wall, metres from its left end, that units are before between two heights; not in a niche."""
        out = []
        for slot in self.slots:
            if slot.top <= low or slot.bottom >= high or (niche and slot.recess):
                continue
            back = 0.0 if slot.line.at_wall else -slot.line.run.overhang
            ends = itertools.product((slot.left, slot.right), (back, slot.depth))
            along, before = zip(*(wall.frame.to_local(*slot.line.frame.at(u, v)[:2]) for u, v in ends), strict=True)
            if min(before) < 0.05 and max(before) > 0.02 and max(along) > 0.0 and min(along) < wall.length:
                out.append((round(min(along), 4), round(max(along), 4)))
        return sorted(out)

    def casing_of(self, is_window: bool) -> float:
        """Width of the casing of the style's windows, or of its doors, metres."""
        return casing_width(self.models, "window" if is_window else "door")

    def beside_casing(self, top: float, is_window: bool) -> float:
        """Return the width to keep free at each side of an opening that reaches up to `top`, in metres.

        It is that of the casing, and of the end of a cornice if the opening is high.
        """
        casing = self.casing_of(is_window)
        is_high = top + casing > standard_sizes.UPPER_TO + 2 * CLASH_M
        has_profile = self.style.cabinets.cornice not in (None, FLAT_PROFILE)
        return casing + CASING_PLAY_M + (CORNICE_DEPTH_M if is_high and has_profile else 0.0)

    def free_middle(self, wall: WallLine, hole: WallHole, width: float, wanted: float) -> float | None:
        """Middle of the free place for an opening on a wall that is nearest to one that is wanted.

        Both in metres from the wall's left end. `hole`: where the opening is, which is not in its own way.
        """
        low, is_high = max(hole.bottom, ON_FLOOR_M), hole.bottom > ON_FLOOR_M
        taken = self.stretches(wall, low - SILL_UNDER_M if is_high else low, hole.top + CASING_WIDTH_M)
        holes = [h for h in self.kitchen.holes if h.wall.id == wall.id and h is not hole]
        taken += [(h.left - CASING_M, h.right + CASING_M) for h in holes]
        from_end = WINDOW_FROM_END_M if is_high else FROM_END_M
        casing = max(SILL_BESIDE_M if is_high else CASING_M, self.beside_casing(hole.top, is_high))
        found, start = list[float](), from_end
        for left, right in [*sorted(taken), (wall.length - from_end, wall.length)]:
            # Beside units and other openings a casing has to find room too.
            first = start + width / 2 + (casing if start > from_end else 0.0)
            last = left - width / 2 - (casing if left < wall.length - from_end else 0.0)
            if first <= last + 1e-6:
                found.append(round(min(max(wanted, first), last), 3))
            start = max(start, right)
        return min(found, key=lambda middle: abs(middle - wanted), default=None)
