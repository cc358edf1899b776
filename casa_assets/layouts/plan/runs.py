"""Place the runs of a plan, and lay out the units of each between its corners, on the floor and on the wall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.errors import PlanConflict
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Room, WallFrame, WallLine, resolve_length, wall_of
from casa_assets.layouts.plan.standard_sizes import WidthRange, share_widths
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import (
    TALL,
    BaseKind,
    BaseUnit,
    CornerKind,
    IslandSide,
    Plan,
    Run,
    RunCorner,
    RunSide,
    UpperKind,
    UpperUnit,
)

TOUCH_M = 0.002  # an end that is so near to a wall stands at it
MAX_FILLER_M, MIN_STRIP_M = 0.12, 0.02
FRIDGE_FROM_WALL_M = 0.02  # between a wall and the place of a refrigerator, with the room beside it that it has anyway
BACK_EDGE_M = 0.01  # least distance that a worktop stands out behind a run that stands at no wall
MIN_LENGTH_M = 0.3  # of a run at a wall


@dataclass(frozen=True)
class LineEnd:
    """An end of a run, and the lengths that a corner takes of its base and wall units, metres."""

    kind: RunEnd
    corner: RunCorner | None = None
    base_length: float = 0.0
    upper_length: float = 0.0


@dataclass(frozen=True)
class RunLine:
    """A run in the room: units extend from `frame` (their backs) to `depth` metres in front of it."""

    run: Run
    frame: WallFrame
    length: float
    depth: float
    left: LineEnd = LineEnd(RunEnd.FREE)
    right: LineEnd = LineEnd(RunEnd.FREE)

    @property
    def id(self) -> str:
        """Id of the run."""
        return self.run.id

    @property
    def at_wall(self) -> bool:
        """True if it is at a wall."""
        return self.run.on is not None

    @property
    def is_island(self) -> bool:
        """True if it is free on all sides."""
        return self.run.faces is not None

    @property
    def has_back(self) -> bool:
        """True if it needs panels behind it: it is not at a wall, and its units have no finished back."""
        return not self.at_wall and all(u.kind is not BaseKind.ISLAND for u in self.run.base)

    @property
    def depth_behind(self) -> float:
        """Metres that its worktop reaches behind its line: over its back panel, and to the seats; 0 at a wall."""
        if self.at_wall:
            return 0.0
        panel = standard_sizes.END_PANEL if self.has_back else 0.0
        return round(panel + max(self.run.overhang, BACK_EDGE_M), 4)


class CornerPart(StrEnum):
    """Units that plans do not name: corner units, and strips that close gaps."""

    BLIND = "corner_blind"
    DIAGONAL = "corner_diagonal"
    FILLER = "filler"


@dataclass(frozen=True)
class UnitSlot:
    """The space of one unit, in the frame of its run.

    Attributes:
        name: of the unit. kind: of unit, or of corner part. unit: as the plan has it, None for a corner part.
        line: its run. left, right: along it. depth: from its back. bottom, top: above the floor. All metres.
        hinge: side of a single door. corner: side of it on which a corner lies.
        recess: how far it is set back into a niche behind its line, metres.
    """

    name: str
    kind: BaseKind | UpperKind | CornerPart
    line: RunLine
    left: float
    right: float
    depth: float
    bottom: float
    top: float
    unit: BaseUnit | UpperUnit | None = None
    hinge: RunSide | None = None
    corner: RunSide | None = None
    recess: float = 0.0

    @property
    def width(self) -> float:
        """Metres."""
        return round(self.right - self.left, 4)

    @property
    def middle(self) -> float:
        """Along the run, metres."""
        return (self.left + self.right) / 2

    @property
    def is_upper(self) -> bool:
        """True if it hangs on the wall."""
        return self.bottom > 1.0

    @property
    def stands_free(self) -> bool:
        """True for a refrigerator without panels at its sides, which needs air beside it."""
        return isinstance(self.unit, BaseUnit) and _stands_free((self.unit,))


def base_slots(plan: Plan, line: RunLine, models: StyleModels) -> tuple[UnitSlot, ...]:
    """The units on the floor from left to right, with corners and strips. Raises PlanConflict where they do not fit."""
    units = line.run.base
    available = line.length - line.left.base_length - line.right.base_length
    spans = [standard_sizes.base_span(u, models) for u in units]
    least = room_at_walls(line)
    most = available - sum(least)
    widths = share_widths(spans, most)
    if widths is None:
        needed = f"at least {sum(s.minimum for s in spans):.3f} m ({describe_units(units, spans)})"
        raise PlanConflict(plan.id, ("runs", line.id, "base"), f"units that need at most {most:.3f} m", needed)
    rest = round(available - sum(widths), 3)
    spare = round(rest - sum(least), 3)
    first, last = _strip_widths(plan, line, spare) if spare > 0.0 else (0.0, 0.0)
    first, last = round(first + least[0], 4), round(last + least[1], 4)
    worktop = models.style.island if line.is_island else models.style.counter
    top = standard_sizes.WORKTOP_HEIGHT - worktop.thickness
    slots: list[UnitSlot] = [*corner_slots(line, RunSide.LEFT, top)]
    left = line.left.base_length
    # A row with a free end begins later where a strip would have to be too wide.
    is_closed = line.left.kind is not RunEnd.FREE or first <= MAX_FILLER_M
    if is_closed and first >= MIN_STRIP_M and not _stands_free(units[:1]):
        slots.append(_strip(line, f"{line.id}_strip_left", left, left + first, units[:1], top))
    left = round(left + first, 4)
    for k, (unit, width) in enumerate(zip(units, widths, strict=True)):
        height = standard_sizes.UPPER_TO if _is_tall(units, k) else top
        slots.append(_base_slot(line, unit, left, round(left + width, 4), height))
        left = round(left + width, 4)
    if last >= MIN_STRIP_M and not _stands_free(units[-1:]):
        slots.append(_strip(line, f"{line.id}_strip_right", left, left + last, units[-1:], top))
    return (*slots, *corner_slots(line, RunSide.RIGHT, top))


def room_at_walls(line: RunLine) -> tuple[float, float]:
    """Room that the pulls of refrigerators need from the walls beside the left and the right end of a run, metres."""
    ends = ((line.left, line.run.base[:1]), (line.right, line.run.base[-1:]))
    left, right = (
        FRIDGE_FROM_WALL_M if end.kind is RunEnd.WALL and any(u.kind is BaseKind.FRIDGE for u in units) else 0.0
        for end, units in ends
    )
    return left, right


def describe_units(units: tuple[BaseUnit, ...] | tuple[UpperUnit, ...], spans: list[WidthRange]) -> str:
    """Units and their least widths, for messages."""
    return ", ".join(f"{u.id} {s.minimum:g}" for u, s in zip(units, spans, strict=True))


def _strip_widths(plan: Plan, line: RunLine, rest: float) -> tuple[float, float]:
    """Widths left over at the left and right end: free ends stop earlier, strips close the gap at walls and corners."""
    if line.right.kind is RunEnd.FREE:
        return 0.0, 0.0
    if line.left.kind is RunEnd.FREE:
        return rest, 0.0
    if rest <= MAX_FILLER_M:
        return (rest, 0.0) if line.left.kind is RunEnd.WALL else (0.0, rest)
    if rest <= 2 * MAX_FILLER_M:
        return round(rest / 2, 3), round(rest - round(rest / 2, 3), 3)
    available = line.length - line.left.base_length - line.right.base_length
    raise PlanConflict(plan.id, ("runs", line.id, "base"), f"units that fill {available:.3f} m", f"{rest:.3f} m less")


def _stands_free(units: tuple[BaseUnit, ...]) -> bool:
    """True if one needs air next to it instead of a strip: a freestanding refrigerator."""
    return any(u.kind is BaseKind.FRIDGE and not u.housing for u in units)


def _strip(line: RunLine, name: str, left: float, right: float, beside: tuple[BaseUnit, ...], top: float) -> UnitSlot:
    high = standard_sizes.UPPER_TO if beside and beside[0].kind in TALL else top
    return UnitSlot(
        name, CornerPart.FILLER, line, round(left, 4), round(right, 4), standard_sizes.BASE_DEPTH, 0.0, high
    )


def corner_slots(line: RunLine, side: RunSide, top: float, is_upper: bool = False) -> tuple[UnitSlot, ...]:
    """Slot that a corner adds at one end of a run, up to `top`, m: a corner cabinet, or a strip next to the other."""
    end = line.left if side is RunSide.LEFT else line.right
    kind = None if end.corner is None else end.corner.upper if is_upper else end.corner.base
    if end.corner is None or kind is None:
        return ()
    is_owner = (end.corner.owner or end.corner.runs[0]) == line.id
    if kind is CornerKind.DIAGONAL and not is_owner:
        return ()
    far, depth, bottom, stem = end.base_length, standard_sizes.BASE_DEPTH, 0.0, f"{line.id}_{side.value}"
    if is_upper:
        far, depth, bottom = end.upper_length, standard_sizes.UPPER_DEPTH, standard_sizes.UPPER_FROM
        stem += "_upper"
    name, part, near = f"{stem}_corner", CornerPart.BLIND, 0.0
    if kind is CornerKind.DIAGONAL:
        part = CornerPart.DIAGONAL
    elif kind is CornerKind.DEAD or not is_owner:
        name, part, near = f"{stem}_filler", CornerPart.FILLER, depth
    left, right = (near, far) if side is RunSide.LEFT else (line.length - far, line.length - near)
    left, right = round(left, 4), round(right, 4)
    return (UnitSlot(name, part, line, left, right, depth, bottom, top, hinge=other_side(side), corner=side),)


def other_side(side: RunSide) -> RunSide:
    """The end that is not this one."""
    return RunSide.RIGHT if side is RunSide.LEFT else RunSide.LEFT


def _is_tall(units: tuple[BaseUnit, ...], k: int) -> bool:
    """True if a unit reaches up to the wall units: tall ones do, and strips and panels next to tall units only."""
    if units[k].kind in (BaseKind.FILLER, BaseKind.PANEL):
        return all(u.kind in TALL for u in (*units[max(0, k - 1) : k], *units[k + 1 : k + 2]))
    return units[k].kind in TALL


def _base_slot(line: RunLine, unit: BaseUnit, left: float, right: float, top: float) -> UnitSlot:
    hinge = unit.hinge
    if hinge is None:
        # Away from a corner, and towards a wall beside it.
        near_left = left - line.left.base_length < TOUCH_M and line.left.kind is RunEnd.WALL
        near_corner = left - line.left.base_length < 0.2 and line.left.kind is RunEnd.CORNER
        ends_at_wall = line.length - right < 0.2 and line.right.kind is RunEnd.WALL
        hinge = RunSide.RIGHT if near_corner or (ends_at_wall and not near_left) else RunSide.LEFT
    return UnitSlot(unit.id, unit.kind, line, left, right, line.depth, 0.0, top, unit=unit, hinge=hinge)


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
            expected, got = f"a unit between {at:.3f} and {end:.3f} m", f"{left:.3f} to {right:.3f} m"
            raise PlanConflict(plan.id, (*pointer, unit.id), expected, got)
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
        length, ends_at_wall = line.left.upper_length, line.length - right < 0.05
        near_corner = left - length < 0.05 and line.left.kind is RunEnd.CORNER and length > 0
        hinge = RunSide.RIGHT if near_corner or ends_at_wall else RunSide.LEFT
    low, high = standard_sizes.UPPER_FROM, standard_sizes.UPPER_TO
    if unit.height is not None:
        low = round(high - unit.height, 4)
    depth = standard_sizes.UPPER_DEPTH
    return UnitSlot(unit.id, unit.kind, line, left, right, depth, low, high, unit=unit, hinge=hinge)


def place_runs(plan: Plan, room: Room, parameters: Mapping[str, float], models: StyleModels) -> dict[str, RunLine]:
    """Place all runs, by id. Raises PlanConflict."""
    _check_names(plan)
    lines: dict[str, RunLine] = {}
    ends = {}
    for corner in plan.corners:
        for name in corner.runs:
            if name not in {r.id for r in plan.runs}:
                raise PlanConflict(plan.id, ("corners",), "runs of the plan", repr(name))
        ends[(corner.runs[0], RunSide.RIGHT)] = _corner_end(corner, 0)
        ends[(corner.runs[1], RunSide.LEFT)] = _corner_end(corner, 1)
    for run in plan.runs:
        left = ends.get((run.id, RunSide.LEFT), LineEnd(RunEnd.FREE))
        right = ends.get((run.id, RunSide.RIGHT), LineEnd(RunEnd.FREE))
        if run.on is not None:
            wall = wall_of(plan, room, run.on, "runs", run.id, "on")
            lines[run.id] = _place_at_wall(plan, run, wall, parameters, left, right)
        else:
            lines[run.id] = _place_free(plan, run, parameters, models, lines, left, right)
    for k, corner in enumerate(plan.corners):
        first, second = (lines[name].frame for name in corner.runs)
        if first.more_deg != second.more_deg:
            got = f"{(first.turn_deg - second.turn_deg) % 360.0:g} degrees between {' and '.join(corner.runs)}"
            raise PlanConflict(plan.id, ("corners", k), "runs that meet at a right angle", got)
        if (first.turn_deg - second.turn_deg) % 360.0 != 90.0:
            expected = "two runs of which the second begins, on its left, where the first ends"
            raise PlanConflict(plan.id, ("corners", k, "runs"), expected, f"{' and '.join(corner.runs)}")
    return lines


def _corner_end(corner: RunCorner, index: int) -> LineEnd:
    """The end of the first (0) or second (1) run of a corner, with the lengths that the corner takes."""
    owner = corner.owner or corner.runs[0]
    is_owner = corner.runs[index] == owner
    door, upper_door = (standard_sizes.CORNER_DOOR, standard_sizes.UPPER_CORNER_DOOR) if is_owner else (0.0, 0.0)
    base = {
        CornerKind.BLIND: standard_sizes.CORNER_CLEARANCE + door,
        CornerKind.DIAGONAL: standard_sizes.DIAGONAL,
        CornerKind.DEAD: standard_sizes.CORNER_CLEARANCE,
    }[corner.base]
    upper = {
        None: 0.0,
        CornerKind.BLIND: standard_sizes.UPPER_CORNER_CLEARANCE + upper_door,
        CornerKind.DIAGONAL: standard_sizes.UPPER_DIAGONAL,
        CornerKind.DEAD: standard_sizes.UPPER_CORNER_CLEARANCE,
    }[corner.upper]
    return LineEnd(RunEnd.CORNER, corner, base, upper)


def _place_at_wall(
    plan: Plan, run: Run, wall: WallLine, parameters: Mapping[str, float], left: LineEnd, right: LineEnd
) -> RunLine:
    at = ("runs", run.id)
    start, end = (resolve_length(plan, x, parameters, *at, n) for x, n in ((run.start, "start"), (run.end, "end")))
    length = round(wall.length - start - end, 4)
    if run.length is not None:
        surplus = round(length - resolve_length(plan, run.length, parameters, *at, "length"), 4)
        if surplus < 0:
            raise PlanConflict(plan.id, (*at, "length"), f"at most {length:.2f} m", f"{length - surplus:.2f} m")
        keeps_right = right.kind is RunEnd.CORNER and left.kind is RunEnd.FREE
        start, end = (start + surplus, end) if keeps_right else (start, end + surplus)
        length = round(length - surplus, 4)
    if length <= MIN_LENGTH_M:
        expected = f"a start and an end that leave some of {wall.length:.2f} m"
        raise PlanConflict(plan.id, at, expected, f"{length:.2f} m")
    if left.kind is RunEnd.FREE and start < TOUCH_M and not wall.left_bare:
        left = LineEnd(RunEnd.WALL)
    if right.kind is RunEnd.FREE and end < TOUCH_M and not wall.right_bare:
        right = LineEnd(RunEnd.WALL)
    return RunLine(run, wall.frame.offset(start), length, standard_sizes.BASE_DEPTH, left, right)


def _place_free(
    plan: Plan,
    run: Run,
    parameters: Mapping[str, float],
    models: StyleModels,
    lines: Mapping[str, RunLine],
    left: LineEnd,
    right: LineEnd,
) -> RunLine:
    at = ("runs", run.id)
    if run.length is not None:
        length = resolve_length(plan, run.length, parameters, *at, "length")
    else:
        units = sum(standard_sizes.base_span(u, models).usual for u in run.base)
        length = round(left.base_length + right.base_length + units, 3)
    other_id = run.faces.run if run.faces else run.joins.run if run.joins else ""
    if other_id not in lines:
        raise PlanConflict(plan.id, at, "a run that stands before it in the plan", repr(other_id))
    other = lines[other_id]
    if run.joins is not None:
        if run.joins.end is RunSide.RIGHT:
            frame = other.frame.offset(other.length, 0.0, -1)
        else:
            frame = other.frame.offset(0.0, 0.0, 1).offset(-length)
        return RunLine(run, frame, length, standard_sizes.BASE_DEPTH, left, right)
    assert run.faces is not None, "the record has one of `on`, `faces` and `joins`"
    is_island = bool(run.base) and run.base[0].kind is BaseKind.ISLAND
    depth = standard_sizes.ISLAND_DEPTH if is_island else standard_sizes.BASE_DEPTH
    unit, middle = run.faces.in_front_of, other.length / 2
    if unit is not None:
        slots = {s.name: s for s in base_slots(plan, other, models)}
        if unit not in slots:
            raise PlanConflict(plan.id, (*at, "faces", "in_front_of"), f"a unit of {other.id}", repr(unit))
        middle = slots[unit].middle
    middle += run.faces.shift
    away = run.faces.aisle + standard_sizes.WORKTOP_OVERHANG + depth
    if run.faces.side is IslandSide.BACK:
        if other.at_wall:
            raise PlanConflict(plan.id, (*at, "faces", "side"), "front, since that run stands at a wall", "'back'")
        frame = other.frame.offset(middle - length / 2, -other.depth_behind - away)
        return RunLine(run, frame, length, depth, left, right)
    back = standard_sizes.WORKTOP_DEPTH + away
    return RunLine(run, other.frame.offset(middle + length / 2, back, 2), length, depth, left, right)


def _check_names(plan: Plan) -> None:
    """Raise PlanConflict where two things of a plan have one name, since placements are named after the plan."""
    seen: set[str] = set()
    names: list[tuple[tuple[str | int, ...], str]] = []
    for run in plan.runs:
        for row, units in (("base", run.base), ("upper", run.upper)):
            names += [(("runs", run.id, row, k), unit.id) for k, unit in enumerate(units)]
    for field in ("openings", "columns", "worktop_items", "tables", "wall_items", "floor_items"):
        names += [((field, item.id), item.id) for item in getattr(plan, field)]
    for pointer, name in names:
        if name in seen:
            raise PlanConflict(plan.id, pointer, "a name of its own", f"a second {name!r}")
        seen.add(name)
