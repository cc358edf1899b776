"""Small rows of registry/: limits, rejections, roles, finishes, textures, projects, curves of confidence, habits."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.asset.asset import Base, Confidence
from casa_assets.model.asset.material import Material, Positive, Substance
from casa_assets.model.issue import Code
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.record import Id, Record, Vec2
from casa_assets.model.registry.category import QCode


class TaxonomyClass(Record):
    """A class of categories or of classes; `parent` is None at the root."""

    id: Id
    parent: Id | None = None
    qcode: QCode


class Limit(Record):
    """A limit for measured values, with its unit (empty for counts and ratios) and its reason in one line."""

    id: Id
    value: float
    unit: str = ""
    why: str


class Rejection(Record):
    """Reason for turning an input away: its meaning and the remedy, for the person who sent it."""

    code: Code
    name: Id
    meaning: str
    remedy: str


class Waiver(Record):
    """A fault of one subject that is known and accepted, with the reason."""

    code: Code
    subject: str
    reason: str


class MisleadingWords(Record):
    """Words that mislead a look-up: they yield to any other, or end the name of the object in a text."""

    weak: tuple[str, ...]
    separators: tuple[str, ...]


class OtherThingsWords(Record):
    """Words in names which show that a mesh is not a single household object; see registry/other_things.yaml.

    All words are in the singular.

    Attributes:
        always: count even if the name contains a category. parts: count as the last word of a name.
        figures, places, shapes, outdoors, arms: count if the name contains no category.
    """

    always: tuple[str, ...]
    parts: tuple[str, ...]
    figures: tuple[str, ...]
    places: tuple[str, ...]
    shapes: tuple[str, ...]
    outdoors: tuple[str, ...]
    arms: tuple[str, ...]


class RoleRule(Record):
    """A role of plans and styles, such as `range`, and the requirements on assets of libraries that fill it.

    Attributes:
        categories: of suitable assets; empty: any.
        width, depth, height: least and greatest size of the asset without its handles, metres; None: any.
        level: allowed heights of its largest horizontal face, which is the cooktop of a range, metres; the asset is
            scaled to them as far as the sizes allow. None: it keeps its size if that fits.
        base: None: as in the asset. refused: why no asset of a library can fill this role; empty if one can.
    """

    id: Id
    categories: tuple[Id, ...] = ()
    width: Vec2 | None = None
    depth: Vec2 | None = None
    height: Vec2 | None = None
    level: Vec2 | None = None
    base: Base | None = None
    refused: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in ("width", "depth", "height", "level"):
            span = getattr(self, name)
            if span is not None and not 0 < span[0] <= span[1]:
                raise ValueError(f"{name} is [least, greatest] in metres, got {list(span)}")
        return self

    @property
    def sizes(self) -> dict[str, Vec2]:
        """Minimum and maximum width, depth and height, metres, of those that are bounded."""
        spans = {"width": self.width, "depth": self.depth, "height": self.height}
        return {name: span for name, span in spans.items() if span is not None}


__all__ = ["Finish", "HexColor", "Plain", "Surface"]

HexColor = Annotated[str, StringConstraints(pattern=r"^#[0-9a-f]{6}$")]


class Plain(Record):
    """A finish without a picture: metal, enamel, plastic, glass, rubber. A row of registry/materials.yaml.

    Attributes:
        color: sRGB, `#rrggbb`, as on a colour card. opacity: below 1 it is see-through.
        substance: id in registry/substances.yaml. glow: share of the colour that it emits (a lamp, a display).
    """

    id: Id
    color: HexColor
    metallic: Annotated[float, Field(ge=0, le=1)] = 0.0
    roughness: Annotated[float, Field(ge=0, le=1)] = 0.5
    opacity: Annotated[float, Field(gt=0, le=1)] = 1.0
    substance: Id
    glow: Annotated[float, Field(ge=0, le=1)] = 0.0


class Finish(Record):
    """A surface, resolved.

    Attributes:
        id: id of the plain finish, texture recipe or pack picture.
        material: with the id of the finish. Its `tile_m` is the real size of its picture; wood grain runs along the
            height (v) of the picture.
    """

    id: Id
    material: Material
    substance: Substance

    @property
    def tile_m(self) -> Vec2 | None:
        """Width and height in metres of one copy of the picture, or None without a picture."""
        return self.material.tile_m


class TextureRecipe(Record):
    """A procedural texture: a row of registry/textures/<surface>.yaml, or of registry/skins/.

    Attributes:
        surface: None for a skin of objects. tile_m: width and height of the picture in metres.
        substance: id in registry/substances.yaml. params: canonical JSON of the kind's own record.
    """

    id: Id
    surface: Surface | None = None
    kind: Id
    seed: int
    tile_m: tuple[Positive, Positive]
    substance: Id
    params: str = "{}"


# Words of a command, such as `ingest` or `scenes build`.
CommandName = Annotated[str, StringConstraints(pattern=r"^[a-z]+( [a-z-]+)?$")]
# Values of arguments and options of a command, by their names without `--`.
Values = Mapping[str, Any]


class Project(Record):
    """`casa.yaml` of a folder with a user's plans, styles, categories and so on, merged over those of the package.

    Attributes:
        libraries: folders of libraries, relative to the project, whose assets styles may name as `library:<id>`.
        runs: steps of `casa-assets make`, in this order: a command -> the values of its arguments and options.
    """

    name: Id
    about: str = ""
    libraries: tuple[str, ...] = ()
    runs: tuple[Annotated[Mapping[CommandName, Values | None], Field(min_length=1, max_length=1)], ...] = ()


# registry/confidence.yaml: calibration curves and thresholds for the confidences of `articulate`.


class Curve(Record):
    """Share of guesses that are right, as a piecewise linear function of the confidence that the code gives them.

    Below the first point it is a straight line from (0, 0), since few of the fitted cases have such a low confidence.

    Attributes:
        given: confidences of the code, ascending. right: share of right guesses at each, never decreasing.
    """

    given: tuple[Confidence, ...]
    right: tuple[Confidence, ...]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not self.given or len(self.given) != len(self.right):
            raise ValueError("given and right have to be of one length")
        if list(self.given) != sorted(set(self.given)) or list(self.right) != sorted(self.right):
            raise ValueError("given has to rise, and right must not fall")
        return self

    def at(self, confidence: float) -> float:
        """Return the share of right guesses at a confidence."""
        return round(float(np.interp(confidence, (0.0, *self.given), (0.0, *self.right))), 3)


class Weights(Record):
    """A logistic model: its log odds are `intercept` plus the weighted sum of the features."""

    intercept: float
    weights: dict[str, float]

    def at(self, features: Mapping[str, float]) -> float:
        """Return the probability for some features. Raises KeyError if one is missing."""
        log_odds = self.intercept + sum(weight * features[name] for name, weight in self.weights.items())
        return round(1.0 / (1.0 + math.exp(-min(max(log_odds, -30.0), 30.0))), 3)


class Bars(Record):
    """Least confidence for accepting a guess without review."""

    frame: Confidence  # of up and front
    plan: Confidence  # of all parts together
    front: Confidence  # of a door or drawer behind which an interior is built


class ConfidenceModel(Record):
    """Calibration from confidences of the code to shares of cases that are right.

    Attributes:
        frame, part: for the guesses of the axes, and of one part with its joint.
        kinds: for kinds of parts with enough examples; `part` is for all other kinds. plan: for all parts together.
        bars: below these confidences a person has to check the result.
    """

    frame: Curve
    part: Curve
    kinds: dict[str, Curve]
    plan: Weights
    bars: Bars

    def part_at(self, kind: str, confidence: float) -> float:
        """Return the share of right guesses for parts of a kind at a confidence."""
        return self.kinds.get(kind, self.part).at(confidence)


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
