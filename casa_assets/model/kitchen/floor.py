"""Floor plan of a finished kitchen: fixtures seen from above, walls, runs, aisles, and where a robot parks."""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import SceneId
from casa_assets.model.record import Id, MixedCaseId, Record, Vec2, Vec3

# Everything is in the world frame (z up, metres). The x axis of a fixture points to the right of a person who looks at
# its front, and the fixture faces -y; `yaw` is its counter-clockwise rotation relative to the world axes, radians.

Corners = tuple[Vec2, ...]


class Role(StrEnum):
    """Purpose of a fixture: sink, range, worktop, seat ..."""

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


APPLIANCES = (Role.RANGE, Role.HOB, Role.OVEN, Role.MICROWAVE, Role.FRIDGE, Role.DISHWASHER)


class Footprint(Record):
    """Rectangle on the floor: centre, full size along its own x and y axes, and yaw."""

    center: Vec2
    size: Vec2
    yaw: float = 0.0

    @property
    def right_axis(self) -> Vec2:
        """Unit vector to the right, as seen by a person in front of it."""
        return (math.cos(self.yaw), math.sin(self.yaw))

    @property
    def front_axis(self) -> Vec2:
        """Unit vector in the direction that it faces."""
        return (math.sin(self.yaw), -math.cos(self.yaw))

    def at(self, across: float, before: float) -> Vec2:
        """World point at a distance to the right of the centre and a distance in front of the front; metres."""
        (a, b), (c, d) = self.right_axis, self.front_axis
        v = before + self.size[1] / 2
        return (self.center[0] + across * a + v * c, self.center[1] + across * b + v * d)

    def to_local(self, point: Vec2) -> Vec2:
        """Distances of a world point to the right of the centre and in front of the front; metres."""
        (a, b), (c, d) = self.right_axis, self.front_axis
        x, y = point[0] - self.center[0], point[1] - self.center[1]
        return (x * a + y * b, x * c + y * d - self.size[1] / 2)

    @property
    def corners(self) -> Corners:
        """The four corners, counter-clockwise."""
        w, d = self.size[0] / 2, self.size[1]
        return (self.at(-w, 0.0), self.at(w, 0.0), self.at(w, -d), self.at(-w, -d))


class SweptArea(Record):
    """Area that a door, flap or drawer passes through, seen from above; outlines are convex and counter-clockwise.

    Attributes:
        open_outline: outline of the moving part when open. bottom, top: heights between which it moves, metres.
        sweeps_front: True for a drawer or a flap, which lies in front of the fixture when open; False for side hinges.
    """

    outline: Corners
    open_outline: Corners
    bottom: float
    top: float
    sweeps_front: bool


class FixtureJoint(Record):
    """A joint of a placed fixture, with the area that it sweeps.

    Attributes:
        range: rad or m. behind: joint that has to be open before this one can move.
        grip_point: middle of the grip with every joint at zero.
        swept_area: None if the part stays within the fixture, such as a knob or a rack.
    """

    name: Id
    kind: JointKind
    range: Vec2
    behind: Id | None = None
    grip_point: Vec3 | None = None
    swept_area: SweptArea | None = None


class FixtureRegion(Record):
    """Box or cylinder of a fixture that holds objects, joints at zero; `bottom` and `top`: heights, metres."""

    name: MixedCaseId
    footprint: Footprint
    bottom: float
    top: float
    is_moving: bool = False


class FixtureSite(Record):
    """Named point of a placed fixture: the place of a pan or a mug, a flame, a button."""

    name: Id
    position: Vec3


class Fixture(Record):
    """A placed asset of the kitchen.

    Attributes:
        unit, run: of the plan; empty if it belongs to none. footprint: without handles.
        buttons: centres of the colliders that are pressed.
    """

    name: Id
    role: Role
    category: str
    unit: str = ""
    run: str = ""
    footprint: Footprint
    bottom: float
    top: float
    joints: tuple[FixtureJoint, ...] = ()
    regions: tuple[FixtureRegion, ...] = ()
    sites: tuple[FixtureSite, ...] = ()
    buttons: tuple[FixtureSite, ...] = ()

    def joint(self, name: str) -> FixtureJoint | None:
        """Return the joint of that name, or None if it does not exist."""
        return next((j for j in self.joints if j.name == name), None)


class RoomWall(Record):
    """Inner face of a wall from its left end to its right end; the room is to the right of that direction."""

    id: Id
    start: Vec2
    end: Vec2
    is_open: bool = False


class WallOpening(Record):
    """A window, door or passage in a wall of the room.

    Attributes:
        start, end: ends of the hole on the inner face of the wall, from left to right.
        clear_width: free width with the door open; for windows the width of the hole; metres.
        can_open: whether it has joints. leads_out: out of the kitchen, and not into a closet.
        swept_area: of a door's leaf.
    """

    id: Id
    kind: OpeningKind
    wall: Id
    start: Vec2
    end: Vec2
    bottom: float
    top: float
    clear_width: float
    can_open: bool = False
    leads_out: bool = True
    swept_area: SweptArea | None = None


