"""Resolve the walls and openings of a plan to metres, each with a frame along it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from casa_assets.core.numeric import decimals
from casa_assets.errors import PlanConflict
from casa_assets.mesh.outline import contains_point
from casa_assets.model.kitchen.plan import (
    Column,
    ColumnShape,
    Heading,
    Length,
    OpeningKind,
    Plan,
    PlanOpening,
    Wall,
    degrees_of,
)
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3, Vec4

_DIRECTIONS: tuple[Vec2, ...] = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
_HALF = math.sqrt(0.5)
_TURNS: tuple[Vec4, ...] = (
    (1.0, 0.0, 0.0, 0.0),
    (_HALF, 0.0, 0.0, _HALF),
    (0.0, 0.0, 0.0, 1.0),
    (_HALF, 0.0, 0.0, -_HALF),
)
WALL_THICKNESS_M = 0.12
MIN_LEVEL_M = 0.4  # metres of ceiling that stay level beside slopes
FOOT_M = 0.015  # metres that the foot of a column stands out
# Headings along each axis of a room, there and back.
AXES = ((Heading.RIGHT, Heading.LEFT), (Heading.BACK, Heading.FRONT))


@dataclass(frozen=True)
class WallFrame:
    """A line on the floor with a left end and a direction; objects at the line face away from it, to its right.

    x, y: its left end in the room, metres. It is turned left from the room's x axis by `quarter_turns` and `more_deg`,
    at least 0 and less than 90 degrees.
    """

    x: float
    y: float
    quarter_turns: int
    more_deg: float = 0.0

    @property
    def turn_deg(self) -> float:
        """Turn to the left from the room's x axis, degrees, at least 0 and less than 360."""
        return self.quarter_turns % 4 * 90.0 + self.more_deg

    @property
    def is_aligned(self) -> bool:
        """True if it runs along an axis of the room."""
        return self.more_deg == 0.0

    @property
    def direction(self) -> Vec2:
        """Unit vector from left to right."""
        return self._direction(self.quarter_turns)

    @property
    def normal(self) -> Vec2:
        """Unit vector from the line into the room."""
        return self._direction(self.quarter_turns - 1)

    def _direction(self, quarters: int) -> Vec2:
        if self.is_aligned:
            return _DIRECTIONS[quarters % 4]
        angle = math.radians(quarters % 4 * 90.0 + self.more_deg)
        return (math.cos(angle), math.sin(angle))

    @property
    def rotation(self) -> Vec4:
        """room_from_asset of what faces away from the line: quaternion (w, x, y, z)."""
        if self.is_aligned:
            return _TURNS[self.quarter_turns % 4]
        half = math.radians(self.turn_deg if self.turn_deg <= 180.0 else self.turn_deg - 360.0) / 2
        return (round(math.cos(half), 12), 0.0, 0.0, round(math.sin(half), 12))

    def at(self, u: float, v: float, z: float = 0.0) -> Vec3:
        """Point u metres along the line, v away from it, z up, in the room."""
        (a, b), (c, d) = self.direction, self.normal
        return (_rounded(self.x + u * a + v * c), _rounded(self.y + u * b + v * d), _rounded(z))

    def pose(self, u: float, v: float, z: float = 0.0) -> Pose:
        """room_from_asset of something there that faces away from the line."""
        return Pose(position=self.at(u, v, z), quaternion=self.rotation)

    def rectangle(self, left: float, right: float, back: float, front: float) -> tuple[Vec2, ...]:
        """Corners (x, y) of what lies between two places along the line and two distances from it, metres."""
        ends = ((left, back), (right, back), (right, front), (left, front))
        return tuple(self.at(u, v)[:2] for u, v in ends)

    def offset(self, u: float, v: float = 0.0, turn: int = 0) -> WallFrame:
        """A frame whose left end is at (u, v), turned by quarter turns to the left."""
        x, y, _ = self.at(u, v)
        return WallFrame(x, y, (self.quarter_turns + turn) % 4, self.more_deg)

    def to_local(self, x: float, y: float) -> Vec2:
        """Distances (u, v) of a point of the room along the line and away from it, metres."""
        (a, b), (c, d) = self.direction, self.normal
        dx, dy = x - self.x, y - self.y
        return (dx * a + dy * b, dx * c + dy * d)


def frame_with_heading(x: float, y: float, heading: Heading | float) -> WallFrame:
    """The frame of a wall with a heading, its left end at x, y; metres."""
    quarters, more = divmod(-degrees_of(heading) % 360.0, 90.0)
    return WallFrame(x, y, int(quarters) % 4, more)


