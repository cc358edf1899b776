"""Mends of what keeps a plan from being a kitchen, and of what the kitchen would fail its checks by; each was tried.

Rows are made to fit in the order in which a kitchen designer would give units up. A mend of a conflict is accepted if
the layout then gets past it and, with the mends of the conflicts that follow, becomes a kitchen; one of a problem, if
after it fewer problems are left. Each part of a kitchen has changes that may help, the smallest first.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from casa_assets.errors import CasaError, PlanConflict, UnknownId
from casa_assets.layouts.check_plan.draft import FROM_END_M, WINDOW_FROM_END_M, Draft
from casa_assets.layouts.check_plan.edit import Edit, Fault, Mend, flow_text, insert, put, remove
from casa_assets.layouts.check_plan.problems import Problem, has_worktop, passage, problems_of
from casa_assets.layouts.check_plan.values import name_faults
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import build_room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot, base_slots, other_side, room_at_walls
from casa_assets.layouts.plan.standard_sizes import WidthRange, share_widths
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import MOST_SEATS, BaseKind, BaseUnit, OpeningKind, Plan, Run, UpperKind, UpperUnit
from casa_assets.model.registry.document import KeyPath

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
OF_WALLS = ("walls", "parameters")  # keys of a plan
KEPT = (BaseKind.SINK, BaseKind.RANGE, BaseKind.HOB, BaseKind.FRIDGE, BaseKind.DISHWASHER)
SOFT = (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SHELF, BaseKind.PANTRY, BaseKind.PANEL)  # a kitchen is one without
# Widths, metres: of the cabinet with one door beside a corner, which opens away from it; of one between a corner and a
# dishwasher, before which people stand; of a strip.
ONE_DOOR, BESIDE_DISHWASHER, STRIP = [0.33, 0.45], [0.47, 0.5], [0.03, 0.12]
DOOR_M, WINDOW_WIDTHS_M, LEAST_UNDER_ITEM_M = 0.93, (0.9, 0.6), 0.3
AISLES_M, MORE_ROOM_M = (0.9, 3.0), (0.3, 0.6)  # least and most of an aisle; by which a room grows at last
SMALLER = 0.7  # share of what is missing that a mend may leave, where none leaves fewer problems


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
    for mend in _mends_of_conflict(draft, conflict):
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


def _mends_of_conflict(draft: Draft, conflict: PlanConflict) -> Iterator[Mend]:
    at, wanted, plan = conflict.pointer, conflict.wanted_m, draft.plan
    table, name = str(at[0]), str(at[1]) if len(at) > 1 else ""
    if at == ("height",) and wanted is not None:
        yield Mend.write((), height=wanted)
    elif at[-1:] == ("model",):
        row, said = _written(draft, at[:-1]), "Take out 'model': the style's stands there, if it has one."
        yield Mend(said, (draft.without(row, "model") if table == "runs" else remove((*row, "model")),))
    elif table == "seats":
        yield from _of_seats(plan, at)
    elif table == "openings":
        yield from _of_hole(draft, name)
    elif table == "slopes" and len(at) == 2 and wanted is not None:  # too low over something
        yield Mend.write(at, knee=math.ceil(100 * wanted + 0.5) / 100)
    elif table == "corners" and at[2:] == ("runs",):
        yield Mend.write(at[:2], runs=[*plan.corners[int(name)].runs[::-1]])
    elif table == "runs" and name:
        run = next(r for r in plan.runs if r.id == name)
        if at[2:] == ("base",):
            yield from _of_base(draft, run)
        elif at[2:3] == ("upper",):
            yield from _of_upper(draft, run) if len(at) == 3 else _of_fixed(draft, run, str(at[3]))
        else:
            keys = ("length",) if at[2:] == ("length",) else ("start", "end")
            edits = tuple(remove((*draft.row("runs", name), key)) for key in keys if getattr(run, key))
            yield Mend(f"Take out {' and '.join(map(repr, keys))} of {name}.", edits)
    if name and table not in ("runs", "walls"):
        yield Mend.take_out(_written(draft, at[:2]), f"{name} of {table}")


def _of_seats(plan: Plan, at: KeyPath) -> Iterator[Mend]:
    """Of too many seats the most stay that have room; two rows at a run are one."""
    if len(at) == 2:
        second = plan.seats[int(at[1])]
        k, first = next((k, row) for k, row in enumerate(plan.seats) if row.run == second.run)
        count = min(first.count + second.count, MOST_SEATS)
        said = f"Write `count: {count}` for {first.run}, and take out the second row."
        yield Mend(said, (put(("seats", k, "count"), count), remove(at)))
    for k, seats in enumerate(plan.seats):
        yield from (Mend.write(("seats", k), count=count) for count in range(seats.count - 1, 0, -1))
        yield Mend.take_out(("seats", k), f"the seats at {seats.run}")


def _of_hole(draft: Draft, name: str) -> Iterator[Mend]:
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
    yield from (Mend.write(at, **keys) for keys in others)


def _of_base(draft: Draft, run: Run) -> Iterator[Mend]:
    line, units = draft.lines()[run.id], run.base
    spans = [standard_sizes.base_span(u, draft.models) for u in units]
    available = round(line.length - line.left.base_length - line.right.base_length - sum(room_at_walls(line)), 4)
    if share_widths(spans, available) is None:
        # What opens away from a corner stays, so that what comes next does not run into the other row.
        ends = ((line.left, 0), (line.right, len(units) - 1))
        kept = [k for end, k in ends if end.kind is RunEnd.CORNER and units[k].kind is BaseKind.DOORS]
        for changes in (shrunk(units, spans, available, kept=kept), shrunk(units, spans, available)):
            if changes:
                yield _changed(draft, run.id, "base", units, changes)
        # Where nothing can be given up: all of the wall, or a longer wall.
        for key in (key for key in ("length", "end", "start") if getattr(run, key)):
            yield Mend.take_out((*draft.row("runs", run.id), key), f"{key!r} of {run.id}")
        yield from longer_walls(draft, line, sum(s.minimum for s in spans) - available, along=True)
        return
    changes, left = widened(units, spans, round(available - sum(s.maximum for s in spans), 3))
    mend = _changed(draft, run.id, "base", units, changes)
    edits, said = [*mend.edits], [mend.sentence] if changes else []
    tail = next((k + 1 for k in reversed(range(len(units))) if str(units[k].kind) in WIDENED), len(units))
    count = math.ceil(left / MOST_ADDED - 1e-3) if left > 0.24 else 0
    for _ in range(count):
        width = [LEAST_ADDED, round(max(left / count, LEAST_ADDED), 3)]
        edits.append(insert(draft.unit(run.id, "base", tail), {"doors": width}))
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
        yield Mend(f"Write {name}: {flow_text(three)}.", (put(("parameters", name), three),))
    elif len(lengths) == 1:
        edits = tuple(put((*draft.row("walls", w.id), "length"), value) for w in walls)
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
    return Mend(f"{said[:1].upper()}{said[1:]}.", (*edits, *(remove(draft.unit(run, row, k)) for k in out)))


def shrunk(
    units: Units, spans: Sequence[WidthRange], available: float, keep_last: int = 1, kept: Sequence[int] = ()
) -> Changes | None:
    """Return changes after which the minimum widths of units fit into `available`, or None if no changes achieve it.

    Units are narrowed first. Then they are removed, the least important first. `keep_last`: minimum number of units
    that remain. `kept`: units that are not removed.
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
        yield Mend("Write wall units in the order of what is below them.", (put(row, moved),))
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
            yield draft.unit_with((*row, k), name, "width", width)
    for j in before[-1:] if is_hood else ():
        yield Mend.take_out((*row, j), f"{run.upper[j].id}, which is where the hood goes")
    yield Mend.take_out((*row, k), name)


