"""All plans, as they are, at the ends of their parameters and between: do they fit, and can one work in them?

What hangs and stands in kitchens keeps clear of what else is there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.problems import problems_of
from casa_assets.layouts.compose import box_in_world, compose, pose_at_spot, scatter_props
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.furnish import LAMP_FROM_ISLAND_M, worktop_width
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.order.room_shell import HOOD_DEPTH_M, beams_of
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import params_of, preset_params, resolve
from casa_assets.model.kitchen.plan import BaseKind, UpperKind, WorktopItem
from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names
from tests.support.asset.family_members import made as family_member
from tests.support.kitchen.plan_geometry import PLAY, STYLE, boxes, draws, extremes, floor_row, made

PLANS = plan_names()
COOKERS = (BaseKind.RANGE, BaseKind.HOB)
NEARLY_M = 0.02  # predictions are bounds: what is built is a little smaller


def row(plan: str) -> Any:
    """A row of all tests of a plan in all its sizes; it is of the style of `made`."""
    return pytest.param(plan, marks=(pytest.mark.content("plan", plan), pytest.mark.content("style", STYLE)))


@pytest.fixture(scope="module", params=list(map(row, PLANS)))
def kitchens(request: pytest.FixtureRequest) -> list[KitchenRequest]:
    plan, _ = load_plan(request.param)
    return [made(request.param, given) for given in (*extremes(plan), *draws(plan, 20))]


def message(kitchen: KitchenRequest, *more: object) -> str:
    return f"{kitchen.plan.id} {dict(kitchen.parameters)}: {' '.join(map(str, more))}"


def test_nothing_is_foreseen_to_fail_at_any_size(kitchens: list[KitchenRequest]) -> None:
    """Aisles, doorways, hoods, corners, ways of doors, worktop to set things down on: as `check-plan` predicts them."""
    for kitchen in kitchens:
        lengths = {name: p.replace(default=kitchen.parameters[name]) for name, p in kitchen.plan.parameters.items()}
        draft = Draft({}, kitchen.plan.replace(parameters=lengths), kitchen.style)
        _, problems = problems_of(draft)
        assert [p for p in problems if p.excess > NEARLY_M] == [], message(kitchen)
        for slot, r in boxes(kitchen):
            mx, my = (r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2
            for x, y in r.corners:
                near_x, near_y = x + 0.005 * (mx - x), y + 0.005 * (my - y)
                assert kitchen.room.contains(near_x, near_y), message(kitchen, slot.name, x, y)


@pytest.mark.content("plan", "{name}")
@pytest.mark.content("style", "all")
@pytest.mark.parametrize("name", PLANS)
def test_a_hand_gets_to_the_keys_of_a_microwave_beside_a_tall_unit(name: str) -> None:
    for style in style_names():
        kitchen = made(name, style=style)
        width = StyleModels(kitchen.style, preset_params()).for_role("microwave").length("width")
        for item in (i for i in kitchen.items if i.role == "microwave" and kitchen.slot(i.unit).top < 1.0):
            row = floor_row(kitchen, kitchen.slot(item.unit).line)
            right = item.spot.u + width / 2
            tall = [s.left - right for s in row if s.top > 1.0 and s.left >= right]
            assert min(tall, default=1.0) >= 0.12, message(kitchen, style, tall)


@pytest.mark.content("plan", "{name}", keep=6)
@pytest.mark.content("style", "{style}")
@pytest.mark.parametrize("style", style_names())
@pytest.mark.parametrize("name", PLANS)
def test_fits_every_style(name: str, style: str) -> None:
    plan, _ = load_plan(name)
    for given in extremes(plan):
        kitchen = made(name, given, style)
        assert [s for row in kitchen.slots.values() for s in row if s.kind in COOKERS]
        assert not list(_crowded(kitchen)), message(kitchen, *_crowded(kitchen))
        for (one, a), (other, b) in itertools.combinations(boxes(kitchen), 2):
            if min(one.top, other.top) - max(one.bottom, other.bottom) > PLAY:
                assert a.gap(b) > -PLAY, message(kitchen, one.name, other.name, a.gap(b))


def _crowded(kitchen: KitchenRequest) -> Iterator[str]:
    """Units that are narrower than what stands on them."""
    models = StyleModels(kitchen.style, preset_params())
    for unit, stands in itertools.groupby(sorted(kitchen.plan.worktop_items, key=lambda s: s.on), key=lambda s: s.on):
        if sum(worktop_width(models, s) for s in stands) > kitchen.slot(unit).width:
            yield unit


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


def test_lamps_over_one_table_do_not_touch_though_beams_move_them() -> None:
    styles = ("industrial", "rustic", "mediterranean", "farmhouse")
    for plan, style in itertools.product(("u_dining", "double_island", "attic"), styles):
        lamps = [w for w in drawn(plan, style, 8600).items if w.role == "lamp"]
        places = [w.spot.frame.at(w.spot.u, w.spot.v)[:2] for w in lamps]
        assert len(places) > 1
        # The least ones are 0.24 m wide.
        assert min(math.dist(a, b) for a, b in itertools.combinations(places, 2)) > 0.3, (plan, style)


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
    assets = {item.name: family_member(item.choice.family, params_of(item.choice)) for item in kept}
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
    assets = {item.name: family_member(item.choice.family, params_of(item.choice)) for item in kept}
    (item,) = (i for i in kept if i.name == "toaster")
    props = [(choice, family_member(choice.family, params_of(choice))) for choice in style.props[:3]]
    box = box_in_world(pose_at_spot(assets["toaster"], item.spot), assets["toaster"].bounds)[:, :2]
    found = 0
    for seed in range(12):
        for prop, asset in scatter_props(replace(wanted, items=kept), assets, props, seed):
            found += 1
            other = box_in_world(pose_at_spot(asset, prop.spot), asset.bounds)[:, :2]
            assert np.maximum(other[0] - box[1], box[0] - other[1]).max() >= 0.36
    assert found > 12
