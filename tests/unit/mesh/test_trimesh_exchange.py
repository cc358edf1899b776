"""Assets as trimesh scenes: the same places, sizes and looks."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from casa_assets.formats.read.from_trimesh import raw_from_trimesh
from casa_assets.mesh.trimesh_exchange import to_trimesh
from casa_assets.model.asset.asset import Asset
from tests.support.asset.assets import EVERY, textured_box


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
    assert raw.up is not None
    assert raw.up.value == "z"
    visuals = [(link, v) for link in asset.links for v in link.visuals]
    assert len(raw.parts) == len(visuals)
    parts = {p.name: p for p in raw.parts}
    for link, visual in visuals:
        ours, theirs = visual.mesh, parts[visual.name].mesh
        placed = asset.asset_from_link(link.name).apply(ours.vertices)
        np.testing.assert_allclose(theirs.vertices[theirs.faces], placed[ours.faces], atol=1e-12)
        if ours.uv is not None:
            assert theirs.uv is not None
            np.testing.assert_allclose(theirs.uv[theirs.faces], ours.uv[ours.faces], atol=1e-12)
