"""Order furnishings: worktop items, wall items, lamps, tables, seats and floor items."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.build_order import (
    BeamGrid,
    BuildOrder,
    DepthReference,
    HeightReference,
    PlacedTable,
    Spot,
    numbered,
)
from casa_assets.layouts.order.room_shell import casing_width, position_on_wall
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Room, WallFrame, resolve_length, wall_of
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import DiningTable, Plan, RunSide, UpperKind, WorktopItem
from casa_assets.model.record import Vec2

PLACE_WIDTH_M = 0.6  # along a table for each person; NKBA planning guideline 9
# Length of a table beyond the places along it, the least length of one, and of the rim of a round one for each place.
TABLE_END_M, TABLE_LEAST_M, ROUND_PLACE_M = 0.2, 1.0, 0.22
CHAIR_UNDER_TABLE_M = 0.05  # that a chair's seat reaches under the table
CHAIR_REACH_M = 0.45  # that a chair stands out beside the table
SEAT_SPACING_M = 0.6  # metres per person at a worktop; NKBA planning guideline 9
SEAT_FROM_WALL_M = 0.45  # metres between a wall and the first place at a worktop that begins there
WORKTOP_WIDTHS_M = {
    "toaster": 0.4,
    "kettle": 0.32,
    "blender": 0.27,
    "stand_mixer": 0.3,
    "knife_block": 0.29,
    "utensil_holder": 0.24,
    "fruit_bowl": 0.36,
    "paper_towel": 0.28,
}
SWITCH_WIDTH_M, GANG_M, SWITCH_FROM_CASING_M = 0.086, 0.046, 0.004  # of a plate, of each further switch in it; a gap
ON_BACKSPLASH_M = 0.0105  # of what hangs on a backsplash from the wall
LAMP_FROM_WALL_M = 0.6  # metres between a wall and a lamp of the room
LAMP_FROM_COLUMN_M = 0.4  # metres between a column and a lamp of the room
# Of the chimney of a hood, and what is between it and the shade of a lamp of the room, metres.
CHIMNEY_WIDTH_M, CHIMNEY_DEPTH_M, LAMP_FROM_HOOD_M = 0.36, 0.32, 0.02
MIN_LAMP_GAP_M = 0.2  # least metres between lamps over a run or a table
LAMP_FROM_END_M = 0.2  # metres along a run at each of its ends over which no lamp of a row hangs
THINGS_BELOW_M = 0.36  # metres over a worktop for what stands on it, below what hangs on the wall: most toaster ovens
# What lamps of the room hang down from the ceiling at most, with a gap, and how far doors of cabinets open before them.
LAMP_HEIGHT_M, WIDEST_DOOR_M = 0.25, 0.5
LAMP_FROM_ISLAND_M = 0.75  # metres between an island and the lamps of the room
Place = tuple[WallFrame, float, float]  # of a lamp: a frame, metres along it and away from it
BLENDER, LID, LID_PARAMS = "blender", "blender_lid", ("jar", "jar_top")
SET_DOWN_GAP_M = 0.0008  # metres over a worktop at which things are set down


def order_tables(order: BuildOrder) -> dict[str, PlacedTable]:
    """Order dining tables with chairs around them; return their places, by id."""
    plan, room, parameters, models = order.kitchen.plan, order.kitchen.room, order.kitchen.parameters, order.models
    placed: dict[str, PlacedTable] = {}
    for table in plan.tables:
        at = ("tables", table.id)
        wall = wall_of(plan, room, table.wall, *at, "wall")
        u = resolve_length(plan, table.at, parameters, *at, "at")
        v = resolve_length(plan, table.from_wall, parameters, *at, "from_wall")
        for role in ("table", "chair"):
            if not models.has(role):
                raise PlanConflict(plan.id, at, f"a style with a model of {role!r}", models.style.id)
        placed[table.id] = _order_table(order, table, wall.frame, (u, v), models)
    return placed


def _order_table(order: BuildOrder, table: DiningTable, frame: WallFrame, at: Vec2, models: StyleModels) -> PlacedTable:
    model = models.for_role("table")
    is_round = bool(model.params.get("is_round", False))
    long_sides = table.chairs // 2
    if is_round:
        width = depth = max(model.length("width"), round(table.chairs * ROUND_PLACE_M, 2))
    else:
        width, depth = max(long_sides * PLACE_WIDTH_M + TABLE_END_M, TABLE_LEAST_M), model.length("depth")
    width = round(width, 3)
    angle = math.radians(table.turn_deg)
    # In the frame of the wall: x along it, y away from it, so that a turn to the left is clockwise.
    along, across = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))

    def moved(a: float, b: float) -> Vec2:
        return (at[0] + a * along[0] + b * across[0], at[1] + a * along[1] + b * across[1])

    spot = Spot(frame, *at, 0.0005, table.turn_deg, DepthReference.MIDDLE)
    order.add(table.id, "table", model.with_params(width=width, **({} if is_round else {"depth": depth})), spot)
    chair = models.for_role("chair")
    reach = chair.length("depth") / 2 - CHAIR_UNDER_TABLE_M
    for k, (a, b, turn) in enumerate(_places(table.chairs, width, depth, is_round)):
        # A chair faces away from the line that it stands at; it is turned to the table.
        sine, cosine = math.sin(math.radians(turn)), math.cos(math.radians(turn))
        u, v = moved(a - reach * sine, b - reach * cosine)
        seat = Spot(frame, round(u, 5), round(v, 5), 0.0005, turn + table.turn_deg, DepthReference.MIDDLE)
        order.add(f"{table.id}_chair_{k + 1}", "chair", chair.choice, seat)
    left = CHAIR_REACH_M if is_round or table.chairs % 2 else 0.0
    us = (-width / 2 - left, width / 2 + (CHAIR_REACH_M if is_round else 0.0))
    vs = (-depth / 2 - CHAIR_REACH_M, depth / 2 + CHAIR_REACH_M)
    ends = ((us[0], vs[0]), (us[1], vs[0]), (us[1], vs[1]), (us[0], vs[1]))
    corners = tuple(frame.at(*moved(a, b))[:2] for a, b in ends)
    (x0, y0), (x1, y1) = frame.at(*moved(0.0, 0.0))[:2], frame.at(*moved(1.0, 0.0))[:2]
    return PlacedTable((x0, y0), width, (round(x1 - x0, 5), round(y1 - y0, 5)), corners)


def _places(chairs: int, width: float, depth: float, is_round: bool) -> list[tuple[float, float, float]]:
    """Places of chairs at the edge of a table: along it and across it, metres, and the turn to the table, degrees."""
    if is_round:
        turns = [(360.0 * k / chairs, math.radians(360.0 * k / chairs)) for k in range(chairs)]
        radius = -width / 2
        return [(radius * math.sin(r), radius * math.cos(r), t if t <= 180 else t - 360) for t, r in turns]
    out: list[tuple[float, float, float]] = []
    for side, turn in ((-depth / 2, 0.0), (depth / 2, 180.0)):
        count = chairs // 2
        pitch = (width - TABLE_END_M) / max(count, 1)
        out += [((k - (count - 1) / 2) * pitch, side, turn) for k in range(count)]
    return [*out, (-width / 2, 0.0, 90.0)] if chairs % 2 else out


def places_over(table: PlacedTable, count: int) -> Sequence[tuple[WallFrame, float, float]]:
    """Places of lamps along the middle of a table."""
    (x, y), (a, b), width = table.middle, table.direction, table.width
    shares = [(k + 0.5) / count - 0.5 for k in range(count)]
    return [(WallFrame(round(x + s * width * a, 5), round(y + s * width * b, 5), 0), 0.0, 0.0) for s in shares]


def order_worktop_items(order: BuildOrder) -> None:
    """Order the items on worktops."""
    plan, models, slots = order.kitchen.plan, order.models, order.kitchen.slot_by_name
    for item in plan.worktop_items:
        if item.on not in slots:
            raise PlanConflict(plan.id, ("worktop_items", item.id, "on"), "a unit of the plan", repr(item.on))
        if item.model is None and not models.has(item.id):
            raise PlanConflict(plan.id, ("worktop_items", item.id), "a role of the style", repr(item.id))
    for name, slot in slots.items():
        row = sorted((s for s in plan.worktop_items if s.on == name), key=lambda s: s.at)
        widths = [worktop_width(models, s) for s in row]
        for item, u in zip(row, _side_by_side(slot, [s.at for s in row], widths), strict=True):
            choice = models.for_item(item).choice
            spot = Spot(slot.line.frame, u, item.back, standard_sizes.WORKTOP_HEIGHT + SET_DOWN_GAP_M, item.turn_deg)
            order.add(item.id, models.role_of(item), choice, spot, unit=slot.name, run=slot.line.id)
            if choice.family == BLENDER:
                # Its lid: the preset of the same name, as wide as the mouth of its jar.
                params = models.resolve(choice).params
                fitting = {name: params[name] for name in LID_PARAMS if name in params}
                at = {"unit": slot.name, "run": slot.line.id, "lid_of": item.id}
                order.add(f"{item.id}_lid", LID, f"{LID}/{choice.name}", spot, fitting, **at)


def worktop_width(models: StyleModels, item: WorktopItem) -> float:
    """Approximate width that an item takes up on a worktop, metres."""
    model = models.for_item(item)
    if model.choice.is_library:
        width, depth, turn = model.length("width"), model.length("depth"), math.radians(item.turn_deg)
        return 0.05 + abs(width * math.cos(turn)) + abs(depth * math.sin(turn))
    if item.id in WORKTOP_WIDTHS_M:
        return WORKTOP_WIDTHS_M[item.id]
    return 0.05 + float(model.params.get("width") or 0.2)


def _side_by_side(slot: UnitSlot, shares: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Middles along the run of things on one unit, from left to right: on it where it is wide enough, and apart."""
    out: list[float] = []
    edge = slot.left
    for share, width in zip(shares, widths, strict=True):
        u = max(slot.left + share * slot.width, edge + width / 2)
        out.append(u)
        edge = u + width / 2
    edge = max(slot.right, slot.left + sum(widths))
    for k in reversed(range(len(out))):
        out[k] = min(out[k], edge - widths[k] / 2)
        edge = out[k] - widths[k] / 2
    return [round(u, 4) for u in out]


