"""A plan in metres, and the order of what it needs: members of families, and where they will be placed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from casa_assets.layouts.plan.room import Room, WallFrame, WallHole
from casa_assets.layouts.plan.runs import RunLine, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import PresetChoice, Style
from casa_assets.model.record import Vec2

BEAM_HALF_WIDTH_M = 0.12  # with a gap


class DepthReference(StrEnum):
    """Side of an item that its distance from the line is measured to."""

    BACK = "back"
    MIDDLE = "middle"
    FRONT = "front"


class HeightReference(StrEnum):
    """End of an item that its height is measured to."""

    FOOT = "foot"
    MIDDLE = "middle"
    HEAD = "head"


@dataclass(frozen=True)
class Spot:
    """Place of an item relative to a line on the floor.

    Attributes:
        frame: of the line. u: of the item's centre along it. v: of the side that `depth_reference` names, away from the
        line. z: of the end that `height_reference` names. All metres.
        turn_deg: yaw, counter-clockwise from above.
        tilt_deg: by which its front is raised about its lower back edge, which lies on the line at `v`.
        least_foot: height below which its foot does not come: an item that reaches lower is raised, metres.
    """

    frame: WallFrame
    u: float
    v: float
    z: float
    turn_deg: float = 0.0
    depth_reference: DepthReference = DepthReference.BACK
    height_reference: HeightReference = HeightReference.FOOT
    tilt_deg: float = 0.0
    least_foot: float = 0.0


@dataclass(frozen=True)
class OrderItem:
    """One thing to build, and the place to put it.

    Attributes:
        name: of the placement. role: purpose (`base`, `upper`, `fridge`, `wall`, `prop` ...).
        choice: family, preset and what differs from it.
        spot: place. unit, run: ids in the plan that it belongs to, empty for parts of the room.
        layer: value of the scene's Layer.
        lid_of: name of the thing that it lies on, with its frame at that thing's site `lid_site`; empty: at its spot.
    """

    name: str
    role: str
    choice: PresetChoice
    spot: Spot
    unit: str = ""
    run: str = ""
    layer: str = "things"
    lid_of: str = ""


def numbered(stem: str, number: int) -> str:
    """Name of one of several items, counted from 0: the first has no number."""
    return stem if number == 0 else f"{stem}_{number + 1}"


@dataclass(frozen=True)
class PlacedTable:
    """A table in the room: (x, y) of its middle, metres, and length and direction (unit vector) of its long side.

    `outline`: corners (x, y) of the area of it and its chairs, metres.
    """

    middle: Vec2
    width: float
    direction: Vec2
    outline: tuple[Vec2, ...]


@dataclass(frozen=True)
class KitchenRequest:
    """A plan in metres with a style applied, before anything is built.

    Parameters are values of the plan's, metres; slots are by run, of units on the floor and on the wall; tables by id.
    """

    plan: Plan
    style: Style
    parameters: Mapping[str, float]
    room: Room
    holes: tuple[WallHole, ...]
    lines: Mapping[str, RunLine]
    slots: Mapping[str, tuple[UnitSlot, ...]]
    items: tuple[OrderItem, ...]
    tables: Mapping[str, PlacedTable] = field(default_factory=dict)

    @property
    def slot_by_name(self) -> dict[str, UnitSlot]:
        """All slots, row by row."""
        return {s.name: s for row in self.slots.values() for s in row}

    def slot(self, name: str) -> UnitSlot:
        """The slot of that name."""
        return self.slot_by_name[name]


@dataclass(frozen=True)
class BeamGrid:
    """`count` beams of one room, evenly apart from `start` to `end` across them, metres; along its x axis, or its y."""

    along_x: bool
    start: float
    end: float
    count: int

    def between(self, x: float, y: float) -> Vec2:
        """The point nearest to x, y that lies in the middle between two beams."""
        pitch = (self.end - self.start) / self.count
        at = y if self.along_x else x
        gap = min(max(round((at - self.start) / pitch), 1), self.count - 1)
        snapped = self.start + gap * pitch
        return (x, snapped) if self.along_x else (snapped, y)

    def crosses(self, low: float, high: float) -> bool:
        """True if a beam comes between two places across the beams, or nearly."""
        pitch = (self.end - self.start) / self.count
        middles = [self.start + (k + 0.5) * pitch for k in range(self.count)]
        return any(low - BEAM_HALF_WIDTH_M < m < high + BEAM_HALF_WIDTH_M for m in middles)


@dataclass
class BuildOrder:
    """List of items to build, with distinct names, while it is written.

    Attributes:
        kitchen: without its items and tables. closed: open walls are built too. beams: under the ceiling.
        seats: where people sit along islands, metres, by run. tables: by id.
    """

    kitchen: KitchenRequest
    models: StyleModels
    closed: bool = False
    beams: BeamGrid | None = None
    seats: Mapping[str, Sequence[float]] = field(default_factory=dict)
    tables: Mapping[str, PlacedTable] = field(default_factory=dict)
    items: list[OrderItem] = field(default_factory=list)

    def add(
        self,
        name: str,
        role: str,
        choice: PresetChoice | str,
        spot: Spot,
        params: Mapping[str, Any] | None = None,
        *,
        unit: str = "",
        run: str = "",
        layer: str = "things",
        lid_of: str = "",
    ) -> None:
        """Append an item of a choice, or of a preset with some numbers changed.

        Raises ValueError where another item has that name, which is a bug of the layout.
        """
        if any(item.name == name for item in self.items):
            raise ValueError(f"two items are called {name!r}")
        made = PresetChoice(preset=choice, params=dict(params or {})) if isinstance(choice, str) else choice
        self.items.append(OrderItem(name, role, made, spot, unit, run, layer, lid_of))
