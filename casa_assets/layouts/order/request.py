"""Resolve a plan and a style into the list of things to build, each with its place."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order import furnish, room_shell, trim, worktops
from casa_assets.layouts.order.build_order import BuildOrder, KitchenRequest
from casa_assets.layouts.order.cabinets import order_unit
from casa_assets.layouts.order.room_shell import HOOD_DEPTH_M
from casa_assets.layouts.order.trim import CORNICE_HEIGHT_M, is_hood_under_cabinet
from casa_assets.layouts.order.worktops import WORKTOP_BREAKS
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import WallLine, build_room
from casa_assets.layouts.plan.runs import CornerPart, RunLine, UnitSlot, base_slots, place_runs, upper_slots
from casa_assets.layouts.plan.style_models import FamilyPresets, StyleModels, check_plan_models
from casa_assets.mesh.outline import penetration_depth
from casa_assets.model.kitchen.floor import PlacedRun, PlacedUnit, RoomWall, RunEnd
from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, Plan, UpperKind
from casa_assets.model.kitchen.style import Style
from casa_assets.model.record import Vec2
from casa_assets.model.registry.rows import RoleRule

MAX_OVERLAP_M = 0.0005
PLAY_M = 0.01  # between what is high and the ceiling over it
LEAST_HOOD_M = 0.4  # height of a hood


def _keep_clear(order: BuildOrder) -> None:
    """Raise PlanConflict if a unit or a table overlaps a column, or the ceiling over a unit is too low."""
    plan, room = order.kitchen.plan, order.kitchen.room
    for placed in room.columns:
        for name, outline in _bodies(order):
            overlap = penetration_depth(placed.outline, outline)
            if overlap > MAX_OVERLAP_M:
                at, expected = ("columns", placed.column.id), f"a place apart from {name}"
                raise PlanConflict(plan.id, at, expected, f"one that is {overlap:.3f} m in it")
    for row in order.kitchen.slots.values():
        for slot in row:
            high = _height(slot, order.models)
            if high is None:
                continue
            depth = HOOD_DEPTH_M if slot.kind is UpperKind.HOOD else slot.depth
            us, vs = (slot.left, slot.right), (-slot.recess, depth - slot.recess)
            over = room.ceiling_over(slot.line.frame, us, vs)
            if over >= high:
                continue
            if not room.slopes:
                least = math.ceil(100 * high) / 100
                raise PlanConflict(plan.id, ("height",), f"at least {least} m, for {slot.name}", f"{over} m", least)
            points = [slot.line.frame.at(u, v)[:2] for u in us for v in vs]
            k = min(range(len(room.slopes)), key=lambda k: min(room.slopes[k].height_at(*p) for p in points))
            expected = f"a ceiling of at least {high:.2f} m over {slot.name}"
            knee = plan.slopes[k].knee + high - over
            raise PlanConflict(plan.id, ("slopes", k), expected, f"{over:.2f} m", knee)


def _bodies(order: BuildOrder) -> Iterator[tuple[str, tuple[Vec2, ...]]]:
    """Name and corners of each unit with its worktop, and of each table with its chairs."""
    for row in order.kitchen.slots.values():
        for slot in row:
            if slot.kind in (BaseKind.GAP, UpperKind.GAP):
                continue
            has_worktop = not slot.is_upper and slot.top <= standard_sizes.WORKTOP_HEIGHT
            front = slot.depth + (standard_sizes.WORKTOP_OVERHANG if has_worktop else 0.0) - slot.recess
            back = -slot.recess - (0.0 if slot.is_upper else slot.line.depth_behind)
            yield slot.name, slot.line.frame.rectangle(slot.left, slot.right, back, front)
    for name, table in order.tables.items():
        yield name, table.outline


def _height(slot: UnitSlot, models: StyleModels) -> float | None:
    """Least height of the ceiling over a unit, metres; None over a gap."""
    if slot.kind in (BaseKind.GAP, UpperKind.GAP):
        return None
    if slot.kind is UpperKind.HOOD and not is_hood_under_cabinet(slot, models):
        return standard_sizes.HOOD_FROM + LEAST_HOOD_M
    if isinstance(slot.unit, BaseUnit) and slot.kind is BaseKind.FRIDGE and not slot.unit.housing:
        return round(models.for_unit(slot.unit).length("height") + PLAY_M, 4)
    is_high = abs(slot.top - standard_sizes.UPPER_TO) < 1e-3
    cornice = CORNICE_HEIGHT_M if is_high and models.style.cabinets.cornice is not None else 0.0
    return round(slot.top + cornice + PLAY_M, 4)


def placed_wall(wall: WallLine, is_open: bool) -> RoomWall:
    """The inner face of a wall."""
    start, end = (wall.frame.at(u, 0.0)[:2] for u in (0.0, wall.length))
    return RoomWall(id=wall.id, start=start, end=end, is_open=is_open)


def placed_run(line: RunLine, slots: Sequence[UnitSlot], fronts: Mapping[str, float]) -> PlacedRun:
    """A run with its units on the floor.

    `fronts`: unit -> distance from the line to the front of fixtures that may reach further than its worktop. Metres.
    """
    corner = line.right.corner
    tall = {s.name for s in slots if s.kind in WORKTOP_BREAKS or s.top > standard_sizes.WORKTOP_HEIGHT}
    return PlacedRun(
        id=line.id,
        origin=(line.frame.x, line.frame.y),
        yaw=round(math.radians(line.frame.turn_deg), 9),
        length=line.length,
        depth_behind=line.depth_behind,
        depth_before=round(line.depth + standard_sizes.WORKTOP_OVERHANG, 4),
        height=standard_sizes.WORKTOP_HEIGHT,
        at_wall=line.at_wall,
        is_island=line.is_island,
        left_end=RunEnd(line.left.kind.value),
        right_end=RunEnd(line.right.kind.value),
        next_run=corner.runs[1] if corner is not None and corner.runs[0] == line.id else None,
        corner_left=line.left.base_length,
        corner_right=line.right.base_length,
        overhang=line.run.overhang,
        units=tuple(
            _unit(slot, slot.name not in tall, fronts)
            for slot in slots
            if not slot.is_upper and not (isinstance(slot.kind, CornerPart) and slot.corner is not None)
        ),
    )


def _unit(slot: UnitSlot, worktop: bool, fronts: Mapping[str, float]) -> PlacedUnit:
    front = slot.depth - slot.recess + (standard_sizes.WORKTOP_OVERHANG if worktop else 0.0)
    if slot.kind is not BaseKind.GAP:
        front = max(front, fronts.get(slot.name, 0.0))
    return PlacedUnit(
        name=slot.name,
        kind=slot.kind.value,
        left=slot.left,
        right=slot.right,
        front=round(front, 4),
        height=slot.top,
        has_worktop=worktop,
    )


def request_kitchen(
    plan: Plan,
    style: Style,
    presets: FamilyPresets,
    given: Mapping[str, float] | None = None,
    closed: bool = False,
    roles: Mapping[str, RoleRule] | None = None,
) -> KitchenRequest:
    """Resolve a plan and a style; closed: open walls are built too; roles: which assets of libraries suit which.

    Raises PlanConflict: the plan does not fit together. StyleConflict: the style names an asset of a library that does
    not suit its role. UnknownId: the style lacks a model, or names one that does not exist.
    """
    lengths = {**plan.defaults, **(given or {})}
    for name in lengths.keys() - plan.parameters.keys():
        raise PlanConflict(plan.id, ("parameters",), f"one of {', '.join(sorted(plan.parameters))}", repr(name))
    models = StyleModels(style, presets, roles or {}, plan.height)
    check_plan_models(plan, models)
    room = build_room(plan, lengths)
    lines = place_runs(plan, room, lengths, models)
    slots: dict[str, tuple[UnitSlot, ...]] = {}
    for name, line in lines.items():
        floor = base_slots(plan, line, models)
        slots[name] = (*floor, *upper_slots(plan, line, {s.name: s for s in floor}, models))
    holes = room_shell.find_holes(plan, room, lengths, {s.name: s for row in slots.values() for s in row})
    slots = room_shell.in_niches(slots, holes)
    order = BuildOrder(KitchenRequest(plan, style, lengths, room, holes, lines, slots, ()), models, closed)
    order.beams = room_shell.beams_of(order.kitchen)
    room_shell.order_shell(order)
    for slot in (s for row in slots.values() for s in row):
        ceiling = room.ceiling_over(slot.line.frame, (slot.left, slot.right), (0.0, HOOD_DEPTH_M))
        order_unit(order, slot, models, ceiling)
    worktops.order_back_panels(order)
    order.seats = furnish.seat_places(plan, lines)
    worktops.order_worktops(order)
    trim.order_backsplash(order)
    trim.order_cornices(order)
    trim.order_curtains(order)
    room_shell.order_skirting(order)
    furnish.order_worktop_items(order)
    furnish.order_seats(order)
    furnish.order_wall_items(order)
    order.tables = furnish.order_tables(order)
    _keep_clear(order)
    furnish.order_lamps(order)
    furnish.order_floor_items(order)
    return replace(order.kitchen, items=tuple(order.items), tables=order.tables)
