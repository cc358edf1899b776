"""A kitchen as a designer and a robot look at it: what stands where on the floor, what swings, where one can walk.

All of it is in the frame of the world (z up, metres). A fixture has its own x axis to the right of somebody who stands
before it, and faces -y; `yaw` is the turn to the left that takes the world's axes to it, radians.
"""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.model.joint import JointKind
from casa_assets.model.plan import OpeningKind
from casa_assets.model.record import Id, Record, Vec2, Vec3
from casa_assets.model.scene import SceneId

Corners = tuple[Vec2, ...]


class Role(StrEnum):
    """What a fixture is there for."""

    SINK = "sink"
    RANGE = "range"
    HOB = "hob"
    OVEN = "oven"
    MICROWAVE = "microwave"
    HOOD = "hood"
    FRIDGE = "fridge"
    DISHWASHER = "dishwasher"
    COFFEE_MACHINE = "coffee_machine"
    TOASTER = "toaster"
    CABINET = "cabinet"
    DRAWERS = "drawers"
    SINK_BASE = "sink_base"
    CORNER = "corner"
    ISLAND = "island"
    PANTRY = "pantry"
    HOUSING = "housing"
    UPPER = "upper"
    SHELF = "shelf"
    WORKTOP = "worktop"
    SEAT = "seat"
    TABLE = "table"
    THING = "thing"
    ON_FLOOR = "on_floor"
    HUNG = "hung"
    TRIM = "trim"
    ROOM = "room"


APPLIANCES = (
    Role.RANGE,
    Role.HOB,
    Role.OVEN,
    Role.MICROWAVE,
    Role.FRIDGE,
    Role.DISHWASHER,
)


class Foot(Record):
    """A rectangle on the floor: its middle, its full size (along its own x, along its own y) and its turn."""

    middle: Vec2
    size: Vec2
    yaw: float = 0.0

    @property
    def right(self) -> Vec2:
        """Unit vector to the right of who stands before it."""
        return (math.cos(self.yaw), math.sin(self.yaw))

    @property
    def front(self) -> Vec2:
        """Unit vector that it faces along."""
        return (math.sin(self.yaw), -math.cos(self.yaw))

    def at(self, across: float, before: float) -> Vec2:
        """A point so far to the right of its middle, and so far before its front; metres."""
        (a, b), (c, d) = self.right, self.front
        v = before + self.size[1] / 2
        return (self.middle[0] + across * a + v * c, self.middle[1] + across * b + v * d)

    def of(self, point: Vec2) -> Vec2:
        """How far a point is to the right of its middle, and before its front; metres."""
        (a, b), (c, d) = self.right, self.front
        x, y = point[0] - self.middle[0], point[1] - self.middle[1]
        return (x * a + y * b, x * c + y * d - self.size[1] / 2)

    @property
    def corners(self) -> Corners:
        """Counter-clockwise."""
        w, d = self.size[0] / 2, self.size[1]
        return (self.at(-w, 0.0), self.at(w, 0.0), self.at(w, -d), self.at(-w, -d))


class Leaf(Record):
    """Where a door, flap or drawer goes, seen from above.

    Attributes:
        swept: convex outline of all that it passes. open: of it alone where it stands open. Counter-clockwise.
        low, high: heights between which it moves.
        down: whether it is a flap that opens downwards, or a drawer: it lies before the fixture once it is open.
    """

    swept: Corners
    open: Corners
    low: float
    high: float
    down: bool


class Movable(Record):
    """A joint of a fixture.

    Attributes:
        name: in its asset. range: rad or m. behind: joint that has to be open before.
        grip: middle of what a hand takes while all is shut, None where there is nothing to take.
        leaf: None for what stays within the fixture, such as knobs and racks.
    """

    name: Id
    kind: JointKind
    range: Vec2
    behind: Id | None = None
    grip: Vec3 | None = None
    leaf: Leaf | None = None


class Volume(Record):
    """A box or cylinder of a fixture where things can be put, all joints at zero: foot, and heights of its ends."""

    name: Id
    foot: Foot
    low: float
    high: float
    round: bool = False
    moves: bool = False


class Mark(Record):
    """A named point of a fixture: where a pan or a mug goes, a flame, a button."""

    name: Id
    at: Vec3


class Fixture(Record):
    """Something in the kitchen.

    Attributes:
        name: of its placement. category: of its asset. unit, run: of the plan, empty where it belongs to none.
        foot: without handles. low, high: above the floor.
        loose: whether it can be pushed away.
        joints, volumes: as above. marks: sites. buttons: keys that are found by touch.
    """

    name: Id
    role: Role
    category: str
    unit: str = ""
    run: str = ""
    foot: Foot
    low: float
    high: float
    loose: bool = False
    joints: tuple[Movable, ...] = ()
    volumes: tuple[Volume, ...] = ()
    marks: tuple[Mark, ...] = ()
    buttons: tuple[Mark, ...] = ()

    def joint(self, name: str) -> Movable | None:
        """Its joint of that name, if it has one."""
        return next((j for j in self.joints if j.name == name), None)


