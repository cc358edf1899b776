"""Resolve the walls and openings of a plan to metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets.errors import PlanConflict
from casa_assets.geometry.outline import contains_point
from casa_assets.layouts.plan.wall_frame import QUARTERS, WallFrame
from casa_assets.model.kitchen.plan import Heading, OpeningKind, Plan, PlanOpening
from casa_assets.model.kitchen.units import Length
from casa_assets.model.record import Vec2

WALL_THICKNESS_M = 0.12


@dataclass(frozen=True)
class WallLine:
    """A wall: its inner face from its left end, as seen from inside.

    Attributes:
        left_outer_corner, right_outer_corner: whether the corner at that end points into the room.
        left_bare, right_bare: whether no wall adjoins that end inside the room: an outer corner, or an open wall.
    """

    id: str
    frame: WallFrame
    length: float
    open: bool
    left_outer_corner: bool = False
    right_outer_corner: bool = False
    left_bare: bool = False
    right_bare: bool = False


@dataclass(frozen=True)
class Room:
    """All walls, clockwise.

    Attributes:
        outline: corners (x, y), metres, clockwise from the back left.
    """

    walls: tuple[WallLine, ...]
    outline: tuple[Vec2, ...]
    height: float

    def bounds(self) -> tuple[Vec2, Vec2]:
        """Lower and upper corner (x, y), metres."""
        xs, ys = zip(*self.outline, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))

    def contains(self, x: float, y: float) -> bool:
        """True if a point of the floor lies inside."""
        return contains_point(self.outline, (x, y))


@dataclass(frozen=True)
class WallHole:
    """An opening in its wall: left and right edge along it, lower and upper edge, metres."""

    opening: PlanOpening
    wall: WallLine
    left: float
    right: float
    bottom: float
    top: float

    @property
    def is_window(self) -> bool:
        """True if it is a window."""
        return self.opening.kind is OpeningKind.WINDOW


def wall_of(plan: Plan, room: Room, name: str, *pointer: str) -> WallLine:
    """The wall of that id. Raises PlanConflict, at the pointer of the key that names it."""
    walls = {wall.id: wall for wall in room.walls}
    if name not in walls:
        raise PlanConflict(plan.id, pointer, f"one of {', '.join(walls)}", repr(name))
    return walls[name]


def resolve_length(plan: Plan, value: Length, parameters: Mapping[str, float], *at: str | int) -> float:
    """A length. Raises PlanConflict where it names no parameter."""
    if isinstance(value, str) and value not in parameters:
        raise PlanConflict(
            plan.id, at, f"metres or one of {', '.join(sorted(parameters)) or 'no parameter'}", repr(value)
        )
    return plan.length(value, parameters)


def build_room(plan: Plan, parameters: Mapping[str, float]) -> Room:
    """The room for lengths of the plan's parameters. Raises PlanConflict where the walls do not close."""
    x = y = 0.0
    lines: list[WallLine] = []
    for wall, length in zip(plan.walls, _lengths(plan, parameters), strict=True):
        frame = WallFrame(round(x, 5), round(y, 5), QUARTERS[wall.heading])
        lines.append(WallLine(wall.id, frame, length, wall.open))
        x, y, _ = frame.at(length, 0.0)
    if max(abs(x), abs(y)) > 1e-3:
        raise PlanConflict(
            plan.id, ("walls",), "walls that lead back to where they begin", f"an end at {x:.3f}, {y:.3f} m"
        )
    count = len(lines)
    turns = [(lines[i].frame.quarter_turns - lines[(i + 1) % count].frame.quarter_turns) % 4 for i in range(count)]
    if any(t in (0, 2) for t in turns):
        wrong = lines[next(i for i, t in enumerate(turns) if t in (0, 2))].id
        raise PlanConflict(plan.id, ("walls", wrong), "a wall at a right angle to the next", "one that goes on or back")
    if turns.count(1) - turns.count(3) != 4:
        raise PlanConflict(plan.id, ("walls",), "walls that go round clockwise once", "others")
    walls = []
    for i, w in enumerate(lines):
        left, right = turns[i - 1] == 3, turns[i] == 3
        bare = (left or lines[i - 1].open, right or lines[(i + 1) % count].open)
        walls.append(WallLine(w.id, w.frame, w.length, w.open, left, right, *bare))
    return Room(tuple(walls), tuple((w.frame.x, w.frame.y) for w in walls), plan.height)


def _lengths(plan: Plan, parameters: Mapping[str, float]) -> list[float]:
    """Lengths of all walls; those that are not given follow from the others."""
    known = {
        w.id: resolve_length(plan, w.length, parameters, "walls", w.id, "length")
        for w in plan.walls
        if w.length is not None
    }
    for headings in ((Heading.RIGHT, Heading.LEFT), (Heading.BACK, Heading.FRONT)):
        open_ended = [w for w in plan.walls if w.heading in headings and w.length is None]
        if len(open_ended) > 1:
            message = f"a length, since that of {open_ended[0].id} is left open"
            raise PlanConflict(plan.id, ("walls", open_ended[1].id), message, "none")
        if open_ended:
            first, second = (sum(known[w.id] for w in plan.walls if w.heading is h and w.id in known) for h in headings)
            rest = round(second - first if open_ended[0].heading is headings[0] else first - second, 4)
            if rest < 0.3:
                raise PlanConflict(
                    plan.id, ("walls", open_ended[0].id), "walls that leave at least 0.3 m for it", f"{rest:.3f} m"
                )
            known[open_ended[0].id] = rest
    return [known[w.id] for w in plan.walls]
