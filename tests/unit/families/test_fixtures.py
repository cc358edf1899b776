"""Fixtures: parts open without touching, a hand reaches pulls, pans stand level, tools hang apart."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import mujoco
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import casa_assets as casa
from casa_assets.asset.assemble import assemble
from casa_assets.asset.asset_builder import AssetBuilder
from casa_assets.kitchenware.fixtures import boards, wall_racks
from casa_assets.kitchenware.fixtures.cabinets import BaseCabinet, DrawerStack, IslandBase, WallCabinet
from casa_assets.kitchenware.fixtures.cookers import DOUBLE_OVEN_WIDTH, Range
from casa_assets.kitchenware.fixtures.dish_rack import DishRack, DishRackForm
from casa_assets.kitchenware.fixtures.microwave import Microwave, MicrowaveControls, MicrowaveHandle, MicrowaveMounting
from casa_assets.kitchenware.fixtures.toasters import PanelPlace, ToasterOven
from casa_assets.kitchenware.fixtures.vases import Bouquet, Vase
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.controls import KnobStyle, add_knob_with_scale
from casa_assets.kitchenware.parts.fronts import CabinetLook, FrontEdge, FrontKind
from casa_assets.kitchenware.parts.handles import HandleKind
from casa_assets.kitchenware.parts.oven import OvenHandle
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.parts import Box, Capsule, Cylinder
from casa_assets.registry.families import family
from tests.support.asset.family_members import made, preset, spec_of, supplies
from tests.unit.families.test_members import GROUPS, height_of, holds

pytestmark = pytest.mark.content("code", "families", keep=0)


MOVED = """
base_cabinet/shaker_navy_cups base_cabinet/slab_oak_groove wall_cabinet/glass_black drawer_stack/birch_leather_five
corner_cabinet_diagonal/navy_cups island_base/navy_cups range/slide_in_gas range/cooker_double_sage wall_oven/double
microwave/built_in_white microwave/retro_cream toaster_oven/mint toaster_oven/pro_four_knobs hood/slanted
"""


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(("family", "name"), [row.split("/") for row in MOVED.split()])
def test_parts_clear_each_other_on_their_way(family: str, name: str, tmp_path: Path) -> None:
    """Every joint alone, with what has to be open before it, in cabinets all at once too; neighbours count."""
    asset = preset(family, name)
    spec = spec_of(asset, tmp_path)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    model = spec.compile()
    data = mujoco.MjData(model)
    far = {j.name: max(j.range, key=abs) for j in asset.joints}
    moved = [[joint] for joint in asset.joints] + ([list(asset.joints)] if GROUPS[family] == "cabinets" else [])
    for joints, share in product(moved, np.linspace(0.0, 1.0, 9)):
        data.qpos[:] = model.qpos0
        for joint in joints:
            if joint.behind:
                data.joint(joint.behind).qpos = far[joint.behind]
            data.joint(joint.name).qpos = share * far[joint.name]
        mujoco.mj_forward(model, data)
        depth = max([0.0, *(-float(c.dist) for c in data.contact)])
        assert depth < 0.0005, f"{[joint.name for joint in joints]} at {share:.0%}"


# Cabinets -------------------------------------------------------------------------------------------------------------


def test_sizes_are_those_asked_for_and_what_cannot_be_built_is_refused() -> None:
    params = BaseCabinet(width=0.43, depth=0.58, height=0.87, look=CabinetLook(handle=HandleKind.FINGER_GROOVE))
    np.testing.assert_allclose(np.ptp(made("base_cabinet", params).bounds, axis=0), (0.43, 0.58, 0.87), atol=1e-5)
    with pytest.raises(ValidationError, match="take two"):
        BaseCabinet(width=0.9, doors=1)
    with pytest.raises(ValidationError, match="lower than"):
        DrawerStack(height=0.6, shares=(1.0,) * 5)
    with pytest.raises(ValidationError, match="shelves"):
        BaseCabinet(height=0.5, shelves=4)


def test_pulls_of_deep_drawer_fronts_are_high_and_rings_of_upper_doors_clear_of_their_lower_edge() -> None:
    """A hand on a wheeled base does not get much lower than 0.3 m; at a ring it is 0.1 m high, over a refrigerator."""
    pulls = [HandleKind.BAR, HandleKind.CUP, HandleKind.RING, HandleKind.KNOB]
    for front, handle in product([FrontKind.SLAB, FrontKind.SHAKER], pulls):
        look = CabinetLook(front=front, handle=handle)
        stack, island = made("drawer_stack", DrawerStack(look=look)), made("island_base", IslandBase(look=look))
        for asset, link in ((stack, "drawer0"), (island, "c0_drawer0")):
            assert height_of(asset, link, f"{link}_handle") > 0.33
    params = WallCabinet(look=CabinetLook(front=FrontKind.RAISED, handle=HandleKind.RING))
    door = made("wall_cabinet", params).link("door")
    assert min(float(c.pose.position[2]) for c in door.colliders if "handle" in c.name) >= 0.05


def test_fronts_fill_their_size_and_are_closed() -> None:
    for groove, kind in product([None, *FrontEdge], FrontKind):
        for drawer, height in ((False, 0.72), (True, 0.14), (False, 2.1)):
            parts = fronts.front_parts(kind, 0.4, height, drawer=drawer, groove=groove)
            assert all(p.solid.volume > 0 for p in parts)
            size = np.ptp(np.concatenate([p.solid.points for p in parts]), axis=0)
            np.testing.assert_allclose(size, (0.4, fronts.FRONT_THICKNESS, height), atol=1e-6)
        assert (kind in fronts.GLAZED_KINDS) == any(p.pane for p in fronts.front_parts(kind, 0.4, 0.72)), kind


def test_handles_stand_on_the_face_and_fit_a_gripper() -> None:
    for kind in [k for k in HandleKind if k is not HandleKind.FINGER_GROOVE]:
        length = handles.handle_length(kind, 0.16)
        pull = handles.edge_pull(length) if kind is HandleKind.EDGE_PULL else handles.handle(kind, length)
        solids = (*pull.metal, *pull.leather)
        assert all(s.volume > 0 for s in solids)
        cloud = np.concatenate([s.points for s in solids])
        assert cloud[:, 1].max() >= -1e-6
        assert -0.06 < cloud[:, 1].min() < -0.02
        shape = pull.shapes[0][0]
        assert isinstance(shape, Box | Capsule)
        touched = np.array([shape_bounds(*placed) for placed in pull.shapes])
        low, high = touched[:, 0].min(axis=0), touched[:, 1].max(axis=0)
        assert (high - low <= np.ptp(cloud, axis=0) + 0.0015).all(), kind
        assert 0.002 < (min(shape.size) if isinstance(shape, Box) else 2 * shape.radius) <= 0.08


# What cooks -----------------------------------------------------------------------------------------------------------


@pytest.mark.content("family", "hob", keep=2)
@pytest.mark.parametrize(
    "name", ["gas_five", "gas_four_side", "gas_six_pro", "gas_black_glass", "coil_steel", "ceramic_framed"]
)
def test_a_small_pan_stands_level_on_every_burner(name: str, tmp_path: Path) -> None:
    """A pan of 14 cm put down at each place site comes to rest there, upright."""
    asset = preset("hob", name)
    spec = spec_of(asset, tmp_path)
    places = [s for s in asset.sites if s.name.endswith("_place_site")]
    for site in places:
        x, y, z = site.pose.position
        body = spec.worldbody.add_body(name=f"pan_{site.name}", pos=[x, y, z + 0.021])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.07, 0.02, 0.0], mass=0.8)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=int(0.6 / model.opt.timestep))
    for site in places:
        pan = data.body(f"pan_{site.name}")
        tilt = np.degrees(np.arccos(np.clip(pan.xmat.reshape(3, 3)[2, 2], -1, 1)))
        assert tilt < 0.5, site.name
        assert abs(float(pan.xpos[2]) - 0.02 - site.pose.position[2]) < 0.0015, site.name


@pytest.mark.content("family", "microwave", keep=0)
def test_every_microwave_has_its_keys_and_handle() -> None:
    for stand, pull, controls in product(MicrowaveMounting, MicrowaveHandle, MicrowaveControls):
        asset = made("microwave", Microwave(stand=stand, pull=pull, controls=controls))
        holds("microwave", asset)
        turned = [j.name for j in asset.joints if j.name.startswith("knob_")]
        assert len(turned) == (2 if controls is MicrowaveControls.KNOBS else 0)


@pytest.mark.content("family", "toaster_oven", keep=1)
@pytest.mark.parametrize(("place", "tray"), list(product(PanelPlace, (False, True))))
def test_a_toaster_oven_has_a_rack_or_a_tray(place: PanelPlace, tray: bool) -> None:
    asset = made("toaster_oven", ToasterOven(panel=place, tray=tray, height=0.29))
    holds("toaster_oven", asset)
    inside = "tray0" if tray else "rack0"
    assert next(j for j in asset.joints if j.name == f"{inside}_joint").behind == "door_joint"
    region = next(r for r in asset.regions if r.name == inside)
    assert region.link == inside
    assert region.size[2] > 0.04


@pytest.mark.content("family", "toaster_oven", keep=1)
@pytest.mark.parametrize(("grip", "height"), list(product(OvenHandle, (0.21, 0.34))))
def test_an_open_toaster_oven_is_clear_of_what_it_stands_on(grip: OvenHandle, height: float, tmp_path: Path) -> None:
    asset = made("toaster_oven", ToasterOven(grip=grip, height=height))
    holds("toaster_oven", asset)
    spec = spec_of(asset, tmp_path)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1.0, 1.0, 0.1], pos=[0.0, 0.0, -0.001])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.joint("door_joint").qpos = max(next(j for j in asset.joints if j.name == "door_joint").range, key=abs)
    mujoco.mj_forward(model, data)
    assert not [c for c in data.contact if int(model.body_geomadr[0]) in c.geom]


@pytest.mark.content("family", "range", keep=0)
def test_the_handle_of_a_drawer_under_an_oven_is_at_its_upper_edge_and_stands_out() -> None:
    for name in family("range").presets:
        asset = preset("range", name)
        for drawer in [link for link in asset.links if link.name == "drawer"]:
            (low, high), (face, _) = (
                shape_bounds(c.shape, asset.asset_from_link("drawer") @ c.pose)
                for part in ("drawer_handle_main", "drawer_front")
                for c in drawer.colliders
                if c.name == part
            )
            assert 0.22 <= low[2] < high[2] <= 0.3
            assert face[1] - low[1] >= 0.03


def test_a_wide_range_has_two_ovens() -> None:
    narrow, wide = (made("range", Range(width=w, burners=6)) for w in (0.91, DOUBLE_OVEN_WIDTH + 0.1))
    assert [j.name for j in narrow.joints if "door" in j.name] == ["door_joint"]
    assert [j.name for j in wide.joints if "door" in j.name] == ["door_joint", "right_door_joint"]
    behind = [str(j.behind) for j in wide.joints if j.name.startswith("rack")]
    assert sorted(behind) == ["door_joint"] * 2 + ["right_door_joint"] * 2


def test_the_pane_of_a_higher_hood_is_no_higher() -> None:
    """A hood that hangs under a high ceiling has a longer chimney, and its pane stays below the cornices beside it."""
    usual = family("hood").presets["slanted"]
    ends = [
        max(float(v.mesh.vertices[:, 2].max()) for v in made("hood", p).root.visuals if v.material == "glass_black")
        for p in (usual, usual.replace(height=1.2))
    ]
    assert ends[0] == ends[1] > 0.3


def test_the_pointer_of_a_knob_follows_the_scale_that_is_printed_round_it() -> None:
    """Of two ticks a quarter turn apart, half of its way is in the middle."""
    builder = AssetBuilder(supplies(family("range"), Range()))
    finishes = ("plastic_black", "steel_galvanised", "plastic_white")
    add_knob_with_scale(builder, "knob", (0.1, 0.0, 0.2), (KnobStyle.SKIRT, 0.02), finishes, np.pi / 2, steps=2)
    asset = assemble(builder, "range", Range())
    (joint,), (scale,) = asset.joints, (v for v in asset.root.visuals if v.label == "print")
    (pointer,) = (v for v in asset.link("knob").visuals if v.material == "plastic_red")
    half = Rotation.from_rotvec(np.array(joint.axis) * joint.range[1] / 2).as_matrix()
    points = pointer.mesh.vertices @ half.T, scale.mesh.vertices - asset.asset_from_link("knob").position
    shown, printed = (p.mean(axis=0)[[0, 2]] for p in points)
    assert shown @ printed / np.linalg.norm(shown) / np.linalg.norm(printed) > 0.99


@pytest.mark.content("family", "kettle", keep=0)
def test_a_kettle_is_hollow_as_wide_as_its_mouth() -> None:
    for name in ("jug_steel", "retro_cream", "glass"):
        asset = preset("kettle", name)
        lid = next(c.shape for c in asset.link("lid").colliders if c.name == "lid_main")
        assert isinstance(lid, Cylinder)
        inside = next(r for r in asset.regions if r.name == "int")
        assert 0.9 < inside.size[0] / (2 * lid.radius) < 1.0, name


# What is worked by hand -----------------------------------------------------------------------------------------------


@pytest.mark.content("family", "sink", keep=0)
def test_water_is_cold_until_the_left_lever_is_turned_to_the_cook(tmp_path: Path) -> None:
    model = spec_of(preset("sink", "steel_single"), tmp_path).compile()
    data, behaviors = mujoco.MjData(model), casa.Behaviors(model)
    assert behaviors.reset(data)["object"]["temperature"] == "cold"
    for angle, towards_cook, water in ((0.6, True, "hot"), (-0.6, False, "cold")):
        joint = data.joint("handle_temp_joint")
        joint.qpos = angle
        mujoco.mj_forward(model, data)
        assert bool(data.geom("handle_temp_main").xpos[1] < joint.xanchor[1]) is towards_cook
        data.time += 0.1
        assert behaviors.update(data)["object"]["temperature"] == water


@pytest.mark.content("family", "door", keep=0)
@pytest.mark.parametrize("name", ["four_panel", "french"])
def test_a_lever_of_a_door_comes_back_to_level(name: str, tmp_path: Path) -> None:
    asset = preset("door", name)
    model = spec_of(asset, tmp_path).compile()
    data = mujoco.MjData(model)
    levers = [j for j in asset.joints if "lever" in j.name]
    for lever in levers:
        data.joint(lever.name).qpos = max(lever.range, key=abs)
    mujoco.mj_step(model, data, nstep=int(1.0 / model.opt.timestep))
    assert levers
    assert [data.joint(lever.name).qpos[0] for lever in levers] == pytest.approx([0.0] * len(levers), abs=0.02)


# What is put out and hung up ------------------------------------------------------------------------------------------


def test_a_dish_rack_has_room_for_a_bowl_and_holds_the_plates_it_is_given() -> None:
    for form, plates in [*((form, 0) for form in DishRackForm), (DishRackForm.BASKET, 3)]:
        asset = made("dish_rack", DishRack(form=form, cup=plates > 0, plates=plates))
        assert sum(c.name.startswith("plate_") for c in asset.root.colliders) == plates
        room = next(r for r in asset.regions if r.name == "int_dishes")
        assert plates or (min(room.size[:2]) >= 0.09 and room.size[2] > 0.0999)


def test_a_vase_of_wood_weighs_less_than_one_of_ceramic() -> None:
    mass = {clay: made("vase", Vase(bunch=Bouquet.NONE, clay=clay)).mass for clay in ("oak_natural", "ceramic_white")}
    assert mass["oak_natural"] < 0.5 * mass["ceramic_white"]


def test_tools_hang_apart_in_front_of_the_wall() -> None:
    for rail in wall_racks.RailStyle:
        asset = made("utensil_rack", wall_racks.UtensilRack(rail=rail, tools=8, length=0.9))
        shafts = np.array([c.pose.position for c in asset.root.colliders if c.name.endswith("_shaft")])
        assert len(shafts) == 8
        assert np.diff(np.sort(shafts[:, 0])).min() > 0.08
        assert shafts[:, 1].max() < float(asset.bounds[1][1]) - 0.02


def test_a_leaning_board_stands_up_and_a_spice_rack_carries_two_tiers() -> None:
    lying, leaning = (made("cutting_board", boards.CuttingBoard(leaning=value)) for value in (False, True))
    assert np.ptp(lying.bounds, axis=0)[2] < 0.03 < 0.2 < np.ptp(leaning.bounds, axis=0)[2]
    for form in wall_racks.SpiceRackForm:
        asset = made("spice_rack", wall_racks.SpiceRack(form=form, columns=4))
        heights = [c.pose.position[2] for c in asset.root.colliders if c.name.startswith("jar_")]
        assert len(heights) == (10 if form is wall_racks.SpiceRackForm.CAROUSEL else 8)
        assert np.ptp(heights) > 0.015
