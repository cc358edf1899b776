"""Resolve a plan and a style into the list of things to build, each with its place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order import furnish, worktops
from casa_assets.layouts.order.back_panels import order_back_panels
from casa_assets.layouts.order.backsplash import order_backsplash
from casa_assets.layouts.order.beams import HOOD_DEPTH_M, beams_of
from casa_assets.layouts.order.build_order import BuildOrder, OrderItem
from casa_assets.layouts.order.cabinets import order_unit
from casa_assets.layouts.order.clearances import keep_clear
from casa_assets.layouts.order.room_shell import find_holes, in_niches, order_shell, order_skirting
from casa_assets.layouts.order.tables import PlacedTable, order_tables
from casa_assets.layouts.order.trim import order_cornices, order_curtains
from casa_assets.layouts.plan.place import place_runs
from casa_assets.layouts.plan.room import Room, WallHole, build_room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot, base_slots
from casa_assets.layouts.plan.style_models import FamilyPresets, StyleModels, check_plan_models
from casa_assets.layouts.plan.wall_units import upper_slots
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.model.kitchen.units import UpperKind
from casa_assets.model.registry.role import RoleRule


@dataclass(frozen=True)
class KitchenRequest:
    """A plan in metres with a style applied, before anything is built.

    Attributes:
        parameters: values of the plan's parameters, metres.
        room, holes, lines: walls, openings and runs.
        slots: run -> slots of its units, on the floor and on the wall.
        items: everything to build.
        tables: places of dining tables, by id.
    """

    plan: Plan
    style: Style
    parameters: Mapping[str, float]
    room: Room
    holes: tuple[WallHole, ...]
    lines: Mapping[str, RunLine]
    slots: Mapping[str, tuple[UnitSlot, ...]]
    items: tuple[OrderItem, ...]
    tables: Mapping[str, PlacedTable] = field(default_factory=dict)

    def slot(self, name: str) -> UnitSlot:
        """The slot of that name."""
        return next(s for row in self.slots.values() for s in row if s.name == name)


def request_kitchen(
    plan: Plan,
    style: Style,
    presets: FamilyPresets,
    given: Mapping[str, float] | None = None,
    closed: bool = False,
    roles: Mapping[str, RoleRule] | None = None,
) -> KitchenRequest:
    """Resolve a plan and a style.

    Args:
        presets: parameters of all presets of all families, and sizes of the assets of libraries.
        given: values of the plan's parameters; those missing have their defaults. closed: open walls are built too.
        roles: which assets of libraries suit which role.
    Raises:
        PlanConflict: the plan does not fit together.
        StyleConflict: the style names an asset of a library that does not suit its role.
        UnknownId: the style lacks a model, or names one that does not exist.
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
    holes = find_holes(plan, room, lengths, {s.name: s for row in slots.values() for s in row})
    slots = in_niches(slots, holes)
    every = {s.name: s for row in slots.values() for s in row}
    order = BuildOrder()
    beams = beams_of(plan, style, room, lines, slots)
    order_shell(order, room, holes, models, closed, beams)
    for row in slots.values():
        for slot in row:
            ceiling = room.ceiling_over(slot.line.frame, (slot.left, slot.right), (0.0, HOOD_DEPTH_M))
            order_unit(order, slot, models, ceiling)
    order_back_panels(order, lines, slots, models)
    seats = furnish.seat_places(plan, lines)
    worktops.order_worktops(order, lines, slots, seats, models)
    order_backsplash(order, lines, slots, holes, models)
    order_cornices(order, lines, slots, models)
    order_curtains(order, [h for h in holes if h.wall in room.walls], models)
    order_skirting(order, room, holes, lines, slots, [c.runs for c in plan.corners], models, closed)
    furnish.order_worktop_items(order, plan, every, models)
    furnish.order_seats(order, lines, seats, models)
    furnish.order_wall_items(order, plan, room, lengths, every, holes, models)
    tables = order_tables(order, plan, room, lengths, models)
    keep_clear(plan, room, slots, tables, models)
    hoods = [s for s in every.values() if s.kind is UpperKind.HOOD]
    furnish.order_lamps(order, plan, room, lines, tables, models, beams, hoods)
    furnish.order_floor_items(order, plan, room, lengths, models)
    return KitchenRequest(plan, style, lengths, room, holes, lines, slots, tuple(order.items), tables)