def problem_faults(draft: Draft, fixed_walls: bool = False) -> list[Fault]:
    """The first problem of a kitchen with its mend, which may be that of others; all of them where it has none.

    `fixed_walls`: no mend changes lengths of walls.
    """
    group, problems = problems_of(draft)
    if not problems:
        return []
    first, metres, smaller = problems[0], sum(p.excess for p in problems), None
    for mend in _mends(draft, first):
        if fixed_walls and any(edit.pointer[0] in OF_WALLS for edit in mend.edits):
            continue
        left, found = _after(draft, mend)
        again = next((p for p in found if (p.kind, p.owners) == (first.kind, first.owners)), None)
        if left < group or (left == group and len(found) < len(problems) and again is None):
            return [first.fault(draft, mend)]
        is_less = left == group and len(found) <= len(problems) and sum(p.excess for p in found) < metres
        if is_less and smaller is None and (again is None or again.excess < SMALLER * first.excess):
            smaller = mend
    return [first.fault(draft, smaller)] if smaller else [problem.fault(draft) for problem in problems]


def _after(draft: Draft, mend: Mend) -> tuple[int, list[Problem]]:
    """The problems after a mend; many groups where it makes no kitchen, or takes away what a kitchen needs."""
    try:
        after, _ = resolve(named(draft.after(mend.edits)))
        if after is not None and _kept(after.plan) >= _kept(draft.plan):
            return problems_of(after)
    except NO_PLAN:
        pass
    return 99, []


