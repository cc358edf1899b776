"""A floor plan as a designer writes it: walls, openings, rows of units, furnishings. No coordinates.

Lengths are metres, or the name of a parameter of the plan. Walls follow each other clockwise as seen from above,
beginning at the back left corner, which is the origin of the room (x right, y back, z up). `left` and `right` of a
wall or a run are as seen by a person in front of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator

from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.record import Id, Record

# Metres, or the name of a parameter of the plan.
Length = Annotated[float, Field(ge=0, le=20)] | Id
Width = Annotated[float, Field(gt=0, le=6)] | tuple[Annotated[float, Field(gt=0)], Annotated[float, Field(gt=0)]]


class RunSide(StrEnum):
    """An end of a run."""

    LEFT = "left"
    RIGHT = "right"


class BaseKind(StrEnum):
    """Kind of a unit on the floor."""

    DOORS = "doors"
    DRAWERS = "drawers"
    SINK = "sink"
    DISHWASHER = "dishwasher"
    RANGE = "range"
    HOB = "hob"
    SHELF = "shelf"
    PANEL = "panel"
    FILLER = "filler"
    GAP = "gap"
    ISLAND = "island"
    PANTRY = "pantry"
    OVEN = "oven"
    MICROWAVE = "microwave"
    FRIDGE = "fridge"


class UpperKind(StrEnum):
    """Kind of a unit on the wall."""

    DOORS = "doors"
    GLASS = "glass"
    SHELF = "shelf"
    BOARDS = "boards"
    HOOD = "hood"
    MICROWAVE = "microwave"
    FILLER = "filler"
    GAP = "gap"


# Units that are as high as the wall units, and end the worktop.
COOKERS = (BaseKind.RANGE, BaseKind.HOB)
TALL = (BaseKind.PANTRY, BaseKind.OVEN, BaseKind.MICROWAVE, BaseKind.FRIDGE)


class Unit(Record):
    """Fields that every unit of a row has.

    Attributes:
        id: unique in the plan; if it is not given, the kind and a number.
        width: metres, or (minimum, maximum) for a unit that shares the width that the others leave; None for the usual
            width.
        model: model of its appliance in the notation of the styles (`range/pro_six`, `library:<id>`); None: the
            style's.
    """

    id: Id
    width: Width | None = None
    model: PresetChoice | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if isinstance(self.width, tuple) and self.width[0] > self.width[1]:
            raise ValueError(f"the minimum width {self.width[0]} is more than the maximum {self.width[1]}")
        return self


class BaseUnit(Unit):
    """A unit on the floor.

    Attributes:
        drawers: number of drawers in a drawer unit, or above the doors of a cabinet (0 or 1).
        hinge: side of a single door's hinges; None: chosen by the layout, away from a corner.
        housing: whether a fridge is placed between panels. oven: whether there is a wall oven under a hob.
        microwave: whether there is a microwave above the oven of a tower.
    """

    kind: BaseKind
    drawers: Annotated[int | None, Field(ge=0, le=5)] = None
    hinge: RunSide | None = None
    housing: bool = True
    oven: bool = False
    microwave: bool = False


class UpperUnit(Unit):
    """A unit on the wall.

    Attributes:
        over: unit below on which it is centred, and whose width it takes if it has no width itself.
    """

    kind: UpperKind
    over: Id | None = None
    hinge: RunSide | None = None
    height: Annotated[float | None, Field(gt=0.2, le=1.4)] = None


def with_ids(units: list[Any], run: str, row: str) -> Iterator[Any]:
    """Convert units in their short forms to mappings with a kind and an id.

    Values that are no unit are passed on unchanged, for validation.
    """
    counts: dict[str, int] = {}
    for unit in units:
        if isinstance(unit, str):
            unit = {unit: {}}
        if not isinstance(unit, Mapping) or len(unit) != 1:
            yield unit
            continue
        kind, value = next(iter(unit.items()))
        fields = dict(value) if isinstance(value, Mapping) else {} if value is None else {"width": value}
        counts[kind] = counts.get(kind, 0) + 1
        stem = f"{run}_{kind}" if row == "base" else f"{run}_upper_{kind}"
        fields.setdefault("id", stem if counts[kind] == 1 else f"{stem}_{counts[kind]}")
        yield {"kind": kind, **fields}


MOST_SEATS = 6  # at one run


class WorktopItem(Record):
    """An item on a worktop or shelf.

    Attributes:
        id: role of the styles, such as `coffee_machine`; any name if `model` is given. on: id of the unit below.
        at: position along the unit, from 0 (left) to 1 (right). back: gap between the item and the wall, metres.
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
        id: unique. wall: wall from which the position is measured.
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
        id: unique. item: role of the styles. wall: id of the wall.
        at: distance of its centre from the wall's left end, metres.
        over: unit that it is centred on, instead of `at`. height: height of its centre above the floor, metres.
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
        item: role of the styles. over: run or table along which they hang; None: over the free floor.
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


class ColumnShape(StrEnum):
    """Section of a column."""

    SQUARE = "square"
    ROUND = "round"


