"""Parameters of the members of a family, and all that drawing and building them needs: finishes, labels, densities."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, get_args

import numpy as np
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from casa_assets.errors import UnknownId
from casa_assets.model.asset.asset import Labels
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.rows import Finish, Surface


class IsFinish:
    """Marks a field of Params as the id of a finish."""


# The field of what is random in a shape, such as its bumps.
SEED = "seed"
# A field that names a finish: a row of registry/materials.yaml, a recipe of registry/textures/, or a picture of a pack.
FinishId = Annotated[Id, IsFinish()]


class Params(Record):
    """Parameters of one member of a family; `build` needs only them and the Supplies."""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """A field that is declared again, with other bounds or another default, keeps its description."""
        for base in cls.__mro__[1:]:
            for name, field in getattr(base, "model_fields", {}).items():
                cls.model_fields[name].description = cls.model_fields[name].description or field.description

    @property
    def finishes(self) -> tuple[str, ...]:
        """Ids of all finishes that it names, sorted."""
        found: list[str] = []
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if isinstance(value, Params):
                found += value.finishes
            elif value is not None and is_finish(field):
                found.append(value)
        return tuple(sorted(dict.fromkeys(found)))

    def rng(self) -> np.random.Generator:
        """A new generator of what is random in a shape, from its seed."""
        return np.random.Generator(np.random.PCG64(getattr(self, SEED)))

    @property
    def design(self) -> dict[str, Any]:
        """The parameters that define a member's design, as plain data: all except colours, seeds and lengths.

        Of a float, only whether it is non-zero counts, since 0 often means that there is no such part.
        """
        found: dict[str, Any] = {}
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if isinstance(value, Params):
                found[name] = value.design
            elif isinstance(value, float):
                found[name] = bool(value)
            elif name != SEED and not is_finish(field):
                found[name] = value
        plain: dict[str, Any] = to_jsonable_python(found)
        return plain


def is_finish(field: FieldInfo) -> bool:
    """True if a field of Params names a finish, or may."""
    marks = list(field.metadata)
    for option in get_args(field.annotation):
        marks += getattr(option, "__metadata__", ())
    return any(isinstance(mark, IsFinish) for mark in marks)


P = TypeVar("P", bound=Params)


@dataclass(frozen=True)
class AvailableFinishes:
    """What `sample` may choose from.

    Attributes:
        surfaces: ids of the recipes and pack pictures of each surface, sorted.
        plain: ids of all plain finishes, sorted.
        looks: type of a look -> draws one, by the rules of registry/look_rules.yaml.
    """

    surfaces: Mapping[Surface, tuple[str, ...]]
    plain: tuple[str, ...]
    looks: Mapping[type[Params], Callable[[np.random.Generator, AvailableFinishes], Params]]

    def draw(self, rng: np.random.Generator, surface: Surface) -> str:
        """Draw one finish for a surface. Raises UnknownId if the surface has no finishes."""
        names = self.surfaces.get(surface, ())
        if not names:
            raise UnknownId("finish", surface.value, self.plain)
        return names[int(rng.integers(len(names)))]

    def draw_look(self, rng: np.random.Generator, look: type[P]) -> P:
        """A look of cabinets or appliances."""
        drawn = self.looks[look](rng, self)
        assert isinstance(drawn, look)
        return drawn


@dataclass(frozen=True)
class Supplies:
    """Finishes, labels and densities that `build` is given besides the parameters.

    Attributes:
        finishes: id -> finish: all plain ones, and those that the Params name.
        labels: of the family's category.
        densities: name -> kg/m^3: rows of registry/densities.yaml, and substances.
    """

    finishes: Mapping[str, Finish]
    labels: Labels
    densities: Mapping[str, float]

    def finish(self, name: str) -> Finish:
        """The finish of that id. Raises UnknownId with the nearest names."""
        if name not in self.finishes:
            raise UnknownId("finish", name, self.finishes)
        return self.finishes[name]

    def density(self, name: str) -> float:
        """kg/m^3 of that name. Raises UnknownId with the nearest names."""
        if name not in self.densities:
            raise UnknownId("density", name, self.densities)
        return self.densities[name]

    def hollow_density(self, name: str, finish: str) -> float:
        """kg/m^3 of a part that is drawn solid and is not: the density of that name, at most that of its finish."""
        return min(self.density(name), self.finish(finish).substance.density)


def pick(rng: np.random.Generator, options: tuple[Any, ...] | list[Any]) -> Any:
    """One of the options."""
    return options[int(rng.integers(len(options)))]


def between(rng: np.random.Generator, low: float, high: float, step: float = 0.001) -> float:
    """Draw a number of low..high in whole steps, rounded so that its decimal text is exact."""
    count = int(np.floor((high - low) / step + 1e-9))
    return float(round(low + step * int(rng.integers(count + 1)), 9))
