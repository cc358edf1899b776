"""Fixtures of a kitchen seen from above: position, swept areas of their doors, regions for things.

Everything is in the frame of the world (z up, metres). A fixture has its own x axis to the right of somebody who stands
before it, and faces -y; `yaw` is the turn to the left that takes the world's axes to it, radians.
"""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.model.asset.joint import JointKind
from casa_assets.model.record import Id, MixedCaseId, Record, Vec2, Vec3

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

    center: Vec2
    size: Vec2
    yaw: float = 0.0

    @property
    def right_axis(self) -> Vec2:
        """Unit vector to the right, for a person in front of it."""
        return (math.cos(self.yaw), math.sin(self.yaw))

    @property
    def front_axis(self) -> Vec2:
        """Unit vector that it faces along."""
        return (math.sin(self.yaw), -math.cos(self.yaw))

    def at(self, across: float, before: float) -> Vec2:
        """World point at a distance to the right of its centre, and a distance before its front; metres."""
        (a, b), (c, d) = self.right_axis, self.front_axis
        v = before + self.size[1] / 2
        return (self.center[0] + across * a + v * c, self.center[1] + across * b + v * d)

    def to_local(self, point: Vec2) -> Vec2:
        """Distances of a world point to the right of the centre, and before the front; metres."""
        (a, b), (c, d) = self.right_axis, self.front_axis
        x, y = point[0] - self.center[0], point[1] - self.center[1]
        return (x * a + y * b, x * c + y * d - self.size[1] / 2)

    @property
    def corners(self) -> Corners:
        """Counter-clockwise."""
        w, d = self.size[0] / 2, self.size[1]
        return (self.at(-w, 0.0), self.at(w, 0.0), self.at(w, -d), self.at(-w, -d))


class SweptArea(Record):
    """Area that a door, flap or drawer passes through, seen from above.

    Attributes:
        outline: convex outline of the swept area. open_outline: of the moving part when open. Counter-clockwise.
        bottom, top: heights between which it moves, metres.
        sweeps_front: whether it is a drawer or a flap, which lies before the fixture when open; False for side hinges.
    """

    outline: Corners
    open_outline: Corners
    bottom: float
    top: float
    sweeps_front: bool


class FixtureJoint(Record):
    """A joint of a placed fixture, with the area that it sweeps.

    Attributes:
        name: in its asset. range: rad or m. behind: joint that has to be open before this one can move.
        grip_point: middle of the grip with every joint at zero, None where there is none.
        swept_area: None for what stays within the fixture, such as knobs and racks.
    """

    name: Id
    kind: JointKind
    range: Vec2
    behind: Id | None = None
    grip_point: Vec3 | None = None
    swept_area: SweptArea | None = None


class FixtureRegion(Record):
    """Box or cylinder of a fixture where things can be put, joints at zero; `bottom` and `top` are heights, metres."""

    name: MixedCaseId
    footprint: Footprint
    bottom: float
    top: float
    is_cylinder: bool = False
    is_moving: bool = False


class FixtureSite(Record):
    """Named point of a placed fixture: where a pan or a mug goes, a flame, a button."""

    name: Id
    position: Vec3


class Fixture(Record):
    """Something in the kitchen.

    Attributes:
        name: of its placement. category: of its asset. unit, run: of the plan, empty where it belongs to none.
        footprint: without handles. bottom, top: heights above the floor, metres.
        is_movable: whether it can be pushed away.
        buttons: centres of colliders that are pressed.
    """

    name: Id
    role: Role
    category: str
    unit: str = ""
    run: str = ""
    footprint: Footprint
    bottom: float
    top: float
    is_movable: bool = False
    joints: tuple[FixtureJoint, ...] = ()
    regions: tuple[FixtureRegion, ...] = ()
    sites: tuple[FixtureSite, ...] = ()
    buttons: tuple[FixtureSite, ...] = ()

    def joint(self, name: str) -> FixtureJoint | None:
        """Its joint of that name, if it has one."""
        return next((j for j in self.joints if j.name == name), None)
