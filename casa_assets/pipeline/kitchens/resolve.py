"""Turn a plan and a style into a scene: resolve, build the assets, compose."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.core.sampling import rng_for
from casa_assets.errors import CasaError, PlanConflict, RegistryError, StyleConflict, UnknownId
from casa_assets.families.family import Params
from casa_assets.layouts.compose.compose import compose
from casa_assets.layouts.compose.scatter_props import scatter_props
from casa_assets.layouts.order.request import KitchenRequest, request_kitchen
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.kitchen.style import LIBRARY, PresetChoice, Style
from casa_assets.model.kitchen.surface import Surface
from casa_assets.model.registry.document import Document
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.families.finishes import available_finishes
from casa_assets.pipeline.families.run import asset_key
from casa_assets.pipeline.kitchens.kept import remember_kitchen_key, remembered_kitchen_key
from casa_assets.pipeline.kitchens.library_assets import LibraryPresets, placed_asset, placed_key
from casa_assets.pipeline.kitchens.lived_in import objects_key, put_into
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.sampling.harmony import goes_together, is_wooden
from casa_assets.pipeline.kitchens.sampling.mix import mixed_style, models_of_roles
from casa_assets.pipeline.textures.ahead import painting_ahead
from casa_assets.pipeline.textures.recipes import missing_paintings
from casa_assets.projects import read_once
from casa_assets.registry import kitchens
from casa_assets.registry.families import families, family
from casa_assets.registry.roles import load_roles

# Draws of a plan's lengths are made anew where one does not fit together; so often, then the seed is given up.
MAX_LENGTH_DRAWS = 20
MAX_FINISH_DRAWS = 50  # of finishes, after which those that were drawn last are taken
LENGTHS_PER_MIX = 5  # of these draws, before a mixed kitchen is mixed anew
# Field of an appliance's numbers, and what its form is called there, where a cabinet front hangs on it.
LOOK, PANEL = "look", "panel"
WARM = f"{__name__}:warm"  # for pools of workers that build scenes


def warm() -> None:
    """Load what every worker that builds scenes needs, once for all of them."""
    registry.load()


@read_once
def preset_params() -> Mapping[str, Mapping[str, Mapping[str, Any]]]:
    """Numbers of all presets of all families."""
    return {
        LIBRARY: LibraryPresets(),
        **{
            name: {preset: params.model_dump(mode="json") for preset, params in made.presets.items()}
            for name, made in families().items()
        },
    }


def ordered_surfaces(surfaces: Iterable[tuple[Surface, str]]) -> tuple[tuple[Surface, str], ...]:
    """Finishes of surfaces in their order. Raises UnknownId where a surface has no such finish."""
    finishes = available_finishes().surfaces
    picked = dict(surfaces)
    for surface, name in picked.items():
        if name not in finishes[surface]:
            raise UnknownId(
                f"{surface.value} texture",
                name,
                finishes[surface],
                f"`casa-assets textures list --set {surface.value}` lists them",
            )
    return tuple((s, picked[s]) for s in Surface if s in picked)


def ordered_models(models: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Models of roles, sorted by role, each a text such as `range/pro_six` or `library:<id>`.

    Raises:
        UnknownId: no style has such a role. CasaError: a text names no model.
    """
    roles, picked = models_of_roles(), dict(models)
    for role, name in picked.items():
        if role not in roles:
            raise UnknownId("role of models", role, roles)
        _choice(role, name)
    return tuple(sorted(picked.items()))


def _choice(role: str, name: str) -> PresetChoice:
    try:
        if isinstance(name, str):
            return PresetChoice.model_validate(name)
    except ValidationError:
        pass
    raise CasaError(f"model of {role}: write FAMILY/PRESET or library:ID, got {name!r}")


def draw_surfaces(seed: int) -> tuple[tuple[Surface, str], ...]:
    """A finish for each surface, each drawn by itself; four that do not go together are drawn anew."""
    have = available_finishes()
    generators = {s: rng_for(seed, f"scene/surface/{s.value}") for s in Surface}
    drawn: tuple[tuple[Surface, str], ...] = ()
    for _ in range(MAX_FINISH_DRAWS):
        drawn = tuple((s, have.draw(rng, s)) for s, rng in generators.items())
        if goes_together(name for _, name in drawn):
            break
    return drawn


