"""Frame along a wall: converts distances along, away from and up the wall to the frame of the room."""

from __future__ import annotations

import math
from dataclasses import dataclass

from casa_assets.core.numeric import decimals
from casa_assets.model.kitchen.plan import Heading, degrees_of
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
