"""Mends of what a kitchen would fail its checks by: one is offered if after it fewer faults are left.

Each part of a kitchen has changes that may help, the smallest first; each is tried, and the first that helps is taken.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from casa_assets.layouts.check_plan.conflicts import HOOD_WIDTHS_M, NO_PLAN, longer_walls, named, resolve
from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.problems import Problem, has_worktop, passage, problems_of
from casa_assets.layouts.plan.runs import RunLine, other_side
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, OpeningKind, Plan, UpperKind, UpperUnit
from casa_assets.registry.edit import Edit, Fault, Mend, flow_text

OF_WALLS = ("walls", "parameters")  # keys of a plan
KEPT = (BaseKind.SINK, BaseKind.RANGE, BaseKind.HOB, BaseKind.FRIDGE, BaseKind.DISHWASHER)
SOFT = (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SHELF, BaseKind.PANTRY, BaseKind.PANEL)  # a kitchen is one without
# Widths, metres: of the cabinet with one door beside a corner, which opens away from it; of one between a corner and a
# dishwasher, before which people stand; of a strip.
ONE_DOOR, BESIDE_DISHWASHER, STRIP = [0.33, 0.45], [0.47, 0.5], [0.03, 0.12]
DOOR_M, WINDOW_WIDTHS_M, LEAST_UNDER_ITEM_M = 0.93, (0.9, 0.6), 0.3
AISLES_M, MORE_ROOM_M = (0.9, 3.0), (0.3, 0.6)  # least and most of an aisle; by which a room grows at last
SMALLER = 0.7  # share of what is missing that a mend may leave, where none leaves fewer problems


def problem_faults(draft: Draft, fixed_walls: bool = False) -> list[Fault]:
    """The first problem of a kitchen with its mend, which may be that of others; all of them where it has none.

    Args:
        fixed_walls: no mend changes lengths of walls.
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
    """How many of its units a kitchen has to keep."""
    return sum(unit.kind in KEPT for unit in plan.units.values())


def _mends(draft: Draft, problem: Problem) -> Iterator[Mend]:
    """Yield mends that may help with a problem, the smallest change first."""
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
    yield from (
        Mend(f"Take out {name}.", (Edit.remove(draft.unit(*at)),)) for name in units if (at := draft.place(name))
    )
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
        yield Mend(f"Write `hinge: {hinge}` for {name}.", (Edit.put((*at, "hinge"), hinge),))
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
            edits = [Edit.remove((*at, "over"))] if opening.over is not None else []
            said = ", ".join(f"{key}: {flow_text(value)}" for key, value in new.items())
            edits += [Edit.put((*at, key), value) for key, value in new.items()]
            yield Mend(f"Write `{said}` for {name}.", tuple(edits))
    if is_door and opening.closet is None:
        yield passage(draft, name)
    yield Mend(f"Take out {name}: no wall has a place for it.", (Edit.remove(at),))


def _of_item(draft: Draft, name: str) -> Iterator[Mend]:
    """Yield other places for an object on a worktop, first in the same row and nearest; last, its removal."""
    at, items = draft.row("worktop_items", name), draft.plan.worktop_items
    before = draft.kitchen.slot(next(i.on for i in items if i.id == name))
    for share in (0.0, 1.0):
        yield Mend(f"Write `at: {share:g}` for {name}.", (Edit.put((*at, "at"), share),))
    others = [s for s in draft.slots if has_worktop(s) and s.width >= LEAST_UNDER_ITEM_M and s.name in draft.plan.units]
    taken = [i.on for i in items]
    others.sort(key=lambda s: (s.name in taken, s.line is not before.line, abs(s.middle - before.middle)))
    for slot in others:
        yield Mend(f"Write `on: {slot.name}` for {name}.", (Edit.put((*at, "on"), slot.name),))
    yield Mend(f"Take out {name}.", (Edit.remove(at),))


def _of_thing(draft: Draft, table: str, name: str) -> Iterator[Mend]:
    """A table, a column or a thing on a wall or the floor: with fewer chairs, or none of it."""
    at = draft.row(table, name)
    for fewer in range(next((t.chairs for t in draft.plan.tables if t.id == name), 0) - 2, 1, -2):
        yield Mend(f"Write `chairs: {fewer}` for {name}.", (Edit.put((*at, "chairs"), fewer),))
    yield Mend(f"Take out {name}.", (*_without(draft.plan, name), Edit.remove(at)))


