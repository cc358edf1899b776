"""Order the room itself: floor, walls with openings, windows, doors, skirting, ceiling and its beams."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.build_order import (
    BeamGrid,
    BuildOrder,
    DepthReference,
    HeightReference,
    KitchenRequest,
    Spot,
    numbered,
)
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.clearances import DOOR_FRAME_M
from casa_assets.layouts.plan.room import WALL_THICKNESS_M, Room, WallFrame, WallHole, WallLine, resolve_length, wall_of
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import (
    BaseKind,
    Closet,
    ColumnShape,
    OpeningKind,
    Plan,
    PlanOpening,
    UpperKind,
    WallItem,
)
from casa_assets.model.kitchen.style import RoomStyle
from casa_assets.model.record import Vec2

BEAM_SPACING_M = 1.1  # metres from beam to beam
MIN_COUNT, MAX_COUNT = 3, 8
MAX_COUNT_CHANGE = 2  # more or fewer than usual, which look as good
BEAM_HEIGHT_M, OVER_UNITS_M = 0.16, 0.08  # as the family of ceilings has it; of a cornice, with a gap
HOOD_DEPTH_M = 0.55
CHIMNEY_WIDTH_M = 0.5  # of most hoods, with a gap; only it reaches the ceiling
CASING_WIDTH_M = 0.07
SKIRTING_HEIGHT_M = 0.098  # fronts over a plinth of 0.1 m pass over it
SKIRTING_DEPTH_M, WAINSCOT_DEPTH_M = 0.017, 0.034
WAINSCOT_HEIGHT_M = 0.92  # as high as worktops
# Units that open beside a wall, and so far before their fronts that a lining would be in their way.
FLAPS, FRONTS = (BaseKind.RANGE, BaseKind.DISHWASHER), (
    BaseKind.DOORS, BaseKind.DRAWERS, BaseKind.SINK, BaseKind.HOB, BaseKind.PANTRY, BaseKind.OVEN, BaseKind.MICROWAVE,
    BaseKind.FRIDGE,
)  # fmt: skip
OPEN_BEFORE_M, FRIDGE_OPEN_BEFORE_M = 0.8, 1.1
WALL_PLAY_M = 0.004  # gap between a wall and what is built into it
MIN_LINING_M, LINING_PLAY_M = 0.3, 0.004  # of a piece of skirting or panelling; gap at its ends, both together
NICHE_HEAD_M = 0.05  # by which a window in a niche may come nearer to its head than to a ceiling
SLAB_M = 0.05  # thickness of the floor of a niche or closet
CLOSET_HEIGHT_M = 2.5  # at most, of a closet
# Shelves in a closet: their usual depth, height and greatest width, and what is free at their ends.
LARDER_DEPTH_M, LARDER_HEIGHT_M, LARDER_MOST_M, LARDER_PLAY_M = 0.35, 2.0, 1.2, 0.003
# A lever of a tap turns back to 0.027 m from the wall, at most so high above the floor that a window over this height
# has its sill over it; the sill of a lower one stands out less.
TAP_LEVERS_M, SILL_BEHIND_TAP_M = 1.08, 0.02


def beams_of(kitchen: KitchenRequest) -> BeamGrid | None:
    """The beams of a style that has some, clear of the hoods and the columns that reach the ceiling.

    If the plan has a row of lamps, the beams run along it, so that it hangs between two of them. None if the style has
    no beams, or the ceiling is so low that they would reach down to cabinets.
    """
    plan, style, room, lines, slots = kitchen.plan, kitchen.style, kitchen.room, kitchen.lines, kitchen.slots
    highest = max((s.top for row in slots.values() for s in row if s.kind is not UpperKind.HOOD), default=0.0)
    if style.room.beams is None or room.height - BEAM_HEIGHT_M < highest + OVER_UNITS_M - 1e-6:
        return None
    (x0, y0), (x1, y1) = room.level_bounds()
    rows = [lines[lamps.over] for lamps in plan.lamps if lamps.over is not None and lamps.over in lines]
    directions = (rows[0].frame.quarter_turns % 2 == 0,) if rows and rows[0].frame.is_aligned else (False, True)
    usual, every = (
        [w for along_x in directions for w in _grids(along_x, *((y0, y1) if along_x else (x0, x1)), off)]
        for off in (MAX_COUNT_CHANGE, MAX_COUNT)
    )
    for grids, reach in ((usual, None), (every, None), (every, CHIMNEY_WIDTH_M)):
        for grid in grids:
            columns = [[corner[1 if grid.along_x else 0] for corner in placed.outline] for placed in room.columns]
            ends = [*_hoods(slots, grid.along_x, reach), *((min(us), max(us)) for us in columns)]
            if not any(grid.crosses(*span) for span in ends):
                return grid
    return usual[0]


def _grids(along_x: bool, low: float, high: float, off: int) -> list[BeamGrid]:
    """Beams across a room, the usual number of them first, then up to `off` more or fewer."""
    usual = min(max(round((high - low) / BEAM_SPACING_M), MIN_COUNT), MAX_COUNT)
    counts = sorted(range(MIN_COUNT, MAX_COUNT + 1), key=lambda n: (abs(n - usual), n))
    return [BeamGrid(along_x, low, high, n) for n in counts if abs(n - usual) <= off]


def _hoods(slots: Mapping[str, Sequence[UnitSlot]], along_x: bool, wide: float | None) -> Iterator[Vec2]:
    """From where to where hoods reach across the beams, metres; of each no more than the middle that is so wide."""
    axis = 1 if along_x else 0
    for slot in (s for row in slots.values() for s in row if s.kind is UpperKind.HOOD):
        middle, half = (slot.left + slot.right) / 2, (slot.right - slot.left) / 2
        half = half if wide is None else min(half, wide / 2)
        ends = [slot.line.frame.at(u, v)[axis] for u in (middle - half, middle + half) for v in (0.0, HOOD_DEPTH_M)]
        yield min(ends), max(ends)


def find_holes(
    plan: Plan, room: Room, parameters: Mapping[str, float], slots: Mapping[str, UnitSlot]
) -> tuple[WallHole, ...]:
    """All openings in their walls; windows also in the backs of niches before them in the plan. Raises PlanConflict."""
    out: list[WallHole] = []
    for opening in plan.openings:
        at = ("openings", opening.id)
        niche = next((h for h in out if h.opening.id == opening.wall and h.back is not None), None)
        if niche is not None and niche.back is not None:
            wall, low, top = niche.back, niche.bottom, niche.top + NICHE_HEAD_M
        else:
            wall = wall_of(plan, room, opening.wall, *at, "wall")
            low, top = 0.0, room.height_of(wall)
        middle = position_on_wall(plan, wall, opening, parameters, slots, *at)
        # A niche over a unit is as wide as that where the plan does not say.
        fits_unit = opening.kind is OpeningKind.NICHE and "width" not in opening.model_fields_set
        width = slots[opening.over].width if fits_unit and opening.over is not None else opening.width
        left, right = round(middle - width / 2, 4), round(middle + width / 2, 4)
        high = round(opening.bottom + opening.height, 4)
        top = min(top, room.ceiling_over(wall.frame, (left, right), (0.0, 0.0)))
        if left < 0.05 or right > wall.length - 0.05 or high > top - 0.1 or opening.bottom < low:
            got = f"{left:.2f} to {right:.2f} m, up to {high:.2f} m"
            raise PlanConflict(plan.id, at, f"a hole inside {wall.length:.2f} x {top:.2f} m", got)
        if niche is not None and opening.kind is not OpeningKind.WINDOW:
            raise PlanConflict(plan.id, (*at, "kind"), "a window, in the back of a niche", opening.kind.value)
        back = None
        if opening.kind is OpeningKind.NICHE:
            assert opening.depth is not None, "the record has it for niches"
            back = WallLine(opening.id, wall.frame.offset(left, -opening.depth), round(right - left, 4), False)
        hole = WallHole(opening, wall, left, right, opening.bottom, high, back)
        out.append(replace(hole, behind_tap=hole.is_window and _is_behind_tap(hole, slots.values())))
    return tuple(out)


def _is_behind_tap(hole: WallHole, slots: Iterable[UnitSlot]) -> bool:
    """True if a sink is at the wall under an opening whose lower edge is no higher than the levers of its tap."""
    if hole.bottom > TAP_LEVERS_M:
        return False
    sinks = [s for s in slots if s.kind is BaseKind.SINK and s.line.run.on == hole.wall.id]
    ends = [[hole.wall.frame.to_local(*s.line.frame.at(u, 0.0)[:2])[0] for u in (s.left, s.right)] for s in sinks]
    return any(a < hole.right and b > hole.left for a, b in ends)


def in_niches(slots: Mapping[str, Sequence[UnitSlot]], holes: Sequence[WallHole]) -> dict[str, tuple[UnitSlot, ...]]:
    """Units, with refrigerators set back into the niches behind them that begin at the floor and are wide enough."""
    niches = [h for h in holes if h.is_niche and h.bottom == 0.0]

    def recess(slot: UnitSlot) -> float:
        for hole in niches if slot.stands_free and slot.line.at_wall else ():
            start = hole.wall.frame.to_local(slot.line.frame.x, slot.line.frame.y)[0]
            left, right = slot.left + start, slot.right + start
            if hole.wall.id == slot.line.run.on and hole.left <= left + 1e-6 and right <= hole.right + 1e-6:
                return float(hole.opening.depth or 0.0)
        return 0.0

    return {name: tuple(replace(s, recess=recess(s)) for s in row) for name, row in slots.items()}


def position_on_wall(
    plan: Plan,
    wall: WallLine,
    item: PlanOpening | WallItem,
    parameters: Mapping[str, float],
    slots: Mapping[str, UnitSlot],
    *pointer: str,
) -> float:
    """Distance of an item's centre from the left end of its wall, metres. Raises PlanConflict."""
    if item.over is None:
        assert item.at is not None, "the record has one of both"
        return resolve_length(plan, item.at, parameters, *pointer, "at")
    if item.over not in slots:
        raise PlanConflict(plan.id, (*pointer, "over"), "a unit of the plan", repr(item.over))
    slot = slots[item.over]
    return wall.frame.to_local(*slot.line.frame.at(slot.middle, 0.0)[:2])[0]


