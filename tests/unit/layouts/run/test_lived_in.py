"""Kitchens that are lived in: what is put into them stays where it is, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from casa_assets.checks.scene.rest import come_to_rest
from casa_assets.formats.mjcf.kitchen import write
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run import resolve
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import bare, build_scene, kitchen_key
from casa_assets.layouts.run.scene_json import describe
from casa_assets.model.kitchen.scene import Scene

pytestmark = pytest.mark.content("code", "layouts.run", keep=0)

COUNT = 4
PLAIN = SceneRecipe("one_wall_small", "scandinavian")
LIVED_IN = replace(PLAIN, objects=COUNT)
Made = tuple[KitchenRequest, Scene]


@pytest.fixture(scope="module")
def lived_in(cache: Path) -> Made:
    return build_scene(LIVED_IN, cache)


def test_objects_are_at_rest_and_change_nothing_else(cache: Path, lived_in: Made) -> None:
    (kitchen, before), (same, after) = build_scene(PLAIN, cache), lived_in
    assert (same, before.objects, after.exclusions) == (kitchen, (), before.exclusions)
    assert after.placements[: len(before.placements)] == before.placements
    assert facts_of(same, after).fixtures == facts_of(kitchen, before).fixtures
    names = [place.name for place in after.objects]
    assert len(names) == COUNT
    rests = come_to_rest(write(bare(after), shared="assets"), names, 2.0)
    assert max(rest.moved for rest in rests.values()) <= 0.005
    assert max(rest.depth for rest in rests.values()) <= 0.001


def test_same_recipe_same_scene(cache: Path, lived_in: Made) -> None:
    assert build_scene(LIVED_IN, cache)[1] == lived_in[1]
    assert kitchen_key(LIVED_IN) != kitchen_key(PLAIN)
    assert kitchen_key(LIVED_IN) != kitchen_key(replace(LIVED_IN, objects_seed=1))


def test_the_key_of_objects_has_the_keys_of_all_that_may_be_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    before = resolve.objects_key(COUNT, 0)
    monkeypatch.setattr(resolve, "asset_key", lambda *_: "of another version")
    resolve._members_key.cache_clear()
    assert resolve.objects_key(COUNT, 0) != before
    resolve._members_key.cache_clear()


def test_facts_list_the_objects_and_what_holds_them(lived_in: Made) -> None:
    kitchen, scene = lived_in
    facts = describe(LIVED_IN, kitchen, scene)
    fixtures = {fixture["name"]: fixture for fixture in facts["fixtures"]}
    assert [row["name"] for row in facts["objects"]] == [place.name for place in scene.objects]
    for row in facts["objects"]:
        holder = fixtures[row["in"]["placement"]]
        assert row["in"]["region"] in {**holder["regions"], **holder["sites"]}
