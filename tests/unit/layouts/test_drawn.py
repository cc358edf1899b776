"""Kitchens of other lengths than the plain ones: what hangs keeps clear of what else hangs there."""

from __future__ import annotations

import itertools
import math

import pytest

from casa_assets.layouts.compose import pose_at_spot
from casa_assets.layouts.order.furnish import LAMP_FROM_ISLAND_M, THINGS_BELOW_M
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.order.room_shell import HOOD_DEPTH_M, beams_of
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import resolve
from casa_assets.model.kitchen.plan import UpperKind
from tests.support.asset.family_members import preset


def drawn(plan: str, style: str, seed: int) -> KitchenRequest:
    return resolve(SceneRecipe(plan, style, seed))


@pytest.mark.parametrize(("style", "seed"), [("mediterranean", 805162), ("farmhouse", 385648)])
def test_no_lamp_of_the_room_hangs_at_one_over_an_island(style: str, seed: int) -> None:
    lamps = [w for w in drawn("wraparound", style, seed).items if w.role == "lamp"]
    places = {w.name: w.spot.frame.at(w.spot.u, w.spot.v)[:2] for w in lamps}
    assert len(places) > 2
    for one, other in itertools.combinations(places, 2):
        if "ceiling_light" in one + other:
            assert math.dist(places[one], places[other]) >= LAMP_FROM_ISLAND_M, (one, other)


def test_lamps_over_one_table_do_not_touch_though_beams_move_them(subtests: pytest.Subtests) -> None:
    for plan in ["u_dining", "double_island", "attic"]:
        for style in ["industrial", "rustic", "mediterranean", "farmhouse"]:
            with subtests.test(style=style, plan=plan):
                kitchen = drawn(plan, style, 8600)
                places = [w.spot.frame.at(w.spot.u, w.spot.v)[:2] for w in kitchen.items if w.role == "lamp"]
                assert len(places) > 1
                assert (
                    min(math.dist(a, b) for a, b in itertools.combinations(places, 2)) > 0.3
                )  # 0.24 m wide, the least ones


def test_a_rack_hangs_beside_the_shelf_at_the_end_of_a_row(subtests: pytest.Subtests) -> None:
    for seed in [0, 30205, 163211]:
        for style in ["modern_1", "modern_2"]:
            with subtests.test(style=style, seed=seed):
                kitchen = drawn("galley", style, seed)
                rack = next(w for w in kitchen.items if w.name == "utensil_rack")
                assert rack.spot.u - kitchen.slot("main_upper_shelf").right > 0.5


def test_a_rack_of_two_rails_hangs_above_what_stands_on_the_worktop() -> None:
    kitchen = resolve(SceneRecipe("one_wall_large", "transitional_2"))
    rack = next(w for w in kitchen.items if w.name == "utensil_rack")
    asset = preset("utensil_rack", "double_chrome")
    foot = asset.bounds[0][2] + pose_at_spot(asset, rack.spot).position[2]
    assert rack.choice.preset == "utensil_rack/double_chrome"
    assert foot == pytest.approx(standard_sizes.WORKTOP_HEIGHT + THINGS_BELOW_M, abs=1e-6)


@pytest.mark.parametrize(("style", "seed"), [("rustic", 395138), ("farmhouse", 912812)])
def test_beams_keep_clear_of_a_hood_that_the_usual_number_would_meet(style: str, seed: int) -> None:
    kitchen = drawn("l_large", style, seed)
    beams = beams_of(kitchen.plan, kitchen.style, kitchen.room, kitchen.lines, kitchen.slots)
    assert beams is not None
    (hood,) = [s for row in kitchen.slots.values() for s in row if s.kind is UpperKind.HOOD]
    axis = 1 if beams.along_x else 0
    ends = [hood.line.frame.at(u, v)[axis] for u in (hood.left, hood.right) for v in (0.0, HOOD_DEPTH_M)]
    assert not beams.crosses(min(ends), max(ends))