def order_shell(order: BuildOrder) -> None:
    """Add floor, walls, windows, doors and ceiling."""
    room, shell = order.kitchen.room, order.kitchen.style.room
    (x0, y0), (x1, y1) = room.bounds()
    outline = [(round(x - x0, 5), round(y - y0, 5)) for x, y in room.outline]
    boards = "y" if shell.turn_deg % 180 else "x"
    floor = {"outline": outline, "face": shell.floor, "boards": boards}
    spot = Spot(WallFrame(x0, y1, 0), (x1 - x0) / 2, 0.0, 0.0, height_reference=HeightReference.HEAD)
    order.add("floor", "floor", "room_floor/oak_boards", spot, floor, layer="room")
    _order_ceiling(order, room, shell)
    _order_columns(order, room, shell)
    for wall in room.walls:
        if wall.open and not order.closed:
            continue
        own_holes = [h for h in order.kitchen.holes if h.wall.id == wall.id]
        _order_wall(order, wall, own_holes)
        for hole in own_holes:
            _order_opening(order, hole)


def _order_ceiling(order: BuildOrder, room: Room, shell: RoomStyle) -> None:
    beams = order.beams
    (x0, y0), (x1, y1) = room.level_bounds()
    outline = [(round(x - x0, 5), round(y - y0, 5)) for x, y in room.level_outline]
    ceiling: dict[str, Any] = {"outline": outline, "face": shell.ceiling, "trim": shell.trim}
    if beams is not None:
        ceiling["beams"] = {"count": beams.count, "run": "x" if beams.along_x else "y", "finish": shell.beams}
    top = Spot(WallFrame(x0, y1, 0), (x1 - x0) / 2, 0.0, room.height, height_reference=HeightReference.FOOT)
    order.add("ceiling", "ceiling", "room_ceiling/white_plain", top, ceiling, layer="ceiling")
    for k, slope in enumerate(room.slopes):
        length, wide = slope.wall.length, round(math.hypot(slope.run, room.height - slope.knee), 5)
        corners = [(0.0, 0.0), (length, 0.0), (length, wide), (0.0, wide)]
        sides = {"outline": corners, "boards": "x", "face": shell.ceiling, "trim": shell.trim}
        spot = Spot(slope.wall.frame, length / 2, 0.0, slope.knee, tilt_deg=slope.pitch_deg)
        order.add(f"ceiling_slope_{k + 1}", "ceiling", "room_ceiling/white_plain", spot, sides, layer="ceiling")