def _rounded(value: float) -> float:
    """Round to a hundredth of a millimetre, so that the order of summation does not change the bytes."""
    return decimals(value, 5)


def turned_left(pose: Pose, degrees: float) -> Pose:
    """A pose turned to the left about its own upright axis."""
    half = math.radians(degrees) / 2
    return pose @ Pose(quaternion=(math.cos(half), 0.0, 0.0, math.sin(half))) if degrees else pose


@dataclass(frozen=True)
class WallLine:
    """A wall: its inner face from its left end, as seen from inside.

    Attributes:
        left_outer_corner, right_outer_corner: whether the corner at that end points into the room.
        left_bare, right_bare: whether no wall adjoins that end inside the room at a right angle: an outer corner, an
            open wall, or a wall aslant.
        left_aslant, right_aslant: whether the wall at that end goes on at another angle than a right one.
    """

    id: str
    frame: WallFrame
    length: float
    open: bool
    left_outer_corner: bool = False
    right_outer_corner: bool = False
    left_bare: bool = False
    right_bare: bool = False
    left_aslant: bool = False
    right_aslant: bool = False


@dataclass(frozen=True)
class Room:
    """All walls, clockwise; outline: corners (x, y), metres, from the back left; height: of the level ceiling."""

    walls: tuple[WallLine, ...]
    outline: tuple[Vec2, ...]
    height: float
    slopes: tuple[CeilingSlope, ...] = ()
    columns: tuple[PlacedColumn, ...] = ()

    def bounds(self) -> tuple[Vec2, Vec2]:
        """Lower and upper corner (x, y), metres."""
        return _bounds(self.outline)

    def contains(self, x: float, y: float) -> bool:
        """True if a point of the floor lies inside."""
        return contains_point(self.outline, (x, y))

    def ceiling_at(self, x: float, y: float) -> float:
        """Height of the ceiling over a point of the floor, metres."""
        return min([self.height, *(slope.height_at(x, y) for slope in self.slopes)])

    def ceiling_over(self, frame: WallFrame, us: Vec2, vs: Vec2) -> float:
        """Least height of the ceiling over a rectangle between two distances along a line and two before it, metres."""
        if not self.slopes:
            return self.height
        return round(min(self.ceiling_at(*frame.at(u, v)[:2]) for u in us for v in vs), 4)

    def height_of(self, wall: WallLine) -> float:
        """Height of a wall, metres: under a slope its knee."""
        return next((slope.knee for slope in self.slopes if slope.wall.id == wall.id), self.height)

    @property
    def level_outline(self) -> tuple[Vec2, ...]:
        """Corners of the level part of the ceiling, in the order of the outline."""
        corners = list(self.outline)
        for slope in self.slopes:
            k = next(i for i, wall in enumerate(self.walls) if wall.id == slope.wall.id)
            (nx, ny), run = slope.wall.frame.normal, slope.run
            for i in (k, (k + 1) % len(corners)):
                corners[i] = (round(corners[i][0] + run * nx, 5), round(corners[i][1] + run * ny, 5))
        return tuple(corners)

    def level_bounds(self) -> tuple[Vec2, Vec2]:
        """Lower and upper corner (x, y) of the level part of the ceiling, metres."""
        return _bounds(self.level_outline)


def _bounds(outline: Sequence[Vec2]) -> tuple[Vec2, Vec2]:
    xs, ys = zip(*outline, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))


@dataclass(frozen=True)
class CeilingSlope:
    """A slope of the ceiling, from height `knee` at a wall up to the level part, `run` into the room. Metres."""

    wall: WallLine
    knee: float
    pitch_deg: float
    run: float

    def height_at(self, x: float, y: float) -> float:
        """Height of its plane over a point of the floor, metres; beyond its run more than the ceiling's."""
        before = self.wall.frame.to_local(x, y)[1]
        return self.knee + max(before, 0.0) * math.tan(math.radians(self.pitch_deg))


@dataclass(frozen=True)
class PlacedColumn:
    """A column in the room.

    Attributes:
        column: as the plan has it. frame: of the wall that it is measured from. u: of its middle along that wall.
            back, front: distances of its back and front from the wall, foot included. left, right: of its sides along
            the wall, foot included. All metres.
    """

    column: Column
    frame: WallFrame
    u: float
    back: float
    front: float
    left: float
    right: float

    @property
    def outline(self) -> tuple[Vec2, ...]:
        """Corners (x, y) on the floor, metres."""
        return self.frame.rectangle(self.left, self.right, self.back, self.front)


