"""All plans, as they are, at the ends of their parameters and between: do they fit, and can one work in them?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.problems import problems_of
from casa_assets.layouts.order.build_order import KitchenRequest, OrderItem
from casa_assets.layouts.order.furnish import worktop_width
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import CornerPart, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.model.kitchen.plan import TALL, BaseKind, OpeningKind, UpperKind
from casa_assets.model.registry.contract import MIN_SURFACE_M
from casa_assets.registry.kitchens import load_plan, plan_names, style_names
from tests.support.kitchen.plan_geometry import (
    PLAY,
    STYLE,
    Rect,
    boxes,
    draws,
    extremes,
    floor_row,
    made,
    rect,
    slot_rect,
)

PLANS = plan_names()
COOKERS = (BaseKind.RANGE, BaseKind.HOB)
NEARLY_M = 0.02  # predictions are bounds: what is built is a little smaller
# Of all plans: width and depth of the room, metres; whether a hob with a wall oven; stools; window.
TABLE = {
    "one_wall_small": (5.8, 3.0, False, 0, False),
    "one_wall_large": (6.5, 5.0, True, 3, False),
    "l_small": (5.2, 5.2, False, 0, True),
    "l_large": (5.5, 5.9, True, 3, True),
    "galley": (3.2, 5.6, False, 0, True),
    "u_small": (4.4, 4.5, False, 0, True),
    "u_large": (6.4, 5.0, True, 3, True),
    "g_small": (4.4, 5.0, False, 2, True),
    "g_large": (6.08, 6.0, True, 3, True),
    "wraparound": (6.2, 4.5, False, 3, True),
    "attic": (5.8, 4.6, False, 0, True),
    "double_island": (7.2, 8.4, False, 4, True),
    "l_bay": (5.8, 5.17279, False, 0, True),
    "l_columns": (6.5, 6.0, False, 3, True),
    "pantry_island": (6.71, 3.96, False, 3, True),
    "u_dining": (5.73, 6.3, False, 0, True),
}


def row(plan: str) -> Any:
    """A row of all tests of a plan in all its sizes; it is of the style of `made`."""
    return pytest.param(plan, marks=(pytest.mark.content("plan", plan), pytest.mark.content("style", STYLE)))


@pytest.fixture(scope="module", params=list(map(row, PLANS)))
def kitchens(request: pytest.FixtureRequest) -> list[KitchenRequest]:
    """A plan in all its sizes."""
    plan, _ = load_plan(request.param)
    return [made(request.param, given) for given in (*extremes(plan), *draws(plan, 20))]


def message(kitchen: KitchenRequest, *more: object) -> str:
    """What to look at."""
    return f"{kitchen.plan.id} {dict(kitchen.parameters)}: {' '.join(map(str, more))}"


def of_kind(kitchen: KitchenRequest, *kinds: BaseKind | UpperKind) -> list[UnitSlot]:
    """All units of some kinds."""
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


class TestContent:
    @pytest.mark.content("plan", "{name}")
    @pytest.mark.content("style", STYLE)
    @pytest.mark.parametrize("name", PLANS)
    def test_sizes_and_kinds(self, name: str) -> None:
        kitchen = made(name)
        assert set(PLANS) == set(TABLE)
        width, depth, hob, stools, window = TABLE[name]
        (x0, y0), (x1, y1) = kitchen.room.bounds()
        assert (x1 - x0, y1 - y0) == pytest.approx((width, depth))
        assert len(of_kind(kitchen, BaseKind.HOB)) == len(of_kind(kitchen, BaseKind.OVEN)) == int(hob)
        assert len(of_kind(kitchen, BaseKind.RANGE)) == int(not hob)
        assert sum(w.role == "stool" for w in kitchen.items) == stools
        assert any(h.is_window for h in kitchen.holes) is window
        assert any(h.opening.kind is not OpeningKind.WINDOW for h in kitchen.holes)
        for role in ("fridge", "microwave", "coffee_machine", "toaster", "dishwasher", "sink", "hood"):
            assert sum(w.role == role for w in kitchen.items) == 1, role
        assert of_kind(kitchen, UpperKind.SHELF, UpperKind.BOARDS, BaseKind.SHELF)

    def test_tasks_find_their_units(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            doors = [s.width for s in of_kind(kitchen, UpperKind.DOORS, UpperKind.GLASS)]
            corners = [s for r in kitchen.slots.values() for s in r if s.is_upper and s.kind is CornerPart.BLIND]
            assert corners or min(doors) <= standard_sizes.WIDEST_SINGLE_DOOR, message(kitchen)
            assert max(doors) > standard_sizes.WIDEST_SINGLE_DOOR, message(kitchen)
            assert any(_stands_free(kitchen, s) for s in of_kind(kitchen, BaseKind.DRAWERS)), message(kitchen)

    def test_small_appliances_stand_in_many_plans(self) -> None:
        kitchens = [made(name) for name in PLANS]
        for role in ("blender", "kettle", "stand_mixer", "toaster_oven"):
            found = {k.plan.id for k in kitchens for w in k.items if w.role == role}
            assert len(found) >= 4, (role, found)
            assert {"g_large", "l_large", "u_large", "wraparound"} <= found, role

    def test_a_microwave_has_worktop_beside_it(self, kitchens: list[KitchenRequest]) -> None:
        """RoboCasa puts a plate there: 0.40 m of one worktop, without a seam."""
        for kitchen in kitchens:
            for item in (w for w in kitchen.items if w.role == "microwave" and w.name == "microwave"):
                half = float(StyleModels(kitchen.style, preset_params()).for_role("microwave").params["width"]) / 2
                left, right = _worktop_under(kitchen, item)
                room = max(item.spot.u - half - left, right - item.spot.u - half)
                assert room >= MIN_SURFACE_M[0], message(kitchen, room)

    @pytest.mark.content("plan", "{name}")
    @pytest.mark.content("style", "all")
    @pytest.mark.parametrize("name", PLANS)
    def test_a_hand_gets_to_the_keys_of_a_microwave_beside_a_tall_unit(self, name: str) -> None:
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
    def test_fits_every_style(self, name: str, style: str) -> None:
        plan, _ = load_plan(name)
        for given in extremes(plan):
            kitchen = made(name, given, style)
            assert of_kind(kitchen, *COOKERS)
            assert not list(_crowded(kitchen)), message(kitchen, *_crowded(kitchen))
            for (one, a), (other, b) in itertools.combinations(boxes(kitchen), 2):
                if min(one.top, other.top) - max(one.bottom, other.bottom) > PLAY:
                    assert a.gap(b) > -PLAY, message(kitchen, one.name, other.name, a.gap(b))


def _worktop_under(kitchen: KitchenRequest, item: OrderItem) -> tuple[float, float]:
    """Left and right end, along its run, of the worktop under a thing; of one arm where it goes round a corner."""
    line = kitchen.lines[item.run]
    for top in (w for w in kitchen.items if w.role == "counter"):
        params = top.choice.params
        if "back_arm" not in params:
            left, right = (top.spot.u + s * params["width"] / 2 for s in (-1, 1))
            runs = {top.run: (left, right)}
        else:
            first, second = next(c.runs for c in kitchen.plan.corners if top.name == "_".join((*c.runs, "top")))
            length = kitchen.lines[first].length
            runs = {first: (length - params["back_arm"], length), second: (params["depth"], params["side_arm"])}
        left, right = runs.get(line.id, (0.0, 0.0))
        if left <= item.spot.u <= right:
            return left, right
    raise AssertionError(message(kitchen, item.name, "stands on no worktop"))


def _crowded(kitchen: KitchenRequest) -> Iterator[str]:
    """Units that are narrower than what stands on them."""
    models = StyleModels(kitchen.style, preset_params())
    for unit, stands in itertools.groupby(sorted(kitchen.plan.worktop_items, key=lambda s: s.on), key=lambda s: s.on):
        if sum(worktop_width(models, s) for s in stands) > kitchen.slot(unit).width:
            yield unit


def _stands_free(kitchen: KitchenRequest, slot: UnitSlot) -> bool:
    """Whether a robot can stand before a drawer unit, to the left or right of its drawers."""
    others = [r for s, r in _solid(kitchen) if s is not slot]
    for way in (-1, 1):
        u = slot.middle + way * (slot.width / 2 + 0.3)
        place = rect(slot.line, u - 0.28, u + 0.28, 0.68, 1.24)
        inside = all(kitchen.room.contains(x, y) for x in (place.x0, place.x1) for y in (place.y0, place.y1))
        if inside and all(place.gap(r) > 0 for r in others):
            return True
    return False


def _solid(kitchen: KitchenRequest) -> Iterator[tuple[UnitSlot, Rect]]:
    for slot, r in boxes(kitchen):
        if not slot.is_upper:
            yield slot, r if slot.kind in TALL else slot_rect(slot)