def _kept(plan: Plan) -> int:
    return sum(unit.kind in KEPT for unit in plan.units.values())


def _mends(draft: Draft, problem: Problem) -> Iterator[Mend]:
    yield from problem.mends
    names, plan = sorted(problem.owners, key=lambda n: (n != problem.about, n)), draft.plan
    units = [n for n in names if any(s.name == n for s in draft.slots)]
    for name in names:
        if any(row.id == name for row in plan.openings):
            yield from _of_opening(draft, name)
        elif any(row.id == name for row in plan.worktop_items):
            yield from _of_item(draft, name)
        for table in ("tables", "columns", "wall_items", "floor_items"):
            if any(row.id == name for row in getattr(plan, table)):
                yield from _of_thing(draft, table, name)
    for name in units:
        yield from _of_unit(draft, problem, name)
    lines = {draft.kitchen.slot(n).line.id if n in units else n for n in names}
    runs = sorted((draft.kitchen.lines[n] for n in lines if n in draft.kitchen.lines), key=lambda r: (r.at_wall, r.id))
    for line in runs:
        yield from _of_run(draft, problem, line)
        yield from longer_walls(draft, line, round(problem.excess + 0.02, 2), along=False)
    places = [place for name in units if (place := draft.place(name)) is not None]
    for run, row, k in places:
        yield from _exchanged(draft, draft.kitchen.lines[run], k) if row == "base" else ()
    yield from (Mend.take_out(draft.unit(*at), name) for name in units if (at := draft.place(name)))
    for line in runs:
        for more, along in itertools.product(MORE_ROOM_M, (False, True)):
            yield from longer_walls(draft, line, more, along)
        if not line.at_wall:
            yield from _smaller(draft, line)


def _of_opening(draft: Draft, name: str) -> Iterator[Mend]:
    """An opening hung on its other side, at another place, of another width; a door as a passage; none of it."""
    hole, at = next(h for h in draft.kitchen.holes if h.opening.id == name), draft.row("openings", name)
    opening, is_door = hole.opening, hole.opening.kind is OpeningKind.DOOR
    hinge = other_side(opening.hinge).value
    if is_door:
        yield Mend.write(at, name, hinge=hinge)
    own, middle = round(hole.right - hole.left, 4), (hole.left + hole.right) / 2
    smaller = {OpeningKind.WINDOW: WINDOW_WIDTHS_M, OpeningKind.NICHE: ()}.get(opening.kind, (DOOR_M,))
    walls = [hole.wall, *(w for w in draft.kitchen.room.walls if w.id != hole.wall.id and not w.open)]
    before = {"wall": opening.wall, "at": opening.at, "width": own}
    for width, wall in itertools.product(dict.fromkeys((own, *smaller)), walls):
        wanted = [middle] * (wall is hole.wall) + [wall.length * share for share in (0.5, 0.2, 0.8, 0.0, 1.0)]
        places = dict.fromkeys(draft.free_middle(wall, hole, width, u) for u in wanted)
        for u, turned in itertools.product((u for u in places if u is not None), (False, is_door)):
            new: dict[str, str | float] = {"wall": wall.id, "at": u, "width": width}
            new = {k: v for k, v in new.items() if v != before[k]} | ({"hinge": hinge} if turned else {})
            mend = Mend.write(at, name, **new)
            alone = (remove((*at, "over")),) if opening.over is not None else ()
            yield replace(mend, edits=(*alone, *mend.edits))
    if is_door and opening.closet is None:
        yield passage(draft, name)
    yield Mend.take_out(at, f"{name}: no wall has a place for it")


