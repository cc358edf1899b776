"""What we know of a kind of object before we have seen the mesh: the rows of registry/categories.yaml."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, StringConstraints, model_validator

from casa_assets.model.record import Id, Record, Vec3


class Certainty(StrEnum):
    """How sure the registry is of a Q-code."""

    CERTAIN = "certain"
    LIKELY = "likely"
    PARENT = "parent"


class Build(StrEnum):
    """How matter fills the outline of an object; decides volume, mass and whether cavities stay open."""

    SOLID = "solid"  # an apple, a cutting board: matter all through
    FILLED = "filled"  # a sealed can or carton: outline full, mixed density
    VESSEL = "vessel"  # a mug, bowl, pot: open cavity that must stay open in collision
    HOLLOW = "hollow"  # an appliance or basket: mostly air inside, mass from the prior


class Upright(StrEnum):
    """How an object rests on a worktop."""

    STANDS = "stands"  # tallest or designed axis up: a bottle, a mug
    LIES = "lies"  # shortest axis up: a knife, a plate, a cutting board
    ANY = "any"  # no preferred pose: an orange


class QCode(Record):
    """A Wikidata item.

    Attributes:
        id: such as `Q89`.
        label: English label of the item.
        certainty: certain or likely for the category's own item, parent where the class above is used instead.
    """

    id: Annotated[str, StringConstraints(pattern=r"^Q[1-9][0-9]*$")]
    label: str
    certainty: Certainty


class Span(Record):
    """A range with a typical value, `low <= typical <= high`, all > 0."""

    low: Annotated[float, Field(gt=0)]
    typical: Annotated[float, Field(gt=0)]
    high: Annotated[float, Field(gt=0)]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.typical <= self.high:
            raise ValueError(f"{self.low} <= {self.typical} <= {self.high} does not hold")
        return self


class Category(Record):
    """A kind of kitchen object.

    Attributes:
        id: such as `mug`.
        parent: class above, such as `tableware`.
        qcode: Wikidata item used as a semantic label.
        longest_m: longest side of the bounding box of a real one, metres.
        mass_kg: mass of a real one, kg.
        shape: typical extents (x, y, z) as it rests, relative to the longest; z is up.
        upright: how it rests.
        build: how matter fills it.
        substance: id of its main substance.
        aliases: other names that sources use.
        fixed: built in or too heavy to move (an oven): its base is welded to the world.
    """

    id: Id
    parent: Id
    qcode: QCode
    longest_m: Span
    mass_kg: Span
    shape: Vec3
    upright: Upright
    build: Build
    substance: Id
    aliases: tuple[str, ...] = ()
    fixed: bool = False