def _without(plan: Plan, name: str) -> Iterator[Edit]:
    """The edits that take out seats, corners and lamps of a run or a table."""
    for table, key in (("seats", "run"), ("corners", "runs"), ("lamps", "over")):
        found = [getattr(row, key) for row in getattr(plan, table)]
        rows = [one if isinstance(one, tuple) else (one,) for one in found]
        yield from (Edit.remove((table, k)) for k in reversed(range(len(rows))) if name in rows[k])


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
        hinge = other_side(unit.hinge).value
        yield Mend(f"Write `hinge: {hinge}` for {name}.", (draft.in_unit(at, "hinge", hinge),))
    if isinstance(unit, UpperUnit) and unit.kind is UpperKind.HOOD:
        for width in (w for w in HOOD_WIDTHS_M if w < draft.kitchen.slot(name).width):
            yield Mend(f"Write `width: {width:g}` for {name}.", (draft.in_unit(at, "width", width),))
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
            yield Mend(said, (Edit.insert((*at[:-1], beside), {"filler": STRIP}),))
        for j in sorted(soft, key=lambda j: abs(j - k)):
            moved = [row for i, row in enumerate(rows) if i != j]
            moved.insert(min(index, len(moved)), {units[j].kind.value: door})
            said = f"Put {units[j].id} {flow_text(door)} at the {side} end of {run}."
            yield Mend(said, (Edit.put(at[:-1], moved),))
        said = f"Add `- doors: {flow_text(door)}` at the {side} end of {run}."
        yield Mend(said, (Edit.insert((*at[:-1], index), {"doors": door}),))
    if unit.kind in (BaseKind.DRAWERS, BaseKind.DOORS, UpperKind.GLASS):
        yield Mend(f"Write `doors: {flow_text(door)}` for {name}.", (Edit.put(at, {"doors": door}),))


def _exchanged(draft: Draft, line: RunLine, k: int) -> Iterator[Mend]:
    """Yield exchanges of a unit, or of a neighbour, with others of its row; then a cabinet inserted next to it."""
    at, base = (*draft.row("runs", line.id), "base"), line.run.base
    near = [i for i in (k, k - 1, k + 1) if 0 <= i < len(base)]
    pairs = [(i, j) for i in near for j in range(len(base)) if i != j]
    for i, j in sorted(pairs, key=lambda p: (abs(p[0] - p[1]), p)):
        rows = list(draft.at(at))
        rows[i], rows[j] = rows[j], rows[i]
        yield Mend(f"Let {base[i].id} and {base[j].id} change places.", (Edit.put(at, rows),))
    for index, side in ((k, "left"), (k + 1, "right")):
        said = f"Add `- doors: {flow_text(ONE_DOOR)}` to the {side} of {base[k].id}."
        yield Mend(said, (Edit.insert((*at, index), {"doors": ONE_DOOR}),))


def _of_run(draft: Draft, problem: Problem, line: RunLine) -> Iterator[Mend]:
    """Yield mends that move a run further from another one, or let it begin later or end earlier."""
    run, at, more = line.run, draft.row("runs", line.id), round(problem.excess + 0.02, 2)
    if run.faces is not None:
        for key, change in (("aisle", more), ("shift", more), ("shift", -more), ("aisle", -more)):
            value = round(getattr(run.faces, key) + change, 2)
            value = min(max(value, AISLES_M[0]), AISLES_M[1]) if key == "aisle" else value
            yield Mend(f"Write `{key}: {value:g}` for {line.id}.", (Edit.put((*at, "faces", key), value),))
    if run.on is not None and run.length is None:
        for key, end in (("start", line.left), ("end", line.right)):
            if end.kind is not RunEnd.CORNER:
                value = round(draft.plan.length(getattr(run, key), draft.plan.defaults) + more, 2)
                yield Mend(f"Write `{key}: {value:g}` for {line.id}.", (Edit.put((*at, key), value),))
    if not draft.plan.compact and "aisle" in problem.expected:
        yield Mend("Add `compact: true`: aisles of a small kitchen are narrower.", (Edit.put(("compact",), True),))


def _smaller(draft: Draft, line: RunLine) -> Iterator[Mend]:
    """Yield mends that make room around an island or peninsula: centre it, no overhang, less length, or remove it."""
    run, at, name = line.run, draft.row("runs", line.id), line.id
    for key in ("shift", "in_front_of"):
        if run.faces is not None and getattr(run.faces, key):
            yield Mend(f"Take out {key!r} of {name}.", (Edit.remove((*at, "faces", key)),))
    if run.overhang:
        seats = [edit for edit in _without(draft.plan, name) if edit.pointer[0] == "seats"]
        yield Mend(f"Take out the overhang and the seats of {name}.", (Edit.remove((*at, "overhang")), *seats))
    shorter: tuple[Edit, ...] = (Edit.remove((*at, "length")),) if run.length is not None else ()
    for k, unit in reversed(list(enumerate(run.base))):
        there = draft.unit(name, "base", k)
        if unit.kind is BaseKind.ISLAND:
            for width in (round(line.length * share, 2) for share in (0.9, 0.8, 0.7, 0.6)):
                yield Mend(f"Write `island: {width:g}`.", (draft.in_unit(there, "width", width),))
        elif unit.kind in SOFT and len(run.base) > 1:
            yield Mend(f"Take out {unit.id}.", (Edit.remove(there), *shorter))
    yield Mend(f"Take out the run {name}: there is no room for it.", (*_without(draft.plan, name), Edit.remove(at)))
