"""Habits of people in a kitchen: which objects they keep together, how, and where. Read from registry/habits.yaml."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.record import Id, Record


class Arrangement(StrEnum):
    """How the objects of a group are placed relative to each other.

    STACK: identical objects, one on top of the other. ROW: side by side, facing the same way. LENGTHWISE: side by side,
    longest side from front to back. LOOSE: side by side, each with a random yaw. HEAP: inside the first object, which
    is a vessel. HANDLE_FRONT: a single object with its handle to the front, such as a pan on a hob. ON_EDGE: in the
    slots of the first object, such as a dish rack.
    """

    STACK = "stack"
    ROW = "row"
    LENGTHWISE = "lengthwise"
    LOOSE = "loose"
    HEAP = "heap"
    HANDLE_FRONT = "handle_front"
    ON_EDGE = "on_edge"


class SpaceKind(Record):
    """A kind of space for objects: which regions of which assets are of this kind, and how they are filled.

    Attributes:
        assets: globs of asset categories, such as `wall_cabinet`.
        regions: globs of names of regions of these assets, or of sites that hold a single object.
        from_m, to_m: least and greatest height of the region's floor above that of the room, metres.
        min_size_m: least width, depth and height, metres.
        gap_m: distance between groups, and between a group and other objects in the space, metres.
        is_open: whether people see it as a worktop, where objects of any theme may be next to each other; any other
            space holds objects of one theme only.
        from_back: whether it is filled from the back, as worktops are, or from the front.
        together: factor by which a space is more likely to be chosen if it already holds objects of the same theme.
        reach_m: maximum distance behind the front edge at which objects are placed, metres.
    """

    assets: Annotated[tuple[str, ...], Field(min_length=1)]
    regions: Annotated[tuple[str, ...], Field(min_length=1)]
    from_m: float = 0.0
    to_m: float = 2.5
    min_size_m: tuple[float, float, float] = (0.08, 0.08, 0.03)
    gap_m: Positive = 0.012
    is_open: bool = False
    from_back: bool = False
    together: Positive = 1.0
    reach_m: Positive = 1.0

    def holds(self, category: str, region: str, floor: float) -> bool:
        """True if a region is of this kind, given its asset's category, its name and the height of its floor (m)."""
        return (
            any(fnmatchcase(category, glob) for glob in self.assets)
            and any(fnmatchcase(region, glob) for glob in self.regions)
            and self.from_m <= floor <= self.to_m
        )


class Habit(Record):
    """A group of objects that people keep together.

    Attributes:
        objects, spaces: category, kind of space -> relative probability; the weights need not sum to one.
        vessel: category of the vessel that holds the objects (HEAP, ON_EDGE) -> relative probability.
        count: least and greatest number of objects in a group, not counting the vessel.
        alike: whether all objects of a group are the same member of a category.
        most: number of groups in a kitchen. weight: relative probability of the group.
        theme: groups of the same theme may share a closed space; a shelf has one theme.
    """

    about: str
    objects: Annotated[Mapping[Id, Positive], Field(min_length=1)]
    spaces: Annotated[Mapping[Id, Positive], Field(min_length=1)]
    vessel: Mapping[Id, Positive] = Field(default_factory=dict)
    arrangement: Arrangement = Arrangement.ROW
    count: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(le=12)]] = (1, 1)
    alike: bool = False
    most: Annotated[int, Field(ge=1)] = 1
    weight: Positive = 1.0
    theme: Id

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if self.count[0] > self.count[1]:
            raise ValueError(f"count {self.count}: the fewest come first")
        if (self.arrangement in (Arrangement.HEAP, Arrangement.ON_EDGE)) != bool(self.vessel):
            raise ValueError("a heap and what stands on edge have a vessel, and nothing else has")
        if self.arrangement is Arrangement.STACK and not self.alike:
            raise ValueError("only what is alike is stacked: alike: true")
        return self

    @property
    def fewest(self) -> int:
        """Minimum number of objects in a group, including its vessel."""
        return self.count[0] + bool(self.vessel)


class Habits(Record):
    """All of registry/habits.yaml: kinds of spaces by name, and habits by name."""

    spaces: Mapping[Id, SpaceKind]
    habits: Mapping[Id, Habit]

    @model_validator(mode="after")
    def _known(self) -> Self:
        for name, habit in self.habits.items():
            unknown = sorted(set(habit.spaces) - set(self.spaces))
            if unknown:
                raise ValueError(f"habit {name!r}: no kind of space {unknown[0]!r}; there are {sorted(self.spaces)}")
        return self

    @property
    def categories(self) -> tuple[str, ...]:
        """Categories of all objects and vessels, sorted."""
        return self.kept_in(self.spaces)

    def kept_in(self, kinds: Collection[str]) -> tuple[str, ...]:
        """Sorted categories of the objects that people keep in spaces of these kinds."""
        habits = [habit for habit in self.habits.values() if not habit.spaces.keys().isdisjoint(kinds)]
        return tuple(sorted({category for habit in habits for category in (*habit.objects, *habit.vessel)}))
