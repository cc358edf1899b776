"""Mends of what keeps a plan from being made into a kitchen: rows too long or too short, things beyond a wall."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.furnish import SEAT_SPACING_M
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.place import place_runs
from casa_assets.layouts.plan.room import Room, build_room
from casa_assets.layouts.plan.rows import WidthRange, share_widths
from casa_assets.layouts.plan.runs import RunLine, UnitSlot, base_slots, room_at_walls
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.furnishing import MOST_SEATS
from casa_assets.model.kitchen.plan import WINDOW_SILL_M, OpeningKind, Plan, PlanOpening, Run
from casa_assets.model.kitchen.units import BaseKind, UpperUnit
from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.fault import Mend, added, removed, replaced
from casa_assets.pipeline.plans.rows import LEAST_ADDED, RowChange, shrunk, widened
from casa_assets.pipeline.plans.written import inserted, key_edit, row_at, unit_at, unit_edit, without_key
from casa_assets.registry.edit import Edit, flow_text

LEAST_HOOD_M = 0.6  # width
# What has to remain of a wall beside an opening; the sill of a window reaches beyond its casing.
FROM_END_M, WINDOW_FROM_END_M = 0.05, 0.13
BELOW_CEILING_M = 0.1
KNEE_MOST_M, PITCH_MOST_DEG = 3.0, 70.0  # bounds of a slope


def mend_of(
    conflict: PlanConflict, raw: Any, plan: Plan, models: StyleModels, lengths: Mapping[str, float]
) -> Mend | None:
    """The nearest mend of a conflict; None where there is none."""
    at = conflict.pointer
    if at[:1] == ("openings",) and len(at) == 2:
        return _opening(raw, plan, str(at[1]), models, lengths)
    if at == ("height",) and conflict.wanted_m is not None:
        height = conflict.wanted_m
        return Mend(f"Write `height: {height:g}`.", (key_edit(raw, (), "height", height),))
    if at[0] == "seats" and len(at) == 2:
        return _joined_seats(plan, int(at[1]))
    if at == ("seats",):
        return _seats(raw, plan, lengths, models)
    if at[-1:] == ("model",):
        return _without_model(raw, at, models)
    if at[:1] == ("columns",) and len(at) > 1:
        column = row_at(raw, "columns", str(at[1]))
        return Mend(f"Take out the column {at[1]}: it stands in the way.", (removed(column),))
    if at[:1] == ("slopes",) and len(at) > 1:
        return _slope(plan, int(at[1]), conflict)
    if at[:1] == ("lamps",) and len(at) == 2:
        return Mend("Take out these lamps.", (removed(at),))
    if at[:1] == ("corners",) and at[2:] == ("runs",):
        return _turned_corner(plan, int(at[1]))
    if at[:1] == ("corners",) and len(at) == 2:
        return Mend("Take out this corner: the two runs stand at walls that meet aslant.", (removed(at),))
    if at[:1] == ("runs",) and len(at) > 1:
        run = next(r for r in plan.runs if r.id == at[1])
        if at[2:3] == ("base",) and len(at) == 3:
            return _base(raw, plan, run, models, lengths)
        if at[2:3] == ("upper",):
            return _upper(raw, plan, run, at[3:], models, lengths)
        return _place(raw, run, at[2:])
    return None


def _without_model(raw: Any, at: KeyPath, models: StyleModels) -> Mend:
    """Take out a model that does not suit: the style's stands there then, or nothing where it has none of that name."""
    if at[0] == "runs":
        unit = unit_at(raw, str(at[1]), str(at[2]), int(at[3]))
        return Mend("Take out 'model': the style's stands there.", (without_key(raw, unit, "model"),))
    row = row_at(raw, str(at[0]), str(at[1]))
    if models.has(str(at[1])):
        return Mend("Take out 'model': the style's stands there.", (removed((*row, "model")),))
    return Mend(f"Take out {str(at[1])!r}.", (removed(row),))


