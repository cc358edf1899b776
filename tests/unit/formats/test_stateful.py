"""What a stateful fixture has beyond a rigid thing, in both formats: labels, glow, places, named poses, behaviour."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from lxml import etree
from pxr import Usd

from casa_assets.formats.mjcf import write
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.packages import stage_of


def xml(asset: Asset, file: str = "model.xml") -> etree._Element:
    return etree.fromstring(write(asset).entries[file])


def one(root: etree._Element, path: str) -> dict[str, str]:
    (found,) = root.findall(path)
    return {str(name): str(value) for name, value in found.attrib.items()}


def prim_of(asset: Asset, path: str) -> Usd.Prim:
    prim = stage_of(asset).GetDefaultPrim().GetPrimAtPath(path)
    assert prim, path
    return prim


class TestMjcfPoses:
    def test_a_free_base_comes_first_in_the_scene(self) -> None:
        loose = grill().replace(base=Base.FREE, contract=None, behavior=None)
        keys = {e.get("name"): e.get("qpos") for e in xml(loose, "scene.xml").findall("keyframe/key")}
        assert keys["open"] == "0 0 0 1 0 0 0 -1.3 0.15 0"
        assert one(xml(loose), "keyframe/key[@name='open']")["qpos"] == "-1.3 0.15 0"


class TestMjcfPlaces:
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


class TestUsdPoses:
    def test_closed_is_there_even_where_nobody_says_it(self) -> None:
        asset = grill()
        fewer = asset.replace(keyframes=asset.keyframes[1:])
        variants = prim_of(fewer, "object").GetParent().GetVariantSet("pose")
        assert variants.GetVariantNames() == ["closed", "on", "open"]
        assert variants.GetVariantSelection() == "closed"

    def test_a_root_that_is_not_at_the_origin_stays_there(self) -> None:
        asset = grill()
        root = asset.root.replace(pose=Pose(position=(0.1, 0.0, 0.2)))
        raised = asset.replace(links=(root, *asset.links[1:]))
        assert list(prim_of(raised, "object").GetAttribute("xformOp:translate").Get()) == [0.1, 0.0, 0.2]
        assert list(prim_of(raised, "rack").GetAttribute("xformOp:translate").Get()) == pytest.approx([0.06, 0.0, 0.3])


def _position(asset: Asset, site: str) -> np.ndarray:
    return np.array([float(n) for n in one(xml(asset), f".//site[@name='{site}']")["pos"].split()])
