"""What makes a kitchen look lived in: racks, tools, jars and boards of every form."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.kitchenware.fixtures import boards, wall_racks
from casa_assets.kitchenware.fixtures.dish_rack import DishRack, DishRackForm
from tests.support.asset.family_members import made

pytestmark = pytest.mark.content("code", "families", keep=0)


def test_a_dish_rack_has_room_for_a_bowl(subtests: pytest.Subtests) -> None:
    for form in list(DishRackForm):
        with subtests.test(form=form):
            asset = made("dish_rack", DishRack(form=form, cup=False))
            room = next(r for r in asset.regions if r.name == "int_dishes")
            assert min(room.size[:2]) >= 0.09
            assert room.size[2] > 0.0999


def test_a_dish_rack_holds_the_plates_it_is_given() -> None:
    for count in (0, 3):
        asset = made("dish_rack", DishRack(plates=count))
        assert sum(c.name.startswith("plate_") for c in asset.root.colliders) == count


def test_tools_hang_apart_in_front_of_the_wall(subtests: pytest.Subtests) -> None:
    for rail in list(wall_racks.RailStyle):
        with subtests.test(rail=rail):
            asset = made("utensil_rack", wall_racks.UtensilRack(rail=rail, tools=8, length=0.9))
            shafts = [c for c in asset.root.colliders if c.name.endswith("_shaft")]
            assert len(shafts) == 8
            across = sorted(c.pose.position[0] for c in shafts)
            assert min(np.diff(across)) > 0.08
            back = float(asset.bounds[1][1])
            assert max(c.pose.position[1] for c in shafts) < back - 0.02


def test_a_leaning_board_stands_up() -> None:
    lying, leaning = (made("cutting_board", boards.CuttingBoard(leaning=value)) for value in (False, True))
    assert np.ptp(lying.bounds, axis=0)[2] < 0.03
    assert np.ptp(leaning.bounds, axis=0)[2] > 0.2


def test_a_spice_rack_carries_two_tiers(subtests: pytest.Subtests) -> None:
    for form in list(wall_racks.SpiceRackForm):
        with subtests.test(form=form):
            asset = made("spice_rack", wall_racks.SpiceRack(form=form, columns=4))
            heights = [c.pose.position[2] for c in asset.root.colliders if c.name.startswith("jar_")]
            assert len(heights) == (10 if form is wall_racks.SpiceRackForm.CAROUSEL else 8)
            assert max(heights) - min(heights) > 0.015
