"""Assets without meshes: primitives that stay inside of what they stand for."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.asset.lightweight import inscribed_primitives, lighten
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_planes, hull_volume
from casa_assets.model.asset.asset import Asset, Collider
from casa_assets.model.asset.parts import Box, Cylinder, Hull, Mesh, MeshShape
from casa_assets.model.kitchen.scene import LightScene
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import drawer_unit, grill
from tests.support.asset.assets import rigid_mug
from tests.support.mesh.meshes import box_mesh

Floats = npt.NDArray[np.float64]
TURNED = Pose(position=(0.3, -0.1, 0.2), quaternion=(math.cos(0.35), 0.1, math.sin(0.35), 0.2))


def prism(outline: list[tuple[float, float]], height: float) -> Floats:
    return np.array([(x, y, z) for z in (0.0, height) for x, y in outline])


def volume(shape: Box | Cylinder) -> float:
    if isinstance(shape, Box):
        return math.prod(shape.size)
    return math.pi * shape.radius**2 * shape.height


def filled(points: Floats) -> float:
    return sum(volume(shape) for shape, _ in inscribed_primitives(points)) / hull_volume(points)


ROD = prism([(0.05 * math.cos(t), 0.05 * math.sin(t)) for t in np.arange(24) * math.pi / 12], 0.6)
CORNER = prism([(0.0, 0.0), (0.9, 0.0), (0.9, 0.6), (0.6, 0.9), (0.0, 0.9)], 0.04)
WEDGE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 0.5), (1, 1, 0.5)], dtype=np.float64)
CLOUD = np.random.default_rng(7).normal(size=(40, 3)) * (0.2, 0.1, 0.3)
PLATE = prism([(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)], 0.0006)


def test_nothing_sticks_out(subtests: pytest.Subtests) -> None:
    for pose in [Pose(), TURNED]:
        for points in [ROD, CORNER, WEDGE, CLOUD, PLATE]:
            with subtests.test(points=points, pose=pose):
                moved = pose.apply(points)
                planes = hull_planes(moved)
                for shape, at in inscribed_primitives(moved):
                    corners, _ = tessellate(shape, at)
                    assert (corners @ planes[:, :3].T + planes[:, 3]).max() <= 1e-9


@pytest.mark.parametrize("points", [CORNER, WEDGE, CLOUD])
def test_boxes_of_one_hull_do_not_overlap(points: Floats) -> None:
    for (first, one), (second, other) in itertools.combinations(inscribed_primitives(points), 2):
        assert isinstance(first, Box)
        assert isinstance(second, Box)
        assert one.quaternion == other.quaternion
        gap = np.abs(one.rotation.T @ (np.array(one.position) - np.array(other.position)))
        assert (gap - (np.array(first.size) + np.array(second.size)) / 2).max() >= -1e-9


def test_how_much_is_left() -> None:
    assert filled(box_mesh((0.1, 0.2, 0.3), (0.0, 0.0, 0.0)).vertices) > 0.999
    assert filled(PLATE) > 0.98
    assert filled(ROD) > 0.95
    assert filled(CORNER) > 0.85
    assert filled(WEDGE) > 0.6


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
    assert light.joints == asset.joints
    assert light.sites == asset.sites
    assert light.exclusions == asset.exclusions
    assert [k.inertial for k in light.links] == [k.inertial for k in asset.links]
    assert [k.pose for k in light.links] == [k.pose for k in asset.links]
    assert not any(k.visuals for k in light.links)
    assert light.materials == ()
    before, after = colliders(asset), colliders(light)
    assert {LightScene.collider_of(name) for name in after} == set(before)
    for name, item in before.items():
        if not isinstance(item.shape, Hull | MeshShape):
            assert after[name] == item
    assert not any(isinstance(item.shape, Hull | MeshShape) for item in after.values())


def colliders(asset: Asset) -> dict[str, Collider]:
    return {item.name: item for link in asset.links for item in link.colliders}


def test_what_leans_keeps_the_foot_that_it_stands_on() -> None:
    # A block whose sides lean over its base, as a knife block's do.
    low = [(x, y, 0.0) for x in (-0.05, 0.05) for y in (-0.08, 0.08)]
    high = [(x, y + 0.09, 0.2) for x, y, _ in low]
    points, faces = convex_hull(np.array(low + high))
    block = Collider(name="block", shape=Hull(mesh=Mesh(vertices=points, faces=faces)), substance="ceramic")
    asset = rigid_mug()
    leaning = asset.replace(links=(asset.root.replace(colliders=(block,)),))
    feet = []
    for item in colliders(lighten(leaning)).values():
        corners, _ = tessellate(item.shape, item.pose)
        assert corners[:, 2].min() > -1e-6
        flat = corners[corners[:, 2] < 1e-4]
        feet.append(float(np.prod(np.ptp(flat[:, :2], axis=0))) if len(flat) >= 4 else 0.0)
    assert max(feet) > 0.8 * 0.1 * 0.16