@dataclass(frozen=True)
class WallHole:
    """An opening in its wall: left and right edge along it, lower and upper edge, metres.

    Attributes:
        back: of a niche, the face of its back as a wall; windows may be in it.
        behind_tap: of a window, whether a tap is in front of it at the height of its sill.
    """

    opening: PlanOpening
    wall: WallLine
    left: float
    right: float
    bottom: float
    top: float
    back: WallLine | None = None
    behind_tap: bool = False

    @property
    def is_window(self) -> bool:
        """True if it is a window."""
        return self.opening.kind is OpeningKind.WINDOW

    @property
    def is_niche(self) -> bool:
        """True if it is a niche."""
        return self.opening.kind is OpeningKind.NICHE


def wall_of(plan: Plan, room: Room, name: str, *pointer: str | int) -> WallLine:
    """The wall of that id. Raises PlanConflict, at the pointer of the key that names it."""
    walls = {wall.id: wall for wall in room.walls}
    if name not in walls:
        raise PlanConflict(plan.id, pointer, f"one of {', '.join(walls)}", repr(name))
    return walls[name]


def resolve_length(plan: Plan, value: Length, parameters: Mapping[str, float], *at: str | int) -> float:
    """A length. Raises PlanConflict where it names no parameter."""
    if isinstance(value, str) and value not in parameters:
        expected = f"metres or one of {', '.join(sorted(parameters)) or 'no parameter'}"
        raise PlanConflict(plan.id, at, expected, repr(value))
    return plan.length(value, parameters)


def build_room(plan: Plan, parameters: Mapping[str, float]) -> Room:
    """The room for lengths of the plan's parameters. Raises PlanConflict where the walls do not close."""
    x = y = 0.0
    lines: list[WallLine] = []
    for wall, length in zip(plan.walls, _lengths(plan, parameters), strict=True):
        frame = frame_with_heading(round(x, 5), round(y, 5), wall.heading)
        lines.append(WallLine(wall.id, frame, length, wall.open))
        x, y, _ = frame.at(length, 0.0)
    if max(abs(x), abs(y)) > 1e-3:
        got = f"an end at {x:.3f}, {y:.3f} m"
        raise PlanConflict(plan.id, ("walls",), "walls that lead back to where they begin", got)
    turns = corner_turns(plan.walls)
    wrong = next((i for i, turn in enumerate(turns) if not is_corner(turn)), None)
    if wrong is not None:
        message = "a wall at a right angle to the next, or one that turns to the right by less"
        got = "one that goes on or back" if turns[wrong] in (0.0, 180.0) else f"a turn of {turns[wrong]:g} degrees"
        raise PlanConflict(plan.id, ("walls", lines[wrong].id), message, got)
    if round(sum(turns), 6) != 360.0:
        raise PlanConflict(plan.id, ("walls",), "walls that go round clockwise once", "others")
    walls, count = [], len(lines)
    for i, w in enumerate(lines):
        left, right = turns[i - 1] == -90.0, turns[i] == -90.0
        aslant = (turns[i - 1] not in (90.0, -90.0), turns[i] not in (90.0, -90.0))
        bare = (left or aslant[0] or lines[i - 1].open, right or aslant[1] or lines[(i + 1) % count].open)
        walls.append(WallLine(w.id, w.frame, w.length, w.open, left, right, *bare, *aslant))
    room = Room(tuple(walls), tuple((w.frame.x, w.frame.y) for w in walls), plan.height)
    room = replace(room, slopes=_slopes(plan, room))
    return replace(room, columns=_columns(plan, room, parameters))


def _slopes(plan: Plan, room: Room) -> tuple[CeilingSlope, ...]:
    """The slopes of the ceiling. Raises PlanConflict if one does not fit between the adjoining walls."""
    found: list[CeilingSlope] = []
    for k, slope in enumerate(plan.slopes):
        at = ("slopes", k)
        wall = wall_of(plan, room, slope.wall, *at, "wall")
        if slope.knee > plan.height - 0.1:
            raise PlanConflict(plan.id, (*at, "knee"), f"less than {plan.height - 0.1:g} m", f"{slope.knee:g} m")
        run = round((plan.height - slope.knee) / math.tan(math.radians(slope.pitch_deg)), 4)
        i = room.walls.index(wall)
        beside = (room.walls[i - 1], room.walls[(i + 1) % len(room.walls)])
        taken = {s.wall.id for s in found}
        if wall.left_outer_corner or wall.right_outer_corner or wall.left_aslant or wall.right_aslant:
            raise PlanConflict(plan.id, (*at, "wall"), "a wall between two inner corners of 90 degrees", repr(wall.id))
        if wall.id in taken or taken & {w.id for w in beside}:
            raise PlanConflict(plan.id, (*at, "wall"), "a wall beside which no other slope begins", repr(wall.id))
        across = [s.run for s in found if s.wall.frame.turn_deg == (wall.frame.turn_deg + 180.0) % 360.0]
        room_for_it = min(w.length for w in beside) - MIN_LEVEL_M - sum(across)
        if run > room_for_it:
            got = f"{run:.2f} m, from {slope.knee:g} m up to {plan.height:g} m at {slope.pitch_deg:g} degrees"
            message = f"a slope that reaches at most {room_for_it:.2f} m into the room"
            raise PlanConflict(plan.id, (*at, "pitch_deg"), message, got, room_for_it)
        found.append(CeilingSlope(wall, slope.knee, slope.pitch_deg, run))
    return tuple(found)