class Column(Record):
    """A column from floor to ceiling, at a wall or free in the room; units and tables keep clear of it.

    Attributes:
        wall: wall from which its position is measured. at: distance of its middle from the wall's left end, metres.
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
        wall: wall at which it begins, whose height is `knee`. knee: height of the lower edge, metres.
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


class Heading(StrEnum):
    """Direction of a wall from its left end to its right end, seen from above."""

    RIGHT = "right"
    FRONT = "front"
    LEFT = "left"
    BACK = "back"


# Degrees clockwise from the room's x axis.
_DEGREES = {Heading.RIGHT: 0.0, Heading.FRONT: 90.0, Heading.LEFT: 180.0, Heading.BACK: 270.0}


def degrees_of(heading: Heading | float) -> float:
    """Degrees of a heading clockwise from `right`, seen from above."""
    return _DEGREES[heading] if isinstance(heading, Heading) else heading


class Parameter(Record):
    """A length that may vary. Metres."""

    default: float
    low: float
    high: float

    @model_validator(mode="before")
    @classmethod
    def _expand_shorthand(cls, value: Any) -> Any:
        """A parameter may be written `[default, low, high]`."""
        if isinstance(value, list) and len(value) == 3:
            return dict(zip(("default", "low", "high"), value, strict=True))
        return value

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not 0 < self.low <= self.default <= self.high:
            raise ValueError("needs 0 < low <= default <= high")
        return self


class Wall(Record):
    """A side of the room. An `open` wall is only drawn if a closed room is requested.

    Attributes:
        heading: direction from its left to its right end, seen from above: a word, or, for an oblique wall, degrees
            clockwise from `right`; 45 is between `right` and `front`.
        length: metres. One wall across the room and one along it may have None: they get the length that closes the
            outline.
    """

    id: Id
    heading: Heading | Annotated[float, Field(ge=0, lt=360)]
    length: Length | None = None
    open: bool = False

    @field_validator("heading")
    @classmethod
    def _in_words(cls, value: Heading | float) -> Heading | float:
        """Replace the degrees of a quarter turn by its word."""
        return next((word for word, degrees in _DEGREES.items() if degrees == value), value)

    @property
    def is_aslant(self) -> bool:
        """True if it does not run along an axis of the room."""
        return not isinstance(self.heading, Heading)


# Height at which a window begins where a plan states none: over a worktop of 0.92 m and the levers of a tap on it.
WINDOW_SILL_M = 1.12


class OpeningKind(StrEnum):
    """Kind of an opening in a wall: window, door, passage, or a niche, which is closed at the back."""

    WINDOW = "window"
    DOOR = "door"
    PASSAGE = "passage"
    NICHE = "niche"


class PlanOpening(Record):
    """A window, a door, a passage without a leaf, or a niche: a recess for a refrigerator, a seat or a shelf.

    Attributes:
        wall: id of its wall; a window in the back of a niche names the wall of the niche.
        at, over: either the distance of its centre from the wall's left end, or the unit that it is centred on.
        width, height: size of the hole; a niche over a unit is as wide as the unit if its width is not stated.
        sill: height of its lower edge; doors and passages, and niches that do not state it, begin at the floor. All
            metres.
        hinge: side of a door's hinges. depth: depth of a niche, from the face of the wall, metres.
        closet: small room that a door or a passage leads to; None: it leads outside.
    """

    id: Id
    kind: OpeningKind
    wall: Id
    at: Length | None = None
    over: Id | None = None
    width: Annotated[float, Field(ge=0.4, le=2.4)] = 1.2
    height: Annotated[float, Field(ge=0.4, le=2.4)] = 1.05
    sill: Annotated[float, Field(ge=0, le=1.8)] = WINDOW_SILL_M
    hinge: RunSide = RunSide.LEFT
    depth: Annotated[float | None, Field(ge=0.2, le=1.2)] = None
    closet: Closet | None = None

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if (self.at is None) == (self.over is None):
            raise ValueError("give either `at` or `over`")
        is_niche = self.kind is OpeningKind.NICHE
        if is_niche is (self.depth is None):
            raise ValueError("a niche needs a `depth`" if is_niche else "only a niche has a `depth`")
        if self.closet is not None and self.kind not in (OpeningKind.DOOR, OpeningKind.PASSAGE):
            raise ValueError("only a door or a passage leads to a `closet`")
        return self

    @property
    def bottom(self) -> float:
        """Height of the lower edge, metres."""
        if self.kind is OpeningKind.NICHE:
            return self.sill if "sill" in self.model_fields_set else 0.0
        return self.sill if self.kind is OpeningKind.WINDOW else 0.0


class IslandSide(StrEnum):
    """Side of a run at which an island is placed.

    The working side, or, for a run that is itself an island, the side behind it.
    """

    FRONT = "front"
    BACK = "back"


class IslandPosition(Record):
    """Position of an island: in front of a run, or behind another island; turned to it.

    Attributes:
        run: id of the run that it faces. side: side of that run. aisle: distance from worktop to worktop, metres.
        in_front_of: unit of that run that it is centred on; None: the middle of the run.
        shift: offset of its centre to the right, for a person in front of the run, metres.
    """

    run: Id
    side: IslandSide = IslandSide.FRONT
    aisle: Annotated[float, Field(ge=0.9, le=3)] = 1.2
    in_front_of: Id | None = None
    shift: float = 0.0


class PeninsulaPosition(Record):
    """Position of a peninsula: at the free end of a run and across it, so that the two form a corner."""

    run: Id
    end: RunSide


class Run(Record):
    """A row of units.

    Attributes:
        on, faces, joins: exactly one of: the wall of the run, the position of an island, the position of a peninsula.
        start, end: distances of its ends from those of the wall, metres.
        length: length of an island or peninsula; None: the sum of the usual widths of its units. For a run at a wall it
            replaces the length that `start` and `end` leave, measured from its corner if it has one at one end, else
            from its left end.
        base, upper: units from left to right.
        overhang: overhang of the worktop behind the run, for seats, metres; 0 at a wall.
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
    def _expand_shorthand(cls, value: Any) -> Any:
        """Rows may be written `- drawers: 0.6`, `- doors: [0.4, 0.9]`, `- sink: {width: 0.8}` or just `- fridge`."""
        if not isinstance(value, Mapping):
            return value
        fields = dict(value)
        for row in ("base", "upper"):
            if isinstance(units := fields.get(row), list):
                fields[row] = list(with_ids(units, str(fields.get("id", "run")), row))
        return fields

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if sum(x is not None for x in (self.on, self.faces, self.joins)) != 1:
            raise ValueError("give one of `on`, `faces` and `joins`")
        return self


