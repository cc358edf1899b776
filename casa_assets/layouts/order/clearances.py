"""Keep units and tables clear of columns, and below the slopes of the ceiling."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from casa_assets.errors import PlanConflict
from casa_assets.geometry.outline import penetration_depth
from casa_assets.layouts.order.beams import HOOD_DEPTH_M
from casa_assets.layouts.order.tables import PlacedTable
from casa_assets.layouts.order.trim import CORNICE_HEIGHT_M, is_hood_under_cabinet
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import CeilingSlope, Room
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.units import BaseKind, BaseUnit, UpperKind
from casa_assets.model.record import Vec2

MAX_OVERLAP_M = 0.0005
PLAY_M = 0.01  # between what is high and the ceiling over it
LEAST_HOOD_M = 0.4  # height of a hood


def keep_clear(
    plan: Plan,
    room: Room,
    slots: Mapping[str, Sequence[UnitSlot]],
    tables: Mapping[str, PlacedTable],
    models: StyleModels,
) -> None:
    """Raise PlanConflict if a unit or a table overlaps a column, or the ceiling over a unit is too low."""
    for placed in room.columns:
        for name, outline in _bodies(slots, tables):
            overlap = penetration_depth(placed.outline, outline)
            if overlap > MAX_OVERLAP_M:
                at, expected = ("columns", placed.column.id), f"a place apart from {name}"
                raise PlanConflict(plan.id, at, expected, f"one that is {overlap:.3f} m in it")
    for row in slots.values():
        for slot in row:
            high = _height(slot, models)
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
            k = _lowest(room.slopes, slot.line, us, vs)
            expected = f"a ceiling of at least {high:.2f} m over {slot.name}"
            knee = plan.slopes[k].knee + high - over
            raise PlanConflict(plan.id, ("slopes", k), expected, f"{over:.2f} m", knee)


def _bodies(
    slots: Mapping[str, Sequence[UnitSlot]], tables: Mapping[str, PlacedTable]
) -> Iterator[tuple[str, tuple[Vec2, ...]]]:
    """Name and corners of each unit with its worktop, and of each table with its chairs."""
    for row in slots.values():
        for slot in row:
            if slot.kind in (BaseKind.GAP, UpperKind.GAP):
                continue
            has_worktop = not slot.is_upper and slot.top <= standard_sizes.WORKTOP_HEIGHT
            front = slot.depth + (standard_sizes.WORKTOP_OVERHANG if has_worktop else 0.0) - slot.recess
            back = -slot.recess - (0.0 if slot.is_upper else slot.line.depth_behind)
            ends = ((slot.left, back), (slot.right, back), (slot.right, front), (slot.left, front))
            yield slot.name, tuple(slot.line.frame.at(u, v)[:2] for u, v in ends)
    for name, table in tables.items():
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


def _lowest(slopes: Sequence[CeilingSlope], line: RunLine, us: Vec2, vs: Vec2) -> int:
    """Number of the slope that is lowest over a rectangle on the floor."""
    points = [line.frame.at(u, v)[:2] for u in us for v in vs]
    return min(range(len(slopes)), key=lambda k: min(slopes[k].height_at(*p) for p in points))
