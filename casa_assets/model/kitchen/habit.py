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
    """How the objects of a group stand to each other.

    STACK: alike, one on top of the other. ROW: side by side, facing the same way. LENGTHWISE: side by side, their
    longest sides from front to back. LOOSE: side by side, each turned by chance. HEAP: in the first, which is a vessel.
    HANDLE_FRONT: one alone, its handle to the front, as a pan on a hob. ON_EDGE: in slots of the first, a dish rack.
    """

    STACK = "stack"
    ROW = "row"
    LENGTHWISE = "lengthwise"
    LOOSE = "loose"
    HEAP = "heap"
    HANDLE_FRONT = "handle_front"
    ON_EDGE = "on_edge"


class SpaceKind(Record):
    """Which regions of which things in a kitchen are a kind of space.

    Attributes:
        assets: globs of the categories of assets, such as `wall_cabinet`.
        regions: globs of names of their regions, or of sites, on which one thing stands.
        from_m, to_m: bounds of the height of its floor above that of the room, metres.
        min_size_m: least width, depth and height, metres; less is no such space.
        gap_m: between groups, and between them and what else stands there.
        is_open: whether people see it as a worktop, on which anything may stand beside anything; what is closed has one
            theme. from_back: whether it is filled from the back, as worktops are, or from the front.
        together: how many times as readily something comes where there is something of its theme already.
        reach_m: how far behind its front edge things stand at most.
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
        """True if the region of that name of an asset of that category, with its floor at that height, is one."""
        return (
            any(fnmatchcase(category, glob) for glob in self.assets)
            and any(fnmatchcase(region, glob) for glob in self.regions)
            and self.from_m <= floor <= self.to_m
        )


class Habit(Record):
    """A group of objects that people keep together.

    Attributes:
        about: one sentence.
        objects: category -> how likely it is; the weights need not sum to one.
        spaces: kind of space -> how likely it is.
        vessel: categories of what the objects lie or stand in (HEAP, ON_EDGE) -> how likely.
        arrangement: how they stand to each other. count: fewest and most objects of a group, a vessel not counted.
        alike: whether all of a group are the same member. most: groups in a kitchen. weight: how likely a group is.
        theme: what shares a closed space with it; a shelf has one theme.
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
        """Fewest objects of a group, its vessel counted."""
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
        """Categories of what people keep in a space of these kinds, sorted."""
        habits = [habit for habit in self.habits.values() if not habit.spaces.keys().isdisjoint(kinds)]
        return tuple(sorted({category for habit in habits for category in (*habit.objects, *habit.vessel)}))
