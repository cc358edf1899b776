"""Categories of kitchen objects: usual size, mass, pose and uses; the rows of registry/categories.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.record import Id, Record, Vec3
from casa_assets.model.registry.contract import RobocasaRelease

# How far `size_m` and `longest_m` may differ, of the length: rounding to a millimetre and no more.
SAME_SIZE = 0.02
# Id of the category of what has no other; not found by name, since many nodes are called so.
FALLBACK = "object"


class Certainty(StrEnum):
    """Confidence of the registry in a Q-code."""

    CERTAIN = "certain"
    LIKELY = "likely"
    PARENT = "parent"


class MatterFill(StrEnum):
    """Distribution of matter within an object's outline; decides volume, mass and whether cavities stay open."""

    SOLID = "solid"  # an apple, a cutting board: matter all through
    FILLED = "filled"  # a sealed can or carton: outline full, mixed density
    VESSEL = "vessel"  # a mug, bowl, pot: open cavity that must stay open in collision
    HOLLOW = "hollow"  # an appliance or basket: mostly air inside, mass from the prior


class RestingPose(StrEnum):
    """Usual pose of an object on a worktop."""

    STANDS = "stands"  # tallest or designed axis up: a bottle, a mug
    LIES = "lies"  # shortest axis up: a knife, a plate, a cutting board
    ANY = "any"  # no preferred pose: an orange


class FrontRule(StrEnum):
    """Rule for the yaw of an object, so that instances of a category face the same way."""

    ANY = "any"  # the same from all sides, or without a front
    FACE = "face"  # its printed or working face looks to -y
    HANDLE = "handle"  # its handle points to +x
    LENGTH = "length"  # its length lies along x


class Affordance(StrEnum):
    """Action that an object allows a robot or an appliance; a closed set."""

    GRASPABLE = "graspable"  # a hand of 0.08 m can take it as it rests
    WASHABLE = "washable"
    MICROWAVABLE = "microwavable"
    COOKABLE = "cookable"
    FREEZABLE = "freezable"
    FRIDGABLE = "fridgable"
    DISHWASHABLE = "dishwashable"
    CONTAINER = "container"  # something loose can be laid into it as it rests
    STACKABLE = "stackable"  # stands on another of its kind


class ObjectType(StrEnum):
    """Group of categories that tasks ask for; the closed set of the reference runtime (RoboCasa)."""

    ALCOHOL = "alcohol"
    BREAD_FOOD = "bread_food"
    CLEANER = "cleaner"
    CONDIMENT = "condiment"
    COOKED_FOOD = "cooked_food"
    DAIRY = "dairy"
    DECORATION = "decoration"
    DRINK = "drink"
    FRUIT = "fruit"
    ICED_ITEM = "iced_item"
    LID = "lid"
    MEAT = "meat"
    PACKAGED_FOOD = "packaged_food"
    PASTRY = "pastry"
    RECEPTACLE = "receptacle"
    SPICE = "spice"
    STACKABLE = "stackable"
    SWEETS = "sweets"
    TOOL = "tool"
    UTENSIL = "utensil"
    VEGETABLE = "vegetable"


class Portion(StrEnum):
    """Remaining part of an object that was cut; a closed set."""

    HALF = "half"  # one of two about equal parts, cut along or across
    WEDGE = "wedge"  # what lies between two cuts through the middle
    SLICE = "slice"  # what lies between two cuts side by side, or several of these on one another
    PIECE = "piece"  # any other part, such as a loaf of which the end is cut off


class NumberBasis(StrEnum):
    """Source of the numbers of a row."""

    USUAL = "usual"  # our estimate of common real ones
    TRADE = "trade"  # sizes and net weights that it is sold in
    PORTION = "portion"  # typical value near the portion weights of food composition tables
    REFERENCE = "reference"  # as the reference runtime has it


class CategoryBases(Record):
    """Source of the sizes, of the mass, and of `types` and `affords` of a category."""

    size: NumberBasis = NumberBasis.USUAL
    mass: NumberBasis = NumberBasis.USUAL
    uses: NumberBasis = NumberBasis.USUAL


class QCode(Record):
    """A Wikidata item.

    Attributes:
        id: such as `Q89`.
        label: English label of the item.
        certainty: certain or likely for the category's own item, parent if the class above is used instead.
    """

    id: Annotated[str, StringConstraints(pattern=r"^Q[1-9][0-9]*$")]
    label: str
    certainty: Certainty


