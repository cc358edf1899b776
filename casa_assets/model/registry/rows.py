"""Small rows of registry/: limits, rejections, roles, finishes, recipes of textures, projects, curves of confidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.material import Material, Positive, Substance
from casa_assets.model.asset.provenance import Confidence
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
        always: count even if the name contains a category.
        parts: count as the last word of a name.
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
        base: None: as in the asset.
        refused: why no asset of a library can fill this role; empty if one can.
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
        substance: id in registry/substances.yaml.
        params: canonical JSON of the kind's own record.
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
        given: confidences of the code, ascending.
        right: share of right guesses at each, never decreasing.
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