def seat_places(plan: Plan, lines: Mapping[str, RunLine]) -> dict[str, tuple[float, ...]]:
    """Middles of seats along their island or peninsula, metres.

    Raises PlanConflict: there is no such run, it has seats already, or too little room.
    """
    found: dict[str, tuple[float, ...]] = {}
    for k, seats in enumerate(plan.seats):
        if seats.run in found:
            raise PlanConflict(plan.id, ("seats", k), "one row of seats at each run", f"a second at {seats.run}")
        if seats.run not in lines:
            raise PlanConflict(plan.id, ("seats",), "a run of the plan", repr(seats.run))
        line = lines[seats.run]
        low, high = _free_interval(line)
        pitch = min(0.75, (high - low) / seats.count)
        if pitch < SEAT_SPACING_M - 0.001:
            got = f"{high - low:.2f} m for {seats.count}"
            raise PlanConflict(plan.id, ("seats",), f"{SEAT_SPACING_M} m for each seat", got)
        middle = (low + high) / 2
        found[seats.run] = tuple(middle + (k - (seats.count - 1) / 2) * pitch for k in range(seats.count))
    return found


def order_seats(order: BuildOrder) -> None:
    """Order stools at the seating side of islands and peninsulas, turned to it."""
    for run, places in order.seats.items():
        line = order.kitchen.lines[run]
        for k, u in enumerate(places):
            # The back of the stool is away from the top, which reaches out behind the line of the run.
            spot = Spot(line.frame, u, -line.run.overhang - 0.12, 0.0005, 0.0, DepthReference.MIDDLE)
            order.add(f"{run}_stool_{k + 1}", "stool", order.models.for_role("stool").choice, spot, run=run)