class SizeRange(Record):
    """A range with a typical value, `low <= typical <= high`, all > 0."""

    low: Annotated[float, Field(gt=0)]
    typical: Annotated[float, Field(gt=0)]
    high: Annotated[float, Field(gt=0)]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.typical <= self.high:
            raise ValueError(f"{self.low} <= {self.typical} <= {self.high} does not hold")
        return self

    def beyond(self, value: float) -> float:
        """Ratio between a value > 0 and the nearer end of the range; below 1 inside the range."""
        return max(self.low / value, value / self.high)

    def scaled(self, factor: float) -> SizeRange:
        """Copy with all three values multiplied by a factor > 0."""
        return SizeRange(low=self.low * factor, typical=self.typical * factor, high=self.high * factor)


class PortionRange(Record):
    """Size and mass of a portion of an object, if they differ from those of a whole one.

    Attributes:
        longest_m: longest side of its bounding box, metres.
        mass_kg: kg.
    """

    longest_m: SizeRange
    mass_kg: SizeRange


class Category(Record):
    """A kind of kitchen object.

    Attributes:
        id: such as `mug`.
        parent: class above, such as `tableware`.
        qcode: Wikidata item used as a semantic label.
        longest_m: longest side of the bounding box of a real one, metres.
        mass_kg: mass of a real one, kg.
        shape: typical extents (x, y, z) as it rests, relative to the longest; z is up.
        size_m: extents along x, y and z as it rests, metres; None if they are `longest_m` times `shape`.
        upright, front: its canonical pose: how it rests, and which way it faces.
        build: how matter fills it.
        substance: id of its main substance.
        aliases: other names that sources use.
        fixed: built in or too heavy to move (an oven): its base is welded to the world.
        types: groups by which tasks may ask for it instead of its name.
        affords: its affordances.
        runtime: releases of the reference runtime that have an object category of this name.
        lvis: its names in LVIS, and so in Objaverse's annotations.
        prompts: noun phrases for a vision-language model; if empty, see `phrases`.
        basis: sources of its numbers.
        portions: size and mass of its portions; for portions that are not listed, those of a whole one apply.
    """

    id: Id
    parent: Id
    qcode: QCode
    longest_m: SizeRange
    mass_kg: SizeRange
    shape: Vec3
    size_m: tuple[SizeRange, SizeRange, SizeRange] | None = None
    upright: RestingPose
    front: FrontRule = FrontRule.ANY
    build: MatterFill
    substance: Id
    aliases: tuple[str, ...] = ()
    fixed: bool = False
    types: tuple[ObjectType, ...] = ()
    affords: tuple[Affordance, ...] = ()
    runtime: tuple[RobocasaRelease, ...] = ()
    lvis: tuple[str, ...] = ()
    prompts: tuple[str, ...] = ()
    basis: CategoryBases = CategoryBases()
    portions: Mapping[Portion, PortionRange] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        for name in ("types", "affords", "runtime", "lvis", "prompts"):
            row = getattr(self, name)
            if len(set(row)) != len(row):
                raise ValueError(f"{name} says something twice")
        if self.size_m is not None:
            longest = max(side.typical for side in self.size_m)
            if abs(longest - self.longest_m.typical) > SAME_SIZE * longest:
                raise ValueError(f"size_m is {longest:g} m at most and longest_m {self.longest_m.typical:g} m")
        return self

    @property
    def extents(self) -> tuple[SizeRange, SizeRange, SizeRange]:
        """Size along x, y and z as it rests, metres."""
        if self.size_m is not None:
            return self.size_m
        x, y, z = (self.longest_m.scaled(share) for share in self.shape)
        return x, y, z

    @property
    def phrases(self) -> tuple[str, ...]:
        """Noun phrases for it, such as `a coffee mug`."""
        name = self.id.replace("_", " ")
        return self.prompts or (f"{'an' if name[0] in 'aeiou' else 'a'} {name}",)

    def called(self, portion: Portion | None) -> str:
        """Text for messages: `a bell_pepper`, or `a half of a bell_pepper` for a portion."""
        return f"a {self.id}" if portion is None else f"a {portion} of a {self.id}"

    def usual(self, portion: Portion | None) -> PortionRange:
        """Size and mass of a portion, or of a whole one if None."""
        whole = PortionRange(longest_m=self.longest_m, mass_kg=self.mass_kg)
        return whole if portion is None else self.portions.get(portion, whole)

    def can(self, use: Affordance) -> bool:
        """True if `use` is among the affordances."""
        return use in self.affords


# How a picture of an asset of ours looks, so that a phrase about the thing becomes one about the picture.
# Ref: Radford et al. 2021, prompts of CLIP; the wording for renders is ours.
PICTURE_PROMPTS = ("a photo of {}.", "a 3D render of {} on a plain background.", "{}, isolated.")


def clip_prompts(category: Category) -> tuple[str, ...]:
    """Every phrase of a category in every prompt template, for a vision-language model (CLIP)."""
    return tuple(picture.format(phrase) for phrase in category.phrases for picture in PICTURE_PROMPTS)
