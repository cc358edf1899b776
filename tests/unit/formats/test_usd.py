"""USD of assets and scenes: what is written is what the records say; nesting, poses, lights, what can be hidden."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

from casa_assets.core.numeric import principal_axes
from casa_assets.formats.usd import document, isaac_lab
from casa_assets.formats.usd.document import axis_and_rotation, float32_moments
from casa_assets.formats.usd.kitchen import REFERENCE_M, pose_looking_along, write
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.pose import Pose
from tests.support.asset.assets import drawer_unit, microwave, rigid_mug, textured_box
from tests.support.asset.packages import stage_of, written
from tests.support.kitchen.scenes import corner, put

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
DIRECTIONS = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.01)


def prim_of(stage: Usd.Stage, path: str) -> Usd.Prim:
    prim = stage.GetDefaultPrim().GetPrimAtPath(path)
    assert prim, path
    return prim


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return put(write(corner()), tmp_path_factory.mktemp("usd"), corner())


@pytest.fixture
def scene(folder: Path) -> Usd.Stage:
    """A stage with a session of its own: no test sees what another selects. Prims expire without it."""
    return Usd.Stage.Open(Sdf.Layer.FindOrOpen(str(folder / "scene.usda")), Sdf.Layer.CreateAnonymous())


def select(stage: Usd.Stage, variants: str, option: str) -> None:
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetDefaultPrim().GetVariantSet(variants).SetVariantSelection(option)


def test_units_and_model() -> None:
    asset, stage = rigid_mug(), stage_of(rigid_mug())
    root = stage.GetDefaultPrim()
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 1.0)
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
    assert (root.GetName(), Usd.ModelAPI(root).GetKind()) == (asset.id, "component")
    assert UsdGeom.Xformable(root).GetOrderedXformOps() == []


def test_articulation_root_is_the_base_body_wherever_a_joint_is(scene: Usd.Stage) -> None:
    for asset, roots in [
        (microwave(Base.FIXED), ["object"]),
        (microwave(Base.FREE), ["object"]),
        (rigid_mug().replace(base=Base.FIXED), ["object"]),
        (rigid_mug(), []),
    ]:
        prims = stage_of(asset).Traverse()
        assert [p.GetName() for p in prims if p.HasAPI(UsdPhysics.ArticulationRootAPI)] == roots, asset.id
        assert any(p.IsA(UsdPhysics.Joint) for p in prims) == bool(roots), asset.id
    prims = list(scene.Traverse())
    bodies = [p.GetPath() for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert sum(p.HasAPI(UsdPhysics.ArticulationRootAPI) for p in prims) == 6
    assert not any(a != b and b.HasPrefix(a) for a in bodies for b in bodies)
    assert not any(p.IsInstance() for p in prims)


@given(
    quaternion=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 0.01),
    moments=st.tuples(st.floats(1e-6, 1.0), st.floats(1e-6, 1.0)),
)
def test_principal_axes_rebuild_the_tensor(
    quaternion: tuple[float, float, float, float], moments: tuple[float, float]
) -> None:
    rotation = Pose(quaternion=quaternion).rotation
    tensor = rotation @ np.diag([*moments, sum(moments)]) @ rotation.T
    values, axes = principal_axes(tensor)
    rebuilt = axes @ np.diag(values) @ axes.T
    assert np.abs(rebuilt - tensor).max() <= 1e-12 * np.trace(tensor)
    a, b, c = sorted(float32_moments(values))
    assert a + b >= c
    assert np.abs(np.array(float32_moments(values)) - values).max() <= 2e-7 * c


def test_colliders_are_guides_with_friction_for_every_reader() -> None:
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


def test_a_mesh_is_written_as_it_is_and_textures_feed_its_surface() -> None:
    asset, stage = textured_box(), stage_of(textured_box())
    mesh, prim = asset.root.visuals[0].mesh, UsdGeom.Mesh(prim_of(stage, "object/visual/carton"))
    assert np.array(prim.GetPointsAttr().Get()) == pytest.approx(mesh.vertices, abs=1e-7)
    assert np.array(prim.GetFaceVertexIndicesAttr().Get()).tolist() == mesh.faces.ravel().tolist()
    assert np.array(prim.GetNormalsAttr().Get()) == pytest.approx(np.array(mesh.normals))
    assert np.array(UsdGeom.PrimvarsAPI(prim).GetPrimvar("st").Get()) == pytest.approx(np.array(mesh.uv))
    assert prim.GetSubdivisionSchemeAttr().Get() == "none"
    surface = UsdShade.Shader(prim_of(stage, "visualMaterials/print/surface"))
    fed = {}
    for name in ("diffuseColor", "metallic", "roughness", "normal"):
        (source,), _ = surface.GetInput(name).GetConnectedSources()
        node = UsdShade.Shader(source.source.GetPrim())
        fed[name] = (source.sourceName, node.GetInput("file").Get().path, node.GetInput("sourceColorSpace").Get())
    color, rough, bumps = (f"./textures/{t.file_name}" for t in asset.materials[0].textures)
    assert fed == {
        "diffuseColor": ("rgb", color, "sRGB"),
        "metallic": ("b", rough, "raw"),
        "roughness": ("g", rough, "raw"),
        "normal": ("rgb", bumps, "raw"),
    }


@given(direction=DIRECTIONS)
@example(direction=(0.0, 0.0, 2.0))
@example(direction=(0.0, 0.0, -2.0))
def test_any_direction_of_a_joint_and_of_a_light(direction: tuple[float, float, float]) -> None:
    x, y, z = (n / math.hypot(*direction) for n in direction)
    token, rotation = axis_and_rotation((x, y, z))
    assert Pose(quaternion=rotation).rotation @ np.array(AXES[token]) == pytest.approx((x, y, z), abs=1e-9)
    assert -pose_looking_along(direction).rotation[:, 2] == pytest.approx((x, y, z), abs=1e-5)


def test_bodies_lie_below_those_that_carry_them(folder: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(written(drawer_unit(), tmp_path).usd_files[1]))
    root = stage.GetDefaultPrim().GetPath()
    bodies = {str(p.GetPath().MakeRelativePath(root)) for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    assert bodies == {"object", "object/drawer", "object/drawer/knob"}
    for joint in (UsdPhysics.Joint(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Joint)):
        for end in (*joint.GetBody0Rel().GetTargets(), *joint.GetBody1Rel().GetTargets()):
            assert stage.GetPrimAtPath(end), f"{joint.GetPath()} names {end}, which is not there"
    layer = Sdf.Layer.FindOrOpen(str(folder / "scene_nested.usda"))
    assert len(layer.relocates) == sum(len(corner().asset_of[p.name].links) - 1 for p in corner().placements)
    stage = Usd.Stage.Open(layer)
    for place in corner().placements:
        asset = corner().asset_of[place.name]
        for link in asset.links:
            path = document.nested_path(Sdf.Path(f"/World/{place.name}"), asset, link.name)
            assert stage.GetPrimAtPath(path).HasAPI(UsdPhysics.RigidBodyAPI), path


@pytest.mark.parametrize(
    ("key", "joint", "degrees"),
    [
        ("start", "oven/physicsJoints/microjoint", math.degrees(-1.0)),
        ("start", "grill/physicsJoints/knob_joint", math.degrees(2.0)),
        ("start", "other_grill/physicsJoints/knob_joint", 0.0),
        ("closed", "grill/physicsJoints/microjoint", 0.0),
        ("open", "grill/physicsJoints/microjoint", math.degrees(-1.3)),
    ],
)
def test_joints_say_where_they_are(key: str, joint: str, degrees: float, scene: Usd.Stage) -> None:
    select(scene, "pose", key)
    prim = scene.GetPrimAtPath(f"/World/{joint}")
    assert prim.GetAttribute("state:angular:physics:position").Get() == pytest.approx(degrees, abs=1e-4)
    assert "PhysicsJointStateAPI:angular" in prim.GetMetadata("apiSchemas").GetAppliedItems()


def test_room_and_ceiling_can_be_hidden(folder: Path) -> None:
    for name, layer in (("wall", "room"), ("ceiling", "ceiling")):
        stage = Usd.Stage.Open(str(folder / "scene.usda"))
        shape = UsdGeom.Imageable(stage.GetPrimAtPath(f"/World/{name}/object/visual/carton"))
        assert shape.ComputeVisibility() == "inherited"
        select(stage, layer, "hidden")
        assert shape.ComputeVisibility() == "invisible"
        mug = UsdGeom.Imageable(stage.GetPrimAtPath("/World/mug/object/visual/body"))
        assert mug.ComputeVisibility() == "inherited"


def test_a_lamp_is_as_bright_as_the_scene_says_on_a_worktop_below(scene: Usd.Stage) -> None:
    lamp = UsdLux.SphereLight(scene.GetPrimAtPath("/World/bulb"))
    radius, intensity = lamp.GetRadiusAttr().Get(), lamp.GetIntensityAttr().Get()
    assert lamp.GetNormalizeAttr().Get()
    # Radiance of the ball times the solid angle that it fills, over pi: what a white surface shows.
    radiance = intensity / (4 * math.pi * radius**2)
    assert radiance * math.pi * (radius / REFERENCE_M) ** 2 / math.pi == pytest.approx(1.0, rel=1e-6)


class Config(SimpleNamespace):
    """Keeps what a configuration of Isaac Lab is made with; so do those inside of it."""

    InitialStateCfg = SimpleNamespace


def test_numbers_for_isaac_lab_are_those_of_the_record(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Isaac Lab is not installed: the source runs with stand-ins that keep their arguments, which are the scene's."""
    stand_ins: dict[str, dict[str, Any]] = {
        "torch": {},
        "isaaclab": {},
        "isaaclab.sim": {"UsdFileCfg": Config},
        "isaaclab.actuators": {"ImplicitActuatorCfg": Config},
        "isaaclab.assets": dict.fromkeys(("ArticulationCfg", "AssetBaseCfg", "RigidObjectCfg"), Config),
        "isaaclab.scene": {"InteractiveSceneCfg": object},
        "isaaclab.utils": {"configclass": lambda kind: kind},
    }
    for name, content in stand_ins.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
        if "." in name:
            setattr(sys.modules["isaaclab"], name.split(".")[1], module)
    path = folder / isaac_lab.FILE
    members: dict[str, Any] = {"__file__": str(path), "__name__": "isaac_lab"}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), members)
    scene, kitchen = corner(), members["KitchenSceneCfg"]
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        if not asset.joints:
            continue
        fixture = getattr(kitchen, place.name)
        world_from_base = place.pose @ asset.root.pose
        assert fixture.init_state.pos == pytest.approx(world_from_base.position, abs=1e-11)
        assert fixture.init_state.rot == pytest.approx(world_from_base.quaternion, abs=1e-11)
        starts, (motor,) = joint_positions(place.joints), fixture.actuators.values()
        assert motor.joint_names_expr == [joint.name for joint in asset.joints]
        for joint in asset.joints:
            assert fixture.init_state.joint_pos[joint.name] == starts.get(joint.name, 0.0)
            assert motor.friction[joint.name] == motor.dynamic_friction[joint.name] == joint.frictionloss
            assert (motor.viscous_friction[joint.name], motor.armature[joint.name]) == (joint.damping, joint.armature)
            spring = (joint.drive.stiffness, joint.drive.damping) if joint.drive else (0.0, 0.0)
            assert (motor.stiffness[joint.name], motor.damping[joint.name]) == spring
            rests = members["SPRING_RESTS"].get(place.name, {})
            assert rests.get(joint.name) == (joint.drive.target if joint.drive else None)