def _order_columns(order: BuildOrder, room: Room, shell: RoomStyle) -> None:
    for placed in room.columns:
        column = placed.column
        params = {
            "width": column.width,
            "depth": column.depth,
            "height": room.height,
            "is_round": column.shape is ColumnShape.ROUND,
            "at_wall": placed.back == 0.0,
            "face": shell.wall,
            "trim": shell.trim,
        }
        spot = Spot(placed.frame, placed.u, placed.back, 0.0)
        order.add(column.id, "column", "room_column/plaster_square", spot, params, layer="room")


def _order_opening(order: BuildOrder, hole: WallHole) -> None:
    models, shell = order.models, order.kitchen.style.room
    if hole.is_niche:
        is_seat = hole.bottom > 0.0
        board = models.style.cabinets.shelf if is_seat else shell.floor
        _threshold(order, hole, board)
        within = [h for h in order.kitchen.holes if hole.back is not None and h.wall.id == hole.back.id]
        depth = (hole.opening.depth or 0.0) - WALL_THICKNESS_M
        _order_recess(order, hole, hole.right - hole.left, depth, within, board, shell)
        for window in within:
            _order_window_or_door(order, window, models)
        return
    if not hole.is_window:
        _threshold(order, hole, shell.floor)
    _order_window_or_door(order, hole, models)
    if hole.opening.closet is not None:
        _order_closet(order, hole, hole.opening.closet)


