"""USD layers: what is written is what the asset says; the nested layer has a body below the one that carries it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.formats.usd import document
from casa_assets.formats.usd.document import axis_and_rotation, float32_moments, principal_axes
from casa_assets.formats.usd.kitchen import write
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose
from tests.support.asset.assets import drawer_unit, microwave, rigid_mug, textured_box
from tests.support.asset.packages import stage_of, written
from tests.support.kitchen.scenes import corner, put

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


def prim_of(stage: Usd.Stage, path: str) -> Usd.Prim:
    prim = stage.GetDefaultPrim().GetPrimAtPath(path)
    assert prim, path
    return prim


class TestStage:
    def test_units_and_model(self) -> None:
        asset = rigid_mug()
        stage = stage_of(asset)
        root = stage.GetDefaultPrim()
        assert UsdGeom.GetStageUpAxis(stage) == "Z"
        assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
        assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
        assert root.GetName() == asset.id
        assert Usd.ModelAPI(root).GetKind() == "component"
        assert UsdGeom.Xformable(root).GetOrderedXformOps() == []


class TestBody:
    def test_articulation_root_is_the_base_body_wherever_a_joint_is(self, subtests: pytest.Subtests) -> None:
        for asset, roots in [
            (microwave(Base.FIXED), ["object"]),
            (microwave(Base.FREE), ["object"]),
            (rigid_mug().replace(base=Base.FIXED), ["object"]),
            (rigid_mug(), []),
        ]:
            with subtests.test(asset=asset.id, roots=roots):
                prims = stage_of(asset).Traverse()
                assert [p.GetName() for p in prims if p.HasAPI(UsdPhysics.ArticulationRootAPI)] == roots
                assert any(p.IsA(UsdPhysics.Joint) for p in prims) == bool(roots)

    @given(
        quaternion=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 0.01),
        moments=st.tuples(st.floats(1e-6, 1.0), st.floats(1e-6, 1.0)),
    )
    def test_principal_axes_rebuild_the_tensor(
        self, quaternion: tuple[float, float, float, float], moments: tuple[float, float]
    ) -> None:
        rotation = Pose(quaternion=quaternion).rotation
        tensor = rotation @ np.diag([*moments, sum(moments)]) @ rotation.T
        values, axes = principal_axes(tensor)
        rebuilt = axes.rotation @ np.diag(values) @ axes.rotation.T
        assert np.abs(rebuilt - tensor).max() <= 1e-12 * np.trace(tensor)
        a, b, c = sorted(float32_moments(values))
        assert a + b >= c
        assert np.abs(np.array(float32_moments(values)) - values).max() <= 2e-7 * c


class TestColliders:
    def test_they_are_guides_with_friction_for_every_reader(self) -> None:
        for prim in stage_of(rigid_mug()).Traverse():
            if not prim.HasAPI(UsdPhysics.CollisionAPI):
                continue
            assert UsdGeom.Imageable(prim).GetPurposeAttr().Get() == "guide"
            for purpose in ("", "physics"):
                material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)
                physics = UsdPhysics.MaterialAPI(material.GetPrim())
                assert physics.GetDynamicFrictionAttr().Get() == pytest.approx(0.45)
                assert physics.GetStaticFrictionAttr().Get() == pytest.approx(0.6)
                assert not physics.GetRestitutionAttr().HasAuthoredValue()


class TestVisuals:
    def test_mesh_is_written_as_it_is(self) -> None:
        mesh = textured_box().root.visuals[0].mesh
        prim = UsdGeom.Mesh(prim_of(stage_of(textured_box()), "object/visual/carton"))
        assert mesh.normals is not None
        assert mesh.uv is not None
        assert np.array(prim.GetPointsAttr().Get()) == pytest.approx(mesh.vertices, abs=1e-7)
        assert np.array(prim.GetFaceVertexIndicesAttr().Get()).tolist() == mesh.faces.ravel().tolist()
        assert np.array(prim.GetNormalsAttr().Get()) == pytest.approx(mesh.normals)
        st_ = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        assert np.array(st_.Get()) == pytest.approx(mesh.uv)
        assert prim.GetSubdivisionSchemeAttr().Get() == "none"

    def test_textures_feed_the_surface(self) -> None:
        asset = textured_box()
        stage = stage_of(asset)
        surface = UsdShade.Shader(prim_of(stage, "visualMaterials/print/surface"))
        fed = {}
        for name in ("diffuseColor", "metallic", "roughness", "normal"):
            (source,), _ = surface.GetInput(name).GetConnectedSources()
            node = UsdShade.Shader(source.source.GetPrim())
            path = node.GetInput("file").Get().path
            fed[name] = (source.sourceName, path, node.GetInput("sourceColorSpace").Get())
        color, rough, bumps = (f"./textures/{t.file_name}" for t in asset.materials[0].textures)
        assert fed == {
            "diffuseColor": ("rgb", color, "sRGB"),
            "metallic": ("b", rough, "raw"),
            "roughness": ("g", rough, "raw"),
            "normal": ("rgb", bumps, "raw"),
        }


class TestJoints:
    @given(direction=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.01))
    def test_any_axis(self, direction: tuple[float, float, float]) -> None:
        x, y, z = (n / math.hypot(*direction) for n in direction)
        token, rotation = axis_and_rotation((x, y, z))
        assert Pose(quaternion=rotation).rotation @ np.array(AXES[token]) == pytest.approx((x, y, z), abs=1e-9)


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