def _columns(plan: Plan, room: Room, parameters: Mapping[str, float]) -> tuple[PlacedColumn, ...]:
    """The columns in their places. Raises PlanConflict if one is outside the room, or under a slope."""
    found = []
    for column in plan.columns:
        at = ("columns", column.id)
        wall = wall_of(plan, room, column.wall, *at, "wall")
        u = resolve_length(plan, column.at, parameters, *at, "at")
        gap = resolve_length(plan, column.from_wall, parameters, *at, "from_wall")
        half = round(column.width / 2 + FOOT_M, 4)
        deep = column.width if column.shape is ColumnShape.ROUND else column.depth
        behind = 0.0 if gap == 0.0 and column.shape is ColumnShape.SQUARE else FOOT_M
        front = round(gap + behind + deep + FOOT_M, 4)
        placed = PlacedColumn(column, wall.frame, u, gap, front, round(u - half, 4), round(u + half, 4))
        middle = wall.frame.at(u, (placed.back + placed.front) / 2)[:2]
        if not room.contains(*middle) or placed.left < 0.0 or placed.right > wall.length:
            raise PlanConflict(plan.id, at, "a place inside the room", f"{middle[0]:.2f}, {middle[1]:.2f} m")
        if room.ceiling_over(wall.frame, (placed.left, placed.right), (placed.back, placed.front)) < room.height:
            raise PlanConflict(plan.id, at, "a place under the level part of the ceiling", "one under a slope")
        found.append(placed)
    return tuple(found)


def corner_turns(walls: Sequence[Wall]) -> list[float]:
    """Degrees from the heading of each wall to that of the next, to the right, more than -180 and at most 180."""
    degrees = [degrees_of(w.heading) for w in walls]
    turns = [round(degrees[(i + 1) % len(degrees)] - d, 6) % 360.0 for i, d in enumerate(degrees)]
    return [t - 360.0 if t > 180.0 else t for t in turns]


def is_corner(turn: float) -> bool:
    """True for the turn of a corner that walls can have: a right angle either way, or less than that to the right.

    Two walls that jut into the room at another angle would have to be cut to fit.
    """
    return turn == -90.0 or 0.0 < turn <= 90.0


def _lengths(plan: Plan, parameters: Mapping[str, float]) -> list[float]:
    known = {
        w.id: resolve_length(plan, w.length, parameters, "walls", w.id, "length")
        for w in plan.walls
        if w.length is not None
    }
    for wall in plan.walls:
        if wall.is_aslant and wall.length is None:
            raise PlanConflict(plan.id, ("walls", wall.id), "a length, since it stands aslant", "none")
    for headings in AXES:
        open_ended = [w for w in plan.walls if w.heading in headings and w.length is None]
        if len(open_ended) > 1:
            message = f"a length, since that of {open_ended[0].id} is left open"
            raise PlanConflict(plan.id, ("walls", open_ended[1].id), message, "none")
        if open_ended:
            first, second = (lengths_along(plan.walls, known, h) for h in headings)
            rest = round(second - first if open_ended[0].heading is headings[0] else first - second, 4)
            if rest < 0.3:
                at = ("walls", open_ended[0].id)
                raise PlanConflict(plan.id, at, "walls that leave at least 0.3 m for it", f"{rest:.3f} m")
            known[open_ended[0].id] = rest
    return [known[w.id] for w in plan.walls]


def lengths_along(walls: Sequence[Wall], known: Mapping[str, float], heading: Heading) -> float:
    """Metres that walls of known lengths lead in a direction; those aslant by their share, none that lead back."""
    total = sum(known[w.id] for w in walls if w.heading is heading and w.id in known)
    for wall in walls:
        if wall.is_aslant and wall.id in known:
            total += known[wall.id] * max(0.0, math.cos(math.radians(degrees_of(wall.heading) - degrees_of(heading))))
    return total