def _order_recess(
    order: BuildOrder,
    hole: WallHole,
    width: float,
    depth: float,
    windows: Sequence[WallHole],
    floor: str,
    shell: RoomStyle,
    height: float | None = None,
) -> None:
    """The room behind a wall, from its outer face; a niche is as high as its hole."""
    tall = round((hole.top if height is None else height) - hole.bottom, 4)
    params = {
        "width": round(width, 4),
        "depth": round(depth, 4),
        "height": tall,
        "walls": WALL_THICKNESS_M,
        "base": SLAB_M,
        "lip": WALL_THICKNESS_M if hole.is_niche else 0.0,
        "openings": [_cut(w, round(w.bottom - hole.bottom, 4)) for w in windows],
        "inside": shell.wall,
        "floor": floor,
    }
    # The lining of a niche begins at the inner face of the wall, a closet at the outer one.
    front = 0.0 if hole.is_niche else -WALL_THICKNESS_M
    middle, foot = (hole.left + hole.right) / 2, round(hole.bottom - SLAB_M, 4)
    spot = Spot(hole.wall.frame, middle, front, foot, depth_reference=DepthReference.FRONT)
    order.add(f"recess_{hole.opening.id}", "recess", "room_recess/fridge_niche", spot, params, layer="room")


def _order_closet(order: BuildOrder, hole: WallHole, closet: Closet) -> None:
    """A closet behind a door or passage, with open shelves along its back."""
    shell = order.kitchen.style.room
    high = min(order.kitchen.room.height_of(hole.wall), CLOSET_HEIGHT_M)
    _order_recess(order, hole, closet.width, closet.depth, (), shell.floor, shell, high)
    if not closet.shelves:
        return
    face = order.kitchen.style.cabinets.shelf
    count = math.ceil((closet.width - 2 * LARDER_PLAY_M) / LARDER_MOST_M)
    width = round((closet.width - 2 * LARDER_PLAY_M) / count, 4)
    deep = round(min(LARDER_DEPTH_M, closet.depth - 0.3), 3)
    for k in range(count):
        params = {
            "width": round(width - 0.001, 4),
            "depth": deep,
            "height": LARDER_HEIGHT_M,
            "plinth": 0.08,
            "shelves": closet.shelves,
            "face": face,
            "inside": face,
        }
        u = (hole.left + hole.right) / 2 - closet.width / 2 + LARDER_PLAY_M + (k + 0.5) * width
        spot = Spot(hole.wall.frame, round(u, 5), -WALL_THICKNESS_M - closet.depth + 0.002, 0.0)
        order.add(numbered(f"{hole.opening.id}_larder", k), "larder", "open_shelf/pine_floor", spot, params)


def _order_wall(order: BuildOrder, wall: WallLine, holes: Sequence[WallHole]) -> None:
    room = order.kitchen.room
    walls = room.walls
    after = walls[(walls.index(wall) + 1) % len(walls)]
    # Of two walls that meet at a right angle, the left one closes the corner; an outer corner needs none.
    is_closed_by_next = wall.right_outer_corner or wall.right_aslant or (after.open and not order.closed)
    right_more = 0.0 if is_closed_by_next else WALL_THICKNESS_M
    # At an outer corner the two walls would overlap: the first one ends earlier.
    length = round(wall.length - (WALL_THICKNESS_M if wall.right_outer_corner else 0.0), 5)
    params = {
        "length": length,
        "height": room.height_of(wall),
        "thickness": WALL_THICKNESS_M,
        "left_more": 0.0,
        "right_more": right_more,
        "openings": [_cut(h, _foot_of(h)) for h in holes],
        "inside": order.kitchen.style.room.wall,
    }
    before = walls[walls.index(wall) - 1]
    for key, beside in (("left_slope", before), ("right_slope", after)):
        slope = next((s for s in room.slopes if s.wall.id == beside.id), None)
        if slope is not None:
            params[key] = {"knee": slope.knee, "run": slope.run}
    spot = Spot(wall.frame, length / 2, -WALL_THICKNESS_M, 0.0)
    order.add(f"wall_{wall.id}", "wall", "room_wall/plaster_bare", spot, params, layer="room")