def _free_interval(line: RunLine) -> tuple[float, float]:
    """Interval along an island or peninsula for seats, metres: a seat keeps a distance from the wall."""
    if line.run.joins is None:
        return 0.0, line.length
    if line.run.joins.end is RunSide.RIGHT:
        return SEAT_FROM_WALL_M, line.length
    return 0.0, line.length - SEAT_FROM_WALL_M


def order_wall_items(order: BuildOrder) -> None:
    """Order the items that hang on walls; a switch is moved clear of the casing of a door."""
    kitchen, models = order.kitchen, order.models
    plan = kitchen.plan
    for item in plan.wall_items:
        at = ("wall_items", item.id)
        if not models.has(item.item):
            continue  # a style may leave a wall bare
        wall = wall_of(plan, kitchen.room, item.wall, *at, "wall")
        u = position_on_wall(plan, wall, item, kitchen.parameters, kitchen.slot_by_name, *at)
        model = models.for_role(item.item)
        if not item.over and "gangs" in model.params:
            half = (SWITCH_WIDTH_M + GANG_M * (int(model.params["gangs"]) - 1)) / 2 + SWITCH_FROM_CASING_M
            away = half + casing_width(models)
            # Moved as little as needed to be so far from doors.
            for hole in kitchen.holes:
                is_door = hole.wall.id == wall.id and hole.bottom <= 0.0
                if is_door and hole.left - away < u < hole.right + away:
                    u = hole.right + away if u > (hole.left + hole.right) / 2 else hole.left - away
            u = round(u, 4)
        is_over_worktop = item.over and standard_sizes.WORKTOP_HEIGHT < item.height < standard_sizes.UPPER_FROM
        v = ON_BACKSPLASH_M if models.style.backsplash and is_over_worktop else 0.0
        # A rack of two rails is twice as high as most, and tools hang from it down to what stands below.
        over_things = item.over and item.height > standard_sizes.UPPER_FROM
        spot = Spot(
            wall.frame,
            u + item.shift,
            v,
            item.height,
            height_reference=HeightReference.MIDDLE,
            least_foot=standard_sizes.WORKTOP_HEIGHT + THINGS_BELOW_M if over_things else 0.0,
        )
        order.add(item.id, item.item, model.choice, spot, unit=item.over or "")


