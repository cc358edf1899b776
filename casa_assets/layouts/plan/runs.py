"""Lay out the floor units of a run between its corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from casa_assets.errors import PlanConflict
from casa_assets.layouts.order.models import StyleModels
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.rows import WidthRange, share_widths
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.kitchen.plan import CornerKind, Plan, Run, RunCorner
from casa_assets.model.kitchen.units import TALL, BaseKind, BaseUnit, RunSide, UpperKind, UpperUnit

TOUCHES = 0.002  # metres: an end that is so near a wall stands at it
WIDEST_FILLER = 0.12


class EndKind(StrEnum):
    """Neighbour at an end of a run."""

    FREE = "free"
    WALL = "wall"
    CORNER = "corner"


@dataclass(frozen=True)
class LineEnd:
    """An end of a run, and how much of it a corner takes below and above, metres."""

    kind: EndKind
    corner: RunCorner | None = None
    base_length: float = 0.0
    upper_length: float = 0.0


@dataclass(frozen=True)
class RunLine:
    """A run in the room: units stand between `frame` (their backs) and its `depth` before it."""

    run: Run
    frame: WallFrame
    length: float
    depth: float
    left: LineEnd = LineEnd(EndKind.FREE)
    right: LineEnd = LineEnd(EndKind.FREE)

    @property
    def id(self) -> str:
        """Id of the run."""
        return self.run.id

    @property
    def at_wall(self) -> bool:
        """True if it stands at a wall."""
        return self.run.on is not None

    @property
    def is_island(self) -> bool:
        """True if it stands free on all sides."""
        return self.run.faces is not None


class CornerPart(StrEnum):
    """Units that plans do not name: what stands in a corner, and strips that close gaps."""

    BLIND = "corner_blind"
    DIAGONAL = "corner_diagonal"
    FILLER = "filler"


@dataclass(frozen=True)
class UnitSlot:
    """The room of one unit, in the frame of its run.

    Attributes:
        name: of the unit. kind: of unit, or of corner part. unit: as the plan has it, None for a corner part.
        line: its run. left, right: along it. depth: from its back. low, high: above the floor. All metres.
        hinge: side of a single door. corner: side of it on which a corner lies.
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
    room = line.length - line.left.base_length - line.right.base_length
    spans = [standard_sizes.base_span(u, models) for u in line.run.base]
    widths = share_widths(spans, room)
    if widths is None:
        least = sum(s.minimum for s in spans)
        message = f"units that need at most {room:.3f} m"
        raise PlanConflict(
            plan.id,
            ("runs", line.id, "base"),
            message,
            f"at least {least:.3f} m ({describe_units(line.run.base, spans)})",
        )
    rest = round(room - sum(widths), 3)
    first = last = 0.0
    if rest > 0.0:
        first, last = _spread(plan, line, rest)
    high = standard_sizes.WORKTOP_HEIGHT - (models.style.island if line.is_island else models.style.counter).thickness
    out: list[UnitSlot] = [*_corner_slots(line, RunSide.LEFT, high)]
    at = line.left.base_length
    if first >= 0.02 and not _bare(line.run.base[:1]):
        out.append(_strip(line, f"{line.id}_strip_left", at, at + first, _beside(line.run.base[:1], high)))
    at = round(at + first, 4)
    for k, (unit, width) in enumerate(zip(line.run.base, widths, strict=True)):
        top = standard_sizes.UPPER_TO if _is_tall(line.run.base, k) else high
        out.append(_base_slot(line, unit, at, round(at + width, 4), top))
        at = round(at + width, 4)
    if last >= 0.02 and not _bare(line.run.base[-1:]):
        out.append(_strip(line, f"{line.id}_strip_right", at, at + last, _beside(line.run.base[-1:], high)))
    out += _corner_slots(line, RunSide.RIGHT, high)
    return tuple(out)


def describe_units(units: tuple[BaseUnit, ...] | tuple[UpperUnit, ...], spans: list[WidthRange]) -> str:
    """Units and their least widths, for messages."""
    return ", ".join(f"{u.id} {s.minimum:g}" for u, s in zip(units, spans, strict=True))


