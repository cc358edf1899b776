"""Lay out the floor units of a run between its corners."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from casa_assets.errors import PlanConflict
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.rows import WidthRange, share_widths
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import CornerKind, Plan, Run, RunCorner
from casa_assets.model.kitchen.units import TALL, BaseKind, BaseUnit, RunSide, UpperKind, UpperUnit

TOUCH_M = 0.002  # an end that is so near to a wall stands at it
MAX_FILLER_M, MIN_STRIP_M = 0.12, 0.02
FRIDGE_FROM_WALL_M = 0.02  # between a wall and the place of a refrigerator, with the room beside it that it has anyway
BACK_EDGE_M = 0.01  # least distance that a worktop stands out behind a run that stands at no wall


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


def base_slots(plan: Plan, line: RunLine, models: StyleModels) -> tuple[UnitSlot, ...]:
    """The units on the floor from left to right, with corners and strips. Raises PlanConflict where they do not fit."""
    units = line.run.base
    available = line.length - line.left.base_length - line.right.base_length
    spans = [standard_sizes.base_span(u, models) for u in units]
    widths = share_widths(spans, available - room_at_walls(line))
    if widths is None:
        needed = f"at least {sum(s.minimum for s in spans):.3f} m ({describe_units(units, spans)})"
        most = available - room_at_walls(line)
        raise PlanConflict(plan.id, ("runs", line.id, "base"), f"units that need at most {most:.3f} m", needed)
    rest = round(available - sum(widths), 3)
    least = _from_walls(line)
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
        slots.append(_strip(line, f"{line.id}_strip_left", left, left + first, _strip_height(units[:1], top)))
    left = round(left + first, 4)
    for k, (unit, width) in enumerate(zip(units, widths, strict=True)):
        height = standard_sizes.UPPER_TO if _is_tall(units, k) else top
        slots.append(_base_slot(line, unit, left, round(left + width, 4), height))
        left = round(left + width, 4)
    if last >= MIN_STRIP_M and not _stands_free(units[-1:]):
        slots.append(_strip(line, f"{line.id}_strip_right", left, left + last, _strip_height(units[-1:], top)))
    return (*slots, *corner_slots(line, RunSide.RIGHT, top))


def room_at_walls(line: RunLine) -> float:
    """Length of a run between refrigerators and the walls next to them, which the pulls of their doors need, metres."""
    return sum(_from_walls(line))


def _from_walls(line: RunLine) -> tuple[float, float]:
    """The same at the left and at the right end."""

    def least(end: LineEnd, units: tuple[BaseUnit, ...]) -> float:
        is_beside = end.kind is RunEnd.WALL and any(unit.kind is BaseKind.FRIDGE for unit in units)
        return FRIDGE_FROM_WALL_M if is_beside else 0.0

    return least(line.left, line.run.base[:1]), least(line.right, line.run.base[-1:])


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
    """True if a unit needs air next to it instead of a strip: a freestanding refrigerator."""
    return any(u.kind is BaseKind.FRIDGE and not u.housing for u in units)


def _strip_height(units: tuple[BaseUnit, ...], top: float) -> float:
    """Height of a strip next to a unit, metres."""
    return standard_sizes.UPPER_TO if units and units[0].kind in TALL else top


def _strip(line: RunLine, name: str, left: float, right: float, top: float) -> UnitSlot:
    return UnitSlot(name, CornerPart.FILLER, line, round(left, 4), round(right, 4), standard_sizes.BASE_DEPTH, 0.0, top)


def corner_slots(line: RunLine, side: RunSide, top: float, is_upper: bool = False) -> tuple[UnitSlot, ...]:
    """Slot that a corner adds at one end of a run: a corner cabinet, or a strip next to that of the other run.

    Args:
        top: height of the slot's upper edge, metres.
        is_upper: whether the corner of the wall units is meant.
    """
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
