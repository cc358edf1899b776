"""A GLB shows what the asset is, as our own reader and trimesh read it, and says how its parts move."""

from __future__ import annotations

import io
import json
import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from casa_assets.formats.gltf import STEPS, asset_glb, encoded, scene_glb
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import Placement, Resting, Scene
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, drawer_unit, microwave, rigid_mug
from tests.support.kitchen.scenes import corner
from tests.support.mesh.meshes import texture

ASSETS = [*EVERY, grill]
Y_FROM_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def json_of(data: bytes) -> dict[str, Any]:
    """The JSON chunk."""
    size = struct.unpack_from("<I", data, 12)[0]
    return dict(json.loads(data[20 : 20 + size]))


def node_poses(document: dict[str, Any], positions: dict[str, float] | None = None) -> dict[str, np.ndarray[Any, Any]]:
    """Name of a node -> (4, 4) world_from_node, z up, with joints moved as the `extras` say."""
    found: dict[str, np.ndarray[Any, Any]] = {}

    def visit(index: int, above: np.ndarray[Any, Any]) -> None:
        node = document["nodes"][index]
        x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
        px, py, pz = node.get("translation", (0.0, 0.0, 0.0))
        matrix = above @ Pose(position=(px, py, pz), quaternion=(w, x, y, z)).matrix
        facts = node.get("extras", {}).get("joint")
        if facts is not None and positions is not None:
            span = (facts["range"][0], facts["range"][1])
            axis, anchor = tuple(facts["axis"]), tuple(facts["anchor"])
            joint = Joint(name="j", child="c", kind=JointKind(facts["type"]), axis=axis, anchor=anchor, range=span)
            matrix = matrix @ joint.motion(positions.get(facts["name"], 0.0) - facts["rest"]).matrix
        found[node["name"]] = matrix
        for child in node.get("children", []):
            visit(child, matrix)

    turned = np.eye(4)
    turned[:3, :3] = Y_FROM_Z.T
    visit(document["scenes"][0]["nodes"][0], turned)
    return found


@pytest.mark.parametrize("build", ASSETS)
def test_our_reader_and_trimesh_see_what_the_asset_shows(build: Callable[[], Asset]) -> None:
    asset = build()
    start = joint_positions(asset.keyframes[0].joints) if asset.keyframes else {}
    shown = [
        (asset.asset_from_link(k.name, start).apply(v.mesh.vertices), len(v.mesh.faces))
        for k in asset.links
        for v in k.visuals
    ]
    corners = np.concatenate([points for points, _ in shown])
    bounds = np.array([corners.min(axis=0), corners.max(axis=0)])
    read = trimesh.load_scene(io.BytesIO(asset_glb(asset)), file_type="glb", process=False).to_mesh()
    inside_out = np.array(read.vertices) @ Y_FROM_Z
    assert np.array([inside_out.min(axis=0), inside_out.max(axis=0)]) == pytest.approx(bounds, abs=1e-5)
    assert len(read.faces) == sum(count for _, count in shown)


def test_links_stand_where_the_asset_has_them_in_every_named_pose() -> None:
    for build in ASSETS:
        asset = build()
        document = json_of(asset_glb(asset))
        poses = document["nodes"][0]["extras"]["poses"]
        assert list(poses) == sorted(key.name for key in asset.keyframes)
        for positions in [*poses.values(), {}]:
            found = node_poses(document, positions)
            for link in asset.links:
                expected = asset.asset_from_link(link.name, positions).matrix
                assert found[link.name] == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize("build", [drawer_unit, microwave, grill])
def test_colliders_stand_where_they_collide(build: Callable[[], Asset]) -> None:
    """Primitives are unit meshes that their nodes scale; trimesh multiplies that out."""
    asset = build()
    read = trimesh.load_scene(io.BytesIO(asset_glb(asset, with_layers=True)), file_type="glb", process=False)
    start = joint_positions(asset.keyframes[0].joints) if asset.keyframes else {}
    for link in asset.links:
        for collider in link.colliders:
            matrix, geometry = read.graph[f"{link.name}/{collider.name}"]
            points = trimesh.transform_points(read.geometry[geometry].vertices, matrix) @ Y_FROM_Z
            expected, _ = tessellate(collider.shape, asset.asset_from_link(link.name, start) @ collider.pose, STEPS)
            assert points.min(axis=0) == pytest.approx(expected.min(axis=0), abs=1e-5)
            assert points.max(axis=0) == pytest.approx(expected.max(axis=0), abs=1e-5)


def test_pictures_are_bounded_and_keep_their_alpha() -> None:
    for side, fill, size, expected in (
        (900, (180, 120, 60), (512, 512), ("image/jpeg", "OPAQUE")),
        (64, (9, 9, 9, 255), (64, 64), ("image/png", "MASK")),
        (64, (9, 9, 9, 128), (64, 64), ("image/png", "BLEND")),
    ):
        pixels = np.full((side, side, len(fill)), fill, dtype=np.uint8)
        pixels[range(side), range(side)] = 0
        data, *told = encoded(texture("picture", pixels))
        with Image.open(io.BytesIO(data)) as small:
            assert (small.size, tuple(told)) == (size, expected)


def test_a_scene_has_each_mesh_once() -> None:
    scene = corner()
    document = json_of(scene_glb(scene, with_layers=True))
    first = scene.placements[0]
    twin = first.replace(name="twin", pose=Pose(position=(5.0, 0.0, 0.0)))
    doubled = json_of(scene_glb(scene.replace(placements=(*scene.placements, twin)), with_layers=True))
    assert len(doubled["nodes"]) > len(document["nodes"])
    assert doubled["meshes"] == document["meshes"]
    assert doubled["buffers"] == document["buffers"]


def test_what_lies_in_a_drawer_goes_along_with_it() -> None:
    unit, mug = drawer_unit(), rigid_mug()
    joint = unit.joints[0]
    holder = Placement(name="unit", asset=unit.id, pose=Pose(position=(1.0, 2.0, 0.0)))
    rest = Resting(placement="unit", link=joint.child, region="inside")
    inside = Placement(name="mug", asset=mug.id, pose=Pose(position=(1.0, 2.0, 0.5)), resting=rest)
    # The object is listed before what carries it.
    scene = Scene(id="one", assets=(unit, mug), placements=(inside, holder))
    document = json_of(scene_glb(scene))
    assert node_poses(document, {})["mug"] == pytest.approx(inside.pose.matrix, abs=2e-6)
    pulled = node_poses(document, {f"unit/{joint.name}": joint.range[1]})["mug"]
    assert math.dist(pulled[:3, 3], inside.pose.position) == pytest.approx(joint.range[1], abs=1e-6)
