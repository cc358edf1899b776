"""Put objects of registry/objects/ into a composed kitchen, and keep those that stay where they were put."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from casa_assets.checks.scene.motion.settling import Rest, come_to_rest
from casa_assets.core.sampling import rng_for
from casa_assets.export.mjcf.scene import kitchen as mjcf
from casa_assets.geometry.inertia import ready_to_simulate
from casa_assets.geometry.lightweight import light_scene
from casa_assets.layouts.lived_in.put_objects import MEMBERS, PutGroup, put_objects, rounded_pose
from casa_assets.layouts.lived_in.spaces import find_spaces
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.habit import Arrangement, Habits
from casa_assets.model.kitchen.scene import Scene
from casa_assets.pipeline.cache.asset_store import AssetStore
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.families.run import FamilyRequest, asset_key, family_of, params_of
from casa_assets.registry.habits import load_habits

LANE = "scene/objects"
FULL, LIGHT = "full", "light"  # forms of a scene
# Members are drawn with the seed that `casa-assets objects build` draws with unless it is told otherwise.
MEMBER_SEED = 0
# Times that new groups are put in for those that did not stay.
MAX_ROUNDS = 3
# In the first run things sink and slide to where they rest: a group of which one goes farther or tips is taken out.
SETTLE_S, MAX_SLIDE_M, MAX_TILT = 2.5, 0.02, 0.2
MAX_SLIDE_IN_HEAP_M = 0.08  # fruit rolls to the bottom of its bowl
# In the second run, from there, nothing moves or stands in anything any more.
STILL_S, MAX_DRIFT_M, MAX_DEPTH_M = 2.0, 0.002, 0.0004
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
        groups = at_rest(scene, (*groups, *more), habits, objects)
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
    habits = load_habits()
    requests = [_request(category, number) for category in habits.categories for number in range(MEMBERS)]
    members = [asset_key(family_of(r), params_of(r)) for r in requests]
    return digest_of("objects", count, seed, habits.digest, members, key_of(put_into))


def _number(groups: Iterable[PutGroup]) -> int:
    return sum(len(group.placements) for group in groups)


def with_groups(scene: Scene, groups: Sequence[PutGroup], objects: ObjectMembers) -> Scene:
    """The scene with the objects of groups."""
    placements = [place for group in groups for place in group.placements]
    known = objects.assets
    added = [known[name] for name in sorted({place.asset for place in placements})]
    return ready_to_simulate(scene.replace(assets=(*scene.assets, *added), placements=(*scene.placements, *placements)))


def at_rest(scene: Scene, groups: Sequence[PutGroup], habits: Habits, objects: ObjectMembers) -> tuple[PutGroup, ...]:
    """The groups that stay where they are put, each object where it came to rest, in the full and in the light form.

    Args:
        scene: without them.
    """
    kept = list(groups)
    for form in (LIGHT, FULL):
        rests = _simulate(scene, kept, objects, form, SETTLE_S)
        kept = [_moved(group, rests, objects) for group in kept if _has_settled(group, habits, rests)]
    for _ in range(MAX_STILL_RUNS):
        runs = [_simulate(scene, kept, objects, form, STILL_S) for form in (FULL, LIGHT)]
        still = [group for group in kept if all(_is_still(group, rests) for rests in runs)]
        if len(still) == len(kept):
            return tuple(kept)
        kept = still
    return ()


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


def _has_settled(group: PutGroup, habits: Habits, rests: dict[str, Rest]) -> bool:
    is_heap = habits.habits[group.habit].arrangement is Arrangement.HEAP
    for number, place in enumerate(group.placements):
        rest = rests[place.name]
        may_roll = is_heap and number > 0
        if rest.moved > (MAX_SLIDE_IN_HEAP_M if may_roll else MAX_SLIDE_M) or (rest.tilt > MAX_TILT and not may_roll):
            return False
    return True


def _moved(group: PutGroup, rests: dict[str, Rest], objects: ObjectMembers) -> PutGroup:
    known = objects.assets
    placements = tuple(
        place.replace(pose=rounded_pose(rests[place.name].pose @ known[place.asset].root.pose.inverse()))
        for place in group.placements
    )
    return replace(group, placements=placements)


def _is_still(group: PutGroup, rests: dict[str, Rest]) -> bool:
    return all(
        rests[place.name].moved <= MAX_DRIFT_M and rests[place.name].depth <= MAX_DEPTH_M for place in group.placements
    )
