"""Draws: the same for the same seed, of finishes that go together; how diverse they are, and what is told of a run."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from casa_assets.layouts.run import diversity, sample
from casa_assets.layouts.run.diversity import Choices, Traits, diversity_of, evenness
from casa_assets.layouts.run.mix import goes_together, mixed_style
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.resolve import draw_surfaces, with_finishes
from casa_assets.layouts.run.sample import RefusalRow, draw_recipes
from casa_assets.model.issue import Issue, Report, Severity
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.style import Style
from casa_assets.registry.kitchens import load_mixing, load_style, plan_names, style_names

CALM = {"wall": "plaster_chalk_white", "floor": "oak_natural_plank", "counter": "marble_carrara"}
CALM |= {"cabinet": "paint_navy"}


def style(name: str) -> Style:
    return load_style(name)[0]


def test_the_same_seed_draws_the_same() -> None:
    many = draw_recipes(60, 5)
    assert many == draw_recipes(60, 5) != draw_recipes(60, 6)
    assert many[:20] == draw_recipes(20, 5)
    with_objects = draw_recipes(20, 5, objects=10)
    assert [replace(one, objects=0, objects_seed=0) for one in with_objects] == many[:20]
    assert len({one.objects_seed for one in with_objects if one.objects == 10}) == 20


def test_finishes_that_are_drawn_go_together() -> None:
    drawn = [draw_surfaces(seed) for seed in range(100)]
    assert all(goes_together(name for _, name in surfaces) for surfaces in drawn)
    assert len(set(drawn)) == 100
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
        assert goes_together({**CALM, **changed}.values()) is expected, changed


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


SURFACES = {"wall": "brick", "floor": "oak", "counter": "marble", "cabinet": "navy"}
FIXTURES = {"fridge": "fridge/steel", "sink": "sink/double", "stool": "stool/woven", "window": "window/slider"}
ONE = Traits("a", "galley", "coastal", {"width": 0.5, "depth": 0.5}, 12.0, SURFACES, "shaker, bar", FIXTURES)
POSSIBLE = Choices(10, 12, 9, dict.fromkeys(SURFACES, 100), dict.fromkeys([*FIXTURES, "hob"], 8))


def test_evenness_of_known_spreads() -> None:
    for values, possible, expected in [
        ("abcd", 4, 1.0),
        ("aabb", 2, 1.0),
        ("aaaa", 4, 0.0),
        ("aaab", 2, 0.8113),
        ("aabb", 4, 0.5),
        ("abc", 100, 1.0),
        ("abc", 2, 1.0),
        ("a", 5, None),
        ("aaa", 1, None),
        ("", 5, None),
        # The entropy over that of an even spread.
        ("aaaaabbbcc", 8, round(-sum(share * math.log(share) for share in (0.5, 0.3, 0.2)) / math.log(8), 4)),
    ]:
        assert evenness(list(values), possible) == expected, (values, possible)


def test_known_distances() -> None:
    surfaces, fixtures = dict.fromkeys(SURFACES, "other"), dict.fromkeys(FIXTURES, "other/one")
    for changes, expected in [
        ({}, 0.0),
        ({"lengths": {"width": 1.0, "depth": 0.5}}, 0.15 * 0.25),
        ({"plan": "u_small", "lengths": {"width": 0.5}}, 0.20 + 0.15),
        # Lengths of another plan that are called the same are others.
        ({"plan": "u_small", "lengths": {"width": 0.5, "depth": 0.5}}, 0.20 + 0.15),
        ({"plan": "u_small", "lengths": {"width": 1.0, "depth": 1.0}}, 0.20 + 0.15),
        ({"style": "rustic"}, 0.10),
        ({"surfaces": {**SURFACES, "wall": "tile"}}, 0.25 / 4),
        ({"fronts": "slab, bar"}, 0.05),
        ({"fixtures": {**FIXTURES, "sink": "sink/single"}}, 0.25 / 4),
        ({"fixtures": {**FIXTURES, "hob": "hob/gas"}}, 0.25 / 5),
        ({"plan": "u", "style": "s", "surfaces": surfaces, "fronts": "slab, knob", "fixtures": fixtures}, 1.0),
    ]:
        other = replace(ONE, **changes)
        for pair in ([ONE, other], [other, ONE]):
            assert diversity_of(pair, POSSIBLE).neighbours.least == pytest.approx(expected, abs=1e-4), changes


def test_nearest_neighbours_are_found_written_and_read_back(tmp_path: Path) -> None:
    twin = replace(ONE, id="b", lengths={"width": 0.7, "depth": 0.5})
    far = replace(ONE, id="c", style="rustic", surfaces=dict.fromkeys(SURFACES, "other"), plan="u_small")
    drawn, reference = diversity_of([ONE, far, twin], POSSIBLE), diversity_of([ONE], POSSIBLE)
    told = drawn.neighbours
    assert (told.closest, told.near) == (("a", "b"), 2)
    assert told.least == pytest.approx(0.15 * 0.1, abs=1e-4)
    assert told.median == pytest.approx(0.15 * 0.1, abs=1e-4), "of a and b each other, of c either"
    diversity.write_diversity(tmp_path, drawn, reference)
    assert diversity.read_diversity(tmp_path) == (drawn, reference)
    (tmp_path / diversity.DIVERSITY).write_text("{", encoding="utf-8")
    assert diversity.read_diversity(tmp_path) is None
    assert diversity.table_rows(drawn, reference)[0] == ("kitchens", "3", "1")


def test_traits_are_those_of_the_kitchen() -> None:
    told = sample.traits_of(SceneRecipe("one_wall_small", "coastal"))
    assert (told.plan, told.style, told.fronts) == ("one_wall_small", "coastal", "shaker, boxed")
    finishes = {"wall": "shiplap_white", "floor": "cement_coastal_black", "counter": "marble_carrara"}
    assert told.surfaces == {**finishes, "cabinet": "paint_navy"}
    assert told.fixtures["fridge"] == "fridge_french_door/steel"
    assert set(told.lengths) == {"width", "depth"}
    assert all(0.0 <= share <= 1.0 for share in told.lengths.values())
    possible = sample.choices()
    assert (possible.plans, possible.styles) == (len(plan_names()), len(style_names()))
    assert set(possible.surfaces.values()) == {100}
    assert (possible.fixtures["fridge"], possible.fixtures["floor_plant"]) == (12, 2)


def test_refusals_are_counted_by_reason_plan_and_style() -> None:
    galley, wall = SceneRecipe("galley", "rustic", 1), SceneRecipe("one_wall_small", "rustic", 1)
    doors = Issue(code="SCN005", severity=Severity.ERROR, pointer="a/b", message="doors meet")
    outside = doors.replace(code="SCN009", message="it is outside")
    done = [
        SceneResult(galley, "somewhere"),
        SceneResult(galley, report=Report(subject="x", issues=(doors, doors, outside))),
        SceneResult(SceneRecipe("galley", "rustic", 2), report=Report(subject="x", issues=(doors,))),
        SceneResult(wall, message="the run main is too long"),
        SceneResult(wall, message="Traceback ...\nValueError: what", is_fault=True),
    ]
    assert sample.refusals(done) == [
        RefusalRow("SCN005", "galley", "rustic", 2, "a/b doors meet"),
        RefusalRow("SCN009", "galley", "rustic", 1, "a/b it is outside"),
        RefusalRow("cannot be built", "one_wall_small", "rustic", 1, "the run main is too long"),
        RefusalRow("fault of the program", "one_wall_small", "rustic", 1, "ValueError: what"),
    ]


def test_cost_is_the_mean_over_those_whose_cost_is_known() -> None:
    recipe = SceneRecipe("galley", "rustic")
    done = [
        SceneResult(recipe, "a", cpu_s={"build": 1.0, "write": 2.0, "check": 6.0, "rest": 1.0}),
        SceneResult(recipe, cpu_s={"build": 3.0, "check": 8.0}),
        SceneResult(recipe, "b", kept=True),
    ]
    cost = sample.cost_of(done)
    assert (cost.kitchens, cost.total, sample.cost_of([]).total) == (2, 10.5, 0.0)
    assert cost.steps == {"build": 2.0, "write": 1.0, "draw": 0.0, "check": 7.0, "rest": 0.5}
