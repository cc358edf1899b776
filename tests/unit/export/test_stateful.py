"""What a stateful fixture has beyond a rigid thing, in both formats: labels, glow, places, named poses, behaviour."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache

import mujoco
import numpy as np
import pytest
from lxml import etree
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade

from casa_assets.core.numeric import srgb_from_linear
from casa_assets.export.mjcf import write
from casa_assets.export.usd import document
from casa_assets.model.asset.asset import Asset, Base, Region
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.pose import Pose
from tests.articulated_assets import grill
from tests.assets import drawer_unit, microwave, rigid_mug


def xml(asset: Asset, file: str = "model.xml") -> etree._Element:
    return etree.fromstring(write(asset).entries[file])


def texts(asset: Asset) -> dict[str, str]:
    return {str(e.get("name")): str(e.get("data")) for e in xml(asset).findall("custom/text")}


def one(root: etree._Element, path: str) -> dict[str, str]:
    (found,) = root.findall(path)
    return {str(name): str(value) for name, value in found.attrib.items()}


@cache  # also keeps the stage alive, without which its prims expire
def stage_of(asset: Asset) -> Usd.Stage:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(document.layer_text(asset))
    return Usd.Stage.Open(layer)


def prim_of(asset: Asset, path: str) -> Usd.Prim:
    prim = stage_of(asset).GetDefaultPrim().GetPrimAtPath(path)
    assert prim, path
    return prim


class TestMjcfTexts:
    def test_one_text_for_each_label_names_geoms_that_there_are(self) -> None:
        found = {name: data.split() for name, data in texts(grill()).items() if name.startswith("label__")}
        assert found == {
            "label__door": ["door_0", "door_main"],
            "label__handle": ["handle_0", "handle_main"],
            "label__knob": ["knob_0", "knob_main"],
            "label__lamp": ["lamp_main"],
            "label__rack": ["rack_0", "rack_main"],
        }
        assert list(found) == sorted(found)
        geoms = {str(e.get("name")) for e in xml(grill()).iter("geom")}
        assert {name for names in found.values() for name in names} <= geoms

    def test_grips_contract_and_what_is_behind(self) -> None:
        found = texts(grill())
        assert found["grip__microjoint"] == "handle_0"
        assert found["behind__rack_joint"] == "microjoint"
        assert found["contract"] == "microwave"

    def test_behavior_is_read_back_as_the_same(self) -> None:
        assert Behavior.from_json(texts(grill())["behavior"]) == grill().behavior

    def test_mujoco_keeps_every_text(self) -> None:
        files = {path: data for path, data in write(grill()).entries.items() if path.endswith(".obj")}
        model = mujoco.MjModel.from_xml_string(write(grill()).entries["model.xml"].decode(), assets=files)
        names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, i) for i in range(model.ntext)]
        assert set(names) == set(texts(grill()))

    def test_nothing_new_where_there_is_nothing(self) -> None:
        assert sorted(texts(rigid_mug())) == ["base", "class", "qcode"]
        assert xml(drawer_unit()).findall("keyframe") == []
        assert b"emission" not in write(microwave()).entries["model.xml"]
        assert [e for e in write(microwave()).entries if e.endswith(".json")] == []


class TestMjcfPoses:
    def test_positions_are_in_the_order_of_the_document(self) -> None:
        root = xml(grill())
        joints = [e.get("name") for e in root.iter("joint")]
        assert joints == ["microjoint", "rack_joint", "knob_joint"]
        keys = {e.get("name"): e.get("qpos") for e in root.findall("keyframe/key")}
        assert keys == {"closed": "0 0 0", "on": "0 0 1.2", "open": "-1.3 0.15 0"}

    def test_a_free_base_comes_first_in_the_scene(self) -> None:
        loose = grill().replace(base=Base.FREE, contract=None, behavior=None)
        keys = {e.get("name"): e.get("qpos") for e in xml(loose, "scene.xml").findall("keyframe/key")}
        assert keys["open"] == "0 0 0 1 0 0 0 -1.3 0.15 0"
        assert one(xml(loose), "keyframe/key[@name='open']")["qpos"] == "-1.3 0.15 0"


class TestMjcfPlaces:
    def test_sizes_are_halved_and_colors_are_those_of_a_display(self) -> None:
        assert one(xml(grill()), ".//site[@name='plate_place']")["size"] == "0.01"
        glow = one(xml(grill()), ".//site[@name='heat_glow']")
        assert (glow["type"], glow["size"]) == ("cylinder", "0.15 0.01")
        shown = [float(n) for n in glow["rgba"].split()]
        assert shown == pytest.approx([1.0, srgb_from_linear(0.2), srgb_from_linear(0.05), 0.0], abs=1e-8)
        box = one(xml(grill()), ".//body[@name='knob']/site[@name='display']")
        assert (box["type"], box["size"]) == ("box", "0.01 0.02 0.0005")

    def test_what_a_runtime_shows_is_in_a_group_that_cameras_see(self) -> None:
        seen = mujoco.MjvOption().sitegroup
        for name, path, shown in (("heat_glow", "object/sites", 1), ("plate_place", "object/sites", 0)):
            group = int(one(xml(grill()), f".//site[@name='{name}']")["group"])
            assert seen[group] == shown
            assert prim_of(grill(), f"{path}/{name}").GetAttribute("mjc:group").Get() == group

    def test_corners_span_the_region_on_its_body(self) -> None:
        asset = grill()
        for name, prefix in (("main", "ext"), ("int", "int")):
            (region,) = [r for r in asset.regions if r.name == name]
            ends = [_position(asset, f"{prefix}_{end}") for end in ("p0", "px", "py", "pz")]
            sides = np.array(ends[1:]) - ends[0]
            assert sides == pytest.approx(np.diag(region.size), abs=1e-8)
            assert ends[0] + sides.sum(axis=0) / 2 == pytest.approx(np.array(region.pose.position), abs=1e-8)

    def test_corners_of_a_link_are_in_its_body(self) -> None:
        asset = grill()
        others = tuple(r for r in asset.regions if r.name != "int")
        moved = asset.replace(regions=(*others, Region(name="int", link="door", size=(0.1, 0.1, 0.1))))
        assert len(xml(moved).findall(".//body[@name='door']/site[@name='int_px']")) == 1

    def test_corners_are_for_fixtures_with_a_contract(self) -> None:
        plain = grill().replace(contract=None)
        assert xml(plain).findall(".//site[@name='int_p0']") == []


class TestLooks:
    def test_a_lamp_glows_in_both(self) -> None:
        (lamp,) = [e for e in xml(grill()).iter("material") if str(e.get("name")).startswith("lamp_")]
        assert lamp.get("emission") == "0.7"
        shader = UsdShade.Shader(prim_of(grill(), "visualMaterials/lamp/surface"))
        assert list(shader.GetInput("emissiveColor").Get()) == pytest.approx([0.7, 0.56, 0.35])

    def test_glass_is_see_through_in_both(self) -> None:
        (glass,) = [e for e in xml(grill()).iter("material") if str(e.get("name")).startswith("glass_")]
        assert str(glass.get("rgba")).split()[3] == "0.5"
        assert UsdShade.Shader(prim_of(grill(), "visualMaterials/glass/surface")).GetInput("opacity").Get() == 0.5


class TestUsd:
    def test_parts_are_labelled(self, subtests: pytest.Subtests) -> None:
        for path in ["handle/visual/handle_main", "handle/collision/handle_0"]:
            with subtests.test(path=path):
                labels = UsdSemantics.LabelsAPI(prim_of(grill(), path), "part").GetLabelsAttr().Get()
                assert list(labels) == ["handle"]

    def test_sites_have_kind_size_and_color(self) -> None:
        rod = UsdGeom.Cylinder(prim_of(grill(), "object/sites/heat_glow"))
        assert (rod.GetRadiusAttr().Get(), rod.GetHeightAttr().Get()) == (0.15, 0.02)
        assert list(rod.GetDisplayColorAttr().Get()[0]) == pytest.approx([1.0, 0.2, 0.05])
        assert list(rod.GetDisplayOpacityAttr().Get()) == [0.0]
        box = prim_of(grill(), "knob/sites/display")
        assert box.IsA(UsdGeom.Cube)
        assert list(box.GetAttribute("xformOp:scale").Get()) == [0.02, 0.04, 0.001]
        assert UsdGeom.Imageable(box).GetPurposeAttr().Get() == "guide"

    def test_behavior_contract_and_grips(self) -> None:
        root = prim_of(grill(), "object").GetParent()
        assert Behavior.from_json(root.GetAttribute("casa:behavior").Get()) == grill().behavior
        assert root.GetAttribute("casa:contract").Get() == "microwave"
        rack = prim_of(grill(), "physicsJoints/rack_joint")
        assert (rack.GetAttribute("casa:grip").Get(), rack.GetAttribute("casa:behind").Get()) == (
            "rack_0",
            "microjoint",
        )

    def test_nothing_new_where_there_is_nothing(self) -> None:
        for asset in (rigid_mug(), microwave()):
            text = document.layer_text(asset)
            for word in ("casa:", "variantSet", "emissiveColor", "labels:part", "JointState"):
                assert word not in text


class TestUsdPoses:
    def test_there_is_a_variant_for_each_and_closed_is_selected(self) -> None:
        variants = prim_of(grill(), "object").GetParent().GetVariantSet("pose")
        assert variants.GetVariantNames() == ["closed", "on", "open"]
        assert variants.GetVariantSelection() == "closed"

    def test_closed_is_there_even_where_nobody_says_it(self) -> None:
        asset = grill()
        fewer = asset.replace(keyframes=asset.keyframes[1:])
        variants = prim_of(fewer, "object").GetParent().GetVariantSet("pose")
        assert variants.GetVariantNames() == ["closed", "on", "open"]
        assert variants.GetVariantSelection() == "closed"

    def test_joint_frames_are_the_same_in_each(self) -> None:
        frames = [
            [prim.GetAttribute(name).Get() for prim in _joints(grill(), key) for name in LOCAL]
            for key in ("closed", "on", "open")
        ]
        assert len(frames[0]) == len(LOCAL) * 5  # three that move, the handle's mount, the base
        assert frames[0] == frames[1] == frames[2]

    def test_a_root_that_is_not_at_the_origin_stays_there(self) -> None:
        asset = grill()
        root = asset.root.replace(pose=Pose(position=(0.1, 0.0, 0.2)))
        raised = asset.replace(links=(root, *asset.links[1:]))
        assert list(prim_of(raised, "object").GetAttribute("xformOp:translate").Get()) == [0.1, 0.0, 0.2]
        assert list(prim_of(raised, "rack").GetAttribute("xformOp:translate").Get()) == pytest.approx([0.06, 0.0, 0.3])

    def test_a_hinge_turns_about_its_anchor(self) -> None:
        (hinge,) = [j for j in grill().joints if j.name == "knob_joint"]
        turned = hinge.motion(0.7)
        anchor = np.array([hinge.anchor])
        along = anchor + np.array([hinge.axis])
        assert turned.apply(anchor) == pytest.approx(anchor)
        assert turned.apply(along) == pytest.approx(along)
        assert np.trace(turned.rotation) == pytest.approx(1 + 2 * np.cos(0.7))


class TestBehaviorFile:
    def test_holds_the_machine_the_states_and_the_poses(self) -> None:
        data = json.loads(write(grill()).entries["behavior.json"])
        assert Behavior.model_validate(data["behavior"]) == grill().behavior
        assert [key["name"] for key in data["keyframes"]] == ["closed", "on", "open"]
        assert [state["name"] for state in data["states"]] == ["door_open", "door_closed"]

    def test_is_the_same_a_second_time(self) -> None:
        assert write(grill()).entries == write(grill()).entries
        assert document.layer_text(grill()) == document.layer_text(grill())


LOCAL = ("physics:localPos0", "physics:localRot0", "physics:localPos1", "physics:localRot1")


def _joints(asset: Asset, key: str) -> Iterator[Usd.Prim]:
    stage = stage_of(asset)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetDefaultPrim().GetVariantSet("pose").SetVariantSelection(key)
        yield from [p for p in stage.Traverse() if p.IsA(UsdPhysics.Joint)]
        stage.GetDefaultPrim().GetVariantSet("pose").ClearVariantSelection()


def _position(asset: Asset, site: str) -> np.ndarray:
    return np.array([float(n) for n in one(xml(asset), f".//site[@name='{site}']")["pos"].split()])
