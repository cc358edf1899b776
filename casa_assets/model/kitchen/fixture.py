"""Fixtures of a kitchen seen from above: position, swept areas of their doors, regions for things.

All of it is in the frame of the world (z up, metres). A fixture has its own x axis to the right of somebody who stands
before it, and faces -y; `yaw` is the turn to the left that takes the world's axes to it, radians.
"""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.model.asset.joint import JointKind
from casa_assets.model.record import Id, Record, Vec2, Vec3

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


APPLIANCES = (
    Role.RANGE,
    Role.HOB,
    Role.OVEN,
    Role.MICROWAVE,
    Role.FRIDGE,
    Role.DISHWASHER,
)


class Footprint(Record):
    """Rectangle on the floor: centre, full size along its own x and y, and yaw."""

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
        """Coordinates of a point: distance to the right of the centre, and before the front; metres."""
        (a, b), (c, d) = self.right, self.front
        x, y = point[0] - self.middle[0], point[1] - self.middle[1]
        return (x * a + y * b, x * c + y * d - self.size[1] / 2)

    @property
    def corners(self) -> Corners:
        """Counter-clockwise."""
        w, d = self.size[0] / 2, self.size[1]
        return (self.at(-w, 0.0), self.at(w, 0.0), self.at(w, -d), self.at(-w, -d))


class SweptArea(Record):
    """Area that a door, flap or drawer passes through, seen from above.

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


class FixtureJoint(Record):
    """A joint of a placed fixture, with the area that it sweeps.

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
    leaf: SweptArea | None = None


class FixtureRegion(Record):
    """Box or cylinder of a fixture where things can be put, joints at zero: footprint, lower and upper end."""

    name: Id
    foot: Footprint
    low: float
    high: float
    round: bool = False
    moves: bool = False


class FixtureSite(Record):
    """Named point of a placed fixture: where a pan or a mug goes, a flame, a button."""

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
    foot: Footprint
    low: float
    high: float
    loose: bool = False
    joints: tuple[FixtureJoint, ...] = ()
    volumes: tuple[FixtureRegion, ...] = ()
    marks: tuple[FixtureSite, ...] = ()
    buttons: tuple[FixtureSite, ...] = ()

    def joint(self, name: str) -> FixtureJoint | None:
        """Its joint of that name, if it has one."""
        return next((j for j in self.joints if j.name == name), None)