def order_lamps(order: BuildOrder) -> None:
    """Order lamps under the ceiling, between beams; none near a high hood, an island's lamps or those of a table."""
    plan, room, lines = order.kitchen.plan, order.kitchen.room, order.kitchen.lines
    models, beams, tables = order.models, order.beams, order.tables
    hoods = [s for s in order.kitchen.slot_by_name.values() if s.kind is UpperKind.HOOD]
    (x0, y0), (x1, y1) = room.level_bounds()
    placed: list[Vec2] = []
    is_low = room.height < standard_sizes.UPPER_TO + LAMP_HEIGHT_M
    for n, lamps in enumerate(plan.lamps):
        if not models.has(lamps.item):
            continue
        choice = models.for_role(lamps.item).choice
        stem = numbered(lamps.item, n)
        size = models.for_role(lamps.item).length("size")
        over = None if lamps.over is None else lines.get(lamps.over) or tables.get(lamps.over)
        if over is None:
            places = _between_beams(_lamps_of_room(lamps.count, lines, (x0, y0, x1, y1), room), beams)
        else:
            places = _row_of_lamps(over, lamps.count, size, beams)
        for k, (frame, u, v) in enumerate(places):
            x, y, _ = frame.at(u, v)
            if room.ceiling_at(x, y) < room.height:
                expected = "a row under the level part of the ceiling, where lamps hang"
                raise PlanConflict(plan.id, ("lamps", n), expected, f"{lamps.over}, under a slope")
            # Doors of wall units and tall ones open before a run.
            before = [(n.frame, (0.0, n.length), (0.0, n.depth + WIDEST_DOOR_M)) for n in lines.values()]
            if lamps.over is None and (
                any(math.hypot(x - a, y - b) < LAMP_FROM_ISLAND_M for a, b in placed)
                or (is_low and any(_is_in(*place, x, y, size / 2) for place in before))
                or any(_is_at_hood(slot, x, y, size / 2 + LAMP_FROM_HOOD_M) for slot in hoods)
            ):
                continue
            placed.append((x, y))
            # A long lamp hangs along the table below it, or along the beams; over a run they go its way already.
            turn = 90.0 if beams is not None and not beams.along_x and lamps.over is None else 0.0
            if isinstance(over, PlacedTable):
                turn = round(math.degrees(math.atan2(over.direction[1], over.direction[0])), 3)
            spot = Spot(frame, u, v, room.height - 0.001, turn, DepthReference.MIDDLE, HeightReference.HEAD)
            order.add(f"{stem}_{k + 1}", "lamp", choice, spot)


