"""Plans and styles into scenes: resolve, build what is wanted, compose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets import registry_kitchens
from casa_assets.errors import CasaError, Misfit, RegistryError
from casa_assets.families.catalog import FAMILIES, family
from casa_assets.families.family import Params
from casa_assets.layouts.compose import compose
from casa_assets.layouts.request import Kitchen, request
from casa_assets.layouts.wanted import Wanted
from casa_assets.model.asset import Asset
from casa_assets.model.scene import Scene
from casa_assets.model.style import Choice
from casa_assets.pipeline.families import build_asset
from casa_assets.registry import Document


@lru_cache(maxsize=1)
def offers() -> Mapping[str, Mapping[str, Mapping[str, Any]]]:
    """Numbers of all presets of all families."""
    return {
        name: {preset: params.model_dump(mode="json") for preset, params in made.presets.items()}
        for name, made in FAMILIES.items()
    }


@dataclass(frozen=True)
class Recipe:
    """What a scene is made from.

    Attributes:
        plan, style: names. given: lengths of parameters that differ from the plan's.
        closed: whether open walls are drawn too.
    """

    plan: str
    style: str
    given: tuple[tuple[str, float], ...] = ()
    closed: bool = False

    @property
    def scene_id(self) -> str:
        """`<plan>__<style>`."""
        return f"{self.plan}__{self.style}"


def resolve(recipe: Recipe) -> Kitchen:
    """The kitchen of a recipe. Raises RegistryError with file and line where the plan does not fit together."""
    plan, pages = registry_kitchens.load_plan(recipe.plan)
    style, _ = registry_kitchens.load_style(recipe.style)
    try:
        return request(plan, style, offers(), dict(recipe.given), recipe.closed)
    except Misfit as error:
        raise located(error, pages) from None


def located(error: Misfit, pages: Document) -> RegistryError:
    """A misfit as an error of the plan's file, with the line."""
    return pages.fault(error.pointer, error.expected, error.got)


def params_of(choice: Choice) -> Params:
    """The numbers of a choice. Raises CasaError where they do not go together."""
    found = family(choice.family)
    base = found.presets[choice.name].model_dump(mode="json")
    try:
        made: Params = found.params.model_validate(merged(base, choice.params))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise CasaError(f"{choice.preset}: {where}: {first['msg']}, got {str(first['input'])[:80]}") from None
    return made


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """A mapping with values replaced, inside its mappings too."""
    out = dict(base)
    for key, value in over.items():
        known = out.get(key)
        out[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return out


def build_wanted(wanted: Wanted, cache: Path) -> Asset:
    """The asset of a thing that a kitchen wants. Raises CasaError with the name of the thing."""
    try:
        return build_asset(family(wanted.choice.family), params_of(wanted.choice), cache)
    except (CasaError, ValueError) as error:
        raise CasaError(f"{wanted.name}: {error}") from error


def build_scene(recipe: Recipe, cache: Path) -> tuple[Kitchen, Scene]:
    """The scene of a recipe."""
    kitchen = resolve(recipe)
    made: dict[str, Asset] = {}
    assets: dict[str, Asset] = {}
    for wanted in kitchen.wanted:
        key = Choice.model_dump_json(wanted.choice)
        if key not in made:
            made[key] = build_wanted(wanted, cache)
        assets[wanted.name] = made[key]
    return kitchen, compose(kitchen, assets, recipe.scene_id)
