"""Fixtures of a kitchen seen from above: position, swept areas of their doors, regions for objects.

Everything is in the world frame (z up, metres). The x axis of a fixture points to the right of a person who looks at
its front, and the fixture faces -y; `yaw` is its counter-clockwise rotation relative to the world axes, radians.
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
    """Area that a door, flap or drawer passes through, seen from above.

    Attributes:
        outline: convex outline of the swept area, counter-clockwise.
        open_outline: outline of the moving part when open, counter-clockwise.
        bottom, top: heights between which it moves, metres.
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
        name: name in its asset.
        range: lower and upper end, rad or m.
        behind: joint that has to be open before this one can move.
        grip_point: middle of the grip with every joint at zero, or None if the joint has no grip.
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
    is_cylinder: bool = False
    is_moving: bool = False


class FixtureSite(Record):
    """Named point of a placed fixture: the place of a pan or a mug, a flame, a button."""

    name: Id
    position: Vec3


class Fixture(Record):
    """A placed asset of the kitchen.

    Attributes:
        name: name of its placement.
        category: category of its asset.
        unit, run: its unit and run in the plan, or empty if it belongs to none.
        footprint: without handles.
        bottom, top: heights above the floor, metres.
        is_movable: whether it can be pushed away.
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
    is_movable: bool = False
    joints: tuple[FixtureJoint, ...] = ()
    regions: tuple[FixtureRegion, ...] = ()
    sites: tuple[FixtureSite, ...] = ()
    buttons: tuple[FixtureSite, ...] = ()

    def joint(self, name: str) -> FixtureJoint | None:
        """Return the joint of that name, or None if it does not exist."""
        return next((j for j in self.joints if j.name == name), None)
