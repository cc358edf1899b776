"""All plans, as they are, at the ends of their parameters and between: do they fit, and can one work in them?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.problems import problems_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.furnish import worktop_width
from casa_assets.layouts.plan.runs import UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.model.kitchen.plan import BaseKind, UpperKind
from casa_assets.registry.kitchens import load_plan, plan_names, style_names
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


def of_kind(kitchen: KitchenRequest, *kinds: BaseKind | UpperKind) -> list[UnitSlot]:
    return [s for row in kitchen.slots.values() for s in row if s.kind in kinds]


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
        assert of_kind(kitchen, *COOKERS)
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
