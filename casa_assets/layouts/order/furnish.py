"""Order furnishings: worktop items, wall items, lamps, seats and floor items."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.beams import BeamGrid
from casa_assets.layouts.order.build_order import BuildOrder, DepthReference, HeightReference, OrderItem, Spot
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Room, resolve_length
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.kitchen.units import RunSide
from casa_assets.model.record import Vec2

SEAT_SPACING_M = 0.6  # metres per person at a worktop; NKBA planning guideline 9
SEAT_FROM_WALL_M = 0.45  # metres between a wall and the first place at a worktop that begins there
WORKTOP_WIDTHS_M = {
    "toaster": 0.4,
    "knife_block": 0.29,
    "utensil_holder": 0.24,
    "fruit_bowl": 0.36,
    "paper_towel": 0.28,
}
LAMP_FROM_WALL_M = 0.6  # metres between a wall and a lamp of the room
MIN_LAMP_GAP_M = 0.2  # least metres between lamps over a run
LAMP_FROM_ISLAND_M = 0.75  # metres between an island and the lamps of the room
SET_DOWN_GAP_M = 0.0008  # metres over a worktop at which things are set down


def order_worktop_items(order: BuildOrder, plan: Plan, slots: Mapping[str, UnitSlot], models: StyleModels) -> None:
    """Order the items that stand on worktops."""
    for stand in plan.worktop_items:
        if stand.on not in slots:
            raise PlanConflict(plan.id, ("worktop_items", stand.id, "on"), "a unit of the plan", repr(stand.on))
        if not models.has(stand.id):
            raise PlanConflict(plan.id, ("worktop_items", stand.id), "a role of the style", repr(stand.id))
    for name, slot in slots.items():
        row = sorted((s for s in plan.worktop_items if s.on == name), key=lambda s: s.at)
        breadths = [worktop_width(models, s.id) for s in row]
        for stand, u in zip(row, _side_by_side(slot, [s.at for s in row], breadths), strict=True):
            spot = Spot(slot.line.frame, u, stand.back, standard_sizes.WORKTOP_HEIGHT + SET_DOWN_GAP_M, stand.turn_deg)
            order.add(OrderItem(stand.id, stand.id, models.for_role(stand.id).choice, spot, slot.name, slot.line.id))


def worktop_width(models: StyleModels, role: str) -> float:
    """Approximate width that an item takes up on a worktop, metres."""
    width = models.for_role(role).params.get("width")
    return 0.05 + float(width) if width is not None else WORKTOP_WIDTHS_M.get(role, 0.25)


def _side_by_side(slot: UnitSlot, shares: Sequence[float], breadths: Sequence[float]) -> list[float]:
    """Middles along the run of things on one unit, from left to right: on it where it is wide enough, and apart."""
    out: list[float] = []
    edge = slot.left
    for share, breadth in zip(shares, breadths, strict=True):
        u = max(slot.left + share * slot.width, edge + breadth / 2)
        out.append(u)
        edge = u + breadth / 2
    edge = max(slot.right, slot.left + sum(breadths))
    for k in reversed(range(len(out))):
        out[k] = min(out[k], edge - breadths[k] / 2)
        edge = out[k] - breadths[k] / 2
    return [round(u, 4) for u in out]


def order_seats(order: BuildOrder, plan: Plan, lines: Mapping[str, RunLine], models: StyleModels) -> None:
    """Order stools at the seating side of islands and peninsulas, turned to it."""
    for seats in plan.seats:
        if seats.run not in lines:
            raise PlanConflict(plan.id, ("seats",), "a run of the plan", repr(seats.run))
        line = lines[seats.run]
        low, high = _free_part(line)
        pitch = min(0.75, (high - low) / seats.count)
        if pitch < SEAT_SPACING_M - 0.001:
            got = f"{high - low:.2f} m for {seats.count}"
            raise PlanConflict(plan.id, ("seats",), f"{SEAT_SPACING_M} m for each seat", got)
        for k in range(seats.count):
            u = (low + high) / 2 + (k - (seats.count - 1) / 2) * pitch
            # The back of the stool is away from the top, which reaches out behind the line of the run.
            spot = Spot(line.frame, u, -line.run.overhang - 0.12, 0.0005, 0.0, DepthReference.MIDDLE)
            name = f"{seats.run}_stool_{k + 1}"
            order.add(OrderItem(name, "stool", models.for_role("stool").choice, spot, "", seats.run))


def _free_part(line: RunLine) -> tuple[float, float]:
    """Part of an island or peninsula to sit at, metres: nobody sits against the wall that it begins at."""
    if line.run.joins is None:
        return 0.0, line.length
    return (
        (SEAT_FROM_WALL_M, line.length)
        if line.run.joins.end is RunSide.RIGHT
        else (0.0, line.length - SEAT_FROM_WALL_M)
    )


def order_wall_items(
    order: BuildOrder,
    plan: Plan,
    room: Room,
    given: Mapping[str, float],
    slots: Mapping[str, UnitSlot],
    models: StyleModels,
) -> None:
    """Order the items that hang on walls."""
    for hung in plan.wall_items:
        at = ("wall_items", hung.id)
        if not models.has(hung.item):
            continue  # a style may leave a wall bare
        wall = room.wall(hung.wall) if hung.wall in {w.id for w in room.walls} else None
        if wall is None:
            raise PlanConflict(plan.id, (*at, "wall"), f"one of {', '.join(w.id for w in room.walls)}", repr(hung.wall))
        if hung.over is not None:
            if hung.over not in slots:
                raise PlanConflict(plan.id, (*at, "over"), "a unit of the plan", repr(hung.over))
            slot = slots[hung.over]
            u = wall.frame.to_local(*slot.line.frame.at(slot.middle, 0.0)[:2])[0]
        else:
            assert hung.at is not None
            u = resolve_length(plan, hung.at, given, *at, "at")
        model = models.for_role(hung.item)
        v = (
            0.0105
            if models.style.backsplash
            and hung.over
            and standard_sizes.WORKTOP_HEIGHT < hung.height < standard_sizes.UPPER_FROM
            else 0.0
        )
        spot = Spot(wall.frame, u + hung.shift, v, hung.height, height_reference=HeightReference.MIDDLE)
        order.add(OrderItem(hung.id, hung.item, model.choice, spot, hung.over or ""))


def order_lamps(
    order: BuildOrder, plan: Plan, room: Room, lines: Mapping[str, RunLine], models: StyleModels, beams: BeamGrid | None
) -> None:
    """Order lamps under the ceiling, between its beams; none near those that hang over an island."""
    (x0, y0), (x1, y1) = room.bounds()
    hung: list[Vec2] = []
    for n, lamps in enumerate(plan.lamps):
        if not models.has(lamps.item):
            continue
        choice = models.for_role(lamps.item).choice
        stem = lamps.item if n == 0 else f"{lamps.item}_{n + 1}"
        count = lamps.count
        if lamps.over is not None and lamps.over in lines:
            count = _fitting(count, lines[lamps.over], models.for_role(lamps.item).length("size"))
        for k, (frame, u, v) in enumerate(_hung_at(lamps.over, count, lines, (x0, y0, x1, y1), room)):
            if beams is not None:
                u, v = frame.to_local(*beams.between(*frame.at(u, v)[:2]))
            x, y, _ = frame.at(u, v)
            if lamps.over is None and any(math.hypot(x - a, y - b) < LAMP_FROM_ISLAND_M for a, b in hung):
                continue
            hung.append((x, y))
            # A long lamp hangs along the beams; over a run they go its way already.
            turn = 90.0 if beams is not None and not beams.along_x and lamps.over is None else 0.0
            spot = Spot(frame, u, v, room.height - 0.001, turn, DepthReference.MIDDLE, HeightReference.HEAD)
            order.add(OrderItem(f"{stem}_{k + 1}", "lamp", choice, spot))


def _fitting(count: int, line: RunLine, breadth: float) -> int:
    """Number of lamps that find room side by side over a run."""
    low, high = _free_part(line)
    return max(1, min(count, int((high - low - 0.4) / (breadth + MIN_LAMP_GAP_M))))


def _hung_at(
    over: str | None, count: int, lines: Mapping[str, RunLine], box: tuple[float, float, float, float], room: Room
) -> Sequence[tuple[WallFrame, float, float]]:
    x0, y0, x1, y1 = box
    if over is not None and over in lines:
        line = lines[over]
        low, high = _free_part(line)
        span = high - low - 0.4
        return [(line.frame, (low + high) / 2 + span * ((k + 0.5) / count - 0.5), line.depth / 2) for k in range(count)]
    rows = 1 if count <= 2 else 2
    if y1 - y0 > x1 - x0:
        rows = -(-count // rows)
    per = -(-count // rows)
    out = []
    for k in range(count):
        row, column = divmod(k, per)
        x = x0 + (x1 - x0) * (column + 0.5) / per
        y = y1 - (y1 - y0) * (row + 0.5) / rows
        beside = (
            (x + dx, y + dy)
            for dx in (-LAMP_FROM_WALL_M, LAMP_FROM_WALL_M)
            for dy in (-LAMP_FROM_WALL_M, LAMP_FROM_WALL_M)
        )
        if all(room.contains(*p) for p in beside) and not any(
            _is_near(line, x, y) for line in lines.values() if not line.at_wall
        ):
            out.append((WallFrame(x0, y1, 0), x - x0, y1 - y))
    return out


def _is_near(line: RunLine, x: float, y: float) -> bool:
    """True if a point is so near an island or peninsula that a lamp there would hang among its own."""
    u, v = line.frame.to_local(x, y)
    return (
        -LAMP_FROM_ISLAND_M < u < line.length + LAMP_FROM_ISLAND_M
        and -LAMP_FROM_ISLAND_M < v < line.depth + LAMP_FROM_ISLAND_M
    )


def order_floor_items(
    order: BuildOrder, plan: Plan, room: Room, given: Mapping[str, float], models: StyleModels
) -> None:
    """Order the items that stand on the floor."""
    for thing in plan.floor_items:
        at = ("floor_items", thing.id)
        if not models.has(thing.item):
            continue
        if thing.wall not in {w.id for w in room.walls}:
            raise PlanConflict(
                plan.id, (*at, "wall"), f"one of {', '.join(w.id for w in room.walls)}", repr(thing.wall)
            )
        wall = room.wall(thing.wall)
        u, v = (
            resolve_length(plan, thing.at, given, *at, "at"),
            resolve_length(plan, thing.from_wall, given, *at, "from_wall"),
        )
        spot = Spot(wall.frame, u, v, 0.0005, thing.turn_deg, DepthReference.MIDDLE)
        choice: PresetChoice = models.for_role(thing.item).choice
        order.add(OrderItem(thing.id, thing.item, choice, spot))