def _spread(plan: Plan, line: RunLine, rest: float) -> tuple[float, float]:
    """Distribute the rest of a run: free ends stop earlier; at walls and corners strips close the gap."""
    if line.right.kind is EndKind.FREE:
        return 0.0, 0.0
    if line.left.kind is EndKind.FREE:
        return rest, 0.0
    if rest <= WIDEST_FILLER:
        return (rest, 0.0) if line.left.kind is EndKind.WALL else (0.0, rest)
    if rest <= 2 * WIDEST_FILLER:
        return round(rest / 2, 3), round(rest - round(rest / 2, 3), 3)
    room = line.length - line.left.base_length - line.right.base_length
    raise PlanConflict(plan.id, ("runs", line.id, "base"), f"units that fill {room:.3f} m", f"{rest:.3f} m less")


def _bare(units: tuple[BaseUnit, ...]) -> bool:
    """True if a unit needs air beside it instead of a strip: a refrigerator that stands free."""
    return any(u.kind is BaseKind.FRIDGE and not u.housing for u in units)


def _beside(units: tuple[BaseUnit, ...], high: float) -> float:
    """Height of a strip beside a unit."""
    return standard_sizes.UPPER_TO if units and units[0].kind in TALL else high


def _strip(line: RunLine, name: str, left: float, right: float, high: float) -> UnitSlot:
    return UnitSlot(
        name, CornerPart.FILLER, line, round(left, 4), round(right, 4), standard_sizes.BASE_DEPTH, 0.0, high
    )


def _corner_slots(line: RunLine, side: RunSide, high: float) -> Iterator[UnitSlot]:
    end = line.left if side is RunSide.LEFT else line.right
    if end.corner is None:
        return
    stem = f"{line.id}_{side.value}"

    def slot(name: str, kind: CornerPart, near: float, far: float) -> UnitSlot:
        a, b = (near, far) if side is RunSide.LEFT else (line.length - far, line.length - near)
        return UnitSlot(
            name,
            kind,
            line,
            round(a, 4),
            round(b, 4),
            standard_sizes.BASE_DEPTH,
            0.0,
            high,
            corner=side,
            hinge=other_side(side),
        )

    owns = (end.corner.owner or end.corner.runs[0]) == line.id
    if end.corner.base is CornerKind.BLIND and owns:
        yield slot(f"{stem}_corner", CornerPart.BLIND, 0.0, end.base_length)
    elif end.corner.base is CornerKind.DIAGONAL:
        if owns:
            yield slot(f"{stem}_corner", CornerPart.DIAGONAL, 0.0, end.base_length)
    else:
        yield slot(f"{stem}_filler", CornerPart.FILLER, standard_sizes.BASE_DEPTH, end.base_length)


def other_side(side: RunSide) -> RunSide:
    """The end that is not this one."""
    return RunSide.RIGHT if side is RunSide.LEFT else RunSide.LEFT


def _is_tall(units: tuple[BaseUnit, ...], k: int) -> bool:
    """True if a unit reaches up to the wall units: tall ones do, and so do strips and panels beside nothing else."""
    if units[k].kind in (BaseKind.FILLER, BaseKind.PANEL):
        return all(u.kind in TALL for u in (*units[max(0, k - 1) : k], *units[k + 1 : k + 2]))
    return units[k].kind in TALL


def _base_slot(line: RunLine, unit: BaseUnit, left: float, right: float, high: float) -> UnitSlot:
    hinge = unit.hinge
    if hinge is None:
        # Away from a corner, and towards a wall beside it.
        near_left = left - line.left.base_length < TOUCHES and line.left.kind is EndKind.WALL
        near_corner = left - line.left.base_length < 0.2 and line.left.kind is EndKind.CORNER
        ends_at_wall = line.length - right < 0.2 and line.right.kind is EndKind.WALL
        hinge = RunSide.RIGHT if near_corner or (ends_at_wall and not near_left) else RunSide.LEFT
    return UnitSlot(unit.id, unit.kind, line, left, right, line.depth, 0.0, high, unit=unit, hinge=hinge)
