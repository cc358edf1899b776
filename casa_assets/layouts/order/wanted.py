"""Items of a kitchen's order: a member of a family, and where it will stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from casa_assets.layouts.plan.wall_frame import WallFrame
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
        frame: of the line. u: of the thing's middle along it. v: of the side that `depth` names, away from the line.
        z: of the end that `height` names. All metres.
        turn_deg: about its upright axis, to the left.
        depth, height: what of it is there.
    """

    frame: WallFrame
    u: float
    v: float
    z: float
    turn_deg: float = 0.0
    depth_reference: DepthReference = DepthReference.BACK
    height_reference: HeightReference = HeightReference.FOOT


@dataclass(frozen=True)
class OrderItem:
    """One thing to build, and the place to put it.

    Attributes:
        name: of the placement. role: what it is for (`base`, `upper`, `fridge`, `wall`, `prop` ...).
        choice: family, preset and what differs from it.
        spot: where it stands. slot: unit of the plan that it belongs to, empty for what the room itself has.
        run: run of the plan that it belongs to.
        drops: stands on something by its weight; else it is fixed.
    """

    name: str
    role: str
    choice: PresetChoice
    spot: Spot
    unit: str = ""
    run: str = ""
    layer: str = "things"


def preset_with(preset: str, params: Mapping[str, Any] | None = None) -> PresetChoice:
    """A preset of a family with some numbers changed."""
    return PresetChoice(preset=preset, params=dict(params or {}))


@dataclass
class BuildOrder:
    """List of items to build, with distinct names."""

    items: list[OrderItem] = field(default_factory=list)

    def add(self, wanted: OrderItem) -> None:
        """Append; a second thing of a name is a bug of the layout."""
        if any(w.name == wanted.name for w in self.items):
            raise ValueError(f"two things are called {wanted.name!r}")
        self.items.append(wanted)
