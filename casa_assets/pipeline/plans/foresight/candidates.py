"""Mends that may help with a problem, the smallest change first; each has to be tried."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.room import WallHole
from casa_assets.layouts.plan.runs import CornerPart, RunLine, UnitSlot
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import OpeningKind, RunCorner
from casa_assets.model.kitchen.units import TALL, BaseKind, BaseUnit, RunSide, UpperKind, UpperUnit
from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.clashes import (
    free_middle,
    moved_opening,
    smaller_island,
    wider_room,
    without_leaf,
    without_run,
)
from casa_assets.pipeline.plans.fault import Mend, added, removed, replaced, value_at
from casa_assets.pipeline.plans.foresight.problems import (
    TOUCH_M,
    USUAL_OVERHANG_M,
    Problem,
    ProblemKind,
    has_worktop,
)
from casa_assets.pipeline.plans.written import (
    inserted,
    key_edit,
    place_of,
    row_at,
    unit_at,
    unit_edit,
    with_unit,
)
from casa_assets.registry.edit import edited_value, flow_text

# Widths, metres: of the cabinet with one door beside a corner, which opens away from it; of one between a corner and a
# dishwasher, before which people stand; of a strip; of a cabinet between a cooker and what is tall.
BESIDE_DISHWASHER = [0.47, 0.5]
ONE_DOOR, STRIP, BESIDE_COOKER = [0.33, 0.45], [0.03, 0.12], [0.3, 0.45]
HOOD_WIDTHS_M = (0.9, 0.76, 0.6)  # usual ones
DOOR_M, MOST_AISLE_M = 0.93, 3.0
MORE_ROOM_M, MOST_TOGETHER = (0.3, 0.6), 12  # by which a room grows at last; how many candidates are tried with that
LEAST_UNDER_ITEM_M = 0.3  # width of a unit on which a thing is put, metres
SOFT = (BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SHELF, BaseKind.PANTRY)
Units = Sequence[BaseUnit | UpperUnit]


def candidates(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """Mends that may help with a problem, one after the other."""
    if problem.kind is ProblemKind.TASKS:
        yield Mend("Write `all_tasks: false`.", (key_edit(raw, (), "all_tasks", False),))
    elif problem.kind is ProblemKind.AISLE:
        yield from _of_runs(raw, kitchen, problem)
    elif problem.kind is ProblemKind.OVERLAP:
        yield from _of_overlap(raw, kitchen, problem)
    elif problem.kind is ProblemKind.SEATS:
        at = row_at(raw, "runs", problem.about)
        said = f"Write `overhang: {USUAL_OVERHANG_M:g}` for {problem.about}."
        yield Mend(said, (key_edit(raw, at, "overhang", USUAL_OVERHANG_M),))
        yield from _without_seats(raw, kitchen, problem.about)
    elif problem.kind is ProblemKind.LANDING:
        items = _items_of(kitchen, problem)
        for name in [*sorted(items - {problem.about}), *({problem.about} & items)]:
            yield from _of_item(raw, kitchen, name)
        yield from _with_worktop(raw, kitchen, problem.about)
    elif problem.kind is ProblemKind.WALL and problem.about in {s.name for row in kitchen.slots.values() for s in row}:
        yield from _off_wall(raw, kitchen, problem)
    elif problem.kind is ProblemKind.DOORWAY:
        yield from _of_doorway(raw, kitchen, problem.about)
    elif problem.kind is ProblemKind.WINDOW:
        yield moved_opening(raw, kitchen, _hole(kitchen, problem.about))
        yield Mend(f"Take out {problem.about}.", (removed(row_at(raw, "openings", problem.about)),))
    elif problem.kind is ProblemKind.HOOD:
        place = place_of(kitchen.plan, problem.about)
        if place is not None:
            yield Mend(f"Take out {problem.about}.", (removed(unit_at(raw, *place)),))
    elif problem.kind is ProblemKind.ITEM:
        for name in (problem.about, *sorted(_items_of(kitchen, problem) - {problem.about})):
            yield from _of_item(raw, kitchen, name)
    else:
        yield from _of_leaves(raw, kitchen, problem)


def last_resorts(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """Larger changes, where no candidate helps: a column or a cabinet less, a larger room, or that with a candidate."""
    for name in sorted({c.id for c in kitchen.plan.columns} & problem.owners):
        yield from _of_thing(raw, kitchen, "columns", name)
    lines = _lines_of(kitchen, problem)
    for line in lines:
        for unit in line.run.base:
            place = place_of(kitchen.plan, unit.id)
            if place is not None and unit.kind in SOFT:
                edits = [removed(unit_at(raw, *place))]
                if not line.at_wall and line.run.length is not None:
                    edits.append(removed((*row_at(raw, "runs", line.id), "length")))
                yield Mend(f"Take out {unit.id}.", tuple(edits))
    for line, along, more in itertools.product(lines, (True, False), MORE_ROOM_M):
        larger = wider_room(raw, kitchen, line, more, along)
        if larger is None:
            continue
        yield larger
        for other in itertools.islice(candidates(raw, kitchen, problem), MOST_TOGETHER):
            yield Mend(f"{larger.sentence} {other.sentence}", (*larger.edits, *other.edits))


def _lines_of(kitchen: KitchenRequest, problem: Problem) -> list[RunLine]:
    """The runs that a problem is of, those first that stand at no wall."""
    runs = {s.name: s.line.id for row in kitchen.slots.values() for s in row}
    names = {name if name in kitchen.lines else runs.get(name, "") for name in problem.owners}
    return sorted(
        (kitchen.lines[name] for name in names & kitchen.lines.keys()), key=lambda line: (line.at_wall, line.id)
    )


def _items_of(kitchen: KitchenRequest, problem: Problem) -> frozenset[str]:
    """The things on worktops that a problem is of."""
    return problem.owners & {item.id for item in kitchen.plan.worktop_items}


def _of_item(raw: Any, kitchen: KitchenRequest, name: str) -> Iterator[Mend]:
    """Another unit for a thing to stand on, of its own row first and the nearest there; or none of it."""
    at = row_at(raw, "worktop_items", name)
    before = kitchen.slot(next(i.on for i in kitchen.plan.worktop_items if i.id == name))
    for share, side in ((0.0, "left"), (1.0, "right")):
        said = f"Write `at: {share:g}` for {name}, at the {side} end of {before.name}."
        yield Mend(said, (key_edit(raw, at, "at", share),))
    taken = [i.on for i in kitchen.plan.worktop_items]
    others = [s for row in kitchen.slots.values() for s in row if has_worktop(s) and s.width >= LEAST_UNDER_ITEM_M]
    others.sort(key=lambda s: (s.name in taken, s.line.id != before.line.id, abs(s.middle - before.middle)))
    for slot in others:
        if slot.name in kitchen.plan.units:
            yield Mend(f"Write `on: {slot.name}` for {name}.", (key_edit(raw, at, "on", slot.name),))
    yield Mend(f"Take out {name}.", (removed(at),))


def _of_leaves(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """What may help where leaves clash, or an appliance is too near to a corner."""
    openings = sorted(problem.owners & {o.id for o in kitchen.plan.openings})
    units = sorted(problem.owners - set(openings), key=lambda n: (_corner_side(kitchen, n) is None, n))
    for name in openings:
        if _hole(kitchen, name).opening.kind is OpeningKind.WINDOW:
            yield moved_opening(raw, kitchen, _hole(kitchen, name))
        else:
            yield from _of_door(raw, kitchen, name)
    slots = {s.name for row in kitchen.slots.values() for s in row}
    for table in ("tables", "columns"):
        for name in sorted({row.id for row in getattr(kitchen.plan, table)} & set(units)):
            yield from _of_thing(raw, kitchen, table, name)
    units = [name for name in units if name in slots]
    for name in units:
        yield from _of_diagonal(raw, kitchen, name)
    for name in units:
        others = problem.owners - {name}
        yield from _of_unit(raw, kitchen, name, next(iter(others)) if others else None)
    yield from _of_runs(raw, kitchen, problem)
    for name in units:
        place = place_of(kitchen.plan, name)
        if place is not None:
            yield Mend(f"Take out {name}.", (removed(unit_at(raw, *place)),))


def _of_diagonal(raw: Any, kitchen: KitchenRequest, name: str) -> Iterator[Mend]:
    """A blind corner in place of a diagonal one, whose door opens before the units beside it."""
    slot = kitchen.slot(name)
    if slot.kind is not CornerPart.DIAGONAL:
        return
    end = slot.line.left if slot.corner is RunSide.LEFT else slot.line.right
    assert end.corner is not None, "a corner cabinet stands in a corner"
    at = ("corners", kitchen.plan.corners.index(end.corner))
    key = "upper" if slot.is_upper else "base"
    said = f"Write `{key}: blind` for the corner of {' and '.join(end.corner.runs)}."
    yield Mend(said, (key_edit(raw, at, key, "blind"),))


def _hole(kitchen: KitchenRequest, name: str) -> WallHole:
    return next(h for h in kitchen.holes if h.opening.id == name)


def _corner_side(kitchen: KitchenRequest, name: str) -> RunSide | None:
    """The end of its run in a corner beside which a unit of the plan stands, as the first one."""
    place = place_of(kitchen.plan, name)
    if place is None:
        return None
    run, row, k = place
    line = kitchen.lines[run]
    units: Units = line.run.base if row == "base" else line.run.upper
    if k == 0 and line.left.kind is RunEnd.CORNER:
        return RunSide.LEFT
    return RunSide.RIGHT if k == len(units) - 1 and line.right.kind is RunEnd.CORNER else None


# Openings --------------------------------------------------------------------------------------------------------


def _of_door(raw: Any, kitchen: KitchenRequest, name: str) -> Iterator[Mend]:
    """A door of the room hung on its other side, or at another place, or without a leaf."""
    hole = _hole(kitchen, name)
    at = row_at(raw, "openings", name)
    side = RunSide.LEFT if hole.opening.hinge is RunSide.RIGHT else RunSide.RIGHT
    yield Mend(f"Write `hinge: {side.value}` for {name}.", (key_edit(raw, at, "hinge", side.value),))
    walls = [hole.wall, *(w for w in kitchen.room.walls if w.id != hole.wall.id and not w.open)]
    for wall in walls:
        here = [(hole.left + hole.right) / 2] if wall.id == hole.wall.id else []
        wanted = [*here, *(wall.length * share for share in (0.5, 0.2, 0.8, 0.0, 1.0))]
        places = [free_middle(kitchen, wall, 0.05, hole.top, hole.right - hole.left, u, hole) for u in wanted]
        for middle in dict.fromkeys(p for p in places if p is not None):
            edits = [removed((*at, "over"))] if hole.opening.over is not None else []
            edits.append(key_edit(raw, at, "at", middle))
            said = f"at: {middle:g}"
            if wall.id != hole.wall.id:
                edits.append(key_edit(raw, at, "wall", wall.id))
                said = f"wall: {wall.id}, {said}"
            yield Mend(f"Write `{said}` for {name}.", tuple(edits))
            more = (*edits, key_edit(raw, at, "hinge", side.value))
            yield Mend(f"Write `{said}, hinge: {side.value}` for {name}.", more)
    yield _passage(raw, name)


def _passage(raw: Any, name: str) -> Mend:
    return Mend(f"Write `kind: passage` for {name}: it has no room for a leaf.", tuple(without_leaf(raw, name)))


def _of_doorway(raw: Any, kitchen: KitchenRequest, name: str) -> Iterator[Mend]:
    """A wider door, where it is or where it has room, or one without a leaf."""
    hole, at = _hole(kitchen, name), row_at(raw, "openings", name)
    width = key_edit(raw, at, "width", DOOR_M)
    yield Mend(f"Write `width: {DOOR_M:g}` for {name}.", (width,))
    for wall in [hole.wall, *(w for w in kitchen.room.walls if w.id != hole.wall.id and not w.open)]:
        middle = free_middle(kitchen, wall, 0.05, hole.top, DOOR_M, (hole.left + hole.right) / 2, hole)
        if middle is not None and hole.opening.over is None:
            said = f"Write `wall: {wall.id}, at: {middle:g}, width: {DOOR_M:g}` for {name}."
            yield Mend(said, (width, key_edit(raw, at, "wall", wall.id), key_edit(raw, at, "at", middle)))
    yield _passage(raw, name)
    yield Mend(f"Take out {name}.", (removed(at),))


# Units -----------------------------------------------------------------------------------------------------------


def _of_unit(raw: Any, kitchen: KitchenRequest, name: str, other: str | None) -> Iterator[Mend]:
    """A cabinet with one door, hung away from a corner, in the place of a unit at the end of its row, or before it."""
    place = place_of(kitchen.plan, name)
    if place is None:
        return
    run, row, k = place
    units: Units = kitchen.lines[run].run.base if row == "base" else kitchen.lines[run].run.upper
    if any(unit.kind is BaseKind.ISLAND for unit in units):
        return
    unit, at = units[k], unit_at(raw, *place)
    door = BESIDE_DISHWASHER if unit.kind is BaseKind.DISHWASHER else ONE_DOOR
    pointer = at[:-1]
    is_left = _towards_left(kitchen, name, other)
    end, side = (0, "left") if is_left else (len(units), "right")
    hinge = getattr(unit, "hinge", None)
    if hinge is not None:
        turned = RunSide.RIGHT if hinge is RunSide.LEFT else RunSide.LEFT
        yield Mend(f"Write `hinge: {turned.value}` for {name}.", (unit_edit(raw, at, "hinge", turned.value),))
    if other is None:
        strip = k if is_left else k + 1
        said = f"Add `- filler: {flow_text(STRIP)}` between {name} and the {side} corner."
        yield Mend(said, (inserted((*pointer, strip), {"filler": STRIP}),))
    soft = [j for j, u in enumerate(units) if u.kind in (BaseKind.DOORS, UpperKind.DOORS)]
    for j in sorted(soft, key=lambda j: abs(j - k)):
        width = unit_edit(raw, (*pointer, j), "width", door)
        if j == k:
            yield Mend(f"Write {name} {flow_text(door)}: one door.", (width,))
            continue
        moved = list(value_at(edited_value(raw, width), pointer))
        moved.insert(min(end, len(moved) - 1), moved.pop(j))
        said = f"Put {units[j].id} {flow_text(door)} at the {side} end of {run}."
        yield Mend(said, (replaced(pointer, moved),))
    new = {"doors": door}
    said = f"Add `- doors: {flow_text(door)}` at the {side} end of {run}."
    yield Mend(said, (inserted((*pointer, end), new),))
    if unit.kind in (BaseKind.DRAWERS, UpperKind.GLASS):
        yield Mend(f"Write `doors: {flow_text(door)}` for {name}.", (replaced(at, new),))


def _with_worktop(raw: Any, kitchen: KitchenRequest, name: str) -> Iterator[Mend]:
    """A sink or a cooker, or what stands beside it, changes places with another unit, or gets a cabinet beside it."""
    place = place_of(kitchen.plan, name)
    if place is None:
        return
    run, _, k = place
    units = kitchen.lines[run].run.base
    pointer = (*row_at(raw, "runs", run), "base")
    pairs = [(i, j) for i in (k, k - 1, k + 1) if 0 <= i < len(units) for j in range(len(units)) if j != i]
    for i, j in sorted(pairs, key=lambda p: (abs(p[0] - p[1]), p)):
        yield _exchanged(raw, pointer, units, i, j)
    for index, side in ((k + 1, "right"), (k, "left")):
        said = f"Add `- doors: {flow_text(ONE_DOOR)}` to the {side} of {name}."
        yield Mend(said, (inserted((*pointer, index), {"doors": ONE_DOOR}),))


def _exchanged(raw: Any, pointer: KeyPath, units: Units, i: int, j: int, why: str = "") -> Mend:
    """Two units of a row change places; `pointer`: of the row."""
    rows = list(value_at(raw, pointer))
    rows[i], rows[j] = rows[j], rows[i]
    return Mend(f"Let {units[i].id} and {units[j].id} change places{why}.", (replaced(pointer, rows),))


def _off_wall(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """A strip between a unit and the wall beside it."""
    place = place_of(kitchen.plan, problem.about)
    if place is None:
        return
    run, row, k = place
    pointer = unit_at(raw, run, row, k)[:-1]
    for index, side in ((k, "left"), (k + 1, "right")):
        said = f"Add `- filler: {flow_text(STRIP)}` to the {side} of {problem.about}."
        yield Mend(said, (inserted((*pointer, index), {"filler": STRIP}),))
    yield from _of_unit(raw, kitchen, problem.about, None)


def _of_thing(raw: Any, kitchen: KitchenRequest, table: str, name: str) -> Iterator[Mend]:
    """A table or a column that is in the way of a leaf: with fewer chairs, or none of it."""
    at = row_at(raw, table, name)
    chairs = next((t.chairs for t in kitchen.plan.tables if t.id == name), 0)
    for fewer in range(chairs - 2, 1, -2):
        yield Mend(f"Write `chairs: {fewer}` for {name}.", (key_edit(raw, at, "chairs", fewer),))
    lamps = [k for k, lamp in enumerate(kitchen.plan.lamps) if lamp.over == name]
    yield Mend(f"Take out {name}.", (*(removed(("lamps", k)) for k in reversed(lamps)), removed(at)))


def _towards_left(kitchen: KitchenRequest, name: str, other: str | None) -> bool:
    """True if another unit or opening, or the nearer corner, lies to the left of a unit along its run."""
    slot = kitchen.slot(name)
    if other is None:
        line = slot.line
        left = slot.left if line.left.kind is RunEnd.CORNER else line.length
        return left < (line.length - slot.right if line.right.kind is RunEnd.CORNER else line.length)
    hole = next((h for h in kitchen.holes if h.opening.id == other), None)
    if hole is not None:
        x, y, _ = hole.wall.frame.at((hole.left + hole.right) / 2, 0.0)
    else:
        beyond = kitchen.slot(other)
        x, y, _ = beyond.line.frame.at(beyond.middle, 0.0)
    return slot.line.frame.to_local(x, y)[0] < slot.middle


# Wall units ------------------------------------------------------------------------------------------------------


def _of_overlap(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """A gap over what is tall, a cooker apart from it, a corner of the wall units, or one less of these."""
    upper = kitchen.slot(problem.about)
    other = kitchen.slot(next(iter(problem.owners - {problem.about})))
    run = upper.line.run
    over = {u.over for u in run.upper}
    if other.kind in TALL and other.line is upper.line and other.name not in over:
        for index in range(len(run.upper) + 1):
            edit = with_unit(raw, run.id, "upper", index, {"gap": {"over": other.name}})
            yield Mend(f"Add `- gap: {{over: {other.name}}}` to the wall units of {run.id}.", (edit,))
    mine = place_of(kitchen.plan, upper.name)
    if mine is not None and run.upper[mine[2]].over == other.name and upper.kind is not UpperKind.HOOD:
        gap = {"gap": {"over": other.name}}
        yield Mend(f"Write `gap: {{over: {other.name}}}` for {upper.name}.", (replaced(unit_at(raw, *mine), gap),))
    if upper.kind is UpperKind.HOOD:
        yield from _narrower_hood(raw, kitchen, upper)
        yield from _cooker_apart(raw, kitchen, upper.name)
        place = place_of(kitchen.plan, other.name)
        if place is not None and other.kind is BaseKind.FRIDGE:
            said = f"Write `housing: false` for {other.name}: without panels the hood has room beside it."
            yield Mend(said, (unit_edit(raw, unit_at(raw, *place), "housing", False),))
    corner = upper.line.right.corner if upper.line.right.corner in _corners(other) else upper.line.left.corner
    if corner is not None and corner in _corners(other) and corner.upper is None:
        at = ("corners", kitchen.plan.corners.index(corner))
        for kind in ("blind", "dead"):
            said = f"Write `upper: {kind}` for the corner of {' and '.join(corner.runs)}."
            yield Mend(said, (key_edit(raw, at, "upper", kind),))
    for slot in (upper, other):
        place = place_of(kitchen.plan, slot.name)
        if place is not None and place[1] == "upper" and slot.kind is not UpperKind.HOOD:
            yield Mend(f"Take out {slot.name}.", (removed(unit_at(raw, *place)),))


def _narrower_hood(raw: Any, kitchen: KitchenRequest, hood: UnitSlot) -> Iterator[Mend]:
    """A hood that takes less room along the wall, the widest first."""
    place = place_of(kitchen.plan, hood.name)
    assert place is not None, "a hood is a unit of the plan"
    for width in (w for w in HOOD_WIDTHS_M if w < hood.width - TOUCH_M):
        edit = unit_edit(raw, unit_at(raw, *place), "width", width)
        yield Mend(f"Write `width: {width:g}` for {hood.name}.", (edit,))


def _corners(slot: UnitSlot) -> list[RunCorner]:
    """The corners in which the run of a unit ends."""
    return [end.corner for end in (slot.line.left, slot.line.right) if end.corner is not None]


def _cooker_apart(raw: Any, kitchen: KitchenRequest, hood: str) -> Iterator[Mend]:
    """The cooker under a hood, or what stands beside it, changes places with another cabinet of the row."""
    found = place_of(kitchen.plan, hood)
    if found is None:
        return
    run = kitchen.lines[found[0]].run
    over = run.upper[found[2]].over
    k = next((k for k, u in enumerate(run.base) if u.id == over), None)
    if k is None:
        return
    pointer = (*row_at(raw, "runs", run.id), "base")
    for index, side in ((k, "left"), (k + 1, "right")):
        said = f"Add `- doors: {flow_text(BESIDE_COOKER)}` to the {side} of {over}, so that the hood has room."
        yield Mend(said, (inserted((*pointer, index), {"doors": BESIDE_COOKER}),))
    near = [i for i in (k, k - 1, k + 1) if 0 <= i < len(run.base)]
    pairs = [(i, j) for i in near for j in range(len(run.base)) if j != i]
    for i, j in sorted(pairs, key=lambda p: (run.base[p[1]].kind not in SOFT, abs(p[0] - p[1]))):
        yield _exchanged(raw, pointer, run.base, i, j, ", so that the hood has room")


# Runs ------------------------------------------------------------------------------------------------------------


def _of_runs(raw: Any, kitchen: KitchenRequest, problem: Problem) -> Iterator[Mend]:
    """Runs that stand further apart, or away from a wall."""
    names = [line.id for line in _lines_of(kitchen, problem)]
    more = round(problem.excess + 0.02, 2)
    for name in names:
        run, at = kitchen.lines[name].run, row_at(raw, "runs", name)
        if run.faces is not None and run.faces.run in names:
            aisle = round(min(run.faces.aisle + more, MOST_AISLE_M), 2)
            yield Mend(f"Write `aisle: {aisle:g}` for {name}.", (key_edit(raw, (*at, "faces"), "aisle", aisle),))
        if run.faces is not None:
            for shift in (more, -more):
                value = round(run.faces.shift + shift, 2)
                yield Mend(f"Write `shift: {value:g}` for {name}.", (key_edit(raw, (*at, "faces"), "shift", value),))
            least = round(max(run.faces.aisle - more, 0.9), 2)
            yield Mend(f"Write `aisle: {least:g}` for {name}.", (key_edit(raw, (*at, "faces"), "aisle", least),))
    for name in names:
        yield from _away(raw, kitchen, name, more)
    for name in names:
        wider = wider_room(raw, kitchen, kitchen.lines[name], more)
        if wider is not None:
            yield wider
    if not kitchen.plan.compact and problem.kind is ProblemKind.AISLE:
        edit = replaced(("compact",), True) if "compact" in raw else added(("compact",), True)
        yield Mend("Add `compact: true`: aisles of a small kitchen are narrower.", (edit,))
    for name in names:
        if not kitchen.lines[name].at_wall:
            yield smaller_island(raw, kitchen, name)
    for name in names:
        if kitchen.lines[name].is_island:
            yield without_run(raw, kitchen, name)


def _away(raw: Any, kitchen: KitchenRequest, name: str, more: float) -> Iterator[Mend]:
    """A run at a wall that begins later, or ends earlier."""
    line, at = kitchen.lines[name], row_at(raw, "runs", name)
    if not line.at_wall or line.run.length is not None:
        return
    for key, end in (("start", line.left), ("end", line.right)):
        if end.kind is not RunEnd.CORNER:
            value = round(kitchen.plan.length(getattr(line.run, key), kitchen.parameters) + more, 2)
            yield Mend(f"Write `{key}: {value:g}` for {name}.", (key_edit(raw, at, key, value),))


def _without_seats(raw: Any, kitchen: KitchenRequest, run: str) -> Iterator[Mend]:
    numbers = [k for k, seats in enumerate(kitchen.plan.seats) if seats.run == run]
    yield Mend(f"Take out the seats at {run}.", tuple(removed(("seats", k)) for k in reversed(numbers)))