def _row_of_lamps(over: RunLine | PlacedTable, count: int, size: float, beams: BeamGrid | None) -> list[Place]:
    """Places of lamps over a run or a table: as many, up to `count`, as find room side by side; at least one."""
    places: list[Place] = []
    for number in range(count, 0, -1):
        row = places_over(over, number) if isinstance(over, PlacedTable) else _places_along(over, number)
        places = _between_beams(row, beams)
        points = [frame.at(u, v)[:2] for frame, u, v in places]
        if all(math.dist(a, b) >= size + MIN_LAMP_GAP_M for a, b in itertools.combinations(points, 2)):
            break
    return places


def _places_along(line: RunLine, count: int) -> list[Place]:
    low, high = _free_interval(line)
    span = high - low - 2 * LAMP_FROM_END_M
    return [(line.frame, (low + high) / 2 + span * ((k + 0.5) / count - 0.5), line.depth / 2) for k in range(count)]


def _between_beams(places: Sequence[Place], beams: BeamGrid | None) -> list[Place]:
    if beams is None:
        return list(places)
    return [(frame, *frame.to_local(*beams.between(*frame.at(u, v)[:2]))) for frame, u, v in places]


def _lamps_of_room(
    count: int, lines: Mapping[str, RunLine], box: tuple[float, float, float, float], room: Room
) -> list[Place]:
    """Places of lamps in rows all over a room, away from its walls, islands and columns."""
    x0, y0, x1, y1 = box
    rows = 1 if count <= 2 else 2
    if y1 - y0 > x1 - x0:
        rows = -(-count // rows)
    per = -(-count // rows)
    out = []
    for k in range(count):
        row, column = divmod(k, per)
        x = x0 + (x1 - x0) * (column + 0.5) / per
        y = y1 - (y1 - y0) * (row + 0.5) / rows
        away = (-LAMP_FROM_WALL_M, LAMP_FROM_WALL_M)
        beside = ((x + dx, y + dy) for dx in away for dy in away)
        islands = [n for n in lines.values() if not n.at_wall]  # a lamp there would hang among their own
        is_crowded = any(_is_in(n.frame, (0.0, n.length), (0.0, n.depth), x, y, LAMP_FROM_ISLAND_M) for n in islands)
        for c in room.columns:
            is_crowded |= _is_in(c.frame, (c.left, c.right), (c.back, c.front), x, y, LAMP_FROM_COLUMN_M)
        if all(room.contains(*p) for p in beside) and not is_crowded:
            out.append((WallFrame(x0, y1, 0), x - x0, y1 - y))
    return out


def _is_at_hood(slot: UnitSlot, x: float, y: float, gap: float) -> bool:
    u, v = slot.line.frame.to_local(x, y)
    return abs(u - slot.middle) < CHIMNEY_WIDTH_M / 2 + gap and v < CHIMNEY_DEPTH_M + gap


def _is_in(frame: WallFrame, us: Vec2, vs: Vec2, x: float, y: float, gap: float) -> bool:
    """True if a point lies in a rectangle along a line and before it, or less than a gap from it, metres."""
    u, v = frame.to_local(x, y)
    return us[0] - gap < u < us[1] + gap and vs[0] - gap < v < vs[1] + gap


def order_floor_items(order: BuildOrder) -> None:
    """Order the items on the floor."""
    plan, room, parameters, models = order.kitchen.plan, order.kitchen.room, order.kitchen.parameters, order.models
    for item in plan.floor_items:
        at = ("floor_items", item.id)
        if not models.has(item.item):
            continue
        wall = wall_of(plan, room, item.wall, *at, "wall")
        u = resolve_length(plan, item.at, parameters, *at, "at")
        v = resolve_length(plan, item.from_wall, parameters, *at, "from_wall")
        spot = Spot(wall.frame, u, v, 0.0005, item.turn_deg, DepthReference.MIDDLE)
        order.add(item.id, item.item, models.for_role(item.item).choice, spot)
