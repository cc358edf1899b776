"""Assets of libraries are scaled to the places of a kitchen, or refused with what would fit."""

from __future__ import annotations

from typing import Any

import pytest

from casa_assets.errors import PlanConflict, StyleConflict
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.plan.style_models import ANYWHERE, ModelMisfit, Place, fitted_choice
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.registry.rows import RoleRule
from casa_assets.registry.kitchens import load_plan, load_style
from casa_assets.registry.tables import load_roles

RULE = RoleRule(id="range", categories=("range",), base=Base.FIXED)
RULE = RULE.replace(width=(0.5, 0.9), depth=(0.5, 0.7), height=(0.8, 1.2), level=(0.9, 0.93))


def sizes(
    width: float, depth: float, height: float, level: float, category: str, base: str = "fixed", stands: bool = True
) -> dict[str, Any]:
    size = max(width, depth)
    named = {"width": width, "depth": depth, "height": height, "level": level, "size": size, "sweep": 0.1, "drop": 0.03}
    return {**named, "category": category, "base": base, "stands": stands}


LIBRARY = {
    "range_0000000001": sizes(0.6, 0.6, 0.915, 0.91, "range"),
    "range_articulated_0000000002": sizes(1.2, 1.2, 2.0, 1.8, "range"),  # twice as large as they are
    "range_0000000003": sizes(0.6, 0.6, 0.3, 0.3, "range"),  # no range has this shape
    "microwave_0000000004": sizes(0.5, 0.4, 0.3, 0.3, "microwave"),
    "toaster_0000000005": sizes(0.3, 0.2, 0.2, 0.2, "toaster", "free"),
    "toaster_0000000006": sizes(0.3, 0.2, 0.2, 0.2, "toaster", "free", stands=False),
    "refrigerator_0000000007": sizes(0.9, 0.7, 1.9, 1.9, "refrigerator"),
    "wall_oven_0000000008": sizes(0.6, 0.56, 0.6, 0.6, "wall_oven"),
}


def fit(name: str, place: Place = ANYWHERE, rule: RoleRule = RULE, **params: Any) -> tuple[PresetChoice, Any]:
    choice = PresetChoice.model_validate({"preset": f"library:{name}", **params})
    return fitted_choice(choice, "range", rule, LIBRARY, place)


def test_what_is_too_large_is_scaled_until_its_cooktop_is_as_high_as_the_worktops() -> None:
    choice, params = fit("range_articulated_0000000002")
    assert choice.params == {"scale": pytest.approx(0.5166, abs=1e-4)}
    assert params["level"] == pytest.approx(0.93, abs=2e-4)
    assert params["width"] == pytest.approx(0.62, abs=2e-4)
    assert params["sweep"] == pytest.approx(0.05166, abs=1e-5)


def test_a_unit_of_a_stated_width_is_filled_or_its_model_is_refused() -> None:
    _, params = fit("range_0000000001", Place({"width": 0.624}, fills=True, name="main_range"))
    assert 0.594 <= params["width"] <= 0.624
    place = Place({"width": 0.894}, fills=True, name="main_range")
    with pytest.raises(ModelMisfit, match=r"expected a range of 0\.894 m, to fill main_range: leave the width"):
        fit("range_articulated_0000000002", place, RULE.replace(height=(0.8, 1.1)))


def test_what_does_not_suit_is_refused_with_what_does_and_how_to_change_it() -> None:
    with pytest.raises(ModelMisfit) as caught:
        fit("range_0000000003")
    sizes = "width 0.5 to 0.9, depth 0.5 to 0.7, height 0.8 to 1.2 m"
    assert all(said in caught.value.expected for said in (sizes, "library:range_0000000001", "--front"))
    assert "0.600 x 0.600 x 0.300 m" in caught.value.got
    with pytest.raises(ModelMisfit) as caught:
        fit("microwave_0000000004")
    suits = ("library:range_articulated_0000000002", "--category range", "roles.yaml")
    assert all(said in caught.value.expected for said in suits)
    assert "library:toaster" not in caught.value.expected
    assert caught.value.got == "library:microwave_0000000004, the category of which is microwave"
    assert fit("range_0000000001", scale=1.1)[1]["width"] == pytest.approx(0.66)
    with pytest.raises(ModelMisfit, match=r"before it is scaled by 3"):
        fit("range_0000000001", scale=3)


def test_the_base_is_that_of_the_role_unless_one_is_stated() -> None:
    for name, role_base, stated, params in [
        ("toaster_0000000005", Base.FIXED, {}, {"base": "fixed"}),
        ("toaster_0000000005", Base.FIXED, {"base": "free"}, {}),
        ("toaster_0000000005", None, {}, {}),
        # What does not stand by itself is fixed unless it is stated to be free.
        ("toaster_0000000006", Base.FREE, {}, {"base": "fixed"}),
    ]:
        assert fit(name, rule=RoleRule(id="toaster", base=role_base), **stated)[0].params == params, (name, stated)


class TestInPlans:
    """Units and worktop items that name a model of their own."""

    def kitchen(self, **changes: Any) -> KitchenRequest:
        """one_wall_small with changes of its units by id, or of worktop items by id."""
        raw = load_plan("one_wall_small")[0].model_dump(mode="json")
        for run in raw["runs"]:
            for row in ("base", "upper"):
                run[row] = [{**unit, **changes.pop(unit["id"], {})} for unit in run[row]]
        raw["worktop_items"] += [{"id": name, **row} for name, row in changes.items()]
        presets = {**preset_params(), "library": LIBRARY}
        return request_kitchen(Plan.model_validate(raw), load_style("modern_1")[0], presets, roles=load_roles())

    def test_open_doors_clear_the_drawer_below_and_have_room_beside(self) -> None:
        kitchen = self.kitchen(main_doors={"kind": "oven", "model": "library:wall_oven_0000000008", "width": None})
        (oven,) = (item for item in kitchen.items if item.role == "oven")
        (housing,) = (item for item in kitchen.items if item.name == "main_doors")
        assert oven.spot.z - 0.03 > housing.choice.params["niche_from"] + 0.009
        assert kitchen.slot("main_doors").width == pytest.approx(0.638)
        kitchen = self.kitchen(main_fridge={"model": "library:refrigerator_0000000007"})
        assert kitchen.slot("main_fridge").width == pytest.approx(0.9 + 2 * 0.115)

    def test_what_does_not_suit_is_told_with_its_place_in_the_plan_or_the_style(self) -> None:
        for unit, model, said in [
            ("main_range", "microwave_0000000004", r"runs\.main\.base\.5\.model: expected an asset of the category"),
            ("main_sink", "toaster_0000000005", "a preset of a family for the sink: its worktop is cut out"),
            ("main_drawers", "toaster_0000000005", "no model for drawers"),
            ("main_range", "range_000000000", r"expected .*range_0000000001, .*got 'range_000000000'"),
        ]:
            with pytest.raises(PlanConflict, match=said):
                self.kitchen(**{unit: {"model": f"library:{model}"}})
        style = load_style("modern_1")[0]
        style = style.replace(models={**style.models, "range": "library:range_0000000003"})
        presets = {**preset_params(), "library": LIBRARY}
        with pytest.raises(StyleConflict, match=r"modern_1: models\.range: expected a range that can be scaled evenly"):
            request_kitchen(load_plan("one_wall_small")[0], style, presets, roles=load_roles())
