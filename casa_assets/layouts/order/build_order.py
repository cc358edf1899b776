"""Items of a kitchen's order: a member of a family, and where it will be placed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from casa_assets.layouts.plan.room import WallFrame
from casa_assets.model.kitchen.style import PresetChoice


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


def preset_with(preset: str, params: Mapping[str, Any] | None = None) -> PresetChoice:
    """A preset of a family with some numbers changed."""
    return PresetChoice(preset=preset, params=dict(params or {}))


def numbered(stem: str, number: int) -> str:
    """Name of one of several items, counted from 0: the first has no number."""
    return stem if number == 0 else f"{stem}_{number + 1}"


@dataclass
class BuildOrder:
    """List of items to build, with distinct names."""

    items: list[OrderItem] = field(default_factory=list)

    def add(self, item: OrderItem) -> None:
        """Append. Raises ValueError where another item has that name, which is a bug of the layout."""
        if any(i.name == item.name for i in self.items):
            raise ValueError(f"two items are called {item.name!r}")
        self.items.append(item)
