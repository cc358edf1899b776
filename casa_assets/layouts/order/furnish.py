"""What a plan puts in besides its units: on worktops, at walls, under the ceiling, before the island, on the floor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.errors import Misfit
from casa_assets.layouts.order.beams import Beamwork
from casa_assets.layouts.order.models import Models
from casa_assets.layouts.order.wanted import Depth, Height, Order, Spot, Wanted
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Room, metres
from casa_assets.layouts.plan.runs import Line, Slot
from casa_assets.layouts.plan.wall_frame import Frame
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Choice
from casa_assets.model.kitchen.units import Side
from casa_assets.model.record import Vec2

SEAT_APART = 0.6  # metres per person at a worktop; NKBA planning guideline 9
AT_WALL = 0.45  # metres between a wall and the first place at a worktop that begins there
BREADTH = {"toaster": 0.4, "knife_block": 0.29, "utensil_holder": 0.24, "fruit_bowl": 0.36, "paper_towel": 0.28}
LAMP_OFF = 0.6  # metres between a wall and a lamp of the room
LAMPS_APART = 0.2  # least metres between lamps over a run
LAMP_ASIDE = 0.75  # metres between an island and the lamps of the room
ON_TOP = 0.0008  # metres over a worktop at which things are set down


def order_stands(order: Order, plan: Plan, slots: Mapping[str, Slot], models: Models) -> None:
    """Things on worktops."""
    for stand in plan.stands:
        if stand.on not in slots:
            raise Misfit(plan.id, ("stands", stand.id, "on"), "a unit of the plan", repr(stand.on))
        if not models.has(stand.id):
            raise Misfit(plan.id, ("stands", stand.id), "a role of the style", repr(stand.id))
    for name, slot in slots.items():
        row = sorted((s for s in plan.stands if s.on == name), key=lambda s: s.at)
        breadths = [breadth(models, s.id) for s in row]
        for stand, u in zip(row, _side_by_side(slot, [s.at for s in row], breadths), strict=True):
            spot = Spot(slot.line.frame, u, stand.back, standard_sizes.TOP + ON_TOP, stand.turn_deg)
            order.add(Wanted(stand.id, stand.id, models.of(stand.id).choice, spot, slot.name, slot.line.id))


def breadth(models: Models, role: str) -> float:
    """About how much of a worktop a thing takes up, metres: members of some families tell their width, others vary."""
    width = models.of(role).numbers.get("width")
    return 0.05 + float(width) if width is not None else BREADTH.get(role, 0.25)


def _side_by_side(slot: Slot, shares: Sequence[float], breadths: Sequence[float]) -> list[float]:
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


def order_seats(order: Order, plan: Plan, lines: Mapping[str, Line], models: Models) -> None:
    """Stools at the guests' side of islands and peninsulas, turned to it."""
    for seats in plan.seats:
        if seats.run not in lines:
            raise Misfit(plan.id, ("seats",), "a run of the plan", repr(seats.run))
        line = lines[seats.run]
        low, high = _free_part(line)
        pitch = min(0.75, (high - low) / seats.count)
        if pitch < SEAT_APART - 0.001:
            got = f"{high - low:.2f} m for {seats.count}"
            raise Misfit(plan.id, ("seats",), f"{SEAT_APART} m for each seat", got)
        for k in range(seats.count):
            u = (low + high) / 2 + (k - (seats.count - 1) / 2) * pitch
            # The back of the stool is away from the top, which reaches out behind the line of the run.
            spot = Spot(line.frame, u, -line.run.overhang - 0.12, 0.0005, 0.0, Depth.MIDDLE)
            name = f"{seats.run}_stool_{k + 1}"
            order.add(Wanted(name, "stool", models.of("stool").choice, spot, "", seats.run))


def _free_part(line: Line) -> tuple[float, float]:
    """Where people sit along an island or peninsula, metres: nobody sits against the wall that it begins at."""
    if line.run.joins is None:
        return 0.0, line.length
    return (AT_WALL, line.length) if line.run.joins.end is Side.RIGHT else (0.0, line.length - AT_WALL)