def _cut(hole: WallHole, bottom: float) -> dict[str, float]:
    """The hole of an opening, as families of slabs take it. bottom: of the hole above the foot of the slab, metres."""
    width, height = round(hole.right - hole.left, 4), round(hole.top - _foot_of(hole), 4)
    return {"left": hole.left, "bottom": bottom, "width": width, "height": height}


def _foot_of(hole: WallHole) -> float:
    """Height at which a hole in a wall begins, metres: that of a niche over the floor holds its slab too."""
    return round(hole.bottom - SLAB_M, 4) if hole.is_niche and hole.bottom > 0.0 else hole.bottom


def _threshold(order: BuildOrder, hole: WallHole, face: str) -> None:
    """The floor in the thickness of the wall, of a niche where that begins."""
    wide = round(hole.right - hole.left, 4)
    outline = [(0.0, 0.0), (wide, 0.0), (wide, WALL_THICKNESS_M), (0.0, WALL_THICKNESS_M)]
    low = hole.bottom if hole.is_niche else 0.0
    middle = (hole.left + hole.right) / 2
    spot = Spot(hole.wall.frame, middle, -WALL_THICKNESS_M, low, height_reference=HeightReference.HEAD)
    params = {"outline": outline, "face": face}
    order.add(f"threshold_{hole.opening.id}", "floor", "room_floor/oak_boards", spot, params, layer="room")


def _order_window_or_door(order: BuildOrder, hole: WallHole, models: StyleModels) -> None:
    opening = hole.opening
    if opening.kind is OpeningKind.PASSAGE:
        return
    role = "window" if hole.is_window else "door"
    model = models.for_role(role)
    width, height = round(hole.right - hole.left - WALL_PLAY_M, 4), round(hole.top - hole.bottom - WALL_PLAY_M / 2, 4)
    casing = float(model.params.get("casing", CASING_WIDTH_M))
    params = {**model.choice.params, "width": width, "height": height, "wall": WALL_THICKNESS_M}
    if hole.behind_tap:
        params["sill"] = min(float(model.params.get("sill", SILL_BEHIND_TAP_M)), SILL_BEHIND_TAP_M)
    if not hole.is_window:
        # A window is as wide as its frame, a door as its leaf.
        params["width"] = round(width - 2 * DOOR_FRAME_M, 4)
        params["height"] = round(height - DOOR_FRAME_M - WALL_PLAY_M, 4)
        params["hinge_right"] = opening.hinge.value == "right"
    middle, high = (hole.left + hole.right) / 2, round(hole.top + casing - WALL_PLAY_M / 2, 4)
    spot = Spot(hole.wall.frame, middle, -WALL_THICKNESS_M, high, height_reference=HeightReference.HEAD)
    order.add(opening.id, role, model.choice.preset, spot, params, layer="room")


def order_skirting(order: BuildOrder) -> None:
    """Skirting, or panelling if the style has it, along every free stretch of wall."""
    kitchen, models = order.kitchen, order.models
    room = kitchen.room
    high = WAINSCOT_HEIGHT_M if models.style.room.wainscot else SKIRTING_HEIGHT_M
    for wall in room.walls:
        if wall.open and not order.closed:
            continue
        beside = casing_width(models)
        own_holes = [h for h in kitchen.holes if h.wall.id == wall.id and h.bottom < high + CASING_WIDTH_M]
        occupied = [(h.left - beside, h.right + beside) for h in own_holes]
        occupied += _occupied_by_units(wall, kitchen)
        occupied += _occupied_by_columns(wall, room)
        occupied += _opened_beside(wall, kitchen, FLAPS + FRONTS if models.style.room.wainscot else FLAPS)
        occupied = [(a, b) for a, b in occupied if b > 0.0 and a < wall.length]
        # In an inner corner it ends before that of the wall beside.
        at, k = WAINSCOT_DEPTH_M if models.style.room.wainscot else SKIRTING_DEPTH_M, 0
        for a, b in [*sorted(occupied), (wall.length, wall.length)]:
            if a - at - LINING_PLAY_M >= MIN_LINING_M:
                k += 1
                spot = Spot(wall.frame, (at + a) / 2, 0.0, 0.0)
                preset, params = _lining(round(a - at - LINING_PLAY_M, 4), models.style.room)
                order.add(f"skirting_{wall.id}_{k}", "skirting", preset, spot, params, layer="room")
            at = max(at, b)