class PlacedUnit(Record):
    """A unit of a run on the floor: left and right end along the run, distance of its front from it, height; metres."""

    name: Id
    kind: str
    left: float
    right: float
    front: float
    height: float
    has_worktop: bool = True


class RunEnd(StrEnum):
    """Neighbour at an end of a run: nothing, a wall, or another run around a corner."""

    FREE = "free"
    WALL = "wall"
    CORNER = "corner"


class PlacedRun(Record):
    """A run of units in the frame of the room.

    Attributes:
        origin: left end of its line. yaw: of the fixtures in it.
        depth_behind, depth_before: of its worktop behind and in front of the line. height: of the worktop.
        at_wall: whether the line is on the face of a wall. is_island: free on all sides.
        next_run: the run that begins at its end, around a corner.
        corner_left, corner_right: lengths that the corners take up. overhang: of the worktop on the seating side.
    """

    id: Id
    origin: Vec2
    yaw: float
    length: float
    depth_behind: float = 0.0
    depth_before: float = 0.65
    height: float = 0.92
    at_wall: bool = True
    is_island: bool = False
    left_end: RunEnd = RunEnd.FREE
    right_end: RunEnd = RunEnd.FREE
    next_run: Id | None = None
    corner_left: float = 0.0
    corner_right: float = 0.0
    overhang: float = 0.0
    units: tuple[PlacedUnit, ...] = ()

    def at(self, along: float, before: float) -> Vec2:
        """World point at a distance along the line and a distance in front of it; metres."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (self.origin[0] + along * c + before * s, self.origin[1] + along * s - before * c)

    def to_local(self, point: Vec2) -> Vec2:
        """Distances of a world point along the line and in front of it; metres."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y = point[0] - self.origin[0], point[1] - self.origin[1]
        return (x * c + y * s, x * s - y * c)

    @property
    def span(self) -> Vec2:
        """First and last position along the line that is taken up by units, including corners; metres."""
        first = 0.0 if self.left_end is not RunEnd.FREE or not self.units else self.units[0].left
        last = self.length if self.right_end is not RunEnd.FREE or not self.units else self.units[-1].right
        return first, last

    @property
    def frontages(self) -> tuple[Vec2, ...]:
        """Intervals of worktop along it without tall units, ranges and gaps; corners not counted; metres."""
        out: list[Vec2] = []
        for unit in self.units:
            if not unit.has_worktop:
                continue
            if out and abs(out[-1][1] - unit.left) < 0.01:
                out[-1] = (out[-1][0], unit.right)
            else:
                out.append((unit.left, unit.right))
        return tuple(out)


class AisleKind(StrEnum):
    """Purpose of an aisle: between two fronts where people work, or for people to walk through."""

    WORK = "work"
    WALK = "walk"


class Aisle(Record):
    """A passage and its minimum width, metres; `first` and `second`: ids of the runs or walls that bound it."""

    kind: AisleKind
    first: str
    second: str
    width: float
    position: Vec2


class ParkingSide(StrEnum):
    """Side of a fixture at which a robot is parked, as seen by a person who looks at the fixture's front."""

    FRONT = "front"
    LEFT = "left"
    RIGHT = "right"
    BEHIND = "behind"


class ParkingPlace(Record):
    """Position of the base of a robot that works at a fixture.

    Attributes:
        fixture: name of the fixture.
        open_joint: joint of the door or drawer that is open meanwhile; empty if everything is closed.
        position: centre of the base. yaw: direction in which the robot looks, radians to the left of the x axis.
        side: in front of the fixture, or next to or behind the open door.
        offset: distance to the right of the fixture's centre, m.
    """

    fixture: Id
    open_joint: str = ""
    position: Vec2
    yaw: float
    side: ParkingSide = ParkingSide.FRONT
    offset: float = 0.0


class KitchenFacts(Record):
    """Floor plan of one finished kitchen.

    Attributes:
        plan, compact, all_tasks: id of the plan, and what it says (see `Plan`).
        outline: of the room, clockwise. fixtures: all placed assets, in the order of the scene.
    """

    id: SceneId
    plan: str = ""
    compact: bool = False
    all_tasks: bool = False
    outline: Corners
    height: float = 2.7
    walls: tuple[RoomWall, ...]
    openings: tuple[WallOpening, ...] = ()
    runs: tuple[PlacedRun, ...] = ()
    fixtures: tuple[Fixture, ...] = ()
    aisles: tuple[Aisle, ...] = ()

    def with_role(self, *roles: Role) -> tuple[Fixture, ...]:
        """Fixtures of these roles, in the order of the scene."""
        return tuple(f for f in self.fixtures if f.role in roles)

    def run(self, name: str) -> PlacedRun | None:
        """Return the run of that id, or None if it does not exist."""
        return next((r for r in self.runs if r.id == name), None)
