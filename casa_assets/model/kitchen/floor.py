"""Floor plan of a finished kitchen: walls, runs, fixtures, aisles, and parking places of a robot.

Everything is in the frame of the world (z up, metres).
"""

from __future__ import annotations

import math
from enum import StrEnum

from casa_assets.model.kitchen.fixture import (
    APPLIANCES,
    Corners,
    Fixture,
    FixtureJoint,
    FixtureRegion,
    FixtureSite,
    Footprint,
    Role,
    SweptArea,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import SceneId
from casa_assets.model.record import Id, Record, Vec2

__all__ = [
    "APPLIANCES",
    "Aisle",
    "AisleKind",
    "Corners",
    "KitchenFacts",
    "Fixture",
    "Footprint",
    "SweptArea",
    "FixtureSite",
    "FixtureJoint",
    "ParkingPlace",
    "Role",
    "PlacedRun",
    "RunEnd",
    "RoomWall",
    "ParkingSide",
    "PlacedUnit",
    "FixtureRegion",
    "WallOpening",
]


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
        bottom, top: heights, metres.
        clear_width: free width with the door open; for windows the width of the hole; metres.
        can_open: whether it has joints.
        leads_out: whether it leads out of the kitchen, and not into a closet.
        swept_area: area that a door's leaf sweeps.
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
    """A unit of a run on the floor: left and right end along the run, front and height; metres.

    Attributes:
        kind: kind in the plan.
        has_worktop: whether it carries a worktop.
        front: distance from the line of the run, metres.
    """

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
        origin: left end of its line.
        yaw: yaw of the fixtures in it, radians.
        length: length of the line, metres.
        depth_behind, depth_before: depth of its worktop behind and in front of the line.
        height: height of the worktop.
        at_wall: whether the line is on the face of a wall.
        is_island: whether it is free on all sides.
        next_run: the run that begins at its end, around a corner.
        corner_left, corner_right: lengths that the corners take up, metres.
        overhang: overhang of the worktop on the seating side, metres.
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
        position: centre of the base.
        yaw: direction in which the robot looks, radians to the left of the x axis.
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
        id: id of the scene.
        plan: id of the plan.
        compact: whether the plan says that it is a small kitchen.
        all_tasks: whether the plan says that it is for all 25 atomic tasks of RoboCasa v0.2.
        outline: outline of the room, clockwise.
        height: height of the room.
        fixtures: all placed assets, in the order of the scene.
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
