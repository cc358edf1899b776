"""Scenes as USD: references, poses, what can be hidden, judges that we did not write, bytes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdPhysics

from casa_assets.formats.usd.kitchen import REFERENCE_M, pose_looking_along, write
from tests.support.kitchen.scenes import body, corner, expected, put


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return put(write(corner()), tmp_path_factory.mktemp("usd"), corner())


@pytest.fixture
def path(folder: Path) -> Path:
    return folder / "scene.usda"


@pytest.fixture
def stage(path: Path) -> Usd.Stage:
    """A stage with a session of its own: no test sees what another selects. Prims expire without it."""
    return Usd.Stage.Open(Sdf.Layer.FindOrOpen(str(path)), Sdf.Layer.CreateAnonymous())


class TestPoses:
    @pytest.mark.parametrize("key", ["start", "closed", "open"])
    def test_every_body_stands_where_the_scene_puts_it(self, key: str, stage: Usd.Stage) -> None:
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            stage.GetDefaultPrim().GetVariantSet("pose").SetVariantSelection(key)
        cache, truth = UsdGeom.XformCache(), expected(corner(), key)
        for place in corner().placements:
            for link in corner().asset_of[place.name].links:
                prim = stage.GetPrimAtPath(f"/World/{place.name}/{link.name}")
                matrix = np.array(cache.GetLocalToWorldTransform(prim)).T
                assert matrix == pytest.approx(truth[body(place.name, link.name)].matrix, abs=1e-8), prim.GetPath()

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
    def test_joints_say_where_they_stand(self, key: str, joint: str, degrees: float, stage: Usd.Stage) -> None:
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            stage.GetDefaultPrim().GetVariantSet("pose").SetVariantSelection(key)
        prim = stage.GetPrimAtPath(f"/World/{joint}")
        assert prim.GetAttribute("state:angular:physics:position").Get() == pytest.approx(degrees, abs=1e-4)
        assert "PhysicsJointStateAPI:angular" in prim.GetMetadata("apiSchemas").GetAppliedItems()


class TestStructure:
    def test_bases_hang_on_the_world_where_they_are_placed(self, stage: Usd.Stage) -> None:
        joint = UsdPhysics.Joint(stage.GetPrimAtPath("/World/unit/physicsJoints/baseToWorld"))
        assert joint.GetBody0Rel().GetTargets() == ["/World"]
        assert joint.GetBody1Rel().GetTargets() == ["/World/unit/object"]
        assert tuple(joint.GetLocalPos0Attr().Get()) == pytest.approx((-0.01, -1.0, 0.2), abs=1e-6)
        assert not stage.GetPrimAtPath("/World/loose_oven/physicsJoints/baseToWorld")

    def test_articulation_roots_are_not_nested(self, stage: Usd.Stage) -> None:
        prims = list(stage.Traverse())
        roots = [p.GetPath() for p in prims if p.HasAPI(UsdPhysics.ArticulationRootAPI)]
        bodies = [p.GetPath() for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI)]
        assert len(roots) == 6
        assert not any(a != b and b.HasPrefix(a) for a in bodies for b in bodies)
        assert not any(p.IsInstance() for p in prims)

    def test_room_and_ceiling_can_be_hidden(self, path: Path) -> None:
        for name in ("wall", "ceiling"):
            stage = Usd.Stage.Open(str(path))
            shape = UsdGeom.Imageable(stage.GetPrimAtPath(f"/World/{name}/object/visual/carton"))
            assert shape.ComputeVisibility() == "inherited"
            with Usd.EditContext(stage, stage.GetSessionLayer()):
                layer = "room" if name == "wall" else name
                stage.GetDefaultPrim().GetVariantSet(layer).SetVariantSelection("hidden")
            assert shape.ComputeVisibility() == "invisible"
            mug = UsdGeom.Imageable(stage.GetPrimAtPath("/World/mug/object/visual/body"))
            assert mug.ComputeVisibility() == "inherited"


class TestRoom:
    def test_a_lamp_is_as_bright_as_the_scene_says_on_a_worktop_below(self, stage: Usd.Stage) -> None:
        lamp = UsdLux.SphereLight(stage.GetPrimAtPath("/World/bulb"))
        radius, intensity = lamp.GetRadiusAttr().Get(), lamp.GetIntensityAttr().Get()
        assert lamp.GetNormalizeAttr().Get()
        # Radiance of the ball times the solid angle that it fills, over pi: what a white surface shows.
        radiance = intensity / (4 * math.pi * radius**2)
        assert radiance * math.pi * (radius / REFERENCE_M) ** 2 / math.pi == pytest.approx(1.0, rel=1e-6)

    @given(direction=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.01))
    def test_lights_look_along_their_direction(self, direction: tuple[float, float, float]) -> None:
        unit = np.array(direction) / math.hypot(*direction)
        assert -pose_looking_along(direction).rotation[:, 2] == pytest.approx(unit, abs=1e-5)

    def test_straight_up_and_down(self) -> None:
        assert -pose_looking_along((0.0, 0.0, 2.0)).rotation[:, 2] == pytest.approx([0, 0, 1])
        assert -pose_looking_along((0.0, 0.0, -2.0)).rotation[:, 2] == pytest.approx([0, 0, -1])
