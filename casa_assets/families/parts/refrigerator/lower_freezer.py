"""The freezer under a refrigerator: drawers that are pulled out, or doors with baskets behind them."""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.parts.appliance.look import ApplianceLook
from casa_assets.families.parts.refrigerator.case import DIVIDER_THICKNESS, Compartment, compartment
from casa_assets.families.parts.refrigerator.door import FridgeDoor, hang_fridge_door
from casa_assets.families.parts.refrigerator.furnishing import center_gap, fill_with_baskets
from casa_assets.families.parts.refrigerator.sliding_parts import add_pull_out


class FreezerFront(StrEnum):
    """Drawers or doors of the freezer below."""

    DRAWER = "drawer"
    TWO_DRAWERS = "two_drawers"
    DOOR = "door"
    TWO_DOORS = "two_doors"


def lower_compartments(
    kind: FreezerFront, left: float, right: float, bottom: float, top: float, depth: float
) -> list[Compartment]:
    """Compartments of a freezer between planes of the case's inside, metres; from left to right, from below."""
    middle = (left + right) / 2
    if kind is FreezerFront.TWO_DOORS:
        return [
            compartment("freezer_left", left, middle - DIVIDER_THICKNESS / 2, bottom, top, depth),
            compartment("freezer_right", middle + DIVIDER_THICKNESS / 2, right, bottom, top, depth),
        ]
    if kind is FreezerFront.TWO_DRAWERS:
        part = bottom + 0.54 * (top - bottom)
        return [
            compartment("freezer_lower", left, right, bottom, part - 0.018, depth),
            compartment("freezer_upper", left, right, part + 0.018, top, depth),
        ]
    return [compartment("freezer", left, right, bottom, top, depth)]


def add_lower_fronts(
    builder: AssetBuilder,
    kind: FreezerFront,
    compartments: list[Compartment],
    width: float,
    bottom: float,
    top: float,
    look: ApplianceLook,
    right: bool,
) -> list[str]:
    """Add fronts before the compartments, from z = bottom to top over the whole width; returns their joints."""
    face = look.lower or look.face
    if kind is FreezerFront.TWO_DOORS:
        middle, half = width / 2, center_gap(width / 2, look.thick) / 2
        doors = [
            FridgeDoor(
                "freezer_left",
                (0.0, bottom),
                (middle - half, top),
                False,
                compartments[0],
                compartments[0].upper[0],
                face,
            ),
            FridgeDoor(
                "freezer_right",
                (middle + half, bottom),
                (width, top),
                True,
                compartments[1],
                compartments[1].lower[0],
                face,
            ),
        ]
        for door in doors:
            hang_fridge_door(builder, door, look, 0, 0.0)
            fill_with_baskets(builder, door.compartment, look, door, 2)
        return [door.joint for door in doors]
    if kind is FreezerFront.DOOR:
        r = compartments[0]
        door = FridgeDoor("freezer", (0.0, bottom), (width, top), right, r, r.lower[0] if right else r.upper[0], face)
        hang_fridge_door(builder, door, look, 0, 0.0)
        fill_with_baskets(builder, r, look, door, 3 if top - bottom > 0.6 else 2)
        return [door.joint]
    joints = []
    planes = [bottom, *((a.upper[2] + b.lower[2]) / 2 for a, b in pairwise(compartments)), top]
    for k, r in enumerate(compartments):
        under, over = planes[k] + (0.003 if k else 0.0), planes[k + 1] - (0.003 if k + 1 < len(compartments) else 0.0)
        door = FridgeDoor(r.name, (0.0, under), (width, over), False, r, 0.0, face, across=True)
        add_pull_out(builder, door, look, f"freezer_drawer{k}")
        joints.append(door.joint)
    return joints
