"""Lay out the wall units of a run: over units below, between fixed ones, and round corners."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from casa_assets.errors import PlanConflict
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.rows import share_widths
from casa_assets.layouts.plan.runs import TOUCH_M, CornerPart, RunLine, UnitSlot, corner_slots, describe_units
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.units import RunSide, UpperKind, UpperUnit


def upper_slots(plan: Plan, line: RunLine, base: Mapping[str, UnitSlot], models: StyleModels) -> tuple[UnitSlot, ...]:
    """The units on the wall from left to right. Raises PlanConflict."""
    pointer = ("runs", line.id, "upper")
    slots: list[UnitSlot] = [*corner_slots(line, RunSide.LEFT, standard_sizes.UPPER_TO, is_upper=True)]
    at, end = line.left.upper_length, round(line.length - line.right.upper_length, 4)
    flexible: list[UpperUnit] = []
    first = True
    for unit in line.run.upper:
        if unit.over is None:
            flexible.append(unit)
            continue
        if unit.over not in base:
            raise PlanConflict(plan.id, (*pointer, unit.id), f"a unit below of {', '.join(base)}", repr(unit.over))
        below = base[unit.over]
        width = below.width if unit.width is None and unit.kind is not UpperKind.HOOD else None
        width = width or standard_sizes.upper_span(unit, models).usual
        left, right = round(below.middle - width / 2, 4), round(below.middle + width / 2, 4)
        if left < at - TOUCH_M or right > end + TOUCH_M:
            raise PlanConflict(
                plan.id, (*pointer, unit.id), f"a unit between {at:.3f} and {end:.3f} m", f"{left:.3f} to {right:.3f} m"
            )
        slots += _between(plan, line, flexible, at, left, models, first and line.left.upper_length == 0.0)
        slots.append(_upper_slot(line, unit, left, right))
        flexible, at, first = [], right, False
    slots += _between(plan, line, flexible, at, end, models, not first and line.right.upper_length > 0.0)
    slots += corner_slots(line, RunSide.RIGHT, standard_sizes.UPPER_TO, is_upper=True)
    return tuple(s for s in slots if s.kind is not UpperKind.GAP and not _is_lone_strip(s, slots))


def _is_lone_strip(slot: UnitSlot, row: list[UnitSlot]) -> bool:
    """True if a strip in a corner closes no gap, since nothing hangs next to it."""
    if slot.kind is not CornerPart.FILLER:
        return False
    beside = [s for s in row if s is not slot and s.kind is not UpperKind.GAP]
    return not any(min(abs(s.left - slot.right), abs(s.right - slot.left)) < TOUCH_M for s in beside)


def _between(
    plan: Plan, line: RunLine, units: list[UpperUnit], left: float, right: float, models: StyleModels, to_right: bool
) -> Iterator[UnitSlot]:
    """Units that share what lies between two fixed ones; what is left over stays away from corners, else outside."""
    spans = [standard_sizes.upper_span(u, models) for u in units]
    widths = share_widths(spans, right - left)
    if widths is None:
        message = f"units that need at most {right - left:.3f} m"
        got = f"at least {sum(s.minimum for s in spans):.3f} m ({describe_units(tuple(units), spans)})"
        raise PlanConflict(plan.id, ("runs", line.id, "upper"), message, got)
    at = round(right - sum(widths), 4) if to_right else left
    for unit, width in zip(units, widths, strict=True):
        yield _upper_slot(line, unit, at, round(at + width, 4))
        at = round(at + width, 4)


def _upper_slot(line: RunLine, unit: UpperUnit, left: float, right: float) -> UnitSlot:
    hinge = unit.hinge
    if hinge is None:
        near_corner = (
            left - line.left.upper_length < 0.05 and line.left.kind is RunEnd.CORNER and line.left.upper_length > 0
        )
        ends_at_wall = line.length - right < 0.05
        hinge = RunSide.RIGHT if near_corner or ends_at_wall else RunSide.LEFT
    low, high = standard_sizes.UPPER_FROM, standard_sizes.UPPER_TO
    if unit.height is not None:
        low = round(high - unit.height, 4)
    return UnitSlot(
        unit.id, unit.kind, line, left, right, standard_sizes.UPPER_DEPTH, low, high, unit=unit, hinge=hinge
    )
