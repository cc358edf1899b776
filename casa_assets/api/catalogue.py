"""List the floor plans, styles, families and textures to choose from, and the plug-ins in use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from casa_assets.model.kitchen.choices import Surface

# What is listed is imported where it is listed: to load all families takes a second.
if TYPE_CHECKING:
    from casa_assets.asset.family import Params
    from casa_assets.registry.plugins import Plugin


@dataclass(frozen=True)
class Bounds:
    """Minimum and maximum of a number, both allowed; None if there is no bound. SI units."""

    low: float | None
    high: float | None


@dataclass(frozen=True)
class PlanInfo:
    """A floor plan: name for `kitchen`, and title.

    Attributes:
        defaults: variable length -> its value in the plan, metres.
        bounds: variable length -> bounds within which a seed draws it.
    """

    name: str
    title: str
    defaults: Mapping[str, float]
    bounds: Mapping[str, Bounds]


@dataclass(frozen=True)
class StyleInfo:
    """A style of kitchens: name for `kitchen`, title, and what makes it recognisable in one line."""

    name: str
    title: str
    description: str


@dataclass(frozen=True)
class FamilyInfo:
    """A parametric family of assets: name for `build`, and title.

    Attributes:
        group: cabinets, counters, cooking, cold, small, decor or room.
        category: category id of the assets that it makes.
        presets: names of ready members. params: type of the parameters of `build`.
        bounds: number -> its bounds; numbers inside a part are named `part.number`.
    """

    name: str
    title: str
    group: str
    category: str
    presets: tuple[str, ...]
    params: type[Params]
    bounds: Mapping[str, Bounds]


def plans() -> Mapping[str, PlanInfo]:
    """All floor plans by name, sorted."""
    from casa_assets.registry.kitchens import plan_names

    return MappingProxyType({name: _plan(name) for name in plan_names()})


def styles() -> Mapping[str, StyleInfo]:
    """All styles by name, sorted."""
    from casa_assets.registry.kitchens import load_style, style_names

    found = (load_style(name)[0] for name in style_names())
    return MappingProxyType({s.id: StyleInfo(s.id, s.title, s.description) for s in found})


def families() -> Mapping[str, FamilyInfo]:
    """All parametric families by name, group by group."""
    from casa_assets.registry.families import family_groups

    found = {}
    for group, members in family_groups().items():
        for f in members:
            bounds = MappingProxyType(dict(_bounds(f.params)))
            found[f.name] = FamilyInfo(f.name, f.title, group, f.category, tuple(f.presets), f.params, bounds)
    return MappingProxyType(found)


def surfaces() -> Mapping[str, tuple[str, ...]]:
    """Ids of the textures that each surface of a kitchen (wall, floor, counter, cabinet) can be covered with."""
    from casa_assets.textures.run.recipes import available_finishes

    found = available_finishes().surfaces
    return MappingProxyType({surface.value: tuple(found[surface]) for surface in Surface})


def plugins() -> Mapping[str, Plugin]:
    """The plug-ins in use, by name: of installed packages, and of the project if its code may run. Raises CasaError."""
    from casa_assets.registry.plugins import load_plugins

    return MappingProxyType({one.plugin.name: one.plugin for one in load_plugins()})


def _plan(name: str) -> PlanInfo:
    from casa_assets.registry.kitchens import load_plan

    plan = load_plan(name)[0]
    lengths = sorted(plan.parameters.items())
    return PlanInfo(
        name,
        plan.title,
        MappingProxyType({key: p.default for key, p in lengths}),
        MappingProxyType({key: Bounds(p.low, p.high) for key, p in lengths}),
    )


def _bounds(params: type[Params], at: str = "") -> list[tuple[str, Bounds]]:
    """Name and bounds of every number of a type of Params, including those of nested Params."""
    from casa_assets.asset.family import Params

    found: list[tuple[str, Bounds]] = []
    for name, field in params.model_fields.items():
        kinds = [field.annotation, *getattr(field.annotation, "__args__", ())]
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, Params):
                found += _bounds(kind, f"{at}{name}.")
        if any(kind in (int, float) for kind in kinds):
            low, high = (_bound(field.metadata, marks) for marks in (("ge", "gt"), ("le", "lt")))
            found.append((f"{at}{name}", Bounds(low, high)))
    return found


def _bound(marks: list[Any], names: tuple[str, ...]) -> float | None:
    """Number of the first constraint in a field's metadata that has one of these names, as in pydantic's Field."""
    return next((float(getattr(mark, name)) for mark in marks for name in names if hasattr(mark, name)), None)
