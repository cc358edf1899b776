"""The light form and what is built in: primitives inside of what they stand for, inertia, pairs that are left out."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.asset.lightweight import inscribed_primitives, light_scene, lighten
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.mesh.inertia import ADJACENT_M, adjacent_links, drop_unfelt_products
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import hull_planes
from casa_assets.model.asset.asset import Asset, Inertial
from casa_assets.model.asset.parts import Box, Cylinder, Hull, MeshShape
from casa_assets.model.kitchen.scene import LightScene, Scene
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import drawer_unit, grill
from tests.support.asset.assets import rigid_mug
from tests.support.asset.cupboard import cupboard, joint_changed
from tests.support.kitchen.rooms import at, block, room

Floats = npt.NDArray[np.float64]
TURNED = Pose(position=(0.3, -0.1, 0.2), quaternion=(math.cos(0.35), 0.1, math.sin(0.35), 0.2))


def prism(outline: list[tuple[float, float]], height: float) -> Floats:
    return np.array([(x, y, z) for z in (0.0, height) for x, y in outline])


ROD = prism([(0.05 * math.cos(t), 0.05 * math.sin(t)) for t in np.arange(24) * math.pi / 12], 0.6)
CORNER = prism([(0.0, 0.0), (0.9, 0.0), (0.9, 0.6), (0.6, 0.9), (0.0, 0.9)], 0.04)
WEDGE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 0.5), (1, 1, 0.5)], dtype=np.float64)
CLOUD = np.random.default_rng(7).normal(size=(40, 3)) * (0.2, 0.1, 0.3)
PLATE = prism([(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)], 0.0006)


def test_nothing_sticks_out() -> None:
    for pose in [Pose(), TURNED]:
        for points in [ROD, CORNER, WEDGE, CLOUD, PLATE]:
            moved = pose.apply(points)
            planes = hull_planes(moved)
            for shape, place in inscribed_primitives(moved):
                corners, _ = tessellate(shape, place)
                assert (corners @ planes[:, :3].T + planes[:, 3]).max() <= 1e-9


@pytest.mark.parametrize("points", [CORNER, WEDGE, CLOUD])
def test_boxes_of_one_hull_do_not_overlap(points: Floats) -> None:
    for (first, one), (second, other) in itertools.combinations(inscribed_primitives(points), 2):
        assert isinstance(first, Box)
        assert isinstance(second, Box)
        assert one.quaternion == other.quaternion
        gap = np.abs(one.rotation.T @ (np.array(one.position) - np.array(other.position)))
        assert (gap - (np.array(first.size) + np.array(second.size)) / 2).max() >= -1e-9


def test_a_round_hull_is_a_cylinder_and_a_corner_is_not() -> None:
    ((rod, pose),) = inscribed_primitives(TURNED.apply(ROD))
    assert isinstance(rod, Cylinder)
    assert np.abs(pose.rotation[:, 2] @ TURNED.rotation[:, 2]) == pytest.approx(1.0, abs=1e-6)
    assert rod.height == pytest.approx(0.6, abs=1e-4)
    boxes = [shape for shape, _ in inscribed_primitives(CORNER)]
    assert len(boxes) > 1
    assert all(isinstance(shape, Box) for shape in boxes)


@pytest.mark.parametrize("asset", [rigid_mug(), drawer_unit(), grill()])
def test_an_asset_keeps_all_but_its_meshes(asset: Asset) -> None:
    light = lighten(asset)
    assert (light.joints, light.sites, light.exclusions) == (asset.joints, asset.sites, asset.exclusions)
    assert [(k.inertial, k.pose) for k in light.links] == [(k.inertial, k.pose) for k in asset.links]
    assert not any(k.visuals for k in light.links)
    assert light.materials == ()
    before, after = ({c.name: c for link in one.links for c in link.colliders} for one in (asset, light))
    assert {LightScene.collider_of(name) for name in after} == set(before)
    for name, item in before.items():
        if not isinstance(item.shape, Hull | MeshShape):
            assert after[name] == item
    assert not any(isinstance(item.shape, Hull | MeshShape) for item in after.values())


# A tensor about axes that lean by some ten degrees, kg*m^2.
LEANS = Inertial(mass=4.0, center_of_mass=(0.2, -0.01, 0.03), inertia=(0.3, 0.25, 0.2, 0.02, -0.03, 0.01))


def leaning(asset: Asset) -> Asset:
    """The asset with that tensor on every link."""
    return asset.replace(links=tuple(link.replace(inertial=LEANS) for link in asset.links))


def leant(asset: Asset) -> list[str]:
    """Links whose inertia leans still where that tensor was on each of them."""
    return [link.name for link in drop_unfelt_products(leaning(asset)).links if any(link.inertial.inertia[3:])]


def resistance(scene: Scene) -> np.ndarray:
    """(nv, nv) inertia against all joints of a scene, those of its assets as they are."""
    model = mujoco.MjModel.from_xml_string(mjcf.write(light_scene(scene)).entries[mjcf.FILE].decode())
    data = mujoco.MjData(model)
    rng = np.random.default_rng(5)
    low, high = model.jnt_range.T
    data.qpos[:] = low + (high - low) * rng.random(model.njnt)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def test_what_leans_or_turns_on_what_turns_keeps_the_tensor_and_nothing_else() -> None:
    whole = cupboard()
    assert leant(whole) == []
    assert leant(joint_changed("knob_turn", axis=(0.0, math.cos(0.2), math.sin(0.2)))) == ["knob"]
    carried = whole.replace(links=tuple(k.replace(parent="door") if k.name == "knob" else k for k in whole.links))
    assert "knob" in leant(carried)


def test_no_joint_can_tell() -> None:
    scene = room((leaning(cupboard()), at(0.0, 0.0, 0.0)))
    found = resistance(scene)
    whole = scene.replace(assets=tuple(a if a.id != cupboard().id else leaning(a) for a in scene.assets))
    assert whole != scene
    assert found == pytest.approx(resistance(whole), rel=1e-9, abs=1e-12)
    assert np.linalg.matrix_rank(found) == len(cupboard().joints)


def test_a_cupboard_is_beside_itself_and_what_is_near() -> None:
    wide = block("near", (0.6, 0.05, 0.7))
    gap = 0.257 + 0.025  # from the middle of what stands before it to the bar of the drawer
    for more, near in ((ADJACENT_M - 0.001, True), (ADJACENT_M + 0.02, False)):
        scene = room((cupboard(), at(0.0, 0.0, 0.0)), (wide, at(0.0, -gap - more, 0.0)))
        pairs = {(f"{a.placement}/{a.link}", b.placement) for a, b in adjacent_links(scene)}
        assert {p for p in pairs if p[1] == "thing_0"} == {
            (f"thing_0/{joint.child}", "thing_0") for joint in cupboard().joints
        }
        assert (("thing_0/drawer", "thing_1") in pairs) == near
