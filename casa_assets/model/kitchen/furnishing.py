"""Furnishings of a plan besides its units: on worktops, at walls, under the ceiling, on the floor."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.kitchen.units import Length
from casa_assets.model.record import Id, Record


class WorktopItem(Record):
    """Something that stands on a worktop or shelf.

    Attributes:
        id: what it is: a role of the styles, such as `coffee_machine`.
        on: the unit under the worktop. at: where along the unit, 0 left to 1 right.
        back: gap between it and the wall, metres. turn_deg: to the left, seen from above.
    """

    id: Id
    on: Id
    at: Annotated[float, Field(ge=0, le=1)] = 0.5
    back: Annotated[float, Field(ge=0.0, le=0.5)] = 0.06
    turn_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0


class SeatRow(Record):
    """Stools along the side of an island or peninsula that is turned away from the cook."""

    run: Id
    count: Annotated[int, Field(ge=1, le=6)]


class WallItem(Record):
    """Something on a wall.

    Attributes:
        id: unique. item: role. wall: where. at: from its left end to the middle; or over: the unit it is centred on.
        height: of its middle above the floor, metres. shift: to the right, metres.
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
        item: role. over: run along which they hang; None: over the free floor. count: of them.
    """

    item: Id
    over: Id | None = None
    count: Annotated[int, Field(ge=1, le=8)] = 1


class FloorItem(Record):
    """Something on the floor: its middle is `beside` metres from the wall, and `at` metres from its left end."""

    id: Id
    item: Id
    wall: Id
    at: Length
    beside: Length = 0.4
    turn_deg: float = 0.0