def _slope(plan: Plan, k: int, conflict: PlanConflict) -> Mend:
    """A slope that is too low over something begins higher, one that reaches too far is steeper; else it goes."""
    slope, at, wanted = plan.slopes[k], conflict.pointer, conflict.wanted_m
    if at[2:] == () and wanted is not None:
        knee = math.ceil(100 * wanted + 0.5) / 100
        if knee <= min(KNEE_MOST_M, plan.height - BELOW_CEILING_M):
            return Mend(f"Write `knee: {knee:g}`.", (added_or_replaced(plan, k, "knee", knee),))
    elif at[2:] == ("pitch_deg",) and wanted is not None:
        pitch = math.ceil(math.degrees(math.atan2(plan.height - slope.knee, max(wanted, 1e-6))) * 10) / 10
        if wanted > 0.0 and pitch <= PITCH_MOST_DEG:
            return Mend(f"Write `pitch_deg: {pitch:g}`.", (added_or_replaced(plan, k, "pitch_deg", pitch),))
    elif at[2:] == ("knee",):
        knee = round(plan.height - 2 * BELOW_CEILING_M, 2)
        return Mend(f"Write `knee: {knee:g}`.", (added_or_replaced(plan, k, "knee", knee),))
    return Mend("Take out this slope.", (removed(("slopes", k)),))


def added_or_replaced(plan: Plan, k: int, key: str, value: float) -> Edit:
    """The edit that sets a number of a slope, which may be the usual one that the file does not state."""
    at = ("slopes", k, key)
    return replaced(at, value) if key in plan.slopes[k].model_fields_set else added(at, value)


def _lines(plan: Plan, lengths: Mapping[str, float], models: StyleModels) -> dict[str, RunLine]:
    """All runs in the room, whether or not their units fit: islands before the middle of a run, not before a unit."""
    runs = [
        run.replace(faces=run.faces.replace(in_front_of=None)) if run.faces and run.faces.in_front_of else run
        for run in plan.runs
    ]
    return place_runs(plan.replace(runs=tuple(runs)), build_room(plan, lengths), lengths, models)


def row_edits(raw: Any, run: str, row: str, changes: Sequence[RowChange]) -> tuple[Edit, ...]:
    """The edits of changes of a row: widths first, then what is taken out, from the right."""
    widths = [unit_edit(raw, unit_at(raw, run, row, c.index), "width", list(c.width)) for c in changes if c.width]
    out = [removed(unit_at(raw, run, row, c.index)) for c in sorted(changes, key=lambda c: -c.index) if c.width is None]
    return (*widths, *out)


def said_of(units: Sequence[Any], changes: Sequence[RowChange]) -> str:
    """Changes as words."""
    out = [units[c.index].id for c in changes if c.width is None]
    narrow = [f"{units[c.index].id} {flow_text(list(c.width))}" for c in changes if c.width]
    parts = [f"take out {', '.join(out)}" if out else "", f"write {', '.join(narrow)}" if narrow else ""]
    text = " and ".join(part for part in parts if part)
    return text[:1].upper() + text[1:] + "."


def _base(raw: Any, plan: Plan, run: Run, models: StyleModels, lengths: Mapping[str, float]) -> Mend | None:
    line = _lines(plan, lengths, models)[run.id]
    spans = [standard_sizes.base_span(u, models) for u in run.base]
    available = round(line.length - line.left.base_length - line.right.base_length - room_at_walls(line), 4)
    if share_widths(spans, available) is None:
        # What opens away from a corner stays, so that what comes next does not run into the other row.
        ends = ((line.left, 0), (line.right, len(run.base) - 1))
        kept = [k for end, k in ends if end.kind is RunEnd.CORNER and run.base[k].kind is BaseKind.DOORS]
        changes = shrunk(run.base, spans, available, kept=kept) or shrunk(run.base, spans, available)
        if changes is None:
            return _longer(raw, plan, run, sum(s.minimum for s in spans) - available, lengths)
        return Mend(said_of(run.base, changes), row_edits(raw, run.id, "base", changes))
    rest = round(available - sum(s.maximum for s in spans), 3)
    return _filled(raw, run, spans, rest)


