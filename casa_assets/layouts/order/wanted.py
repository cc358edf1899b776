"""What a kitchen needs built: a member of a family, and where it will stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from casa_assets.layouts.plan.wall_frame import Frame
from casa_assets.model.kitchen.style import Choice


class Depth(StrEnum):
    """Which side of a thing is at a distance from the line."""

    BACK = "back"
    MIDDLE = "middle"
    FRONT = "front"


class Height(StrEnum):
    """Which end of a thing is at a height."""

    FOOT = "foot"
    MIDDLE = "middle"
    HEAD = "head"


@dataclass(frozen=True)
class Spot:
    """A place on a line.

    Attributes:
        frame: of the line. u: of the thing's middle along it. v: of the side that `depth` names, away from the line.
        z: of the end that `height` names. All metres.
        turn_deg: about its upright axis, to the left.
        depth, height: what of it is there.
    """

    frame: Frame
    u: float
    v: float
    z: float
    turn_deg: float = 0.0
    depth: Depth = Depth.BACK
    height: Height = Height.FOOT


@dataclass(frozen=True)
class Wanted:
    """A thing to build and to put in a place.

    Attributes:
        name: of the placement. role: what it is for (`base`, `upper`, `fridge`, `wall`, `prop` ...).
        choice: family, preset and what differs from it.
        spot: where it stands. slot: unit of the plan that it belongs to, empty for what the room itself has.
        run: run of the plan that it belongs to.
        drops: stands on something by its weight; else it is fixed.
    """

    name: str
    role: str
    choice: Choice
    spot: Spot
    slot: str = ""
    run: str = ""
    layer: str = "things"


def member(preset: str, params: Mapping[str, Any] | None = None) -> Choice:
    """A preset of a family with some numbers changed."""
    return Choice(preset=preset, params=dict(params or {}))


@dataclass
class Order:
    """The list of what is wanted while it grows; names are made distinct."""

    items: list[Wanted] = field(default_factory=list)

    def add(self, wanted: Wanted) -> None:
        """Append; a second thing of a name is a bug of the layout."""
        if any(w.name == wanted.name for w in self.items):
            raise ValueError(f"two things are called {wanted.name!r}")
        self.items.append(wanted)
