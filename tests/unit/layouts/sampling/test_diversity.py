"""Evenness and distances of kitchens whose traits are made by hand, so that each number is known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from casa_assets.layouts.run import draws
from casa_assets.layouts.run.draws import Choices, Traits, diversity_of, evenness
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.registry.kitchens import plan_names, style_names

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


class TestDiversity:
    def test_nearest_neighbours_and_near_duplicates(self) -> None:
        twin = replace(ONE, id="b", lengths={"width": 0.7, "depth": 0.5})
        far = replace(ONE, id="c", style="rustic", surfaces=dict.fromkeys(SURFACES, "other"), plan="u_small")
        told = diversity_of([ONE, far, twin], POSSIBLE).neighbours
        assert told.closest == ("a", "b")
        assert told.least == pytest.approx(0.15 * 0.1, abs=1e-4)
        assert told.median == pytest.approx(0.15 * 0.1, abs=1e-4), "of a and b each other, of c either"
        assert told.near == 2

    def test_each_trait_is_told_by_itself(self) -> None:
        other = replace(ONE, id="b", floor_m2=30.0, surfaces={**SURFACES, "floor": "tile"})
        told = diversity_of([ONE, other], POSSIBLE)
        assert (told.kitchens, told.plans, told.styles, told.room_sizes, told.fronts) == (2, 0.0, 0.0, 1.0, 0.0)
        assert told.surfaces == {"wall": 0.0, "floor": 1.0, "counter": 0.0, "cabinet": 0.0}
        assert told.fixtures == 0.0

    def test_roles_that_some_lack_count_where_they_are(self) -> None:
        without = replace(ONE, id="c", fixtures={k: v for k, v in FIXTURES.items() if k != "stool"})
        other = replace(ONE, id="b", fixtures={**FIXTURES, "stool": "stool/sled"})
        told = diversity_of([ONE, other, without], POSSIBLE)
        assert told.roles["stool"] == 1.0
        assert told.fixtures == pytest.approx(0.25)

    def test_areas_of_one_step_are_one_size(self) -> None:
        for areas, expected in (((12.1, 14.9), 0.0), ((11.9, 12.1), 1.0), ((46.0, 90.0), 0.0), ((1.0, 9.5), 0.0)):
            found = [replace(ONE, id=str(area), floor_m2=area) for area in areas]
            assert diversity_of(found, POSSIBLE).room_sizes == expected

    def test_fewer_than_two_have_none(self) -> None:
        for found in ([], [ONE]):
            told = diversity_of(found, POSSIBLE)
            assert (told.plans, told.fixtures, told.neighbours.least, told.neighbours.near) == (None, None, None, 0)

    def test_what_is_written_is_read_back(self, tmp_path: Path) -> None:
        drawn, reference = diversity_of([ONE], POSSIBLE), diversity_of([ONE, replace(ONE, id="b")], POSSIBLE)
        draws.write_diversity(tmp_path, drawn, reference)
        assert draws.read_diversity(tmp_path) == (drawn, reference)
        (tmp_path / draws.DIVERSITY).write_text("{", encoding="utf-8")
        assert draws.read_diversity(tmp_path) is None
        rows = draws.table_rows(drawn, reference)
        assert rows[0] == ("kitchens", "1", "2")
        assert ("plans", "", "0.00") in rows


def test_traits_are_those_of_the_kitchen() -> None:
    told = draws.traits_of(SceneRecipe("one_wall_small", "coastal"))
    assert (told.plan, told.style, told.fronts) == ("one_wall_small", "coastal", "shaker, boxed")
    finishes = {"wall": "shiplap_white", "floor": "cement_coastal_black", "counter": "marble_carrara"}
    assert told.surfaces == {**finishes, "cabinet": "paint_navy"}
    assert told.fixtures["fridge"] == "fridge_french_door/steel"
    assert set(told.lengths) == {"width", "depth"}
    assert all(0.0 <= share <= 1.0 for share in told.lengths.values())
    possible = draws.choices()
    assert (possible.plans, possible.styles) == (len(plan_names()), len(style_names()))
    assert set(possible.surfaces.values()) == {100}
    assert (possible.fixtures["fridge"], possible.fixtures["floor_plant"]) == (12, 2)
