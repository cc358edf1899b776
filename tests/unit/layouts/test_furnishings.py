"""What hangs and stands in kitchens keeps clear of what else is there, also in other lengths than the plain ones."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from casa_assets.layouts.compose import box_in_world, compose, pose_at_spot, scatter_props
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.furnish import LAMP_FROM_ISLAND_M
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.order.room_shell import HOOD_DEPTH_M, beams_of
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import params_of, preset_params, resolve
from casa_assets.model.kitchen.plan import UpperKind, WorktopItem
from casa_assets.registry.kitchens import load_plan, load_style
from tests.support.asset.family_members import made


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
                # The least ones are 0.24 m wide.
                assert min(math.dist(a, b) for a, b in itertools.combinations(places, 2)) > 0.3


@pytest.mark.parametrize(("style", "seed"), [("rustic", 395138), ("farmhouse", 912812)])
def test_beams_keep_clear_of_a_hood_that_the_usual_number_would_meet(style: str, seed: int) -> None:
    kitchen = drawn("l_large", style, seed)
    beams = beams_of(kitchen)
    (hood,) = [s for row in kitchen.slots.values() for s in row if s.kind is UpperKind.HOOD]
    axis = 1 if beams.along_x else 0
    ends = [hood.line.frame.at(u, v)[axis] for u in (hood.left, hood.right) for v in (0.0, HOOD_DEPTH_M)]
    assert not beams.crosses(min(ends), max(ends))


def test_the_lid_lies_on_the_jar() -> None:
    plan, _ = load_plan("one_wall_small")
    item = WorktopItem(id="blender", on=plan.worktop_items[0].on, at=0.5)
    wanted = request_kitchen(plan.replace(worktop_items=(item,)), load_style("coastal")[0], preset_params())
    kept = tuple(item for item in wanted.items if item.name.startswith("blender"))
    assets = {item.name: made(item.choice.family, params_of(item.choice)) for item in kept}
    scene = compose(replace(wanted, items=kept), assets, "a")
    blender, lid = scene.placements
    site = next(site for site in assets["blender"].sites if site.name == "lid_site")
    above = (blender.pose @ site.pose).inverse() @ lid.pose
    assert above.position[:2] == pytest.approx((0.0, 0.0), abs=1e-5)
    assert 0.0 < above.position[2] < 2e-4
    # Its cover lies over the mouth, its plug reaches into the jar.
    top = lid.pose.position[2] + assets["blender_lid"].bounds[0][2]
    assert top < blender.pose.position[2] + assets["blender"].bounds[1][2]


def test_props_keep_away_from_what_is_operated_on_a_worktop() -> None:
    plan, _ = load_plan("l_large")
    toaster = next(item for item in plan.worktop_items if item.id == "toaster")
    style = load_style("mediterranean")[0]
    wanted = request_kitchen(plan.replace(worktop_items=(toaster,)), style, preset_params())
    kept = tuple(item for item in wanted.items if item.role == "counter" or item.name == "toaster")
    assets = {item.name: made(item.choice.family, params_of(item.choice)) for item in kept}
    (item,) = (i for i in kept if i.name == "toaster")
    props = [(choice, made(choice.family, params_of(choice))) for choice in style.props[:3]]
    box = box_in_world(pose_at_spot(assets["toaster"], item.spot), assets["toaster"].bounds)[:, :2]
    found = 0
    for seed in range(12):
        for prop, asset in scatter_props(replace(wanted, items=kept), assets, props, seed):
            found += 1
            other = box_in_world(pose_at_spot(asset, prop.spot), asset.bounds)[:, :2]
            assert np.maximum(other[0] - box[1], box[0] - other[1]).max() >= 0.36
    assert found > 12
