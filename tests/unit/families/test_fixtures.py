"""Cabinets: sizes, pulls that a hand reaches, parts that open without touching; racks, tools, boards of every form."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.kitchenware.fixtures import boards, wall_racks
from casa_assets.kitchenware.fixtures.cabinets import BaseCabinet, DrawerStack, IslandBase, WallCabinet
from casa_assets.kitchenware.fixtures.dish_rack import DishRack, DishRackForm
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.fronts import CabinetLook, FrontEdge, FrontKind
from casa_assets.kitchenware.parts.handles import HandleKind
from casa_assets.model.asset.parts import Box, Capsule
from tests.support.asset.family_members import made, preset, spec_of

pytestmark = pytest.mark.content("code", "families", keep=0)


def test_sizes_are_those_asked_for() -> None:
    params = BaseCabinet(width=0.43, depth=0.58, height=0.87, look=CabinetLook(handle=HandleKind.FINGER_GROOVE))
    low, high = made("base_cabinet", params).bounds
    np.testing.assert_allclose(high - low, (0.43, 0.58, 0.87), atol=1e-5)
    np.testing.assert_allclose(low[2], 0.0, atol=1e-6)


@pytest.mark.parametrize("handle", [HandleKind.BAR, HandleKind.CUP, HandleKind.RING, HandleKind.KNOB])
@pytest.mark.parametrize("front", [FrontKind.SLAB, FrontKind.SHAKER])
def test_pulls_of_deep_drawer_fronts_are_high(front: FrontKind, handle: HandleKind) -> None:
    """A hand that comes from a wheeled base does not get much lower than 0.3 m above the floor."""
    look = CabinetLook(front=front, handle=handle)
    stack, island = made("drawer_stack", DrawerStack(look=look)), made("island_base", IslandBase(look=look))
    for asset, link in ((stack, "drawer0"), (island, "c0_drawer0")):
        grip = next(c for c in asset.link(link).colliders if c.name == f"{link}_handle")
        assert (asset.asset_from_link(link) @ grip.pose).position[2] > 0.33


def test_rings_of_upper_doors_hang_clear_of_what_stands_before_their_lower_edge() -> None:
    """The hand at a ring is 0.1 m high; a refrigerator may stand out below the doors over it."""
    params = WallCabinet(look=CabinetLook(front=FrontKind.RAISED, handle=HandleKind.RING))
    link = made("wall_cabinet", params).link("door")
    assert min(float(c.pose.position[2]) for c in link.colliders if "handle" in c.name) >= 0.05


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(
    ("family", "name"),
    [
        ("base_cabinet", "shaker_navy_cups"),
        ("base_cabinet", "slab_oak_groove"),
        ("wall_cabinet", "glass_black"),
        ("drawer_stack", "birch_leather_five"),
        ("corner_cabinet_diagonal", "navy_cups"),
        ("island_base", "navy_cups"),
    ],
)
def test_parts_clear_each_other_when_all_stand_open(family: str, name: str, tmp_path: Path) -> None:
    """Every share of the way, all at once and one by one, without the exclusion of neighbours."""
    spec = spec_of(preset(family, name), tmp_path)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    model = spec.compile()
    data = mujoco.MjData(model)
    far = np.where(np.abs(model.jnt_range[:, 0]) > np.abs(model.jnt_range[:, 1]), *model.jnt_range.T)
    deepest = 0.0
    for share in np.linspace(0.0, 1.0, 9):
        for mask in (np.ones(model.njnt), *np.eye(model.njnt)):
            data.qpos[:] = share * far * mask
            mujoco.mj_forward(model, data)
            deepest = max([deepest, *(-float(c.dist) for c in data.contact)])
    assert deepest < 0.0005


def test_fronts_fill_their_size_and_are_closed(subtests: pytest.Subtests) -> None:
    for groove in [None, *FrontEdge]:
        for kind in list(FrontKind):
            with subtests.test(kind=kind, groove=groove):
                for drawer, height in ((False, 0.72), (True, 0.14), (False, 2.1)):
                    parts = fronts.front_parts(kind, 0.4, height, drawer=drawer, groove=groove)
                    assert all(p.solid.volume > 0 for p in parts)
                    cloud = np.concatenate([p.solid.points for p in parts])
                    np.testing.assert_allclose(
                        cloud.max(axis=0) - cloud.min(axis=0), (0.4, fronts.FRONT_THICKNESS, height), atol=1e-6
                    )
                    assert (kind in fronts.GLAZED_KINDS) == any(p.pane for p in fronts.front_parts(kind, 0.4, 0.72))


def test_handles_stand_on_the_face_and_fit_a_gripper(subtests: pytest.Subtests) -> None:
    for kind in [k for k in HandleKind if k is not HandleKind.FINGER_GROOVE]:
        with subtests.test(kind=kind):
            length = handles.handle_length(kind, 0.16)
            made = handles.edge_pull(length) if kind is HandleKind.EDGE_PULL else handles.handle(kind, length)
            solids = (*made.metal, *made.leather)
            assert all(s.volume > 0 for s in solids)
            cloud = np.concatenate([s.points for s in solids])
            assert cloud[:, 1].max() >= -1e-6
            assert -0.06 < cloud[:, 1].min() < -0.02
            shape = made.shapes[0][0]
            assert isinstance(shape, Box | Capsule)
            section = min(shape.size) if isinstance(shape, Box) else 2 * shape.radius
            assert 0.002 < section <= 0.08


def test_what_cannot_be_built_is_refused() -> None:
    with pytest.raises(ValidationError, match="take two"):
        BaseCabinet(width=0.9, doors=1)
    with pytest.raises(ValidationError, match="lower than"):
        DrawerStack(height=0.6, shares=(1.0,) * 5)
    with pytest.raises(ValidationError, match="shelves"):
        BaseCabinet(height=0.5, shelves=4)


# What is put out and hung up ------------------------------------------------------------------------------------------


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