def _lining(length: float, shell: RoomStyle) -> tuple[str, dict[str, Any]]:
    if shell.wainscot:
        panels = {"height": WAINSCOT_HEIGHT_M, "panels": shell.wainscot}
        return "wall_panelling/white_flat", {"length": length, **panels, "face": shell.trim}
    strip = {"height": SKIRTING_HEIGHT_M, "profile": shell.skirting}
    return "skirting/white_bevel", {"length": length, **strip, "face": shell.trim}


def casing_width(models: StyleModels, role: str = "door") -> float:
    """Distance by which the casing of a door or a window extends to the sides of its hole, metres."""
    return float(models.for_role(role).params.get("casing", CASING_WIDTH_M)) if models.has(role) else CASING_WIDTH_M


def _occupied_by_units(wall: WallLine, kitchen: KitchenRequest) -> list[tuple[float, float]]:
    """Intervals of a wall that units occupy, including units of runs along the adjoining walls."""
    out, lines, slots = [], kitchen.lines, kitchen.slots
    for name, line in lines.items():
        for slot in slots[name]:
            if slot.is_upper or slot.kind is BaseKind.GAP:
                continue
            # Worktops stand out before fronts, and panels behind what stands at no wall.
            back = 0.0 if line.at_wall else -2 * standard_sizes.END_PANEL - line.run.overhang
            front = slot.depth + standard_sizes.WORKTOP_OVERHANG + WALL_PLAY_M
            out += _touched_interval(wall, line, (slot.left, slot.right), (back, front))
    for first, second in (corner.runs for corner in kitchen.plan.corners):
        # A corner of two runs may be empty below its worktop; it counts as occupied.
        a, b = lines[first], lines[second]
        last, begin = max(s.right for s in slots[first]), min(s.left for s in slots[second])
        out += _touched_interval(wall, a, (last, last + b.depth + standard_sizes.WORKTOP_OVERHANG), (0.0, a.depth))
        out += _touched_interval(wall, b, (begin - a.depth - standard_sizes.WORKTOP_OVERHANG, begin), (0.0, b.depth))
    return out


def _opened_beside(wall: WallLine, kitchen: KitchenRequest, kinds: Sequence[BaseKind]) -> list[tuple[float, float]]:
    """Intervals of a wall along which units of some kinds open that are right next to it."""
    out = []
    for name, line in kitchen.lines.items():
        row = [s for s in kitchen.slots[name] if not s.is_upper]
        # The pull of an open refrigerator reaches beyond a strip beside it.
        fridges = [s for s in row[1:-1] if s.kind is BaseKind.FRIDGE]
        for slot in row[:1] + row[-1:] + fridges:
            for at, gap in ((slot.left, slot.left), (slot.right, line.length - slot.right)):
                if line.at_wall and slot.kind in kinds and gap < WAINSCOT_DEPTH_M:
                    reach = FRIDGE_OPEN_BEFORE_M if slot.kind is BaseKind.FRIDGE else OPEN_BEFORE_M
                    before = (slot.depth, slot.depth + reach)
                    out += _touched_interval(wall, line, (at - 0.01, at + 0.01), before)
    return out


def _occupied_by_columns(wall: WallLine, room: Room) -> list[tuple[float, float]]:
    out = []
    for placed in room.columns:
        along, before = zip(*(wall.frame.to_local(x, y) for x, y in placed.outline), strict=True)
        if min(before) < WAINSCOT_DEPTH_M + 0.01:
            out.append((min(along), max(along)))
    return out


def _touched_interval(wall: WallLine, line: RunLine, us: Vec2, vs: Vec2) -> list[tuple[float, float]]:
    """Interval of a wall that a rectangle (u and v ranges on a line) touches; empty where it does not."""
    found = [wall.frame.to_local(*line.frame.at(u, v)[:2]) for u in us for v in vs]
    along, before = zip(*found, strict=True)
    return [(min(along), max(along))] if min(before) < 0.05 and max(before) > -0.05 else []
