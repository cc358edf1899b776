"""Draws: the same for the same seed, of everything there is, of finishes that go together and parts that match."""

from __future__ import annotations

from dataclasses import replace

import pytest

from casa_assets.layouts.run import draws
from casa_assets.layouts.run.mix import goes_together, mixed_style
from casa_assets.layouts.run.recipe import SceneRecipe, recipe_of
from casa_assets.layouts.run.resolve import draw_surfaces, resolve, with_finishes
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.style import Style
from casa_assets.registry.kitchens import load_mixing, load_style, plan_names, style_names

CALM = {"wall": "plaster_chalk_white", "floor": "oak_natural_plank", "counter": "marble_carrara"}
CALM |= {"cabinet": "paint_navy"}


def style(name: str) -> Style:
    return load_style(name)[0]


class TestRecipes:
    def test_the_same_seed_draws_the_same(self) -> None:
        many = draws.draw_recipes(60, 5)
        assert many == draws.draw_recipes(60, 5)
        assert many[:20] == draws.draw_recipes(20, 5)
        assert many != draws.draw_recipes(60, 6)
        with_objects = draws.draw_recipes(20, 5, objects=10)
        assert [replace(one, objects=0, objects_seed=0) for one in with_objects] == many[:20]
        assert len({one.objects_seed for one in with_objects if one.objects == 10}) == 20

    def test_draws_are_of_every_plan_and_style(self) -> None:
        many = draws.draw_recipes(200, 0)
        assert {r.plan for r in many} == set(plan_names())
        assert {r.style for r in many} == set(style_names())
        assert len({r.scene_id for r in many}) == 200
        assert len({r.surfaces for r in many}) > 190
        assert all(r.mixed for r in many)

    def test_a_draw_that_was_drawn_before_is_drawn_again(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(draws, "MAX_SEED", 1)
        monkeypatch.setattr(draws, "plan_names", lambda: ("galley",))
        many = draws.draw_recipes(12, 3)
        assert len({r.scene_id for r in many}) == len(many) == 12

    def test_an_id_tells_the_whole_recipe(self) -> None:
        for recipe in draws.draw_recipes(5, 7):
            assert recipe_of(recipe.scene_id) == recipe


class TestFinishes:
    def test_drawn_ones_go_together(self) -> None:
        drawn = [draw_surfaces(seed) for seed in range(100)]
        assert all(goes_together(name for _, name in surfaces) for surfaces in drawn)
        assert len(set(drawn)) == 100

    def test_what_goes_together(self, subtests: pytest.Subtests) -> None:
        for changed, expected in [
            ({}, True),
            ({"wall": "paper_damask_taupe"}, True),
            ({"wall": "paper_damask_taupe", "floor": "cement_coastal_black"}, False),
            ({"cabinet": "oak_natural"}, True),
            ({"cabinet": "oak_natural", "counter": "block_oak"}, False),
            ({"wall": "zellige_cobalt", "floor": "oak_ebony", "counter": "soapstone_dark"}, False),
            ({"wall": "zellige_emerald", "cabinet": "lacquer_burgundy_gloss"}, False),
            ({"wall": "zellige_honey", "cabinet": "paint_navy"}, True),
        ]:
            with subtests.test(changed=changed, expected=expected):
                assert goes_together({**CALM, **changed}.values()) is expected


class TestMixing:
    def test_the_same_seed_mixes_the_same_and_finishes_and_light_stay(self) -> None:
        first = mixed_style(style("coastal"), 5)
        assert first == mixed_style(style("coastal"), 5)
        assert first not in (mixed_style(style("coastal"), 6), mixed_style(style("coastal"), 5, turn=1))

        def kept(of: Style) -> list[object]:
            groups = (of.cabinets.base, of.cabinets.upper, of.cabinets.tall, of.cabinets.island)
            faces = [of.counter.face, of.island.face, *(group.face for group in groups)]
            return [of.id, of.lamp_kelvin, of.room.wall, of.room.floor, faces, set(of.models)]

        assert kept(mixed_style(style("modern_2"), 11)) == kept(style("modern_2"))

    def test_what_belongs_together_comes_from_one_style(self) -> None:
        styles = [style(name) for name in style_names()]
        for seed in range(20):
            mixed = mixed_style(style("modern_1"), seed)
            for roles in load_mixing().suites.values():
                assert any(all(s.models[role] == mixed.models[role] for role in roles) for s in styles), (seed, roles)
            # What hangs on a splashback is of its style.
            found = [s for s in styles if s.backsplash == mixed.backsplash and s.counter.edge == mixed.counter.edge]
            assert mixed.models["utensil_rack"] in [s.models["utensil_rack"] for s in found], seed

    def test_appliances_behind_fronts_get_those_of_the_cabinets(self) -> None:
        painted = with_finishes(style("rustic"), {Surface.CABINET: "paint_navy"})
        assert painted.models["fridge"].params["look"]["face"] == "paint_navy"
        look = {"front": "v_groove", "face": "paint_navy", "metal": "cast_iron_black"}
        assert painted.models["dishwasher"].params["look"] == look
        assert with_finishes(style("rustic"), {Surface.WALL: "zellige_snow"}).models == style("rustic").models
        steel = with_finishes(style("coastal"), {Surface.CABINET: "paint_sage"})
        assert steel.models["fridge"] == style("coastal").models["fridge"]
        assert steel.cabinets.shelf == "oak_whitened"
        # Open shelves beside cabinets of wood are of that wood.
        assert with_finishes(style("coastal"), {Surface.CABINET: "walnut_straight"}).cabinets.shelf == "walnut_straight"

    def test_a_mixed_kitchen_fits_into_every_plan(self) -> None:
        for plan in plan_names():
            for seed in range(4):
                assert resolve(SceneRecipe(plan, "transitional_2", seed, mixed=True)).plan.id == plan