class Side(Record):
    """A wall: its inner face from its left end to its right end, the room to the right of that way."""

    id: Id
    start: Vec2
    end: Vec2
    open: bool = False


class Way(Record):
    """A window, door or passage.

    Attributes:
        start, end: of the hole on the inner face of the wall, from left to right. low, high: of it.
        clear: how wide it is for who walks through it, the leaf open; of windows the width of the hole.
        movable: whether it opens. leaf: where a door's leaf goes.
    """

    id: Id
    kind: OpeningKind
    wall: Id
    start: Vec2
    end: Vec2
    low: float
    high: float
    clear: float
    movable: bool = False
    leaf: Leaf | None = None


class Unit(Record):
    """A unit of a run on the floor: where it begins and ends along it, and its front and height; metres.

    Attributes:
        kind: as the plan has it. worktop: whether it carries one. front: distance from the line of the run.
    """

    name: Id
    kind: str
    left: float
    right: float
    front: float
    high: float
    worktop: bool = True


class RunEnd(StrEnum):
    """What is at an end of a run."""

    FREE = "free"
    WALL = "wall"
    CORNER = "corner"


class Row(Record):
    """A run of units.

    Attributes:
        origin: left end of its line. yaw: as of a fixture in it. length: of it.
        back: how far its worktop reaches behind the line; depth: how far before it. height: of the worktop.
        at_wall: whether the line is a wall's face. island: whether it stands free on all sides.
        left, right: its ends. next: the run that begins where it ends, round a corner.
        corner_left, corner_right: what corners take of it.
        overhang: of the worktop over those who sit behind it.
    """

    id: Id
    origin: Vec2
    yaw: float
    length: float
    back: float = 0.0
    depth: float = 0.65
    height: float = 0.92
    at_wall: bool = True
    island: bool = False
    left: RunEnd = RunEnd.FREE
    right: RunEnd = RunEnd.FREE
    next: Id | None = None
    corner_left: float = 0.0
    corner_right: float = 0.0
    overhang: float = 0.0
    units: tuple[Unit, ...] = ()

    def at(self, along: float, before: float) -> Vec2:
        """A point so far along the line, and so far before it; metres."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (self.origin[0] + along * c + before * s, self.origin[1] + along * s - before * c)

    def of(self, point: Vec2) -> Vec2:
        """How far along the line a point is, and how far before it; metres."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y = point[0] - self.origin[0], point[1] - self.origin[1]
        return (x * c + y * s, x * s - y * c)

    @property
    def span(self) -> Vec2:
        """Where it begins and ends along its line, corners included, metres."""
        first = 0.0 if self.left is not RunEnd.FREE or not self.units else self.units[0].left
        last = self.length if self.right is not RunEnd.FREE or not self.units else self.units[-1].right
        return first, last

    @property
    def frontages(self) -> tuple[Vec2, ...]:
        """Stretches of worktop along it that nothing tall, no range and no gap interrupts; corners not counted."""
        out: list[Vec2] = []
        for unit in self.units:
            if not unit.worktop:
                continue
            if out and abs(out[-1][1] - unit.left) < 0.01:
                out[-1] = (out[-1][0], unit.right)
            else:
                out.append((unit.left, unit.right))
        return tuple(out)


class AisleKind(StrEnum):
    """Between two fronts at which people work, or for people to pass."""

    WORK = "work"
    WALK = "walk"


class Aisle(Record):
    """A passage and how wide it is at its narrowest, metres; `one` and `other`: runs or walls that bound it."""

    kind: AisleKind
    one: str
    other: str
    width: float
    at: Vec2


class Stance(StrEnum):
    """Where a robot stands as seen by who looks at the fixture's front."""

    FRONT = "front"
    LEFT = "left"
    RIGHT = "right"
    BEHIND = "behind"


class Parking(Record):
    """Where a robot's base stands to work at a fixture.

    Attributes:
        fixture: its name. open: joint whose leaf stands open meanwhile, empty where all is shut.
        at: middle of the base. yaw: direction in which the robot looks, radians to the left of the x axis.
        stance: before the fixture, or beside or behind the open leaf. aside: how far from the fixture's middle, metres.
    """

    fixture: Id
    open: str = ""
    at: Vec2
    yaw: float
    stance: Stance = Stance.FRONT
    aside: float = 0.0


class Facts(Record):
    """A kitchen. See the module.

    Attributes:
        id: of the scene. plan: of the plan. compact: whether the plan says that it is a small one.
        outline: of the room, clockwise. height: of the room.
        fixtures: all that was placed, in the order of the scene.
    """

    id: SceneId
    plan: str = ""
    compact: bool = False
    outline: Corners
    height: float = 2.7
    walls: tuple[Side, ...]
    ways: tuple[Way, ...] = ()
    rows: tuple[Row, ...] = ()
    fixtures: tuple[Fixture, ...] = ()
    aisles: tuple[Aisle, ...] = ()

    def of(self, *roles: Role) -> tuple[Fixture, ...]:
        """Fixtures of these roles, in order."""
        return tuple(f for f in self.fixtures if f.role in roles)

    def row(self, name: str) -> Row | None:
        """The run of that id, if there is one."""
        return next((r for r in self.rows if r.id == name), None)
