"""What is made of whole assets: scaled ones, trimesh scenes, the material that a primitive shows; what stands."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import trimesh

from casa_assets.asset.scale_asset import scaled
from casa_assets.asset.shown_materials import ShownMaterials
from casa_assets.formats.mjcf.document import write
from casa_assets.formats.read.from_trimesh import raw_from_trimesh
from casa_assets.mesh.planar import stands_by_itself
from casa_assets.mesh.trimesh_exchange import to_trimesh
from casa_assets.model.asset.asset import Asset, JointKind, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.source import Up
from tests.support.asset.articulated_assets import drawer_unit, microwave
from tests.support.asset.asset_parts import box_collider
from tests.support.asset.assets import EVERY, textured_box
from tests.support.asset.box_assets import plain_box, touched
from tests.support.mesh.meshes import box_mesh, some, texture

FACTOR = 1.25


@pytest.fixture(params=["microwave", "drawers"])
def asset(request: pytest.FixtureRequest) -> Asset:
    return microwave() if request.param == "microwave" else drawer_unit()


def test_all_lengths_are_scaled(asset: Asset) -> None:
    made = scaled(asset, FACTOR, 2 * asset.mass)
    assert made.bounds == pytest.approx(FACTOR * asset.bounds, abs=1e-6)
    assert made.mass == pytest.approx(2 * asset.mass, rel=1e-5)
    for before, after in zip(asset.regions, made.regions, strict=True):
        assert after.size == pytest.approx(FACTOR * np.array(before.size), rel=1e-6)
        assert after.pose.position == pytest.approx(FACTOR * np.array(before.pose.position), abs=1e-6)
    for before, after in zip(asset.joints, made.joints, strict=True):
        factor = FACTOR if before.kind is JointKind.SLIDE else 1.0
        assert after.range == pytest.approx(factor * np.array(before.range), abs=1e-6)
        # A hand needs as much force, at an arm that is longer.
        arm = 1.0 if before.kind is JointKind.SLIDE else FACTOR
        assert after.frictionloss == pytest.approx(arm * before.frictionloss, rel=0.01)


def test_mujoco_has_the_masses_and_inertias_of_a_scaled_body(asset: Asset) -> None:
    small, large = (_model(one) for one in (asset, scaled(asset, FACTOR, 2 * asset.mass)))
    assert large.body_mass == pytest.approx(2 * small.body_mass, rel=1e-5)
    assert large.body_inertia == pytest.approx(2 * FACTOR**2 * small.body_inertia, rel=1e-4, abs=1e-9)
    assert large.body_pos == pytest.approx(FACTOR * small.body_pos, abs=1e-6)


def _model(asset: Asset) -> mujoco.MjModel:
    files = dict(write(asset).entries)
    return mujoco.MjModel.from_xml_string(files["model.xml"].decode(), files)


def on_feet(*corners: tuple[float, float]) -> Asset:
    """A box of 0.2 x 0.06 x 0.12 m over feet at some of its corners."""
    feet = (box_collider(f"foot_{i}", (0.02, 0.02, 0.01), (x, y, 0.005)) for i, (x, y) in enumerate(corners))
    return touched(box_collider("body", (0.2, 0.06, 0.11), (0.0, 0.0, 0.065)), *feet)


def test_a_box_a_fixture_and_four_feet_stand_and_one_or_two_at_a_side_do_not() -> None:
    assert stands_by_itself(plain_box())
    assert stands_by_itself(microwave())
    assert stands_by_itself(on_feet((-0.09, -0.02), (0.09, -0.02), (-0.09, 0.02), (0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, -0.02), (-0.09, 0.02)))


OPEN = np.ones(6, dtype=bool)
PAINT = Material(id="paint")
GRAIN = texture("grain", np.full((4, 8, 3), 120, dtype=np.uint8))
OAK = Material(id="oak", base_color_texture=GRAIN, tile_m=(0.5, 0.25))
GLASS = Material(id="glass", base_color=(1.0, 1.0, 1.0, 0.2))
# A panel that looks along x, at the right end of a cabinet.
PANEL: Vec3 = (0.018, 0.6, 0.7)


def shown(*parts: tuple[Mesh, str], middle: Vec3 = (-0.3, 0.0, 0.0), is_room: bool = False) -> ShownMaterials:
    """Of meshes with a material each."""
    visuals = [(Visual(name=f"v{i}", mesh=mesh, material=name), Pose()) for i, (mesh, name) in enumerate(parts)]
    return ShownMaterials.of(visuals, (PAINT, OAK, GLASS), np.array(middle), is_room)


def test_the_outermost_layer_counts_where_it_is_not_behind_something() -> None:
    """A panel of oak with a sheet of paint on its right side, each drawn as a box of its own."""
    sheet: Vec3 = (0.003, 0.6, 0.7)
    layered = shown((box_mesh(PANEL, (0.0, 0.0, 0.0)), "oak"), (box_mesh(sheet, (0.0105, 0.0, 0.0)), "paint"))
    for sides, material in ((OPEN, "paint"), (np.array([True, False, True, True, True, True]), "oak")):
        assert some(layered.on(Box(size=PANEL), Pose(), sides)).material.id == material


def test_a_room_is_seen_from_inside() -> None:
    slab: Vec3 = (4.0, 4.0, 0.02)
    parts = ((box_mesh(slab, (0.0, 0.0, -0.01)), "oak"), (box_mesh(slab, (0.0, 0.0, -0.03)), "paint"))
    floor = Box(size=(4.0, 4.0, 0.04)), Pose(position=(0.0, 0.0, -0.02)), OPEN
    assert some(shown(*parts, middle=(0.0, 0.0, 1.3), is_room=True).on(*floor)).material.id == "oak"


def test_the_picture_lies_upright_on_what_stands_and_along_the_grain() -> None:
    """`box_mesh` draws it with its width along the side, its height up, seen from outside, on all sides."""
    standing, lying = box_mesh((0.6, 0.018, 0.7), (0.0, 0.0, 0.0)), box_mesh((2.0, 0.6, 0.04), (0.0, 0.0, 0.0))
    turns = []
    # The second with its picture turned by a quarter.
    for mesh in (standing, lying.replace(uv=some(lying.uv)[:, ::-1])):
        drawn = Box(size=tuple(np.ptp(mesh.vertices, axis=0).tolist()))
        found = some(shown((mesh, "oak"), middle=(0.0, 0.0, 0.0)).on(drawn, Pose(), OPEN))
        turns.append(some(found.turn))
    upright, along = turns
    assert np.linalg.det(upright) == pytest.approx(1.0)
    assert abs(upright[0, 0]) == 1.0
    assert upright[2, 1] == 1.0
    assert abs(upright[1, 2]) == 1.0
    assert abs(along[1, 0]) == 1.0


def test_what_is_seen_lies_where_the_asset_has_it(subtests: pytest.Subtests) -> None:
    for asset in [make() for make in EVERY]:
        with subtests.test(asset=asset.id):
            scene = to_trimesh(asset)
            assert scene.units == "meters"
            np.testing.assert_allclose(scene.bounds, asset.bounds, atol=1e-12)
            visuals = {v.name: v for link in asset.links for v in link.visuals}
            assert set(scene.geometry) == visuals.keys()
            for name, visual in visuals.items():
                mesh = scene.geometry[name]
                assert isinstance(mesh, trimesh.Trimesh)
                np.testing.assert_array_equal(mesh.faces, visual.mesh.faces)
                if visual.mesh.normals is not None:
                    np.testing.assert_allclose(mesh.vertex_normals, visual.mesh.normals, atol=1e-12)


def test_what_is_touched_is_closed_and_convex(subtests: pytest.Subtests) -> None:
    for asset in [make() for make in EVERY]:
        with subtests.test(asset=asset.id):
            scene = to_trimesh(asset, "collision")
            assert len(scene.geometry) == sum(len(link.colliders) for link in asset.links)
            for mesh in scene.geometry.values():
                assert isinstance(mesh, trimesh.Trimesh)
                assert mesh.is_watertight
                assert mesh.is_winding_consistent
                assert mesh.volume > 0
                assert mesh.volume == pytest.approx(mesh.convex_hull.volume, rel=1e-6)


def test_textures_and_factors_go_over() -> None:
    asset = textured_box()
    scene = to_trimesh(asset)
    for link in asset.links:
        for visual in link.visuals:
            ours = {m.id: m for m in asset.materials}[visual.material]
            theirs = scene.geometry[visual.name].visual.material
            assert theirs.metallicFactor == ours.metallic
            assert theirs.roughnessFactor == ours.roughness
            np.testing.assert_allclose(theirs.baseColorFactor / 255, ours.base_color, atol=0.5 / 255)
            assert (theirs.baseColorTexture is None) == (ours.base_color_texture is None)


@pytest.mark.parametrize("asset", [make() for make in EVERY], ids=lambda a: a.id)
def test_there_and_back_is_the_same_form(asset: Asset) -> None:
    raw = raw_from_trimesh(to_trimesh(asset))
    assert raw.metres_per_unit == pytest.approx(1.0)
    assert raw.up is Up.Z
    visuals = [(link, v) for link in asset.links for v in link.visuals]
    assert len(raw.parts) == len(visuals)
    parts = {p.name: p for p in raw.parts}
    for link, visual in visuals:
        ours, theirs = visual.mesh, parts[visual.name].mesh
        placed = asset.asset_from_link(link.name).apply(ours.vertices)
        np.testing.assert_allclose(theirs.vertices[theirs.faces], placed[ours.faces], atol=1e-12)
        if ours.uv is not None:
            np.testing.assert_allclose(some(theirs.uv)[theirs.faces], ours.uv[ours.faces], atol=1e-12)