class CornerKind(StrEnum):
    """Kind of corner between two runs.

    BLIND: one cabinet reaches into the corner, and its door is next to the corner. DIAGONAL: one cabinet has its front
    across the corner. DEAD: the corner holds no cabinet and stays closed.
    """

    BLIND = "blind"
    DIAGONAL = "diagonal"
    DEAD = "dead"


class RunCorner(Record):
    """Corner between the right end of one run and the left end of the next.

    Attributes:
        runs: the two runs, clockwise seen from above. base: kind of the base units.
        upper: kind of the wall units, or None if one of the runs has no wall units there.
        owner: run whose cabinet fills the corner; None: the first.
    """

    runs: tuple[Id, Id]
    base: CornerKind = CornerKind.BLIND
    upper: CornerKind | None = None
    owner: Id | None = None


class Plan(Record):
    """A floor plan.

    Attributes:
        id: name of the plan. title: name for people. parameters: lengths that may vary.
        height: height of the room, metres; for a room with slopes, the height where its ceiling is level.
        worktop_items, seats, tables, wall_items, lamps, floor_items: furnishings in addition to the units.
        compact: whether it is a small kitchen, in which aisles may be 0.914 m wide, as walkways are.
        all_tasks: whether each of the 25 atomic tasks of RoboCasa v0.2 has to find what it needs (check TSK001).
    """

    id: Id
    title: str
    parameters: Mapping[Id, Parameter] = Field(default_factory=dict)
    height: Annotated[float, Field(ge=2.3, le=3.4)] = 2.7
    walls: Annotated[tuple[Wall, ...], Field(min_length=4)]
    openings: tuple[PlanOpening, ...] = ()
    columns: tuple[Column, ...] = ()
    slopes: tuple[Slope, ...] = ()
    runs: Annotated[tuple[Run, ...], Field(min_length=1)]
    corners: tuple[RunCorner, ...] = ()
    worktop_items: tuple[WorktopItem, ...] = ()
    seats: tuple[SeatRow, ...] = ()
    tables: tuple[DiningTable, ...] = ()
    wall_items: tuple[WallItem, ...] = ()
    lamps: tuple[CeilingLamps, ...] = ()
    floor_items: tuple[FloorItem, ...] = ()
    compact: bool = False
    all_tasks: bool = False

    @model_validator(mode="before")
    @classmethod
    def _expand_shorthand(cls, value: Any) -> Any:
        """Walls, openings, runs and furnishings may be written as a mapping of ids to rows."""
        if not isinstance(value, Mapping):
            return value
        fields = dict(value)
        for field in ("walls", "openings", "columns", "runs", "worktop_items", "tables", "wall_items", "floor_items"):
            if isinstance(rows := fields.get(field), Mapping):
                fields[field] = [{"id": name, **row} if isinstance(row, Mapping) else row for name, row in rows.items()]
        return fields

    def length(self, value: Length, parameters: Mapping[str, float]) -> float:
        """Metres of a length: a number, or the value of a parameter."""
        return parameters[value] if isinstance(value, str) else value

    @property
    def defaults(self) -> dict[str, float]:
        """Default values of the parameters, metres."""
        return {name: p.default for name, p in self.parameters.items()}

    @property
    def units(self) -> dict[str, BaseUnit]:
        """All units on the floor by id."""
        return {u.id: u for run in self.runs for u in run.base}
