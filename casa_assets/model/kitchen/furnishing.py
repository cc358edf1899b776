"""Furnishings of a plan besides its units: on worktops, at walls, under the ceiling, on the floor."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.kitchen.units import Length
from casa_assets.model.record import Id, Record

MOST_SEATS = 6  # at one run


class WorktopItem(Record):
    """Something that stands on a worktop or shelf.

    Attributes:
        id: role of the styles, such as `coffee_machine`; any name where `model` is given.
        on: id of the unit below. at: position along the unit, 0 left to 1 right.
        back: gap between it and the wall, metres. turn_deg: yaw, counter-clockwise from above.
        model: as a style names it, such as `library:<id>`; None: the style's for the role.
    """

    id: Id
    on: Id
    at: Annotated[float, Field(ge=0, le=1)] = 0.5
    back: Annotated[float, Field(ge=0.0, le=0.5)] = 0.06
    turn_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    model: PresetChoice | None = None


class SeatRow(Record):
    """Stools along the side of an island or peninsula that is turned away from the cook."""

    run: Id
    count: Annotated[int, Field(ge=1, le=MOST_SEATS)]


class DiningTable(Record):
    """A table to eat at, with chairs round it: the style's, as long as its chairs need.

    Attributes:
        id: unique.
        wall: from which its place is measured. at: distance of its middle from the wall's left end. from_wall: distance
            of its middle from the wall. Metres.
        chairs: how many stand at it, along its long sides, the odd one at its left end; evenly round a round one.
        turn_deg: yaw, counter-clockwise from above; at 0 its long sides run along the wall.
    """

    id: Id
    wall: Id
    at: Length
    from_wall: Length
    chairs: Annotated[int, Field(ge=1, le=8)] = 4
    turn_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0


class WallItem(Record):
    """Something on a wall.

    Attributes:
        id: unique. item: role of the styles. wall: id.
        at: distance of its centre from the wall's left end, metres; or over: the unit it is centred on.
        height: of its centre above the floor, metres. shift: to the right, metres.
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
        item: role of the styles. over: run or table along which they hang; None: over the free floor.
    """

    item: Id
    over: Id | None = None
    count: Annotated[int, Field(ge=1, le=8)] = 1


class FloorItem(Record):
    """Something on the floor, its centre `from_wall` metres from a wall and `at` metres from the wall's left end."""

    id: Id
    item: Id
    wall: Id
    at: Length
    from_wall: Length = 0.4
    turn_deg: float = 0.0
