"""The nested layer: a body below the one that carries it, and everything that names it names it there."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf, Usd, UsdPhysics

from casa_assets.formats.usd import document
from casa_assets.formats.usd.kitchen import write
from tests.support.asset.articulated_assets import drawer_unit
from tests.support.asset.packages import written
from tests.support.kitchen.scenes import corner, put


def test_bodies_lie_below_those_that_carry_them(tmp_path: Path) -> None:
    package = written(drawer_unit(), tmp_path)
    stage = Usd.Stage.Open(str(package.usd_files[1]))
    root = stage.GetDefaultPrim().GetPath()
    bodies = {str(p.GetPath().MakeRelativePath(root)) for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    assert bodies == {"object", "object/drawer", "object/drawer/knob"}
    for joint in (UsdPhysics.Joint(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Joint)):
        for end in (*joint.GetBody0Rel().GetTargets(), *joint.GetBody1Rel().GetTargets()):
            assert stage.GetPrimAtPath(end), f"{joint.GetPath()} names {end}, which is not there"


def test_each_placement_of_a_scene_is_nested(tmp_path: Path) -> None:
    folder = put(write(corner()), tmp_path, corner())
    layer = Sdf.Layer.FindOrOpen(str(folder / "scene_nested.usda"))
    assert len(layer.relocates) == sum(len(corner().asset_of[p.name].links) - 1 for p in corner().placements)
    stage = Usd.Stage.Open(layer)
    for place in corner().placements:
        asset, root = corner().asset_of[place.name], Sdf.Path(f"/World/{place.name}")
        for link in asset.links:
            path = document.nested_path(root, asset, link.name)
            assert stage.GetPrimAtPath(path).HasAPI(UsdPhysics.RigidBodyAPI), path