def _filled(raw: Any, run: Run, spans: list[WidthRange], rest: float) -> Mend:
    """Widen units, then add cabinets, until a row fills its wall."""
    changes, left = widened(run.base, spans, rest)
    edits = list(row_edits(raw, run.id, "base", changes))
    said = [said_of(run.base, changes)] if changes else []
    tail = len(run.base)
    while tail and run.base[tail - 1].kind in (BaseKind.FILLER, BaseKind.PANEL, BaseKind.FRIDGE):
        tail -= 1
    at = (*row_at(raw, "runs", run.id), "base", tail)
    count = -(-int(left * 1000) // 900) if left > 0.24 else 0
    for _ in range(count):
        width = [LEAST_ADDED, round(max(left / count, LEAST_ADDED), 3)]
        edits.append(inserted(at, {"doors": width}) if run.base else key_edit(raw, at[:-2], "base", [{"doors": width}]))
        said.append(f"Add `- doors: {flow_text(width)}`.")
    return Mend(" ".join(said), tuple(edits))


def _longer(raw: Any, plan: Plan, run: Run, more: float, lengths: Mapping[str, float]) -> Mend | None:
    """Where nothing can be given up: all of the wall, or a longer wall."""
    at = row_at(raw, "runs", run.id)
    for key, none in (("length", None), ("end", 0.0), ("start", 0.0)):
        if getattr(run, key) not in (none, 0.0):
            return Mend(f"Take out '{key}' of {run.id}.", (removed((*at, key)),))
    wall = next((w for w in plan.walls if w.id == run.on), None)
    if wall is None:
        return None
    own = [w for w in plan.walls if w.length == wall.length] if isinstance(wall.length, str) else []
    if own and isinstance(wall.length, str) and wall.length in plan.parameters:
        parameter = plan.parameters[wall.length]
        low = round(parameter.default + more + 0.005, 2)
        value = [low, low, max(low, parameter.high)]
        return Mend(f"Write {wall.length}: {flow_text(value)}.", (replaced(("parameters", wall.length), value),))
    now = next(w for w in build_room(plan, lengths).walls if w.id == wall.id).length
    length = round(now + more + 0.005, 2)
    return Mend(
        f"Write `length: {length:g}` for {wall.id}.", (key_edit(raw, row_at(raw, "walls", wall.id), "length", length),)
    )


def _upper(
    raw: Any, plan: Plan, run: Run, rest: tuple[str | int, ...], models: StyleModels, lengths: Mapping[str, float]
) -> Mend | None:
    line = _lines(plan, lengths, models)[run.id]
    below = {s.name: s for s in base_slots(plan, line, models)}
    ordered = _in_order(run, below)
    at = (*row_at(raw, "runs", run.id), "upper")
    if ordered is not None:
        units = _raw_units(raw, run)
        made = [units[k] for k in ordered]
        return Mend("Write wall units in the order of what is below them.", (replaced(at, made),))
    if rest:
        k = next(k for k, u in enumerate(run.upper) if u.id == rest[0])
        return _fixed_unit(raw, run, k, line, below, models)
    # The groups between two fixed units, as `upper_slots` has them.
    here, end = line.left.upper_length, round(line.length - line.right.upper_length, 4)
    group: list[int] = []
    for k, unit in enumerate([*run.upper, None]):
        if unit is not None and unit.over is None:
            group.append(k)
            continue
        left, right = end, end
        if unit is not None and unit.over is not None:
            width = _fixed_width(unit, below[unit.over], models)
            left, right = below[unit.over].middle - width / 2, below[unit.over].middle + width / 2
        spans = [standard_sizes.upper_span(run.upper[i], models) for i in group]
        if share_widths(spans, left - here) is None:
            changes = shrunk([run.upper[i] for i in group], spans, max(left - here, 0.0), keep_last=0)
            if changes is None:
                return None
            moved = [RowChange(group[c.index], c.width) for c in changes]
            return Mend(said_of(run.upper, moved), row_edits(raw, run.id, "upper", moved))
        group, here = [], right
    return None


def _raw_units(raw: Any, run: Run) -> list[Any]:
    here = raw
    for step in (*row_at(raw, "runs", run.id), "upper"):
        here = here[step]
    return list(here)


def _in_order(run: Run, below: Mapping[str, Any]) -> list[int] | None:
    """Order of wall units in which those over units come as these do; None where they are in it."""
    fixed = [k for k, u in enumerate(run.upper) if u.over in below]
    wanted = sorted(fixed, key=lambda k: below[str(run.upper[k].over)].middle)
    if wanted == fixed:
        return None
    free = [k for k in range(len(run.upper)) if k not in fixed]
    out: list[int] = []
    for k in range(len(run.upper)):
        out.append(wanted.pop(0) if k in fixed else free.pop(0))
    return out


def _fixed_unit(
    raw: Any, run: Run, k: int, line: RunLine, below: Mapping[str, Any], models: StyleModels
) -> Mend | None:
    """A wall unit over another that reaches beyond its place: narrower, or taken out."""
    unit = run.upper[k]
    slot = below[str(unit.over)]
    start = line.left.upper_length
    for j, other in enumerate(run.upper[:k]):
        under = below.get(str(other.over))
        if under is None:
            continue
        start = max(start, round(under.middle + _fixed_width(other, under, models) / 2, 4))
        wide = _fixed_width(other, under, models) > under.width + 0.001
        if start > slot.middle - _fixed_width(unit, slot, models) / 2 and wide and other.kind.value != "hood":
            at = unit_at(raw, run.id, "upper", j)
            return Mend(
                f"Take the width of {other.id} out: it is as wide as {other.over}.", (without_key(raw, at, "width"),)
            )
    end = round(line.length - line.right.upper_length, 4)
    room = round(2 * min(slot.middle - start, end - slot.middle), 3)
    at = unit_at(raw, run.id, "upper", k)
    if room >= (LEAST_HOOD_M if unit.kind.value == "hood" else 0.25):
        return Mend(f"Write `width: {room:g}` for {unit.id}.", (unit_edit(raw, at, "width", room),))
    others = [j for j, u in enumerate(run.upper) if j < k and u.over in below and u.kind.value != "hood"]
    if unit.kind.value == "hood" and others:
        j = others[-1]
        return Mend(
            f"Take out {run.upper[j].id}, which is where the hood goes.", (removed(unit_at(raw, run.id, "upper", j)),)
        )
    if unit.kind.value == "hood" and (room < standard_sizes.upper_span(unit, models).usual):
        moved = _away_from_end(raw, run, str(unit.over))
        if moved:
            return moved
    return Mend(f"Take out {unit.id}.", (removed(at),))


def _fixed_width(unit: UpperUnit, below: UnitSlot, models: StyleModels) -> float:
    """Width of a wall unit that is over another, metres."""
    width = below.width if unit.width is None and unit.kind.value != "hood" else None
    return width or standard_sizes.upper_span(unit, models).usual


def _away_from_end(raw: Any, run: Run, name: str) -> Mend | None:
    """Change places of a cooker at the end of a row with the unit beside it, so that its hood has room."""
    k = next((k for k, u in enumerate(run.base) if u.id == name), None)
    if k is None or len(run.base) < 2:
        return None
    other = k + 1 if k < len(run.base) / 2 else k - 1
    beside = run.base[other]
    if beside.kind not in (BaseKind.DOORS, BaseKind.DRAWERS):
        return None
    at = (*row_at(raw, "runs", run.id), "base")
    here = raw
    for step in at:
        here = here[step]
    units = list(here)
    units[k], units[other] = units[other], units[k]
    return Mend(f"Let {name} and {beside.id} change places, so that the hood has room.", (replaced(at, units),))


def _place(raw: Any, run: Run, rest: tuple[str | int, ...]) -> Mend | None:
    at = row_at(raw, "runs", run.id)
    if rest == ("length",):
        return Mend(f"Take out 'length' of {run.id}.", (removed((*at, "length")),))
    edits = tuple(removed((*at, key)) for key in ("start", "end") if getattr(run, key) != 0.0)
    return Mend(f"Take out 'start' and 'end' of {run.id}.", edits) if edits else None


def _opening(raw: Any, plan: Plan, name: str, models: StyleModels, lengths: Mapping[str, float]) -> Mend | None:
    """An opening that reaches beyond its wall: moved, then made smaller, then taken out."""
    opening = next(o for o in plan.openings if o.id == name)
    room = build_room(plan, lengths)
    wall = next(w for w in room.walls if w.id == opening.wall)
    at = row_at(raw, "openings", name)
    edits: list[Edit] = []
    said: list[str] = []

    def put(key: str, value: float) -> None:
        edits.append(key_edit(raw, at, key, value))
        said.append(f"{key}: {value:g}")

    top = room.height_of(wall) - BELOW_CEILING_M
    if round(opening.bottom + opening.height, 4) > top:
        _lowered(opening, top, put)
    from_end = WINDOW_FROM_END_M if opening.kind is OpeningKind.WINDOW else FROM_END_M
    most = round(wall.length - 2 * from_end, 3)
    width = opening.width
    if width > most:
        if most < 0.4:
            return Mend(f"Take out {name}.", (removed(at),))
        width = most
        put("width", width)
    if opening.at is not None:
        middle = plan.length(opening.at, lengths)
        fits = round(min(max(middle, from_end + width / 2), wall.length - from_end - width / 2), 3)
        if fits != middle:
            put("at", fits)
    else:
        return _over_unit(raw, plan, opening, room, wall.id, models, lengths, edits)
    if not edits and room.slopes:
        return Mend(f"Take out {name}: the ceiling is too low there.", (removed(at),))
    return Mend(f"Write `{', '.join(said)}`.", tuple(edits)) if edits else None


def _lowered(opening: PlanOpening, top: float, put: Callable[[str, float], None]) -> None:
    if opening.kind is not OpeningKind.WINDOW:
        put("height", round(top, 3))
        return
    sill = round(top - opening.height, 3)
    if sill < 0.9:
        put("height", round(max(top - WINDOW_SILL_M, 0.4), 3))
        sill = WINDOW_SILL_M
    put("sill", min(sill, opening.sill))


def _over_unit(
    raw: Any,
    plan: Plan,
    opening: PlanOpening,
    room: Room,
    wall_id: str,
    models: StyleModels,
    lengths: Mapping[str, float],
    edits: list[Edit],
) -> Mend | None:
    """An opening over a unit whose middle is too near to the end of its wall, or which stands at another."""
    wall = next(w for w in room.walls if w.id == wall_id)
    at = row_at(raw, "openings", opening.id)
    run = next((r for r in plan.runs if any(u.id == opening.over for u in (*r.base, *r.upper))), None)
    if run is not None and run.on is not None and run.on != wall_id:
        return Mend(f"Write `wall: {run.on}`, where {opening.over} stands.", (*edits, replaced((*at, "wall"), run.on)))
    lines = _lines(plan, lengths, models)
    slots = {s.name: s for line in lines.values() for s in base_slots(plan, line, models)}
    if opening.over not in slots:
        return Mend(f"Take out {opening.id}.", (removed(at),))
    slot = slots[opening.over]
    middle = wall.frame.to_local(*slot.line.frame.at(slot.middle, 0.0)[:2])[0]
    width = round(2 * min(middle - FROM_END_M, wall.length - FROM_END_M - middle) - 0.002, 3)
    if width >= 0.4:
        return Mend(f"Write `width: {width:g}`.", (*edits, key_edit(raw, at, "width", width)))
    return Mend(f"Take out {opening.id}.", (removed(at),)) if not edits else Mend("Make it lower.", tuple(edits))


def _turned_corner(plan: Plan, k: int) -> Mend:
    """A corner of two runs in the wrong order, or of two that do not meet."""
    first, second = plan.corners[k].runs
    on = {run.id: run.on for run in plan.runs}
    walls = [wall.id for wall in plan.walls]
    meets = on[first] is None or on[second] is None or _follows(walls, on[second], on[first])
    known = any(corner.runs == (second, first) for corner in plan.corners)
    if meets and not known:
        runs = [second, first]
        return Mend(f"Write `runs: {flow_text(runs)}`.", (replaced(("corners", k, "runs"), runs),))
    return Mend(f"Take out this corner: {first} and {second} do not meet.", (removed(("corners", k)),))


def _follows(walls: Sequence[str], first: str | None, second: str | None) -> bool:
    """True if a wall is the next one, clockwise."""
    return first in walls and walls[(walls.index(str(first)) + 1) % len(walls)] == second


def _joined_seats(plan: Plan, k: int) -> Mend:
    """Two rows of seats at one run: all of them in the first."""
    run = plan.seats[k].run
    first = next(j for j, seats in enumerate(plan.seats) if seats.run == run)
    count = min(plan.seats[first].count + plan.seats[k].count, MOST_SEATS)
    edits = (replaced(("seats", first, "count"), count), removed(("seats", k)))
    return Mend(f"Write `count: {count}` for {run}, and take out the second row.", edits)


def _seats(raw: Any, plan: Plan, lengths: Mapping[str, float], models: StyleModels) -> Mend | None:
    lines = _lines(plan, lengths, models)
    edits, said = [], []
    for k in range(len(plan.seats) - 1, -1, -1):
        seats = plan.seats[k]
        line = lines[seats.run]
        most = int((line.length - (0.45 if line.run.joins else 0.0) + 0.001) / SEAT_SPACING_M)
        if most >= seats.count:
            continue
        edits.append(replaced(("seats", k, "count"), most) if most else removed(("seats", k)))
        said.append(f"Write `count: {most}`." if most else f"Take out the seats at {seats.run}.")
    return Mend(" ".join(said), tuple(edits)) if edits else None
