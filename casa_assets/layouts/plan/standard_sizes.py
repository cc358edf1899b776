"""Standard dimensions of kitchens, metres, and the division of a row's length among its units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from casa_assets.model.kitchen.plan import BaseKind, BaseUnit, UpperKind, UpperUnit

if TYPE_CHECKING:
    from casa_assets.layouts.plan.style_models import StyleModels


WIDTH_STEP_M = 0.001  # widths are whole millimetres


@dataclass(frozen=True)
class WidthRange:
    """Least and greatest width of a unit, metres."""

    minimum: float
    maximum: float

    @property
    def usual(self) -> float:
        """Width where the row leaves a choice."""
        return round((self.minimum + self.maximum) / 2, 3)


def share_widths(spans: Sequence[WidthRange], available: float) -> list[float] | None:
    """Widths whose sum is `available`, or the maximum widths if their sum is less; None if the minimum does not fit.

    Every unit takes the same share of its range.
    """
    minimum, maximum = sum(s.minimum for s in spans), sum(s.maximum for s in spans)
    if minimum > available + WIDTH_STEP_M / 2:
        return None
    share = 1.0 if maximum <= available or maximum <= minimum else (available - minimum) / (maximum - minimum)
    widths = [round(s.minimum + share * (s.maximum - s.minimum), 3) for s in spans]
    rest = round(min(available, maximum) - sum(widths), 3)
    for i in sorted(range(len(spans)), key=lambda k: spans[k].minimum - spans[k].maximum):
        if rest and spans[i].maximum > spans[i].minimum:
            widths[i] = round(widths[i] + rest, 3)
            break
    return widths


# Ref: trade sizes of kitchens: worktops 0.9 to 0.92 m high and 0.635 to 0.65 m deep, 0.45 m up to the wall units.
WORKTOP_HEIGHT = 0.92
WORKTOP_DEPTH = 0.65
BASE_DEPTH = 0.6
UPPER_DEPTH = 0.35
UPPER_FROM = 1.38
UPPER_TO = 2.26
ISLAND_DEPTH = 0.75
# How far a worktop stands out before the fronts, and what lies between fronts and the inside of a corner, so that
# handles of both runs pass each other.
WORKTOP_OVERHANG = WORKTOP_DEPTH - BASE_DEPTH
CORNER_CLEARANCE = 0.72
UPPER_CORNER_CLEARANCE = 0.48
CORNER_DOOR = 0.45
UPPER_CORNER_DOOR = 0.38
DIAGONAL, UPPER_DIAGONAL = 0.92, 0.66
# A refrigerator's door turns with its handle outside its own width: room beside it.
FRIDGE_SIDE = 0.07
HOUSING_SIDE = 0.06
# Room that the doors of a library's refrigerator may take beside it as they turn, and the gap to what stands there; a
# door that reaches farther opens less wide.
MAX_DOOR_REACH, DOOR_PLAY = 0.1, 0.015
END_PANEL = 0.02
BOARD_THICKNESS = 0.018  # of the boards round a niche
# Width that units leave beside their appliances, both sides together.
PLAY_BESIDE: Mapping[BaseKind | UpperKind, float] = {
    BaseKind.RANGE: 0.006,
    BaseKind.DISHWASHER: 0.004,
    BaseKind.OVEN: 0.005,
}
NICHE_PLAY = 0.002  # gap between the sides of a niche and an asset of a library that they hold, both together
TOP_PLAY = 0.004  # gap between a dishwasher and the worktop over it
# Ref: NKBA kitchen planning guideline 18: 24 inches over the cooking surface to what does not burn.
HOOD_FROM = 1.62
CANOPY_LEDGE = 0.012
WIDEST_SINGLE_DOOR, WIDEST_SINK_DOOR = 0.5, 0.549  # a wider cabinet, or a wider one below a sink, has two doors


def base_span(unit: BaseUnit, models: StyleModels) -> WidthRange:
    """Least and greatest width of a unit on the floor."""
    fixed = _stated_span(unit) or _span_of_model(unit, models)
    return (
        fixed
        or {
            BaseKind.DOORS: WidthRange(0.4, 0.9),
            BaseKind.DRAWERS: WidthRange(0.4, 0.9),
            BaseKind.SHELF: WidthRange(0.3, 0.6),
            BaseKind.PANEL: WidthRange(END_PANEL, END_PANEL),
            BaseKind.FILLER: WidthRange(0.03, 0.12),
            BaseKind.GAP: WidthRange(0.3, 1.0),
            BaseKind.ISLAND: WidthRange(1.4, 2.2),
            BaseKind.PANTRY: WidthRange(0.45, 0.6),
            BaseKind.MICROWAVE: WidthRange(0.6, 0.6),
        }[unit.kind]
    )


def _stated_span(unit: BaseUnit | UpperUnit) -> WidthRange | None:
    if isinstance(unit.width, tuple):
        return WidthRange(*unit.width)
    return None if unit.width is None else WidthRange(unit.width, unit.width)


def island_columns(width: float) -> tuple[str, ...]:
    """Contents of the columns of an island of a width, from left to right: drawers or doors."""
    return ("drawers", "doors", "drawers") if width > 1.55 else ("drawers", "doors")


def room_beside(unit: BaseUnit | UpperUnit, is_library: bool, sweep: float = 0.0) -> float:
    """Width of a unit that its appliance leaves on both sides together, metres; `sweep`: of its doors to the side.

    The front of an asset of a library does not cover the sides of a niche.
    """
    if unit.kind is BaseKind.FRIDGE:
        assert isinstance(unit, BaseUnit)
        side = HOUSING_SIDE if unit.housing else FRIDGE_SIDE
        return 2 * (max(side, min(sweep, MAX_DOOR_REACH) + DOOR_PLAY) if is_library else side)
    if is_library and unit.kind in (BaseKind.OVEN, BaseKind.MICROWAVE, UpperKind.MICROWAVE):
        return 2 * BOARD_THICKNESS + NICHE_PLAY
    return PLAY_BESIDE.get(unit.kind, 0.0)


def _span_of_model(unit: BaseUnit, models: StyleModels) -> WidthRange | None:
    if unit.kind in (BaseKind.RANGE, BaseKind.DISHWASHER, BaseKind.FRIDGE, BaseKind.OVEN):
        model = models.for_unit(unit)
        beside = room_beside(unit, model.choice.is_library, model.params.get("sweep", 0.0))
        width = round(model.length("width") + beside, 3)
        return WidthRange(width, width)
    if unit.kind is BaseKind.SINK:
        minimum = round(models.for_unit(unit).length("width") + 0.08, 2)
        return WidthRange(max(0.6, minimum), max(0.9, minimum + 0.1))
    if unit.kind is BaseKind.HOB:
        minimum = round(models.for_unit(unit).length("width") + 0.06, 2)
        return WidthRange(max(0.6, minimum), max(0.9, minimum))
    return None


def upper_span(unit: UpperUnit, models: StyleModels) -> WidthRange:
    """Least and greatest width of a unit on the wall that is not centred over another."""
    if stated := _stated_span(unit):
        return stated
    if unit.kind is UpperKind.HOOD:
        hood = models.for_unit(unit)
        # The ledge of a canopy stands out beside it.
        width = hood.length("width") + (2 * CANOPY_LEDGE if hood.params.get("form") == "canopy" else 0.0)
        return WidthRange(width, width)
    return {
        UpperKind.DOORS: WidthRange(0.35, 0.9),
        UpperKind.GLASS: WidthRange(0.35, 0.9),
        UpperKind.SHELF: WidthRange(0.3, 0.6),
        UpperKind.BOARDS: WidthRange(0.5, 1.2),
        UpperKind.FILLER: WidthRange(0.03, 0.12),
        UpperKind.GAP: WidthRange(0.05, 2.0),
        UpperKind.MICROWAVE: WidthRange(0.6, 0.6),
    }[unit.kind]