def draw_lengths(plan: Plan, seed: int, turn: int = 0) -> dict[str, float]:
    """Lengths of a plan's parameters, each within its bounds, in whole centimetres."""
    lengths = {}
    for name, p in plan.parameters.items():
        share = float(rng_for(seed, f"scene/plan/{name}/{turn}").random())
        lengths[name] = round(p.low + share * (p.high - p.low), 2)
    return lengths


def resolve(recipe: SceneRecipe) -> KitchenRequest:
    """The kitchen of a recipe.

    Raises:
        RegistryError: with file and line, where the plan does not fit together, or a model does not suit its role.
        UnknownId: no such plan, style or model. CasaError: a model that the recipe names suits nothing.
    """
    plan, document = kitchens.load_plan(recipe.plan)
    style, style_document = kitchens.load_style(recipe.style)
    turns = 1 if recipe.seed is None else MAX_LENGTH_DRAWS
    failed: PlanConflict | None = None
    chosen = {role: _choice(role, name) for role, name in recipe.models}
    for turn in range(turns):
        given = None if recipe.seed is None else draw_lengths(plan, recipe.seed, turn)
        mixed = mixed_style(style, recipe.seed or 0, turn // LENGTHS_PER_MIX) if recipe.mixed else style
        equipped = mixed.replace(models={**mixed.models, **chosen}) if chosen else mixed
        finished = with_finishes(equipped, dict(recipe.surfaces), recipe.mixed)
        try:
            kitchen = request_kitchen(plan, finished, preset_params(), given, recipe.closed, load_roles())
            _check_taken(recipe.plan, chosen, kitchen)
            return kitchen
        except PlanConflict as error:
            failed = error
        except StyleConflict as error:
            if error.pointer[-1] in chosen:
                raise CasaError(f"model of {error.pointer[-1]}: expected {error.expected}, got {error.got}") from error
            raise style_document.fault(error.pointer, error.expected, error.got) from error
    assert failed is not None
    raise error_with_line(failed, document)


def _check_taken(plan: str, chosen: Mapping[str, PresetChoice], kitchen: KitchenRequest) -> None:
    """Raise CasaError where nothing in a kitchen is of a model that was chosen for it."""
    there = {item.choice.preset for item in kitchen.items}
    for role, choice in chosen.items():
        if choice.preset not in there:
            message = f"plan {plan} has nothing of this role, or names another model for it itself"
            raise CasaError(f"model of {role}: {choice.preset} would stand nowhere: {message}")


def with_finishes(style: Style, surfaces: Mapping[Surface, str], mixed: bool = False) -> Style:
    """A style with other finishes of its surfaces, and of what has to match them.

    Appliances behind cabinet fronts get the fronts of the cabinets; beside cabinets of wood, open shelves are of that
    wood.

    Args:
        mixed: the fronts are not those that the style was made with, so that appliances get them in any case.
    """
    style = style.with_surfaces(surfaces)
    if not mixed and Surface.CABINET not in surfaces:
        return style
    wood = surfaces.get(Surface.CABINET)
    if wood is not None and is_wooden(wood):
        style = style.replace(cabinets=style.cabinets.replace(shelf=wood))
    base = style.cabinets.base
    look = {"front": base.front, "face": base.face, "metal": base.metal}
    models = {
        role: choice.replace(params=merge_nested(choice.params, {LOOK: look})) if _is_behind_panels(choice) else choice
        for role, choice in style.models.items()
    }
    return style.replace(models=models)


def _is_behind_panels(choice: PresetChoice) -> bool:
    """True if a model is an appliance that a cabinet front is hung on."""
    if choice.is_library:
        return False
    params = preset_params().get(choice.family, {}).get(choice.name, {})
    look = merge_nested(params, choice.params).get(LOOK)
    return isinstance(look, Mapping) and look.get("form") == PANEL


def error_with_line(error: PlanConflict, document: Document) -> RegistryError:
    """A misfit as an error of the plan's file, with the line."""
    return document.fault(error.pointer, error.expected, error.got)


def params_of(choice: PresetChoice) -> Params:
    """The numbers of a choice. Raises CasaError where they do not go together."""
    found = family(choice.family)
    if choice.name not in found.presets:
        raise UnknownId(f"preset of {choice.family}", choice.name, found.presets)
    base = preset_params()[choice.family][choice.name]
    try:
        made: Params = found.params.model_validate(merge_nested(base, choice.params))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise CasaError(f"{choice.preset}: {where}: {first['msg']}, got {str(first['input'])[:80]}") from None
    return made


def merge_nested(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """A mapping with values replaced, inside its mappings too."""
    merged = dict(base)
    for key, value in over.items():
        current = merged.get(key)
        merged[key] = (
            merge_nested(current, value) if isinstance(current, Mapping) and isinstance(value, Mapping) else value
        )
    return merged


def build_choice(name: str, choice: PresetChoice, store: AssetStore) -> Asset:
    """The asset of a choice. Raises CasaError with the name of the thing that it is for; other errors are faults."""
    try:
        if choice.is_library:
            return placed_asset(choice)
        return store.built(family(choice.family), params_of(choice))
    except CasaError as error:
        raise CasaError(f"{name}: {error}") from error


def build_scene(recipe: SceneRecipe, cache: Path) -> tuple[KitchenRequest, Scene]:
    """The kitchen and the scene of a recipe. Raises as `resolve` does, and CasaError where a part cannot be built.

    Args:
        cache: folder of the store that keeps painted pictures and built assets.
    """
    kitchen = resolve(recipe)
    store = AssetStore(cache)
    made: dict[str, Asset] = {}

    def built(name: str, choice: PresetChoice) -> Asset:
        key = choice.model_dump_json()
        if key not in made:
            made[key] = build_choice(name, choice, store)
        return made[key]

    choices = [*(wanted.choice for wanted in kitchen.items), *kitchen.style.props]
    with painting_ahead(lambda: missing_paintings(_finishes_of(choices), cache)):
        assets = {w.name: built(w.name, w.choice) for w in kitchen.items}
        props = [(choice, built(choice.preset, choice)) for choice in kitchen.style.props]
    composed = compose_kitchen(kitchen, assets, props, recipe.seed or 0, recipe.scene_id)
    if recipe.objects:
        composed = composed[0], put_into(composed[1], recipe.objects, recipe.objects_seed, store)
    store.tidy()
    return composed


def _finishes_of(choices: Iterable[PresetChoice]) -> Iterator[str]:
    """Ids of the finishes that choices ask for, each once."""
    asked: dict[str, None] = {}
    for choice in choices:
        if not choice.is_library:
            with suppress(CasaError):  # raised again where it is built, with the name of what it is for
                asked |= dict.fromkeys(params_of(choice).finishes)
    yield from asked


def compose_kitchen(
    kitchen: KitchenRequest, assets: dict[str, Asset], props: list[tuple[PresetChoice, Asset]], seed: int, scene_id: str
) -> tuple[KitchenRequest, Scene]:
    """The scene of a kitchen, once everything in it is built, and the kitchen with the props that found a place.

    Args:
        assets: by name of what is wanted. props: what may be put on worktops and shelves. seed: draws their places.
    """
    added = scatter_props(kitchen, assets, props, seed)
    kitchen = replace(kitchen, items=(*kitchen.items, *(wanted for wanted, _ in added)))
    every = assets | {wanted.name: asset for wanted, asset in added}
    return kitchen, compose(kitchen, every, scene_id)


def kitchen_key(recipe: SceneRecipe) -> str:
    """Key of `build_scene`: what the plan and the style ask for, the assets of it, and what puts them together.

    Raises as `resolve` and `build_choice` do.
    """
    if known := remembered_kitchen_key(recipe):
        return known
    kitchen = resolve(recipe)
    choices = {c.model_dump_json(): c for c in (*(w.choice for w in kitchen.items), *kitchen.style.props)}
    assets = [
        (name, placed_key(c) if c.is_library else asset_key(family(c.family), params_of(c)))
        for name, c in sorted(choices.items())
    ]
    # Its text is the same in every process: it holds numbers, text and records, in tuples and in dicts that are filled
    # in one order.
    key = digest_of("kitchen", repr(kitchen), assets, recipe.seed, recipe.scene_id, key_of(compose_kitchen))
    if recipe.objects:
        key = digest_of(key, objects_key(recipe.objects, recipe.objects_seed))
    if not any(choice.is_library for choice in choices.values()):  # what a library holds may change at any time
        remember_kitchen_key(recipe, key)
    return key
