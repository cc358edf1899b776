"""What cooks keeps clear of itself and carries a pan level; knobs, figures and signs; forms of microwaves and ovens."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import mujoco
import numpy as np
import pytest

from casa_assets.kitchenware.fixtures.cookers import DOUBLE_OVEN_WIDTH, Range
from casa_assets.kitchenware.fixtures.microwave import Microwave, MicrowaveControls, MicrowaveHandle, MicrowaveMounting
from casa_assets.kitchenware.fixtures.toasters import PanelPlace, ToasterOven
from casa_assets.kitchenware.parts.oven import OvenHandle
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.registry.families import family
from tests.support.asset.family_members import made, preset, spec_of
from tests.unit.families.test_members import holds

pytestmark = pytest.mark.content("code", "families", keep=0)


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(
    ("family", "name"),
    [
        ("range", "slide_in_gas"),
        ("range", "cooker_double_sage"),
        ("wall_oven", "double"),
        ("microwave", "built_in_white"),
        ("microwave", "retro_cream"),
        ("toaster_oven", "mint"),
        ("toaster_oven", "pro_four_knobs"),
        ("hood", "slanted"),
    ],
)
def test_parts_clear_each_other_on_their_way(family: str, name: str, tmp_path: Path) -> None:
    """Every joint alone, with what has to be open before it, without the exclusion of neighbours."""
    asset = preset(family, name)
    spec = spec_of(asset, tmp_path)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    model = spec.compile()
    data = mujoco.MjData(model)
    address = {j.name: int(model.joint(j.name).qposadr[0]) for j in asset.joints}
    far = {j.name: max(j.range, key=abs) for j in asset.joints}
    for joint in asset.joints:
        for share in np.linspace(0.0, 1.0, 9):
            data.qpos[:] = model.qpos0
            if joint.behind:
                data.qpos[address[joint.behind]] = far[joint.behind]
            data.qpos[address[joint.name]] = share * far[joint.name]
            mujoco.mj_forward(model, data)
            depth = max([0.0, *(-float(c.dist) for c in data.contact)])
            assert depth < 0.0005, f"{joint.name} at {share:.0%}"


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
def test_every_microwave_has_its_keys_and_handle(subtests: pytest.Subtests) -> None:
    for stand, pull, controls in list(product(MicrowaveMounting, MicrowaveHandle, MicrowaveControls)):
        with subtests.test(stand=stand, pull=pull, controls=controls):
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
    joint = next(j for j in asset.joints if j.name == f"{inside}_joint")
    assert joint.behind == "door_joint"
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
    plane = int(model.body_geomadr[0])
    assert not [c for c in data.contact if plane in c.geom]


@pytest.mark.content("family", "range", keep=0)
def test_the_handle_of_a_drawer_under_an_oven_is_at_its_upper_edge_and_stands_out(subtests: pytest.Subtests) -> None:
    for name in family("range").presets:
        with subtests.test(name=name):
            asset = preset("range", name)
            drawers = [link for link in asset.links if link.name == "drawer"]
            for drawer in drawers:
                handle = next(c for c in drawer.colliders if c.name == "drawer_handle_main")
                front = next(c for c in drawer.colliders if c.name == "drawer_front")
                low, high = shape_bounds(handle.shape, asset.asset_from_link("drawer") @ handle.pose)
                face = shape_bounds(front.shape, asset.asset_from_link("drawer") @ front.pose)[0, 1]
                assert 0.22 <= low[2] < high[2] <= 0.3
                assert face - low[1] >= 0.03


def test_a_wide_range_has_two_ovens() -> None:
    narrow, wide = (made("range", Range(width=w, burners=6)) for w in (0.91, DOUBLE_OVEN_WIDTH + 0.1))
    assert [j.name for j in narrow.joints if "door" in j.name] == ["door_joint"]
    assert [j.name for j in wide.joints if "door" in j.name] == ["door_joint", "right_door_joint"]
    behind = {j.name: j.behind for j in wide.joints if j.name.startswith("rack")}
    assert sorted(str(b) for b in behind.values()) == ["door_joint"] * 2 + ["right_door_joint"] * 2


def test_the_pane_of_a_higher_hood_is_no_higher() -> None:
    """A hood that hangs under a high ceiling has a longer chimney, and its pane stays below the cornices beside it."""
    usual = family("hood").presets["slanted"]
    ends = [
        max(float(v.mesh.vertices[:, 2].max()) for v in made("hood", p).root.visuals if v.material == "glass_black")
        for p in (usual, usual.replace(height=1.2))
    ]
    assert ends[0] == ends[1] > 0.3
