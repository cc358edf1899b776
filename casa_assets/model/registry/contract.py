"""Contracts of runtimes: names, joints, sites and thresholds that a fixture has to have; registry/contracts.

Every `name` is a pattern (a regular expression that has to match the whole name); a plain name matches itself.
"""

from __future__ import annotations

import re
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, model_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.record import Id, Record, Vec2

# Lengths by which RoboCasa v1.0 decides what a fixture is for; checks and the export use the same.
# Heights between which it looks for shelves of a wall cabinet. Ref: robocasa v1.0, fixture_is_type.
SHELF_HEIGHTS_M = (1.0, 1.5)
# Smaller surfaces of a worktop are none to it: width and depth. Ref: robocasa v1.0, Counter.get_reset_regions.
MIN_SURFACE_M = (0.40, 0.25)
# Depth before a deep appliance that is enough for the plate that it puts there.
PLATE_DEPTH_M = 0.25


def _compiles(pattern: str) -> str:
    # `{loc}` is replaced by a value of `for_each`.
    try:
        re.compile(re.sub(r"\{[a-z]+\}", "x", pattern))
    except re.error as error:
        raise ValueError(f"{pattern!r} is no pattern: {error}") from None
    return pattern


Pattern = Annotated[str, Field(min_length=1), AfterValidator(_compiles)]
Count = Annotated[int, Field(ge=0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
SignedShare = Annotated[float, Field(ge=-1.0, le=1.0)]


class RobocasaRelease(StrEnum):
    """Release of the reference runtime (RoboCasa) that reads a name."""

    V0_2 = "v0_2"
    V1_0 = "v1_0"


class Axis(StrEnum):
    """Direction of a joint's axis in the asset frame with every joint at zero; without a sign either way."""

    X = "x"
    Y = "y"
    Z = "z"
    PLUS_X = "+x"
    PLUS_Y = "+y"
    PLUS_Z = "+z"
    MINUS_X = "-x"
    MINUS_Y = "-y"
    MINUS_Z = "-z"


class OpeningSide(StrEnum):
    """Position of a joint's range relative to zero, which is closed."""

    POSITIVE = "positive"  # 0..a
    NEGATIVE = "negative"  # -a..0
    EITHER = "either"  # one of both
    BOTH = "both"  # -a..b


class Named(Record):
    """A rule that may be written as its name alone."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, row: Any) -> Any:
        return {"name": row} if isinstance(row, str) else row


class NamePattern(Named):
    """Pattern of names of which `min_count` to `max_count` have to exist (None: any number)."""

    name: Pattern
    min_count: Count = 1
    max_count: Count | None = None

    @model_validator(mode="after")
    def _counts(self) -> Self:
        if self.max_count is not None and self.max_count < self.min_count:
            raise ValueError(f"at least {self.min_count} and at most {self.max_count} cannot both hold")
        return self

    def matches(self, name: str) -> bool:
        """True if the whole name fits."""
        return re.fullmatch(self.name, name) is not None


class LinkRule(NamePattern):
    """A link; `depth` is counted from `object` (0), as in the fixed paths of a runtime."""

    depth: Count | None = None


class JointRule(NamePattern):
    """A joint.

    Attributes:
        reach: (lower, upper) positions that the range has to contain, rad or m.
        travel: (least, greatest) width of the range, rad or m.
        depth, link: of the link that it moves, a depth of 1 is a child of `object`; pattern of its name.
    """

    kind: JointKind | None = None
    axis: Axis | None = None
    opens: OpeningSide | None = None
    reach: Vec2 | None = None
    travel: Vec2 | None = None
    depth: Count | None = None
    link: Pattern | None = None


class ShapeRule(NamePattern):
    """A collider (or a visual) of that name; `link` and `label` are given if they matter."""

    link: Pattern | None = None
    label: Id | None = None


class SiteRule(NamePattern):
    """A site; `depth` of its link, 0 is on `object` itself."""

    depth: Count | None = None
    kind: Id | None = None


class RegionRule(NamePattern):
    """A region; `inside`: within the region `main`; `link`: link that it has to move with, if any."""

    inside: bool = True
    link: Pattern | None = None


class PlaceRule(Record):
    """Regions in which a runtime places objects, by heights and sizes as the runtime reads them from the file.

    Attributes:
        stands_m: height above the floor of a kitchen of the lower end of `main`, or of its upper end if `let_in`.
        heights_m: allowed height of a region's lower side above the floor; None: any.
        min_height_m: lower regions are ignored. fixed: they have to be on the root link.
    """

    regions: Pattern
    min_count: Count = 1
    stands_m: float = 0.0
    let_in: bool = False
    heights_m: Vec2 | None = None
    min_height_m: Annotated[float, Field(ge=0.0)] = 0.0
    fixed: bool = False


class VariableRule(NamePattern):
    """A variable of the behaviour that has at least these values."""

    values: tuple[Id, ...] = ()


class Requirements(Record):
    """Links, joints, shapes, sites and regions that have to exist."""

    links: tuple[LinkRule, ...] = ()
    joints: tuple[JointRule, ...] = ()
    colliders: tuple[ShapeRule, ...] = ()
    visuals: tuple[ShapeRule, ...] = ()
    sites: tuple[SiteRule, ...] = ()
    regions: tuple[RegionRule, ...] = ()
    variables: tuple[VariableRule, ...] = ()

    def filled(self, key: str, value: str) -> Requirements:
        """Copy with `{key}` replaced by a value in every pattern."""
        return Requirements.model_validate(_fill(self.model_dump(mode="json"), "{" + key + "}", value))


def _fill(data: Any, placeholder: str, value: str) -> Any:
    if isinstance(data, str):
        return data.replace(placeholder, value)
    if isinstance(data, list):
        return [_fill(item, placeholder, value) for item in data]
    return {k: _fill(v, placeholder, value) for k, v in data.items()} if isinstance(data, dict) else data


class Alternatives(Record):
    """Sets of requirements of which at least one has to be met."""

    any_of: Annotated[tuple[Requirements, ...], Field(min_length=2)]


class ForEach(Record):
    """Requirements that are repeated for every value in use, at least `min_count`.

    Attributes:
        key: `loc`, written `{loc}` in patterns.
        used_by: a value is in use if one of these patterns matches the name of a joint, site, collider or region.
    """

    key: Id
    values: Annotated[tuple[Id, ...], Field(min_length=1)]
    used_by: Annotated[tuple[Pattern, ...], Field(min_length=1)]
    min_count: Count = 1
    needs: Requirements


class Threshold(Record):
    """Joint position at which a runtime changes its view of a fixture; exactly one of `at` and `share` is given.

    Attributes:
        joint: pattern. at: rad or m.
        share: share of the range, from the end that is nearer to zero (the lower one if both are equally near).
    """

    name: Id
    joint: Pattern
    at: float | None = None
    share: Share | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.at is None) == (self.share is None):
            raise ValueError(f"threshold {self.name!r} is given at a position or at a share of the range")
        return self

    def position(self, span: Vec2) -> float:
        """Position of the threshold on a joint of this range, rad or m."""
        if self.at is not None:
            return self.at
        assert self.share is not None, "one of them is given"
        low, high = span
        near, far = (high, low) if abs(high) < abs(low) else (low, high)
        return near + self.share * (far - near)


class KeyRule(Named):
    """A named pose.

    Attributes:
        joint_shares: joint pattern -> least position of every such joint, as a share of its way from zero.
        values: variable pattern -> pattern of the value that every such variable gets in this pose.
        min_count: 0 if the pose may be missing.
    """

    name: Id
    joint_shares: dict[Pattern, Share] = Field(default_factory=dict)
    values: dict[Pattern, Pattern] = Field(default_factory=dict)
    min_count: Annotated[int, Field(ge=0, le=1)] = 1


class Step(Record):
    """One move of a trial, and the conditions that have to hold after it.

    Attributes:
        move: joint pattern -> position as a share of the way from zero to the end that is farther from zero (the upper
            one if both are equally far); negative: towards the other end.
        press: pattern of the colliders that are touched in this step only. wait_s: time to wait after that.
        expect: variable pattern -> pattern of the value that every such variable then has.
    """

    move: dict[Pattern, SignedShare] = Field(default_factory=dict)
    press: Pattern | None = None
    wait_s: Annotated[float, Field(ge=0)] = 0.0
    expect: dict[Pattern, Pattern] = Field(default_factory=dict)


class Trial(Record):
    """Moves, one after the other, from the initial state."""

    name: Id
    steps: Annotated[tuple[Step, ...], Field(min_length=1)]


class Contract(Requirements):
    """Requirements of a runtime on one class of fixture.

    Attributes:
        id: such as `microwave`; the name of its file.
        read_by: release -> classes that read these names. for_each: of each burner, drawer, ... in use.
        forbidden_joints, forbidden_geoms: patterns of names that a runtime would mistake for something else.
        labels: each has to be the label of a visual or collider.
        outside: labels of parts that may stick out of the region `main`: handles, a faucet.
        beside: sites of model.xml that have to be in the body around `object`.
        falls_into: site -> pattern of regions; the site is above one of them.
        by_subclass: whether the classes of RoboCasa v1.0 build their geometry themselves and load no file: then a
            subclass that calls `Fixture.__init__` is needed, like those of `export robocasa --scenes`.
        main_margin_m: how far `main` may extend beyond the visuals, metres.
    """

    id: Id
    title: str
    read_by: dict[RobocasaRelease, tuple[str, ...]] = Field(default_factory=dict)
    one_of: tuple[Alternatives, ...] = ()
    for_each: tuple[ForEach, ...] = ()
    forbidden_joints: tuple[Pattern, ...] = ()
    forbidden_geoms: tuple[Pattern, ...] = ()
    labels: tuple[Id, ...] = ()
    outside: tuple[Id, ...] = ()
    places: tuple[PlaceRule, ...] = ()
    beside: tuple[Id, ...] = ()
    falls_into: dict[Id, Pattern] = Field(default_factory=dict)
    by_subclass: bool = False
    thresholds: tuple[Threshold, ...] = ()
    keyframes: tuple[KeyRule, ...] = ()
    trials: tuple[Trial, ...] = ()
    main_margin_m: Positive = 0.05