def _of_item(draft: Draft, name: str) -> Iterator[Mend]:
    """Yield other places for an object on a worktop, first in the same row and nearest; last, its removal."""
    at, items = draft.row("worktop_items", name), draft.plan.worktop_items
    before = draft.kitchen.slot(next(i.on for i in items if i.id == name))
    yield from (Mend.write(at, name, at=share) for share in (0.0, 1.0))
    others = [s for s in draft.slots if has_worktop(s) and s.width >= LEAST_UNDER_ITEM_M and s.name in draft.plan.units]
    taken = [i.on for i in items]
    others.sort(key=lambda s: (s.name in taken, s.line is not before.line, abs(s.middle - before.middle)))
    yield from (Mend.write(at, name, on=slot.name) for slot in others)
    yield Mend.take_out(at, name)


def _of_thing(draft: Draft, table: str, name: str) -> Iterator[Mend]:
    """A table, a column or a thing on a wall or the floor: with fewer chairs, or none of it."""
    at, chairs = draft.row(table, name), next((t.chairs for t in draft.plan.tables if t.id == name), 0)
    yield from (Mend.write(at, name, chairs=fewer) for fewer in range(chairs - 2, 1, -2))
    yield Mend(f"Take out {name}.", (*_without(draft.plan, name), remove(at)))


def _without(plan: Plan, name: str) -> Iterator[Edit]:
    """The edits that take out seats, corners and lamps of a run or a table."""
    for table, key in (("seats", "run"), ("corners", "runs"), ("lamps", "over")):
        found = [getattr(row, key) for row in getattr(plan, table)]
        rows = [one if isinstance(one, tuple) else (one,) for one in found]
        yield from (remove((table, k)) for k in reversed(range(len(rows))) if name in rows[k])


def _of_unit(draft: Draft, problem: Problem, name: str) -> Iterator[Mend]:
    """Yield another hinge, a strip or a one-door cabinet next to a unit, another place in its row, another width."""
    place = draft.place(name)
    if place is None:
        return
    (run, row, k), at = place, draft.unit(*place)
    line = draft.kitchen.lines[run]
    units: Sequence[BaseUnit | UpperUnit] = line.run.base if row == "base" else line.run.upper
    unit, rows = units[k], list(draft.at(at[:-1]))
    if unit.hinge is not None:
        yield draft.unit_with(at, name, "hinge", other_side(unit.hinge).value)
    if isinstance(unit, UpperUnit) and unit.kind is UpperKind.HOOD:
        for width in (w for w in HOOD_WIDTHS_M if w < draft.kitchen.slot(name).width):
            yield draft.unit_with(at, name, "width", width)
        k = next((i for i, u in enumerate(line.run.base) if u.id == unit.over), -1)
        if k >= 0:
            yield from _exchanged(draft, line, k)
        return
    door = BESIDE_DISHWASHER if unit.kind is BaseKind.DISHWASHER else ONE_DOOR
    ends = [(line.left.kind, "left", 0, k), (line.right.kind, "right", len(units), k + 1)]
    for end, side, index, beside in sorted(ends, key=lambda e: (e[0] is not RunEnd.CORNER, abs(e[2] - k))):
        soft = [j for j, u in enumerate(units) if u.kind in ("doors", "glass")]
        if (end is not RunEnd.FREE and len(problem.owners) == 1) or end is RunEnd.WALL:
            said = f"Add `- filler: {flow_text(STRIP)}` to the {side} of {name}."
            yield Mend(said, (insert((*at[:-1], beside), {"filler": STRIP}),))
        for j in sorted(soft, key=lambda j: abs(j - k)):
            moved = [row for i, row in enumerate(rows) if i != j]
            moved.insert(min(index, len(moved)), {units[j].kind.value: door})
            said = f"Put {units[j].id} {flow_text(door)} at the {side} end of {run}."
            yield Mend(said, (put(at[:-1], moved),))
        said = f"Add `- doors: {flow_text(door)}` at the {side} end of {run}."
        yield Mend(said, (insert((*at[:-1], index), {"doors": door}),))
    if unit.kind in (BaseKind.DRAWERS, BaseKind.DOORS, UpperKind.GLASS):
        yield Mend(f"Write `doors: {flow_text(door)}` for {name}.", (put(at, {"doors": door}),))


