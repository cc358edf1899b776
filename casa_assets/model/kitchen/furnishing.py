"""Furnishings of a plan in addition to its units: on worktops, at walls, under the ceiling, on the floor."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.kitchen.units import Length
from casa_assets.model.record import Id, Record

MOST_SEATS = 6  # at one run


class WorktopItem(Record):
    """An item on a worktop or shelf.

    Attributes:
        id: role of the styles, such as `coffee_machine`; any name if `model` is given.
        on: id of the unit below.
        at: position along the unit, from 0 (left) to 1 (right).
        back: gap between the item and the wall, metres.
        turn_deg: yaw, counter-clockwise from above.
        model: model in the notation of the styles, such as `library:<id>`; None: the style's model for the role.
    """

    id: Id
    on: Id
    at: Annotated[float, Field(ge=0, le=1)] = 0.5
    back: Annotated[float, Field(ge=0.0, le=0.5)] = 0.06
    turn_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    model: PresetChoice | None = None


class SeatRow(Record):
    """Stools along the side of an island or peninsula that faces away from the cook."""

    run: Id
    count: Annotated[int, Field(ge=1, le=MOST_SEATS)]


class DiningTable(Record):
    """A dining table with chairs around it: the style's model, as long as its chairs need.

    Attributes:
        id: unique.
        wall: wall from which the position is measured.
        at: distance of the table's middle from the wall's left end, metres.
        from_wall: distance of the table's middle from the wall, metres.
        chairs: number of chairs, placed along the long sides, with an odd one at the left end; evenly spaced around a
            round table.
        turn_deg: yaw, counter-clockwise from above; at 0 the long sides are parallel to the wall.
    """

    id: Id
    wall: Id
    at: Length
    from_wall: Length
    chairs: Annotated[int, Field(ge=1, le=8)] = 4
    turn_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0


class WallItem(Record):
    """An item on a wall.

    Attributes:
        id: unique.
        item: role of the styles.
        wall: id of the wall.
        at: distance of its centre from the wall's left end, metres.
        over: unit that it is centred on, instead of `at`.
        height: height of its centre above the floor, metres.
        shift: offset to the right, metres.
    """

    id: Id
    item: Id
    wall: Id
    at: Length | None = None
    over: Id | None = None
    height: Annotated[float, Field(ge=0.1, le=3)]
    shift: float = 0.0

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if (self.at is None) == (self.over is None):
            raise ValueError("give either `at` or `over`")
        return self


class CeilingLamps(Record):
    """Lamps under the ceiling.

    Attributes:
        item: role of the styles.
        over: run or table along which they hang; None: over the free floor.
    """

    item: Id
    over: Id | None = None
    count: Annotated[int, Field(ge=1, le=8)] = 1


class FloorItem(Record):
    """An item on the floor, its centre `from_wall` metres from a wall and `at` metres from the wall's left end."""

    id: Id
    item: Id
    wall: Id
    at: Length
    from_wall: Length = 0.4
    turn_deg: float = 0.0
