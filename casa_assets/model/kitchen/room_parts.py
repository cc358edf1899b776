"""Parts of a room in addition to its walls: columns, slopes of the ceiling, and closets behind doors."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.model.kitchen.units import Length
from casa_assets.model.record import Id, Record


class ColumnShape(StrEnum):
    """Section of a column."""

    SQUARE = "square"
    ROUND = "round"


class Column(Record):
    """A column from floor to ceiling, at a wall or free in the room; units and tables keep clear of it.

    Attributes:
        wall: wall from which its position is measured.
        at: distance of its middle from the wall's left end, metres.
        from_wall: gap between the wall and the column, metres; 0: it touches the wall.
        width, depth: size along the wall and away from it, metres; the diameter of a round column is its width.
    """

    id: Id
    wall: Id
    at: Length
    from_wall: Length = 0.0
    shape: ColumnShape = ColumnShape.SQUARE
    width: Annotated[float, Field(ge=0.1, le=0.8)] = 0.3
    depth: Annotated[float, Field(ge=0.1, le=0.8)] = 0.3


class Slope(Record):
    """A slope of the ceiling, as under a roof: it rises from a wall to the height of the room.

    Attributes:
        wall: wall at which it begins, whose height is `knee`.
        knee: height of the lower edge, metres.
        pitch_deg: angle to the floor.
    """

    wall: Id
    knee: Annotated[float, Field(ge=0.8, le=3.0)] = 1.6
    pitch_deg: Annotated[float, Field(ge=15, le=70)] = 40.0


class Closet(Record):
    """A small room behind a door or a passage, such as a walk-in pantry, with shelves along its back.

    Attributes:
        width, depth: inside, along the wall and away from it, metres. shelves: boards over each other in the shelves.
    """

    width: Annotated[float, Field(ge=0.9, le=3.0)] = 1.5
    depth: Annotated[float, Field(ge=0.6, le=2.4)] = 1.2
    shelves: Annotated[int, Field(ge=0, le=5)] = 4
