"""Inside of refrigerators: shelves, crispers, baskets and the fronts of freezers below."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from itertools import pairwise

from casa_assets.ext.solids import AssetBuilder, board
from casa_assets.kitchenware.parts.appliance import ApplianceLook
from casa_assets.kitchenware.parts.cases import tub_walls
from casa_assets.kitchenware.parts.drawers import add_crisper, crisper_reach
from casa_assets.kitchenware.parts.refrigerator import (
    BIN_DEPTH,
    DIVIDER_THICKNESS,
    DOOR_GAP,
    DOOR_TRAVEL,
    LINER_THICKNESS,
    Compartment,
    FridgeDoor,
    add_face,
    add_pull,
    add_shelf,
    compartment,
    gasket_frame,
    hang_fridge_door,
)

SIDE_CLEARANCE = 0.006  # metres at each side of what slides

# Ref: RoboCasa v1.0, Fridge: things are put where there are 0.20 m and more.
SHELF_PITCH = 0.214
# Share of its range from which a door is open. Ref: RoboCasa v1.0, Fridge.is_open.
OPEN_SHARE = 0.9
LINER_PLUG = 0.012  # metres by which the liner of a door stands out behind it
LOWEST_LIP = 0.35  # height of the lip of the lowest of stacked crispers, above the floor; lower no wheeled arm reaches
CRISPER_SETBACK = 0.018  # metres from the front plane to the lip of a crisper, behind the liner of the door

FreezerFront = StrEnum("FreezerFront", "DRAWER TWO_DRAWERS DOOR TWO_DOORS")


def add_pull_out(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, region: str) -> None:
    """Add a front with a deep basket behind it that slide out together; link and joint are those of `door`."""
    t, w, h, r = look.thick, door.width, door.height, door.compartment
    builder.link(door.link, at=(door.lower[0], -DOOR_GAP - t, door.lower[1]))
    add_face(builder, door, look)
    seal = gasket_frame((0.012, 0.012), (w - 0.012, h - 0.012), t + 2e-4, t + DOOR_GAP - 3e-4)
    builder.draw(door.link, seal, "gasket_grey", "gasket", density="magnetic_gasket")
    add_pull(builder, door, look)
    x0, x1 = (
        r.lower[0] + LINER_THICKNESS + SIDE_CLEARANCE + 0.012 - door.lower[0],
        r.upper[0] - LINER_THICKNESS - SIDE_CLEARANCE - 0.012 - door.lower[0],
    )
    z0 = max(r.lower[2] + 0.012 - door.lower[1], 0.03)
    z1 = z0 + 0.8 * (min(r.upper[2] - 0.02 - door.lower[1], h - 0.03) - z0)
    y0, y1, e = t + DOOR_GAP, t + DOOR_GAP + r.upper[1] - 0.03, 0.004
    # The front board reaches forward to the front itself.
    walls = tub_walls(((x0, t + 1e-4, z0), (x1, y1, z1)), ((x0 + e, y0 + 0.01, z0 + e), (x1 - e, y1 - e, z1)))
    walls[0] = ((x0, y0, z0), (x1, y1, z0 + e))
    for corners, part in zip(walls, ("bottom", "front", "back", "left", "right"), strict=True):
        name = f"{door.name}_basket_{part}"
        builder.add(
            door.link, board(*corners, 0.001), "plastic_white", "drawer", collider=name, density="ribbed_plastic"
        )
    for x in (x0 - 0.0105, x1 + 0.0005):
        rail = board((x, y0 + 0.012, z0 + 0.03), (x + 0.01, y1 - 0.06, z0 + 0.05), 0.001)
        builder.draw(door.link, rail, "steel_galvanised", "rail", density="drawer_runner")
    travel = round(0.82 * (y1 - y0), 3)
    builder.slide(door.joint, door.link, (0.0, 1.0, 0.0), (-travel, 0.0), (f"{door.link}_handle_main"), start_n=11.0)
    builder.region(region, (x0 + e, y0 + 0.01, z0 + e), (x1 - e, y1 - e, z1), link=door.link)


def center_gap(width: float, thickness: float) -> float:
    """Gap between two doors of a width that meet in the middle: the rear corner of one swings out by it, metres."""
    return math.hypot(width, thickness) - width + 0.0014


def open_leaf(thickness: float, reach: float) -> float:
    """Width next to the hinge that a door takes up in front of the case once it counts as open, metres.

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

    doors: in front of it, one or two from left to right. shelves: panes over the lowest level. drawers: crispers, next
    to each other or stacked. height: of each crisper; the lowest of a stack reaches up to `LOWEST_LIP` at least.
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
            ends = (x0, CRISPER_SETBACK, z), (x1, back, z + height)
            add_crisper(builder, name, doors[0].joint, *ends, look, "plastic_white")
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


# Lower freezer --------------------------------------------------------------------------------------------------------


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
        (one, two), middle, half = compartments, width / 2, center_gap(width / 2, look.thick) / 2
        doors = [
            FridgeDoor("freezer_left", (0.0, bottom), (middle - half, top), False, one, one.upper[0], face),
            FridgeDoor("freezer_right", (middle + half, bottom), (width, top), True, two, two.lower[0], face),
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
