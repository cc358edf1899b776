"""Runs in the frame of the room, as checks of design and of aisles look at them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.layouts.order.worktops import WORKTOP_BREAKS
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import CornerPart, RunLine, UnitSlot
from casa_assets.model.kitchen.floor import PlacedRun, PlacedUnit, RunEnd
from casa_assets.model.kitchen.units import BaseKind


def placed_run(line: RunLine, slots: Sequence[UnitSlot], fronts: Mapping[str, float]) -> PlacedRun:
    """A run with its units on the floor.

    Args:
        slots: of its units.
        fronts: unit -> distance from the line to the front of the fixtures in its place, if they may reach further than
            its worktop. Metres.
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