def order_hangings(
    order: Order, plan: Plan, room: Room, given: Mapping[str, float], slots: Mapping[str, Slot], models: Models
) -> None:
    """Things on walls."""
    for hung in plan.hangings:
        at = ("hangings", hung.id)
        if not models.has(hung.item):
            continue  # a style may leave a wall bare
        wall = room.wall(hung.wall) if hung.wall in {w.id for w in room.walls} else None
        if wall is None:
            raise Misfit(plan.id, (*at, "wall"), f"one of {', '.join(w.id for w in room.walls)}", repr(hung.wall))
        if hung.over is not None:
            if hung.over not in slots:
                raise Misfit(plan.id, (*at, "over"), "a unit of the plan", repr(hung.over))
            slot = slots[hung.over]
            u = wall.frame.of(*slot.line.frame.at(slot.middle, 0.0)[:2])[0]
        else:
            assert hung.at is not None
            u = metres(plan, hung.at, given, *at, "at")
        model = models.of(hung.item)
        v = (
            0.0105
            if models.style.splash and hung.over and standard_sizes.TOP < hung.height < standard_sizes.UPPER_FROM
            else 0.0
        )
        spot = Spot(wall.frame, u + hung.shift, v, hung.height, height=Height.MIDDLE)
        order.add(Wanted(hung.id, hung.item, model.choice, spot, hung.over or ""))


def order_lamps(
    order: Order, plan: Plan, room: Room, lines: Mapping[str, Line], models: Models, beams: Beamwork | None
) -> None:
    """Lamps under the ceiling, between its beams; none of the room's where one over an island hangs already."""
    (x0, y0), (x1, y1) = room.bounds()
    hung: list[Vec2] = []
    for n, lamps in enumerate(plan.lamps):
        if not models.has(lamps.item):
            continue
        choice = models.of(lamps.item).choice
        stem = lamps.item if n == 0 else f"{lamps.item}_{n + 1}"
        count = lamps.count
        if lamps.over is not None and lamps.over in lines:
            count = _fitting(count, lines[lamps.over], models.of(lamps.item).number("size"))
        for k, (frame, u, v) in enumerate(_hung_at(lamps.over, count, lines, (x0, y0, x1, y1), room)):
            if beams is not None:
                u, v = frame.of(*beams.between(*frame.at(u, v)[:2]))
            x, y, _ = frame.at(u, v)
            if lamps.over is None and any(math.hypot(x - a, y - b) < LAMP_ASIDE for a, b in hung):
                continue
            hung.append((x, y))
            # A long lamp hangs along the beams; over a run they go its way already.
            turn = 90.0 if beams is not None and not beams.along_x and lamps.over is None else 0.0
            spot = Spot(frame, u, v, room.height - 0.001, turn, Depth.MIDDLE, Height.HEAD)
            order.add(Wanted(f"{stem}_{k + 1}", "lamp", choice, spot))


def _fitting(count: int, line: Line, breadth: float) -> int:
    """How many of the lamps find room side by side over a run."""
    low, high = _free_part(line)
    return max(1, min(count, int((high - low - 0.4) / (breadth + LAMPS_APART))))


def _hung_at(
    over: str | None, count: int, lines: Mapping[str, Line], box: tuple[float, float, float, float], room: Room
) -> Sequence[tuple[Frame, float, float]]:
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
        beside = ((x + dx, y + dy) for dx in (-LAMP_OFF, LAMP_OFF) for dy in (-LAMP_OFF, LAMP_OFF))
        if all(room.holds(*p) for p in beside) and not any(
            _is_near(line, x, y) for line in lines.values() if not line.at_wall
        ):
            out.append((Frame(x0, y1, 0), x - x0, y1 - y))
    return out


def _is_near(line: Line, x: float, y: float) -> bool:
    """Whether a point is so near an island or peninsula that a lamp there would hang among its own."""
    u, v = line.frame.of(x, y)
    return -LAMP_ASIDE < u < line.length + LAMP_ASIDE and -LAMP_ASIDE < v < line.depth + LAMP_ASIDE


def order_floor(order: Order, plan: Plan, room: Room, given: Mapping[str, float], models: Models) -> None:
    """Things on the floor."""
    for thing in plan.floor:
        at = ("floor", thing.id)
        if not models.has(thing.item):
            continue
        if thing.wall not in {w.id for w in room.walls}:
            raise Misfit(plan.id, (*at, "wall"), f"one of {', '.join(w.id for w in room.walls)}", repr(thing.wall))
        wall = room.wall(thing.wall)
        u, v = metres(plan, thing.at, given, *at, "at"), metres(plan, thing.beside, given, *at, "beside")
        spot = Spot(wall.frame, u, v, 0.0005, thing.turn_deg, Depth.MIDDLE)
        choice: Choice = models.of(thing.item).choice
        order.add(Wanted(thing.id, thing.item, choice, spot))
