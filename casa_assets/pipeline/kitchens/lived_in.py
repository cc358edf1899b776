"""Put objects of registry/objects/ into a composed kitchen, and keep those that stay where they were put."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial

from casa_assets.checks.scene.motion.settling import Rest, come_to_rest
from casa_assets.core.sampling import rng_for
from casa_assets.export.mjcf.scene import kitchen as mjcf
from casa_assets.geometry.inertia import ready_to_simulate
from casa_assets.geometry.lightweight import light_scene
from casa_assets.layouts.lived_in.put_objects import MEMBERS, PutGroup, put_objects, rounded_pose
from casa_assets.layouts.lived_in.spaces import find_spaces
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.habit import Arrangement
from casa_assets.model.kitchen.scene import Scene
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.families.run import FamilyRequest, asset_key, family_of, params_of
from casa_assets.projects import read_once
from casa_assets.registry.habits import load_habits

LANE = "scene/objects"
FULL, LIGHT = "full", "light"  # forms of a scene
# Members are drawn with the seed that `casa-assets objects build` draws with unless it is told otherwise.
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


def put_into(scene: Scene, count: int, seed: int, store: AssetStore) -> Scene:
    """The scene with `count` objects more, or fewer where it has no room for so many; all at rest.

    Args:
        seed: draws what is put where. store: keeps built assets.
    """
    habits, objects = load_habits(), ObjectMembers(store)
    rng = rng_for(seed, f"{LANE}/{scene.id}")
    spaces = find_spaces(scene, habits.spaces)
    groups: tuple[PutGroup, ...] = ()
    for _ in range(MAX_ROUNDS):
        more = put_objects(spaces, habits, objects.member, count - _number(groups), rng, groups)
        if not more:
            break
        # Groups stand apart, so that those which rest already are not simulated again.
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
            self._made[key] = self.store.built(family_of(request), params_of(request))
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
    return digest_of("members", [asset_key(family_of(r), params_of(r)) for r in requests])


def _number(groups: Iterable[PutGroup]) -> int:
    return sum(len(group.placements) for group in groups)


def with_groups(scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers) -> Scene:
    """The scene with the objects of groups."""
    placements = [place for group in groups for place in group.placements]
    known = objects.assets
    added = [known[name] for name in sorted({place.asset for place in placements})]
    return ready_to_simulate(scene.replace(assets=(*scene.assets, *added), placements=(*scene.placements, *placements)))


def at_rest(scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers) -> tuple[PutGroup, ...]:
    """The groups that stay where they are put, each object where it came to rest, in the full and in the light form.

    Args:
        scene: without them.
    """
    rests = _simulate(scene, groups, objects, FULL, SETTLE_S)
    kept = [_moved(group, rests, objects) for group in _kept(groups, partial(_has_settled, rests))]
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
    filled = with_groups(_holders(scene, groups), groups, objects)
    shown = light_scene(filled, objects.store.lightened) if form == LIGHT else bare(filled)
    return come_to_rest(mjcf.write(shown, shared="assets"), names, seconds)


def _holders(scene: Scene, groups: Sequence[PutGroup]) -> Scene:
    """The part of a scene that holds the groups: what else there is touches none of them, and would cost time."""
    held_by = {place.resting.placement for group in groups for place in group.placements if place.resting}
    placements = tuple(place for place in scene.placements if place.name in held_by)
    assets = {place.asset for place in placements}
    return scene.replace(placements=placements, assets=tuple(a for a in scene.assets if a.id in assets), exclusions=())


def bare(scene: Scene) -> Scene:
    """The scene without what is only seen, so that it is written and compiled in a fraction of the time."""
    return scene.replace(assets=tuple(_bare(asset) for asset in scene.assets), cameras=(), lights=(), sky=None)


def _bare(asset: Asset) -> Asset:
    links = tuple(link.replace(visuals=()) for link in asset.links)
    return asset.replace(links=links, materials=(), behavior=None)


def _has_settled(rests: dict[str, Rest], group: PutGroup, number: int) -> bool:
    arrangement = load_habits().habits[group.habit].arrangement
    stands = arrangement not in ROLLING or (arrangement is Arrangement.HEAP and number == 0)
    farthest = MAX_EDGE_ROLL_M if arrangement is Arrangement.ON_EDGE and number else MAX_SLIDE_M
    rest = rests[group.placements[number].name]
    return rest.moved <= farthest and rest.tilt <= (MAX_TILT if stands else MAX_ROLL)


def _moved(group: PutGroup, rests: dict[str, Rest], objects: ObjectMembers) -> PutGroup:
    known = objects.assets
    placements = tuple(
        place.replace(pose=rounded_pose(rests[place.name].pose @ known[place.asset].root.pose.inverse()))
        for place in group.placements
    )
    return replace(group, placements=placements)


def _is_still(runs: dict[str, dict[str, Rest]], group: PutGroup, number: int) -> bool:
    found = {form: rests[group.placements[number].name] for form, rests in runs.items()}
    return all(rest.moved <= MAX_DRIFT_M[form] and rest.depth <= MAX_DEPTH_M for form, rest in found.items())
