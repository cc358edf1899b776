"""Units of a row: base units on the floor and wall units of a run, from left to right."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

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
        housing: whether a fridge is placed between panels.
        oven: whether there is a wall oven under a hob.
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
