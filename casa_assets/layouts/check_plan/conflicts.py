"""Find conflicts that prevent the layout of a plan, such as rows too long or parts beyond a wall, with tested mends.

Rows are made to fit in the order in which a kitchen designer would give units up. A mend is accepted if the layout
then gets past the conflict and, with the mends of the conflicts that follow, becomes a kitchen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from casa_assets.errors import CasaError, PlanConflict, UnknownId
from casa_assets.layouts.check_plan.draft import FROM_END_M, WINDOW_FROM_END_M, Draft
from casa_assets.layouts.check_plan.values import name_faults
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import build_room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot, base_slots, room_at_walls
from casa_assets.layouts.plan.standard_sizes import WidthRange, share_widths
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import MOST_SEATS, BaseKind, BaseUnit, OpeningKind, Plan, Run, UpperKind, UpperUnit
from casa_assets.model.registry.document import KeyPath
from casa_assets.registry.edit import Edit, Fault, Mend, flow_text

# What is raised where edits make no plan, since what they name is no longer there.
NO_PLAN = (ValidationError, CasaError, KeyError, IndexError, TypeError)
MOST_CONFLICTS = 12  # one after the other, on the way to a kitchen
# Least widths, metres, that a unit may be narrowed to; what is not here has the width of its appliance.
LEAST = {"gap": 0.05, "filler": 0.03, "shelf": 0.25, "island": 0.8}
LEAST |= dict.fromkeys(("boards", "glass", "doors", "drawers", "pantry"), 0.3)
# What is taken out first; of units of one kind the last in the row. Sinks, cookers and refrigerators stay, and so does
# the hood over a cooker.
GIVEN_UP = (
    "filler", "gap", "panel", "shelf", "boards", "glass", "doors", "microwave", "pantry", "drawers", "oven",
    "dishwasher",
)  # fmt: skip
# Units that may be made wider where a row is too short, and how wide; widths of one that is added.
WIDENED = {"doors": 1.1, "drawers": 1.1, "pantry": 0.9, "shelf": 0.9, "glass": 0.9}
LEAST_ADDED, MOST_ADDED = 0.3, 0.9
WORKTOPS = (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.DISHWASHER)
HOOD_WIDTHS_M = (0.9, 0.76, 0.6)  # usual ones
LEAST_UPPER_M = 0.25
BELOW_CEILING_M = 0.1  # that has to remain of a wall over an opening

Units = Sequence[BaseUnit | UpperUnit]
Changes = Mapping[int, tuple[float, float] | None]  # number of a unit: its least and greatest width; None: it goes


def resolve(draft: Draft) -> tuple[Draft | None, Fault | None]:
    """A plan that makes a kitchen, and the first conflict of the one that was given.

    It is the given one, or what the mends of its conflicts make of it, one after the other; where they lead to no
    kitchen, it is None, and the conflict has no mend.
    """
    first: Fault | None = None
    for _ in range(MOST_CONFLICTS):
        conflict = outcome_of(draft)
        if isinstance(conflict, KitchenRequest):
            return draft, first
        if isinstance(conflict, UnknownId):
            return None, Fault((), "models that the style has", str(conflict))
        mend, after = next(_tried(draft, conflict), (None, None))
        first = first or Fault(_written(draft, conflict.pointer), conflict.expected, conflict.got, mend)
        if after is None:
            break
        draft = after
    return None, None if first is None else Fault(first.pointer, first.expected, first.got)


def outcome_of(draft: Draft) -> KitchenRequest | PlanConflict | UnknownId:
    """The kitchen of a plan, or what keeps it from being one."""
    try:
        return draft.kitchen
    except (PlanConflict, UnknownId) as error:
        return error


def named(draft: Draft) -> Draft:
    """A plan with mends of names that are no longer there, such as that of a unit which was taken out."""
    for _ in range(MOST_CONFLICTS):
        mend = next((fault.mend for fault in name_faults(draft) if fault.mend), None)
        if mend is None:
            break
        draft = draft.after(mend.edits)
    return draft


def _tried(draft: Draft, conflict: PlanConflict) -> Iterator[tuple[Mend, Draft]]:
    """Mends that lead beyond a conflict, each with the plan after it."""
    for mend in _mends(draft, conflict):
        try:
            after = named(draft.after(mend.edits))
            left = outcome_of(after)
        except NO_PLAN:
            continue
        if not isinstance(left, PlanConflict) or (left.pointer, left.expected) != (conflict.pointer, conflict.expected):
            yield mend, after


def _written(draft: Draft, pointer: KeyPath) -> KeyPath:
    """A pointer of a conflict, which names rows and units by their ids, as the file has them."""
    if len(pointer) < 2 or not isinstance(pointer[1], str):
        return pointer
    at = (*draft.row(str(pointer[0]), pointer[1]), *pointer[2:])
    while at and draft.at(at) is None:
        at = at[:-1]
    return at


def _mends(draft: Draft, conflict: PlanConflict) -> Iterator[Mend]:
    """Mends that may help with a conflict, the smallest change first."""
    at, wanted, plan = conflict.pointer, conflict.wanted_m, draft.plan
    table, name = str(at[0]), str(at[1]) if len(at) > 1 else ""
    if at == ("height",) and wanted is not None:
        yield Mend(f"Write `height: {wanted:g}`.", (Edit.put(at, wanted),))
    elif at[-1:] == ("model",):
        row, said = _written(draft, at[:-1]), "Take out 'model': the style's stands there, if it has one."
        yield Mend(said, (draft.without(row, "model") if table == "runs" else Edit.remove((*row, "model")),))
    elif table == "seats":
        yield from _of_seats(plan, at)
    elif table == "openings":
        yield from _of_opening(draft, name)
    elif table == "slopes" and len(at) == 2 and wanted is not None:  # too low over something
        knee = math.ceil(100 * wanted + 0.5) / 100
        yield Mend(f"Write `knee: {knee:g}`.", (Edit.put((*at, "knee"), knee),))
    elif table == "corners" and at[2:] == ("runs",):
        runs = list(plan.corners[int(name)].runs)[::-1]
        yield Mend(f"Write `runs: {flow_text(runs)}`.", (Edit.put(at, runs),))
    elif table == "runs" and name:
        run = next(r for r in plan.runs if r.id == name)
        if at[2:] == ("base",):
            yield from _of_base(draft, run)
        elif at[2:3] == ("upper",):
            yield from _of_upper(draft, run) if len(at) == 3 else _of_fixed(draft, run, str(at[3]))
        else:
            keys = ("length",) if at[2:] == ("length",) else ("start", "end")
            edits = tuple(Edit.remove((*draft.row("runs", name), key)) for key in keys if getattr(run, key))
            yield Mend(f"Take out {' and '.join(map(repr, keys))} of {name}.", edits)
    if name and table not in ("runs", "walls"):
        yield Mend(f"Take out {name} of {table}.", (Edit.remove(_written(draft, at[:2])),))


def _of_seats(plan: Plan, at: KeyPath) -> Iterator[Mend]:
    """Of too many seats the most stay that have room; two rows at a run are one."""
    if len(at) == 2:
        second = plan.seats[int(at[1])]
        k, first = next((k, row) for k, row in enumerate(plan.seats) if row.run == second.run)
        count = min(first.count + second.count, MOST_SEATS)
        said = f"Write `count: {count}` for {first.run}, and take out the second row."
        yield Mend(said, (Edit.put(("seats", k, "count"), count), Edit.remove(at)))
    for k, seats in enumerate(plan.seats):
        for count in range(seats.count - 1, 0, -1):
            yield Mend(f"Write `count: {count}`.", (Edit.put(("seats", k, "count"), count),))
        yield Mend(f"Take out the seats at {seats.run}.", (Edit.remove(("seats", k)),))


def _of_opening(draft: Draft, name: str) -> Iterator[Mend]:
    """An opening that reaches beyond its wall: lower, narrower and moved, as far as is needed, else taken out."""
    plan, opening = draft.plan, next(o for o in draft.plan.openings if o.id == name)
    room, at = build_room(plan, plan.defaults), draft.row("openings", name)
    wall = next((w for w in room.walls if w.id == opening.wall), room.walls[0])
    is_window, new = opening.kind is OpeningKind.WINDOW, dict[str, Any]()
    top = round(room.height_of(wall) - BELOW_CEILING_M, 3)
    if opening.bottom + opening.height > top + 1e-4:
        new["sill"] = min(opening.sill, max(round(top - opening.height, 3), 0.9)) if is_window else opening.sill
        new["height"] = round(min(opening.height, top - (new["sill"] if is_window else 0.0)), 3)
    from_end = WINDOW_FROM_END_M if is_window else FROM_END_M
    width = new["width"] = min(opening.width, round(wall.length - 2 * from_end, 3))
    if opening.at is not None:
        middle = plan.length(opening.at, plan.defaults)
        fits = round(min(max(middle, from_end + width / 2), wall.length - from_end - width / 2), 3)
        new["at"] = opening.at if fits == middle else fits
    new = {key: value for key, value in new.items() if value != getattr(opening, key)}
    others = [new] if new else []
    if opening.over is not None:
        run = next((r for r in plan.runs if any(u.id == opening.over for u in (*r.base, *r.upper))), None)
        others += [{**new, "wall": run.on}] if run is not None and run.on not in (None, opening.wall) else []
        others += [{**new, "width": w} for w in (0.9, 0.76, 0.6, 0.4) if w < width]
    for keys in others:
        said = ", ".join(f"{key}: {flow_text(value)}" for key, value in keys.items())
        yield Mend(f"Write `{said}`.", tuple(Edit.put((*at, key), value) for key, value in keys.items()))


def _of_base(draft: Draft, run: Run) -> Iterator[Mend]:
    """A row that is too long for its place, or too short."""
    line, units = draft.lines()[run.id], run.base
    spans = [standard_sizes.base_span(u, draft.models) for u in units]
    available = round(line.length - line.left.base_length - line.right.base_length - room_at_walls(line), 4)
    if share_widths(spans, available) is None:
        # What opens away from a corner stays, so that what comes next does not run into the other row.
        ends = ((line.left, 0), (line.right, len(units) - 1))
        kept = [k for end, k in ends if end.kind is RunEnd.CORNER and units[k].kind is BaseKind.DOORS]
        for changes in (shrunk(units, spans, available, kept=kept), shrunk(units, spans, available)):
            if changes:
                yield _changed(draft, run.id, "base", units, changes)
        # Where nothing can be given up: all of the wall, or a longer wall.
        for key in (key for key in ("length", "end", "start") if getattr(run, key)):
            yield Mend(f"Take out {key!r} of {run.id}.", (Edit.remove((*draft.row("runs", run.id), key)),))
        yield from longer_walls(draft, line, sum(s.minimum for s in spans) - available, along=True)
        return
    changes, left = widened(units, spans, round(available - sum(s.maximum for s in spans), 3))
    mend = _changed(draft, run.id, "base", units, changes)
    edits, said = [*mend.edits], [mend.sentence] if changes else []
    tail = next((k + 1 for k in reversed(range(len(units))) if str(units[k].kind) in WIDENED), len(units))
    count = math.ceil(left / MOST_ADDED - 1e-3) if left > 0.24 else 0
    for _ in range(count):
        width = [LEAST_ADDED, round(max(left / count, LEAST_ADDED), 3)]
        edits.append(Edit.insert(draft.unit(run.id, "base", tail), {"doors": width}))
        said.append(f"Add `- doors: {flow_text(width)}`.")
    yield Mend(" ".join(said), tuple(edits))


def longer_walls(draft: Draft, line: RunLine, more: float, along: bool) -> Iterator[Mend]:
    """Walls along or across a row made longer by some metres, where they are numbers or one parameter."""
    plan, room = draft.plan, build_room(draft.plan, draft.plan.defaults)
    turns = {w.id: (w.frame.quarter_turns - line.frame.quarter_turns) % 2 for w in room.walls}
    walls = [w for w in plan.walls if turns[w.id] != along and w.length is not None]
    lengths = {w.length for w in walls}
    name = (walls[0].length if walls else None) or 0.0
    value = round(plan.length(name, plan.defaults) + more + 0.005, 2)
    if len(lengths) == 1 and isinstance(name, str):
        three = [value, value, round(max(value, plan.parameters[name].high + more), 2)]
        yield Mend(f"Write {name}: {flow_text(three)}.", (Edit.put(("parameters", name), three),))
    elif len(lengths) == 1:
        edits = tuple(Edit.put((*draft.row("walls", w.id), "length"), value) for w in walls)
        yield Mend(f"Write `length: {value:g}` for {' and '.join(w.id for w in walls)}.", edits)


def _changed(draft: Draft, run: str, row: str, units: Units, changes: Changes) -> Mend:
    """The mend of changes of a row: widths first, then what is taken out, from the right."""
    out = [k for k in sorted(changes, reverse=True) if changes[k] is None]
    widths = {k: list(width) for k, width in changes.items() if width}
    narrow = ", ".join(f"{units[k].id} {flow_text(width)}" for k, width in widths.items())
    taken = ", ".join(units[k].id for k in out[::-1])
    parts = [f"take out {taken}" if taken else "", f"write {narrow}" if narrow else ""]
    said = " and ".join(part for part in parts if part)
    edits = [draft.in_unit(draft.unit(run, row, k), "width", width) for k, width in widths.items()]
    return Mend(f"{said[:1].upper()}{said[1:]}.", (*edits, *(Edit.remove(draft.unit(run, row, k)) for k in out)))


def shrunk(
    units: Units, spans: Sequence[WidthRange], available: float, keep_last: int = 1, kept: Sequence[int] = ()
) -> Changes | None:
    """Return changes after which the minimum widths of units fit into `available`, or None if no changes achieve it.

    Units are narrowed first. Then they are removed, the least important first.

    Args:
        keep_last: minimum number of units that remain. kept: units that are not removed.
    """
    floors = [min(s.minimum, LEAST.get(str(u.kind), s.minimum)) for u, s in zip(units, spans, strict=True)]
    stay = list(range(len(units)))
    for kind in ("", *GIVEN_UP):
        while True:
            if round(sum(floors[k] for k in stay), 4) <= available:
                return _narrowed(units, spans, floors, stay, available)
            left = [k for k in stay if k not in kept and str(units[k].kind) == kind]
            # The last worktop of a row stays, to set things down on.
            tops = [k for k in stay if isinstance(units[k], BaseUnit) and units[k].kind in WORKTOPS]
            if not left or len(stay) <= keep_last or (tops == left and kind != BaseKind.DISHWASHER):
                break
            stay.remove(left[-1])
    return None


def _narrowed(
    units: Units, spans: Sequence[WidthRange], floors: Sequence[float], stay: Sequence[int], available: float
) -> Changes:
    changes: dict[int, tuple[float, float] | None] = {k: None for k in range(len(units)) if k not in stay}
    excess = round(sum(spans[k].minimum for k in stay) - available, 4)
    for kind in ("gap", *GIVEN_UP, "island"):
        for k in (k for k in stay if str(units[k].kind) == kind and k not in changes):
            if (less := min(round(spans[k].minimum - floors[k], 4), excess)) > 0.0:
                excess = round(excess - less, 4)
                low = max(round(spans[k].minimum - less - 0.0004, 3), floors[k])
                changes[k] = (low, max(low, spans[k].maximum))
    return changes


def widened(units: Units, spans: Sequence[WidthRange], rest: float) -> tuple[Changes, float]:
    """Changes that take up what is left of a row, and what they leave, metres."""
    changes: dict[int, tuple[float, float] | None] = {}
    flexible = [k for k, u in enumerate(units) if WIDENED.get(str(u.kind), 0.0) > spans[k].maximum]
    for n, k in enumerate(flexible):
        more = min(WIDENED[str(units[k].kind)] - spans[k].maximum, round(rest / (len(flexible) - n), 3))
        if more > 0.001:
            changes[k] = (spans[k].minimum, round(spans[k].maximum + more, 3))
            rest = round(rest - more, 4)
    return changes, rest


def _below(draft: Draft, line: RunLine) -> dict[str, UnitSlot]:
    return {s.name: s for s in base_slots(draft.plan, line, draft.models)}


def _span(unit: UpperUnit, below: Mapping[str, UnitSlot], models: StyleModels) -> tuple[float, float]:
    """Left and right end of a wall unit that is over another, metres along the run."""
    slot = below[str(unit.over)]
    width = slot.width if unit.width is None and unit.kind is not UpperKind.HOOD else None
    half = (width or standard_sizes.upper_span(unit, models).usual) / 2
    return slot.middle - half, slot.middle + half


def _of_upper(draft: Draft, run: Run) -> Iterator[Mend]:
    """Wall units between two that are over others, which are too wide for their place."""
    line = draft.lines()[run.id]
    below, here, group = _below(draft, line), line.left.upper_length, list[int]()
    end = round(line.length - line.right.upper_length, 4)
    for k, unit in enumerate([*run.upper, None]):
        if unit is not None and unit.over is None:
            group.append(k)
            continue
        left, right = (end, end) if unit is None else _span(unit, below, draft.models)
        units = [run.upper[i] for i in group]
        spans = [standard_sizes.upper_span(u, draft.models) for u in units]
        if group and share_widths(spans, left - here) is None:
            changes = shrunk(units, spans, max(left - here, 0.0), keep_last=0) or {}
            yield _changed(draft, run.id, "upper", run.upper, {group[i]: width for i, width in changes.items()})
        group, here = [], right


def _of_fixed(draft: Draft, run: Run, name: str) -> Iterator[Mend]:
    """A wall unit over another that reaches beyond its place: in its order, narrower, or something less."""
    line, below = draft.lines()[run.id], _below(draft, draft.lines()[run.id])
    row, k = (*draft.row("runs", run.id), "upper"), next(k for k, u in enumerate(run.upper) if u.id == name)
    unit, units = run.upper[k], draft.at(row)
    fixed = [j for j, u in enumerate(run.upper) if u.over in below]
    wanted = sorted(fixed, key=lambda j: below[str(run.upper[j].over)].middle)
    if wanted != fixed:
        order = dict(zip(fixed, wanted, strict=True))
        moved = [units[order.get(j, j)] for j in range(len(units))]
        yield Mend("Write wall units in the order of what is below them.", (Edit.put(row, moved),))
    before = [j for j in fixed if j < k]
    start = max([line.left.upper_length, *(_span(run.upper[j], below, draft.models)[1] for j in before)])
    middle, end = below[str(unit.over)].middle, line.length - line.right.upper_length
    for j in before:
        if run.upper[j].width is not None and run.upper[j].kind is not UpperKind.HOOD:
            said = f"Take the width of {run.upper[j].id} out: it is as wide as {run.upper[j].over}."
            yield Mend(said, (draft.without((*row, j), "width"),))
    room, is_hood = round(2 * min(middle - start, end - middle), 3), unit.kind is UpperKind.HOOD
    for width in HOOD_WIDTHS_M if is_hood else (room,):
        if LEAST_UPPER_M <= width <= room:
            yield Mend(f"Write `width: {width:g}` for {name}.", (draft.in_unit((*row, k), "width", width),))
    if is_hood:
        for j in before[-1:]:
            yield Mend(f"Take out {run.upper[j].id}, which is where the hood goes.", (Edit.remove((*row, j)),))
    yield Mend(f"Take out {name}.", (Edit.remove((*row, k)),))
