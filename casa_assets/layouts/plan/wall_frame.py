"""Frame along a wall: converts distances along, away from and up the wall to the frame of the room."""

from __future__ import annotations

import math
from dataclasses import dataclass

from casa_assets.core.rounding import decimals
from casa_assets.model.kitchen.plan import Heading
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3, Vec4

# Quarter turns to the left, seen from above, that take the x axis to a heading.
QUARTERS = {Heading.RIGHT: 0, Heading.BACK: 1, Heading.LEFT: 2, Heading.FRONT: 3}
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
    """A line on the floor with a left end and a direction; what stands at it faces away from it, to its right.

    Attributes:
        x, y: its left end in the room, metres.
        quarter_turns: turns to the left from the room's x axis.
    """

    x: float
    y: float
    quarter_turns: int

    @property
    def direction(self) -> Vec2:
        """Unit vector from left to right."""
        return _DIRECTIONS[self.quarter_turns % 4]

    @property
    def normal(self) -> Vec2:
        """Unit vector from the line into the room."""
        return _DIRECTIONS[(self.quarter_turns - 1) % 4]

    @property
    def rotation(self) -> Vec4:
        """room_from_asset of what faces away from the line: quaternion (w, x, y, z)."""
        return _TURNS[self.quarter_turns % 4]

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
        return WallFrame(x, y, (self.quarter_turns + turn) % 4)

    def to_local(self, x: float, y: float) -> Vec2:
        """Distances (u, v) of a point of the room along the line and away from it, metres."""
        (a, b), (c, d) = self.direction, self.normal
        dx, dy = x - self.x, y - self.y
        return (dx * a + dy * b, dx * c + dy * d)


def _rounded(value: float) -> float:
    """Round to a hundredth of a millimetre, so that the order of summation does not change the bytes."""
    return decimals(value, 5)


def turned_left(pose: Pose, degrees: float) -> Pose:
    """A pose turned to the left about its own upright axis."""
    half = math.radians(degrees) / 2
    return pose @ Pose(quaternion=(math.cos(half), 0.0, 0.0, math.sin(half))) if degrees else pose
