"""What makes a kitchen look lived in: presets and draws of each family are built, of usual size and mass."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.families.fixtures.kitchenware import cutting_board
from casa_assets.families.fixtures.kitchenware.dish_rack import DishRack, DishRackForm
from casa_assets.families.fixtures.wall_decor import spice_rack, utensil_rack
from casa_assets.families.parts.decor.jars import JarLid, jar
from casa_assets.families.parts.decor.tools import HungTool, ToolHandle, hung_tool
from casa_assets.families.parts.hardware.handles import open_tub
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.registry.families import family, family_groups
from tests.family_members import drawn, known, made, preset, unmet

pytestmark = pytest.mark.content("code", "families", keep=0)

BY_NAME = {f.name: f for f in (*family_groups()["decor"], family("counter_corner"))}
PRESETS = [(f.name, p) for f in BY_NAME.values() for p in f.presets]
HANGS = {"wall_clock", "utensil_rack", "picture_frame", "pendant_light", "ceiling_light", "curtain", "counter_corner"}
NEW = ("dish_rack", "utensil_rack", "spice_rack", "vase", "candle", "jar", "bottle", "cutting_board", "cookbook_stack")
SLACK = 1.2  # as registry/limits.yaml allows a size to leave the range of its category


def sides(asset: Asset) -> np.ndarray:
    """(3,) width, depth, height of what is seen, metres."""
    low, high = asset.bounds
    return np.asarray(high - low)


def holds(family: str, asset: Asset) -> None:
    """Names of the contract, a usual size and mass, few shapes and faces, a place on the ground."""
    category = known().fixtures[BY_NAME[family].category]
    contract = known().contracts[str(asset.contract)]
    assert unmet(asset, contract) == []
    longest = float(sides(asset).max())
    assert category.longest_m.low / SLACK <= longest <= category.longest_m.high * SLACK
    assert category.mass_kg.low / 1.5 <= asset.mass <= category.mass_kg.high * 1.5
    low, high = asset.bounds
    np.testing.assert_allclose((low[:2] + high[:2]) / 2, 0, atol=1e-5)
    assert abs(float(low[2])) < 1e-5
    assert all(0 < len(k.colliders) <= 32 for k in asset.links)
    assert sum(len(v.mesh.faces) for k in asset.links for v in k.visuals) <= 26000
    shapes = [c.name for k in asset.links for c in k.colliders]
    assert len(set(shapes)) == len(shapes)


def mesh_digest(asset: Asset) -> tuple[tuple[str, bytes], ...]:
    return tuple((v.name, v.mesh.vertices.tobytes()) for k in asset.links for v in k.visuals)


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(("family", "name"), PRESETS)
def test_every_preset_is_built_as_usual(family: str, name: str) -> None:
    holds(family, preset(family, name))


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
@pytest.mark.parametrize("seed", [1, 2])
def test_draws_are_built_as_usual(family: str, seed: int) -> None:
    params = drawn(family, seed)
    holds(family, made(family, params))
    assert drawn(family, seed) == params
    assert type(params).from_json(params.to_json()) == params


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_presets_have_meshes_of_their_own(family: str) -> None:
    found = BY_NAME[family]
    least = 8 if family in ("dish_rack", "utensil_rack", "spice_rack", "counter_corner") else 6
    assert len(found.presets) >= least
    assert len({mesh_digest(preset(family, name)) for name in found.presets}) == len(found.presets)


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_what_hangs_is_fixed_and_what_stands_is_free(family: str) -> None:
    bases = {preset(family, name).base for name in BY_NAME[family].presets}
    assert Base.FIXED in bases or family not in HANGS
    if family in NEW and family not in HANGS:
        assert bases == {Base.FREE}


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", NEW)
def test_fifty_draws_differ(family: str) -> None:
    assert len({drawn(family, seed).digest for seed in range(50)}) >= 48


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
    for rail in list(utensil_rack.RailStyle):
        with subtests.test(rail=rail):
            asset = made("utensil_rack", utensil_rack.UtensilRack(rail=rail, tools=8, length=0.9))
            shafts = [c for c in asset.root.colliders if c.name.endswith("_shaft")]
            assert len(shafts) == 8
            across = sorted(c.pose.position[0] for c in shafts)
            assert min(np.diff(across)) > 0.08
            back = float(asset.bounds[1][1])
            assert max(c.pose.position[1] for c in shafts) < back - 0.02


def test_a_hung_tool_is_closed_and_as_long_as_asked(subtests: pytest.Subtests) -> None:
    for grip in list(ToolHandle):
        for kind in list(HungTool):
            with subtests.test(kind=kind, grip=grip):
                pieces = hung_tool(kind, grip, 0.3)
                solids = [*pieces.grip, *pieces.metal, *pieces.head]
                assert all(s.volume > 0 for s in solids)
                low = min(float(s.bounds[0][2]) for s in solids)
                assert -0.32 < low < -0.27


def test_a_jar_holds_less_than_its_outside_and_is_shut(subtests: pytest.Subtests) -> None:
    for lid in list(JarLid):
        with subtests.test(lid=lid):
            found = jar(0.05, 0.15, lid, fill=0.5)
            assert found.inside.volume < found.shell.volume - found.body.volume
            assert found.body.volume < 0.35 * found.shell.volume
            assert 0.15 < found.top < 0.19
            assert max(float(s.bounds[1][2]) for s in found.lid) <= found.top + 1e-9
            more = jar(0.05, 0.15, lid, fill=0.8)
            assert more.inside.volume > 1.4 * found.inside.volume


def test_a_tub_is_as_hollow_as_its_shapes() -> None:
    solid = open_tub(0.3, 0.2, 0.1, 0.004, 0.03)
    assert len(solid.shapes) == 5
    assert 0 < solid.volume < 0.2 * 0.3 * 0.2 * 0.1
    np.testing.assert_allclose(np.ptp(solid.bounds, axis=0), (0.3, 0.2, 0.1), atol=1e-9)


def test_a_leaning_board_stands_up() -> None:
    boards = [cutting_board.CuttingBoard(leaning=value) for value in (False, True)]
    lying, leaning = (made("cutting_board", board) for board in boards)
    assert sides(lying)[2] < 0.03
    assert sides(leaning)[2] > 0.2


def test_a_spice_rack_carries_two_tiers(subtests: pytest.Subtests) -> None:
    for form in list(spice_rack.SpiceRackForm):
        with subtests.test(form=form):
            asset = made("spice_rack", spice_rack.SpiceRack(form=form, columns=4))
            heights = [c.pose.position[2] for c in asset.root.colliders if c.name.startswith("jar_")]
            assert len(heights) == (10 if form is spice_rack.SpiceRackForm.CAROUSEL else 8)
            assert max(heights) - min(heights) > 0.015
