"""A floor plan as a designer writes it: walls, openings, rows of units, and what stands where. No coordinates.

Lengths are metres, or the name of a parameter of the plan. Walls follow each other clockwise as seen from above,
beginning at the back left corner, which is the origin of the room (x right, y back, z up). `left` and `right` of a wall
or a run are as seen by somebody who stands in front of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from casa_assets.model.kitchen.furnishing import CeilingLamps, FloorItem, SeatRow, WallItem, WorktopItem
from casa_assets.model.kitchen.units import BaseUnit, Length, RunSide, UpperUnit, numbered
from casa_assets.model.record import Id, Record


class Heading(StrEnum):
    """Direction of a wall from its left end to its right end, seen from above."""

    RIGHT = "right"
    FRONT = "front"
    LEFT = "left"
    BACK = "back"


class Parameter(Record):
    """A length that may vary. Metres."""

    default: float
    low: float
    high: float

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        if isinstance(value, list) and len(value) == 3:
            return dict(zip(("default", "low", "high"), value, strict=True))
        return value

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not 0 < self.low <= self.default <= self.high:
            raise ValueError("0 < low <= default <= high")
        return self


class Wall(Record):
    """A side of the room. An `open` one is drawn only where a closed room is asked for.

    Attributes:
        length: metres; None: what leads back to where the walls begin, for one across the room and one along it.
    """

    id: Id
    go: Heading
    length: Length | None = None
    open: bool = False


class OpeningKind(StrEnum):
    """Kind of an opening in a wall: window, door or passage."""

    WINDOW = "window"
    DOOR = "door"
    PASSAGE = "passage"


class PlanOpening(Record):
    """A window, a door, or a passage without a leaf.

    Attributes:
        wall: where. at: from the wall's left end to its middle; or over: the unit that it is centred on.
        width, height: of the hole. sill: height of its lower edge; doors and passages stand on the floor.
        hinge: side on which a door is hung.
    """

    id: Id
    kind: OpeningKind
    wall: Id
    at: Length | None = None
    over: Id | None = None
    width: Annotated[float, Field(ge=0.4, le=2.4)] = 1.2
    height: Annotated[float, Field(ge=0.4, le=2.4)] = 1.1
    sill: Annotated[float, Field(ge=0, le=1.8)] = 1.02
    hinge: RunSide = RunSide.LEFT

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if (self.at is None) == (self.over is None):
            raise ValueError("give either `at` or `over`")
        return self

    @property
    def bottom(self) -> float:
        """Height of the lower edge, metres."""
        return self.sill if self.kind is OpeningKind.WINDOW else 0.0


class IslandPosition(Record):
    """Position of an island: in front of a run, and turned to it.

    Attributes:
        run: the run that it faces. aisle: from worktop to worktop, metres.
        by: the unit of that run that its middle is in front of; None: the middle of the run.
        shift: of its middle to the right as seen by who stands before the run, metres.
    """

    run: Id
    aisle: Annotated[float, Field(ge=0.9, le=3)] = 1.2
    by: Id | None = None
    shift: float = 0.0


class PeninsulaPosition(Record):
    """Position of a peninsula: at the free end of a run and across it, so that the two form a corner."""

    run: Id
    end: RunSide


class Run(Record):
    """A row of units.

    Attributes:
        on: the wall that it stands at; or faces: a run that it stands before; or joins: a run that it continues.
        start, end: distance of its ends from those of the wall, metres.
        length: of an island or peninsula; None: the usual widths of its units. At a wall: instead of what `start` and
            `end` leave, from the corner that it has on one side, else from its left end.
        base, upper: from left to right.
        overhang: how far the worktop reaches out behind, for people to sit; 0 at a wall.
    """

    id: Id
    on: Id | None = None
    faces: IslandPosition | None = None
    joins: PeninsulaPosition | None = None
    start: Length = 0.0
    end: Length = 0.0
    length: Length | None = None
    base: tuple[BaseUnit, ...] = ()
    upper: tuple[UpperUnit, ...] = ()
    overhang: Annotated[float, Field(ge=0, le=0.45)] = 0.0

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        """Rows may be written `- drawers: 0.6`, `- doors: [0.4, 0.9]`, `- sink: {width: 0.8}` or just `- fridge`."""
        if not isinstance(value, Mapping):
            return value
        whole = dict(value)
        for row in ("base", "upper"):
            if isinstance(units := whole.get(row), list):
                whole[row] = list(numbered(units, str(whole.get("id", "run")), row))
        return whole

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if sum(x is not None for x in (self.on, self.faces, self.joins)) != 1:
            raise ValueError("give one of `on`, `faces` and `joins`")
        return self


class CornerKind(StrEnum):
    """Kind of corner between two runs."""

    BLIND = "blind"
    DIAGONAL = "diagonal"
    DEAD = "dead"


class RunCorner(Record):
    """Corner between the right end of one run and the left end of the next.

    Attributes:
        runs: the first, and the one that is met clockwise of it.
        base: below. upper: above, or None where one of the runs has no wall units there.
        by: the run whose blind cabinet reaches into the corner; None: the first.
    """

    runs: tuple[Id, Id]
    base: CornerKind = CornerKind.BLIND
    upper: CornerKind | None = None
    by: Id | None = None


class Plan(Record):
    """A floor plan. See the module.

    Attributes:
        id, title: name, and what a person calls it.
        parameters: lengths that may vary.
        height: of the room.
        walls, openings, runs, corners: as above.
        stands, seats, hangings, lamps, floor: what is put in besides the units.
        dining: whether people eat in it at a worktop.
        compact: a small kitchen: the aisle may be 0.914 m, as between walls that people only pass.
    """

    id: Id
    title: str
    parameters: Mapping[Id, Parameter] = Field(default_factory=dict)
    height: Annotated[float, Field(ge=2.3, le=3.4)] = 2.7
    walls: Annotated[tuple[Wall, ...], Field(min_length=4)]
    openings: tuple[PlanOpening, ...] = ()
    runs: Annotated[tuple[Run, ...], Field(min_length=1)]
    corners: tuple[RunCorner, ...] = ()
    stands: tuple[WorktopItem, ...] = ()
    seats: tuple[SeatRow, ...] = ()
    hangings: tuple[WallItem, ...] = ()
    lamps: tuple[CeilingLamps, ...] = ()
    floor: tuple[FloorItem, ...] = ()
    compact: bool = False

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        """Walls, openings, runs and all that is put in may be written as a mapping of ids to rows."""
        if not isinstance(value, Mapping):
            return value
        whole = dict(value)
        for field in ("walls", "openings", "runs", "stands", "hangings", "floor"):
            if isinstance(rows := whole.get(field), Mapping):
                whole[field] = [{"id": name, **row} if isinstance(row, Mapping) else row for name, row in rows.items()]
        return whole

    def length(self, value: Length, given: Mapping[str, float]) -> float:
        """Metres of a length: a number, or what the parameters are."""
        return given[value] if isinstance(value, str) else value

    @property
    def defaults(self) -> dict[str, float]:
        """The parameters as the plan has them."""
        return {name: p.default for name, p in self.parameters.items()}

    @property
    def units(self) -> dict[str, BaseUnit]:
        """All units on the floor by id."""
        return {u.id: u for run in self.runs for u in run.base}