def _exchanged(draft: Draft, line: RunLine, k: int) -> Iterator[Mend]:
    """Yield exchanges of a unit, or of a neighbour, with others of its row; then a cabinet inserted next to it."""
    at, base = (*draft.row("runs", line.id), "base"), line.run.base
    near = [i for i in (k, k - 1, k + 1) if 0 <= i < len(base)]
    pairs = [(i, j) for i in near for j in range(len(base)) if i != j]
    for i, j in sorted(pairs, key=lambda p: (abs(p[0] - p[1]), p)):
        rows = list(draft.at(at))
        rows[i], rows[j] = rows[j], rows[i]
        yield Mend(f"Let {base[i].id} and {base[j].id} change places.", (put(at, rows),))
    for index, side in ((k, "left"), (k + 1, "right")):
        said = f"Add `- doors: {flow_text(ONE_DOOR)}` to the {side} of {base[k].id}."
        yield Mend(said, (insert((*at, index), {"doors": ONE_DOOR}),))


def _of_run(draft: Draft, problem: Problem, line: RunLine) -> Iterator[Mend]:
    run, at, more = line.run, draft.row("runs", line.id), round(problem.excess + 0.02, 2)
    if run.faces is not None:
        for key, change in (("aisle", more), ("shift", more), ("shift", -more), ("aisle", -more)):
            value = round(getattr(run.faces, key) + change, 2)
            value = min(max(value, AISLES_M[0]), AISLES_M[1]) if key == "aisle" else value
            yield Mend.write((*at, "faces"), line.id, **{key: value})
    if run.on is not None and run.length is None:
        for key, end in (("start", line.left), ("end", line.right)):
            if end.kind is not RunEnd.CORNER:
                value = round(draft.plan.length(getattr(run, key), draft.plan.defaults) + more, 2)
                yield Mend.write(at, line.id, **{key: value})
    if not draft.plan.compact and "aisle" in problem.expected:
        yield Mend("Add `compact: true`: aisles of a small kitchen are narrower.", (put(("compact",), True),))


def _smaller(draft: Draft, line: RunLine) -> Iterator[Mend]:
    """Yield mends that make room around an island or peninsula: centre it, no overhang, less length, or remove it."""
    run, at, name = line.run, draft.row("runs", line.id), line.id
    for key in ("shift", "in_front_of"):
        if run.faces is not None and getattr(run.faces, key):
            yield Mend.take_out((*at, "faces", key), f"{key!r} of {name}")
    if run.overhang:
        seats = [edit for edit in _without(draft.plan, name) if edit.pointer[0] == "seats"]
        yield Mend(f"Take out the overhang and the seats of {name}.", (remove((*at, "overhang")), *seats))
    shorter: tuple[Edit, ...] = (remove((*at, "length")),) if run.length is not None else ()
    for k, unit in reversed(list(enumerate(run.base))):
        there = draft.unit(name, "base", k)
        if unit.kind is BaseKind.ISLAND:
            for width in (round(line.length * share, 2) for share in (0.9, 0.8, 0.7, 0.6)):
                yield Mend(f"Write `island: {width:g}`.", (draft.in_unit(there, "width", width),))
        elif unit.kind in SOFT and len(run.base) > 1:
            yield Mend(f"Take out {unit.id}.", (remove(there), *shorter))
    yield Mend(f"Take out the run {name}: there is no room for it.", (*_without(draft.plan, name), remove(at)))
