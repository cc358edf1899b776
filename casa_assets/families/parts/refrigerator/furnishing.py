"""Rooms of a refrigerator furnished: shelves, crispers, regions, the lamp that burns while a door is open."""

from __future__ import annotations

import math
from collections.abc import Sequence

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.behavior_builder import negated
from casa_assets.families.parts.appliance.look import ApplianceLook
from casa_assets.families.parts.refrigerator.case import DOOR_GAP, LINER_THICKNESS, Compartment, add_shelf
from casa_assets.families.parts.refrigerator.door import BIN_DEPTH, DOOR_TRAVEL, FridgeDoor
from casa_assets.families.parts.refrigerator.sliding_parts import SIDE_CLEARANCE, add_crisper, crisper_reach
from casa_assets.model.asset.behavior import Condition

# Ref: RoboCasa v1.0, Fridge: things are put where there are 0.20 m and more.
SHELF_PITCH = 0.214
LAMP_COLOR = (1.0, 0.96, 0.88, 1.0)
# Ref: RoboCasa v1.0, Fridge.is_closed and is_open: up to the first share of its range a door is shut, from the second
# on it is open.
CLOSED_SHARE, OPEN_SHARE = 0.005, 0.9
LINER_PLUG = 0.012  # metres by which the liner of a door stands out behind it
LOWEST_LIP = 0.35  # height of the lip of the lowest of stacked crispers, above the floor; lower no wheeled arm reaches
CRISPER_SETBACK = 0.018  # metres from the front plane to the lip of a crisper, behind the liner of the door


def center_gap(width: float, thickness: float) -> float:
    """Gap between two doors of a width that meet in the middle: the rear corner of one swings out by it, metres."""
    return math.hypot(width, thickness) - width + 0.0014


def open_leaf(thickness: float, reach: float) -> float:
    """Width next to the hinge that a door takes up in front of the case once it counts as open, metres.

    Args:
        thickness: of the door. reach: how far in front of the case anything passes by it, metres.
    """
    angle, inner = OPEN_SHARE * DOOR_TRAVEL, thickness + LINER_PLUG
    # The point of its inner face that is as far in front as what slides out; the hinge is at the outer front corner.
    along = (reach - thickness - DOOR_GAP + inner * math.cos(angle)) / math.sin(angle)
    return along * math.cos(angle) + inner * math.sin(angle) + SIDE_CLEARANCE


def furnish_compartment(
    builder: AssetBuilder,
    r: Compartment,
    look: ApplianceLook,
    doors: Sequence[FridgeDoor],
    shelves: int,
    drawers: int,
    height: float,
    stacked: bool,
) -> float:
    """Add crispers at the bottom and panes above them; return the z from which there may be bins in the door, metres.

    Args:
        doors: in front of it, one or two from left to right.
        shelves: panes over the lowest level. drawers: crispers, next to each other or stacked. height: of each crisper;
            the lowest of a stack reaches up to `LOWEST_LIP` at least.
    """
    floor, top = r.lower[2] + LINER_THICKNESS + 0.004, r.upper[2] - 0.014
    level, first = r.lower[2] + LINER_THICKNESS, BIN_DEPTH + 0.012
    if drawers:
        lowest = max(height, LOWEST_LIP - floor) if stacked else height
        level = _crispers(builder, r, look, doors, (lowest, *(drawers - 1) * [height]), stacked, floor)
        add_shelf(builder, f"{r.name}_shelf0", r, level, 0.022, look)
    count = max(0, min(shelves, int((top - level) / SHELF_PITCH) - 1))
    levels = [level + (top - level) * k / (count + 1) for k in range(count + 1)]
    for k, z in enumerate(levels):
        if k:
            add_shelf(builder, f"{r.name}_shelf{k}", r, z, first, look)
        ceiling = levels[k + 1] - 0.018 if k < count else top
        lower, upper = (r.lower[0] + 0.006, first + 0.004, z), (r.upper[0] - 0.006, r.upper[1] - 0.016, ceiling)
        builder.region(f"{r.name}_shelf{k}", lower, upper)
    return level + 0.012


def _crispers(
    builder: AssetBuilder,
    r: Compartment,
    look: ApplianceLook,
    doors: Sequence[FridgeDoor],
    heights: Sequence[float],
    stacked: bool,
    floor: float,
) -> float:
    """Crispers of these heights; returns the z of the pane that covers them, metres."""
    x0, x1 = r.lower[0] + LINER_THICKNESS + SIDE_CLEARANCE, r.upper[0] - LINER_THICKNESS - SIDE_CLEARANCE
    # An open door stands before the wall of its hinge; what slides out must pass beside it.
    back = r.upper[1] - 0.02
    room = open_leaf(look.thick, crisper_reach(CRISPER_SETBACK, back))
    for door in doors:
        x0 = max(x0, door.lower[0] + room) if not door.right else x0
        x1 = min(x1, door.upper[0] - room) if door.right else x1
    drawers, z = len(heights), floor
    for k, height in enumerate(heights):
        name = f"{r.name}_drawer{k}"
        if stacked:
            add_crisper(
                builder, name, doors[0].joint, (x0, CRISPER_SETBACK, z), (x1, back, z + height), look, "plastic_white"
            )
            z += height + 0.012
        else:
            pitch = (x1 - x0) / drawers
            a = x0 + k * pitch + (0.0 if k == 0 else 0.004)
            b = x0 + (k + 1) * pitch - (0.0 if k == drawers - 1 else 0.004)
            behind = doors[min(k * len(doors) // drawers, len(doors) - 1)].joint
            add_crisper(builder, name, behind, (a, CRISPER_SETBACK, floor), (b, back, floor + height), look)
    return (z if stacked else floor + heights[0] + 0.012) + 0.02


def fill_with_baskets(builder: AssetBuilder, r: Compartment, look: ApplianceLook, door: FridgeDoor, count: int) -> None:
    """A room that is nothing but baskets above each other."""
    floor, ceiling = r.lower[2] + LINER_THICKNESS + 0.004, r.upper[2] - 0.014
    _crispers(builder, r, look, (door,), count * [(ceiling - floor) / count - 0.012], True, floor)


def finish_refrigerator(builder: AssetBuilder, doors: Sequence[str], fridge: Sequence[str]) -> None:
    """States, poses and the behaviour of a refrigerator.

    Args:
        doors: all joints that count as doors. fridge: those of the fridge, whose lamp they switch.
    """
    builder.door_states(*doors)
    builder.keyframe("closed")
    builder.keyframe("open", **{m.name: builder.joint_position(m.name) for m in builder.joints})
    add_lamp_behavior(builder, fridge)


def add_lamp_behavior(builder: AssetBuilder, fridge: Sequence[str]) -> None:
    """The lamp burns while a door of the fridge is not shut."""
    shut = []
    for joint in fridge:
        ends = sorted((0.0, builder.joint_position(joint) * CLOSED_SHARE))
        # A door may stand a little beyond its stop.
        low, high = (ends[0], 0.01) if builder.joint_position(joint) < 0 else (-0.01, ends[1])
        shut.append(Condition(joint=joint, interval=(low, high)))
    builder.behavior.variable("light")
    builder.behavior.rule("light", "off", *shut)
    for condition in shut:
        builder.behavior.rule("light", "on", negated(condition))
    builder.behavior.light("light", "fridge_light_visual", LAMP_COLOR)
