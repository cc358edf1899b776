"""All plans, as they are, at the ends of their parameters and between: do they fit, and can one work in them?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from casa_assets.core.robocasa import MIN_SURFACE_M
from casa_assets.layouts.order.build_order import OrderItem
from casa_assets.layouts.order.furnish import worktop_width
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.order.worktops import WORKTOP_BREAKS
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.runs import CornerPart, UnitSlot
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import TALL, BaseKind, OpeningKind, UpperKind
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
    passages,
    rect,
    slot_rect,
    walls_free,
)

PLANS = plan_names()
COOKERS = (BaseKind.RANGE, BaseKind.HOB)
APPLIANCES = (*COOKERS, BaseKind.DISHWASHER, BaseKind.FRIDGE, BaseKind.OVEN, BaseKind.MICROWAVE)
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


class TestRoom:
    def test_no_two_units_overlap(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for (one, a), (other, b) in itertools.combinations(boxes(kitchen), 2):
                if min(one.top, other.top) - max(one.bottom, other.bottom) > PLAY:
                    assert a.gap(b) > -PLAY, message(kitchen, one.name, other.name, a.gap(b))

    def test_no_unit_leaves_the_room(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for slot, r in boxes(kitchen):
                mx, my = (r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2
                for x, y in r.corners:
                    near_x, near_y = x + 0.005 * (mx - x), y + 0.005 * (my - y)
                    assert kitchen.room.contains(near_x, near_y), message(kitchen, slot.name, x, y)

    def test_units_on_the_wall_stay_out_of_windows(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for hole in (h for h in kitchen.holes if not h.is_niche):
                for slot, _ in boxes(kitchen):
                    if slot.line.run.on == hole.wall.id and slot.top > hole.bottom:
                        shift = hole.wall.frame.to_local(*slot.line.frame.at(0.0, 0.0)[:2])[0]
                        left, right = slot.left + shift, slot.right + shift
                        clear = max(left - hole.right, hole.left - right)
                        assert clear > 0.05, message(kitchen, slot.name, hole.opening.id, clear)

    def test_people_pass(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for one, other, gap, least in passages(kitchen):
                assert gap >= least, message(kitchen, one, other, gap, "m, at least", least)
            for line, wall, gap in walls_free(kitchen):
                assert gap >= 0.914, message(kitchen, line, wall, gap)

    def test_doorways_are_wide_and_free(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for hole in kitchen.holes:
                if hole.is_window or hole.is_niche:
                    continue
                assert hole.right - hole.left >= 0.86, message(kitchen, hole.opening.id)
                (xa, ya, _), (xb, yb, _) = hole.wall.frame.at(hole.left, 0.0), hole.wall.frame.at(hole.right, 0.9)
                way = Rect(min(xa, xb), min(ya, yb), max(xa, xb), max(ya, yb))
                for slot, r in boxes(kitchen):
                    assert way.gap(r) > 0, message(kitchen, hole.opening.id, slot.name)


class TestWork:
    def test_no_cooker_stands_under_a_window(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for slot in of_kind(kitchen, *COOKERS):
                for hole in (h for h in kitchen.holes if h.is_window and h.wall.id == slot.line.run.on):
                    shift = hole.wall.frame.to_local(*slot.line.frame.at(0.0, 0.0)[:2])[0]
                    assert slot.left + shift > hole.right or slot.right + shift < hole.left, message(kitchen, slot.name)

    def test_a_hood_hangs_over_the_cooker(self, kitchens: list[KitchenRequest]) -> None:
        assert standard_sizes.HOOD_FROM - standard_sizes.WORKTOP_HEIGHT >= 0.61
        for kitchen in kitchens:
            (cooker,), (hood,) = of_kind(kitchen, *COOKERS), of_kind(kitchen, UpperKind.HOOD)
            assert hood.line is cooker.line
            assert hood.middle == pytest.approx(cooker.middle, abs=1e-3)

    def test_appliances_keep_off_inside_corners(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for slot in of_kind(kitchen, *APPLIANCES):
                line = slot.line
                if line.left.kind is RunEnd.CORNER:
                    assert slot.left - standard_sizes.BASE_DEPTH >= 0.38, message(kitchen, slot.name)
                if line.right.kind is RunEnd.CORNER:
                    assert line.length - standard_sizes.BASE_DEPTH - slot.right >= 0.38, message(kitchen, slot.name)

    def test_one_stands_beside_the_dishwasher(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            (washer,), (sink,) = of_kind(kitchen, BaseKind.DISHWASHER), of_kind(kitchen, BaseKind.SINK)
            assert washer.line is sink.line
            assert max(washer.left - sink.right, sink.left - washer.right) < 0.02, message(kitchen)
            line = washer.line
            if washer.left > sink.left and line.right.kind in (RunEnd.CORNER, RunEnd.WALL):
                edge = standard_sizes.WORKTOP_DEPTH if line.right.kind is RunEnd.CORNER else 0.0
                assert line.length - edge - washer.right >= 0.55, message(kitchen)
            elif washer.left < sink.left and line.left.kind in (RunEnd.CORNER, RunEnd.WALL):
                edge = standard_sizes.WORKTOP_DEPTH if line.left.kind is RunEnd.CORNER else 0.0
                assert washer.left - edge >= 0.55, message(kitchen)

    def test_there_is_room_to_set_things_down(self, kitchens: list[KitchenRequest]) -> None:
        for kitchen in kitchens:
            for kinds, least, most in (((BaseKind.SINK,), 0.45, 0.6), (COOKERS, 0.3, 0.38)):
                (slot,) = of_kind(kitchen, *kinds)
                beside = sorted(_tops_beside(kitchen, slot))
                assert beside[0] >= least, message(kitchen, slot.name, beside)
                assert beside[1] >= most, message(kitchen, slot.name, beside)
            for slot in of_kind(kitchen, BaseKind.MICROWAVE):
                assert max(_tops_beside(kitchen, slot)) >= 0.38, message(kitchen, slot.name)

    def test_corners_open(self, kitchens: list[KitchenRequest]) -> None:
        """Beside a corner stands a single door on either side, hung away from it."""
        for kitchen in kitchens:
            for corner in kitchen.plan.corners:
                for which, name in enumerate(corner.runs):
                    row = [
                        s
                        for s in floor_row(kitchen, kitchen.lines[name])
                        if s.kind not in (CornerPart.FILLER, BaseKind.FILLER)
                    ]
                    door = row[-1] if which == 0 else row[0]
                    assert door.kind in (CornerPart.BLIND, BaseKind.DOORS, BaseKind.PANTRY), message(kitchen, door.name)
                    assert door.hinge is not None
                    assert door.hinge.value == ("left" if which == 0 else "right"), message(kitchen, door.name)
                    if door.kind is BaseKind.DOORS:
                        assert door.width <= 0.451, message(kitchen, door.name, door.width)


class TestContent:
    def test_is_that_of_the_table(self) -> None:
        assert set(PLANS) == set(TABLE)

    @pytest.mark.content("plan", "{name}")
    @pytest.mark.content("style", STYLE)
    @pytest.mark.parametrize("name", PLANS)
    def test_sizes_and_kinds(self, name: str) -> None:
        kitchen = made(name)
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


def _tops_beside(kitchen: KitchenRequest, slot: UnitSlot) -> tuple[float, float]:
    """Metres of worktop on both sides of a unit, up to what interrupts it."""
    row = floor_row(kitchen, slot.line)
    k = row.index(slot)
    return _run_of_top(row[k + 1 :]), _run_of_top(row[:k][::-1])


def _run_of_top(row: list[UnitSlot]) -> float:
    stops = (*WORKTOP_BREAKS, BaseKind.SINK, BaseKind.HOB)
    return sum(s.width for s in itertools.takewhile(lambda s: s.kind not in stops and s.top < 1.0, row))


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
