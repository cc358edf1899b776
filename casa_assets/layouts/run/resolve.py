"""Turn a plan and a style into a scene: resolve, build the assets, compose, put objects in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.asset.family import Params
from casa_assets.asset.lightweight import light_scene
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.checks.scene.rest import Rest, come_to_rest
from casa_assets.core.numeric import rng_for
from casa_assets.errors import CasaError, PlanConflict, StyleConflict, UnknownId
from casa_assets.families.asset_store import AssetStore
from casa_assets.families.build import FamilyRequest, asset_key, family_of
from casa_assets.families.build import params_of as member_params_of
from casa_assets.formats.mjcf.kitchen import write
from casa_assets.layouts.compose import compose, scatter_props
from casa_assets.layouts.lived_in import MEMBERS, PutGroup, put_objects, rounded_pose
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.run.kept import remember_kitchen_key, remembered_kitchen_key
from casa_assets.layouts.run.library_assets import LibraryPresets, placed_asset, placed_key
from casa_assets.layouts.run.mix import goes_together, is_wooden, mixed_style, models_of_roles
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.spaces import find_spaces
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.model.kitchen.style import LIBRARY, PresetChoice, Style
from casa_assets.model.registry.rows import Arrangement
from casa_assets.projects import read_once
from casa_assets.registry import kitchens
from casa_assets.registry.families import families, family
from casa_assets.registry.habits import load_habits
from casa_assets.registry.tables import load_roles
from casa_assets.textures.run.recipes import available_finishes, missing_paintings, painting_ahead

FULL, LIGHT = "full", "light"  # forms of a scene
# Members are drawn with the seed that `casa-assets objects build` draws with by default.
MEMBER_SEED = 0
# Times that new groups are put in for those that did not stay.
MAX_ROUNDS = 4
# In the first run things sink and slide to where they rest: a group of which one goes farther or tips is taken out.
# Fruit and tools may roll a little, what stands in a row or a stack may not lean.
SETTLE_S, MAX_SLIDE_M = 1.0, 0.02
# A plate on its edge rolls on to the next flat of its collision shapes.
MAX_EDGE_ROLL_M = 0.06
MAX_TILT, MAX_ROLL = 0.15, 0.7
ROLLING = (Arrangement.HEAP, Arrangement.LOOSE, Arrangement.LENGTHWISE)
# In the second run, from there, nothing moves or stands in anything any more. In the light form, the shapes of which
# are smaller, what is stacked sinks a little more.
STILL_S, MAX_DEPTH_M = 5.0, 0.0004
MAX_DRIFT_M = {FULL: 0.0025, LIGHT: 0.004}
MAX_STILL_RUNS = 4
# Draws of a plan's lengths are made again where one does not fit together, up to this number of times.
MAX_LENGTH_DRAWS = 20
MAX_FINISH_DRAWS = 50  # of finishes, after which those that were drawn last are taken
LENGTHS_PER_MIX = 5  # of these draws, before a mixed kitchen is mixed again
# Field of an appliance's numbers, and what its form is called there, where a cabinet front hangs on it.
LOOK, PANEL = "look", "panel"


def put_into(scene: Scene, count: int, seed: int, store: AssetStore) -> Scene:
    """Return the scene with up to `count` more objects, fewer if there is not enough room; all at rest."""
    habits, objects = load_habits(), ObjectMembers(store)
    rng = rng_for(seed, f"scene/objects/{scene.id}")
    spaces = find_spaces(scene, habits.spaces)
    groups: tuple[PutGroup, ...] = ()
    for _ in range(MAX_ROUNDS):
        more = put_objects(spaces, habits, objects.member, count - _number(groups), rng, groups)
        if not more:
            break
        # Groups are apart, so that those which rest already are not simulated again.
        groups = (*groups, *at_rest(scene, more, objects))
    return with_groups(scene, groups, objects)


class ObjectMembers:
    """The members of the categories of registry/objects/, each built once."""

    def __init__(self, store: AssetStore) -> None:
        self.store = store
        self._made: dict[tuple[str, int], Asset] = {}

    def member(self, category: str, number: int) -> Asset:
        """Draw `number` of a category."""
        key = (category, number)
        if key not in self._made:
            request = _request(category, number)
            self._made[key] = self.store.built(family_of(request), member_params_of(request))
        return self._made[key]

    @property
    def assets(self) -> dict[str, Asset]:
        """Those that were asked for, by id."""
        return {asset.id: asset for asset in self._made.values()}


def _request(category: str, number: int) -> FamilyRequest:
    return FamilyRequest(category, seed=MEMBER_SEED, index=number, is_object=True)


def objects_key(count: int, seed: int) -> str:
    """Key of what `put_into` adds: the habits, the members that it may draw, and its code."""
    return digest_of("objects", count, seed, load_habits().digest, _members_key(), key_of(put_into))


@read_once
def _members_key() -> str:
    requests = [_request(category, number) for category in load_habits().categories for number in range(MEMBERS)]
    return digest_of("members", [asset_key(family_of(r), member_params_of(r)) for r in requests])


def _number(groups: Iterable[PutGroup]) -> int:
    return sum(len(group.placements) for group in groups)


def with_groups(scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers) -> Scene:
    """The scene with the objects of groups."""
    placements = [place for group in groups for place in group.placements]
    added = [objects.assets[name] for name in sorted({place.asset for place in placements})]
    return ready_to_simulate(scene.replace(assets=(*scene.assets, *added), placements=(*scene.placements, *placements)))


def at_rest(scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers) -> tuple[PutGroup, ...]:
    """The groups that stay where they are put, each object where it came to rest, in the full and in the light form.

    `scene`: without them.
    """
    rests = _simulate(scene, groups, objects, FULL, SETTLE_S)
    assets = objects.assets

    def rested(place: Placement) -> Placement:
        return place.replace(pose=rounded_pose(rests[place.name].pose @ assets[place.asset].root.pose.inverse()))

    kept = [
        replace(group, placements=tuple(map(rested, group.placements)))
        for group in _kept(groups, partial(_has_settled, rests))
    ]
    for _ in range(MAX_STILL_RUNS):
        runs = {form: _simulate(scene, kept, objects, form, STILL_S) for form in (FULL, LIGHT)}
        still = _kept(kept, partial(_is_still, runs))
        if _number(still) == _number(kept):
            return tuple(kept)
        kept = still
    return ()


def _kept(groups: Iterable[PutGroup], stays: Callable[[PutGroup, int], bool]) -> list[PutGroup]:
    """The groups without the objects that do not stay, nor what lies on them; without those that are too small then."""
    habits, kept = load_habits().habits, []
    for group in groups:
        habit, places = habits[group.habit], group.placements
        good = [stays(group, number) for number in range(len(places))]
        if habit.arrangement is Arrangement.STACK and not all(good):
            good = [number < good.index(False) for number in range(len(places))]
        if habit.vessel and not good[0]:
            continue
        if sum(good) >= habit.fewest:
            kept.append(replace(group, placements=tuple(p for p, is_good in zip(places, good, strict=True) if is_good)))
    return kept


def _simulate(
    scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers, form: str, seconds: float
) -> dict[str, Rest]:
    names = [place.name for group in groups for place in group.placements]
    if not names:
        return {}
    # What does not hold the groups touches none of them, and would cost time.
    held_by = {place.resting.placement for group in groups for place in group.placements if place.resting}
    placements = tuple(place for place in scene.placements if place.name in held_by)
    ids = {place.asset for place in placements}
    assets = tuple(asset for asset in scene.assets if asset.id in ids)
    holders = scene.replace(placements=placements, assets=assets, exclusions=())
    filled = with_groups(holders, groups, objects)
    shown = light_scene(filled, objects.store.lightened) if form == LIGHT else bare(filled)
    return come_to_rest(write(shown, shared="assets"), names, seconds)


def bare(scene: Scene) -> Scene:
    """The scene without what is only seen, so that it is written and compiled in a fraction of the time."""
    assets = tuple(
        asset.replace(links=tuple(link.replace(visuals=()) for link in asset.links), materials=(), behavior=None)
        for asset in scene.assets
    )
    return scene.replace(assets=assets, cameras=(), lights=(), sky=None)


def _has_settled(rests: dict[str, Rest], group: PutGroup, number: int) -> bool:
    arrangement = load_habits().habits[group.habit].arrangement
    stands = arrangement not in ROLLING or (arrangement is Arrangement.HEAP and number == 0)
    farthest = MAX_EDGE_ROLL_M if arrangement is Arrangement.ON_EDGE and number else MAX_SLIDE_M
    rest = rests[group.placements[number].name]
    return rest.moved <= farthest and rest.tilt <= (MAX_TILT if stands else MAX_ROLL)


def _is_still(runs: dict[str, dict[str, Rest]], group: PutGroup, number: int) -> bool:
    found = {form: rests[group.placements[number].name] for form, rests in runs.items()}
    return all(rest.moved <= MAX_DRIFT_M[form] and rest.depth <= MAX_DEPTH_M for form, rest in found.items())


def warm() -> None:
    """Load what every worker that builds scenes needs, once for all of them."""
    registry.load()


@read_once
def preset_params() -> Mapping[str, Mapping[str, Mapping[str, Any]]]:
    """Numbers of all presets of all families, and of the assets of libraries."""
    of_families = {
        name: {preset: params.model_dump(mode="json") for preset, params in made.presets.items()}
        for name, made in families().items()
    }
    return {LIBRARY: LibraryPresets(), **of_families}


def ordered_surfaces(surfaces: Iterable[tuple[Surface, str]]) -> tuple[tuple[Surface, str], ...]:
    """Finishes of surfaces in their order. Raises UnknownId where a surface has no such finish."""
    finishes = available_finishes().surfaces
    picked = dict(surfaces)
    for surface, name in picked.items():
        if name not in finishes[surface]:
            listed_by = f"`casa-assets textures list --set {surface.value}` lists them"
            raise UnknownId(f"{surface.value} texture", name, finishes[surface], listed_by)
    return tuple((s, picked[s]) for s in Surface if s in picked)


def ordered_models(models: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Models of roles, sorted by role, each a text such as `range/pro_six` or `library:<id>`.

    Raises UnknownId: no style has such a role. CasaError: a text names no model.
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
    """Draw a finish for each surface independently; all four are drawn again if they do not go together."""
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

    Raises RegistryError: with file and line, where the plan does not fit together, or a model does not suit its role.
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
            there = {item.choice.preset for item in kitchen.items}
            for role, choice in chosen.items():
                if choice.preset not in there:
                    message = f"plan {recipe.plan} has nothing of this role, or names another model for it itself"
                    raise CasaError(f"model of {role}: {choice.preset} would stand nowhere: {message}")
            return kitchen
        except PlanConflict as error:
            failed = error
        except StyleConflict as error:
            if error.pointer[-1] in chosen:
                raise CasaError(f"model of {error.pointer[-1]}: expected {error.expected}, got {error.got}") from error
            raise style_document.fault(error.pointer, error.expected, error.got) from error
    assert failed is not None
    raise document.fault(failed.pointer, failed.expected, failed.got)


def with_finishes(style: Style, surfaces: Mapping[Surface, str], mixed: bool = False) -> Style:
    """Return a style with other finishes of its surfaces, and of the parts that have to match them.

    Appliances behind cabinet fronts get the fronts of the cabinets. With wooden cabinets, open shelves are of the same
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
    if choice.is_library:
        return False
    params = preset_params().get(choice.family, {}).get(choice.name, {})
    look = merge_nested(params, choice.params).get(LOOK)
    return isinstance(look, Mapping) and look.get("form") == PANEL


def params_of(choice: PresetChoice) -> Params:
    """The numbers of a choice. Raises CasaError where they do not go together."""
    found = family(choice.family)
    if choice.name not in found.presets:
        raise UnknownId(f"preset of {choice.family}", choice.name, found.presets)
    return checked_params(choice.preset, found.params, preset_params()[choice.family][choice.name], choice.params)


def checked_params(name: str, kind: type[Params], base: Mapping[str, Any], over: Mapping[str, Any]) -> Params:
    """Numbers with some replaced. Raises CasaError, which begins with the name, where they do not go together."""
    try:
        return kind.model_validate(merge_nested(base, over))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise CasaError(f"{name}: {where}: {first['msg']}, got {str(first['input'])[:80]}") from None


def merge_nested(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """A mapping with values replaced, inside its mappings too."""
    merged = dict(base)
    for key, value in over.items():
        current = merged.get(key)
        if isinstance(current, Mapping) and isinstance(value, Mapping):
            value = merge_nested(current, value)
        merged[key] = value
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

    `cache`: folder of the store that keeps painted pictures and built assets.
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

    `assets`: by name of what is wanted. `props`: what may be put on worktops and shelves. `seed`: draws their places.
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
