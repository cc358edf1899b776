"""The finished asset: its origin, numbers that both formats carry, names, labels and provenance."""

from __future__ import annotations

import re

import numpy as np
import pytest

from casa_assets.ingest.assemble import assemble
from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.mesh.solid.solids import small_hull
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import Asset, Base, Inertial
from casa_assets.model.asset.parts import Box, Hull, Mesh
from casa_assets.model.asset.provenance import split_of
from casa_assets.model.pose import Pose
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import Floats, brief, draft, moved

BODY = moved(box_mesh((0.1, 0.2, 0.3), (0, 0, 0)), (1 / 3, -2 / 7, 0.7))
LONE = Mesh(vertices=[[0.3, -0.2, 0.9], [0.4, -0.2, 0.9], [0.3, -0.3, 0.9]], faces=[[0, 1, 2]])
SHARED = moved(box_mesh((0.1, 0.2, 0.3), (0, 0, 0), shared=True), (1 / 3, -2 / 7, 0.7))
TILT = Pose(position=(1 / 3, -2 / 7, 0.7), quaternion=(0.9, 0.1, 0.3, 0.2))
INERTIAL = Inertial(mass=1.5, center_of_mass=(1 / 3, -2 / 7, 0.7), inertia=(0.02, 0.02, 0.02, 0.0, 0.0, 0.0))


def ready(*meshes: Mesh, colliders: tuple[PlacedShape, ...] = (PlacedShape(shape=Hull(mesh=SHARED)),)) -> Draft:
    return draft(*(meshes or (BODY,))).replace(colliders=colliders, inertial=INERTIAL)


def finished(state: Draft, name: str = "can") -> Asset:
    told = brief(name)
    return assemble(state, told.asset_id, told.category, told.classes, told.substance, told.source, told.sha256)


def exact(values: Floats) -> bool:
    """Every number is one that a float32 holds."""
    return bool((values.astype(np.float32).astype(np.float64) == values).all())


class TestPlace:
    def test_origin_is_under_the_middle(self) -> None:
        low, high = finished(ready()).bounds
        assert low == pytest.approx([-0.05, -0.1, 0.0], abs=1e-7)
        assert high == pytest.approx([0.05, 0.1, 0.3], abs=1e-7)

    def test_the_bbox_holds_all_shapes_and_no_more(self) -> None:
        placed = (PlacedShape(shape=Box(size=(0.1, 0.2, 0.3)), pose=TILT), PlacedShape(shape=Hull(mesh=SHARED)))
        asset = finished(ready(colliders=placed))
        [region] = asset.regions
        assert region.name == "bbox"
        bounds = link_bounds(asset.root)
        assert bounds is not None
        middle, half = np.array(region.pose.position), np.array(region.size) / 2
        assert np.array([middle - half, middle + half]) == pytest.approx(bounds, abs=1e-6)


class TestNumbers:
    def test_every_array_is_exact_in_float32(self) -> None:
        asset = finished(ready(BODY, moved(BODY, (0.01, 0.02, 1e-9), 0.9)))
        for visual in asset.root.visuals:
            assert exact(visual.mesh.vertices)
            assert visual.mesh.normals is not None
            assert exact(visual.mesh.normals)
            assert visual.mesh.uv is None or exact(visual.mesh.uv)
        hull = asset.root.colliders[0].shape
        assert isinstance(hull, Hull)
        assert exact(hull.mesh.vertices)

    def test_normals_are_unit_and_made_where_there_were_none(self) -> None:
        zero = Mesh(vertices=SHARED.vertices, faces=SHARED.faces, normals=np.zeros((8, 3)))
        for mesh in (BODY, Mesh(vertices=SHARED.vertices, faces=SHARED.faces), zero):
            [visual] = finished(ready(mesh)).root.visuals
            normals = visual.mesh.normals
            assert normals is not None
            assert np.linalg.norm(normals, axis=1) == pytest.approx(1, abs=1e-6)
            if mesh is zero:
                continue
            flat, _ = face_normals(visual.mesh.vertices, visual.mesh.faces.astype(np.int64))
            assert np.einsum("fd,fkd->fk", flat, normals[visual.mesh.faces]) == pytest.approx(1, abs=1e-6)

    @pytest.mark.parametrize("seed", range(4))
    def test_rounded_hulls_stay_convex_and_small(self, seed: int) -> None:
        cloud = np.random.default_rng(seed).normal(size=(400, 3)) * [0.05, 0.05, 10.0 ** -(seed + 2)]
        points, faces = small_hull(cloud + np.array([0.3, -0.2, 0.7]))
        placed = (PlacedShape(shape=Hull(mesh=Mesh(vertices=points, faces=faces))),)
        hull = finished(ready(colliders=placed)).root.colliders[0].shape
        assert isinstance(hull, Hull)
        assert 4 <= len(hull.mesh.vertices) <= 64
        ids = hull.mesh.faces.astype(np.int64)
        corners = hull.mesh.vertices[ids]
        volumes = np.einsum(
            "fd,fvd->fv",
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
            hull.mesh.vertices[None] - corners[:, :1],
        )
        size = float(np.ptp(hull.mesh.vertices, axis=0).max())
        assert volumes.max() <= 1e-6 * size**3


class TestVisuals:
    def test_no_visual_has_fewer_than_four_vertices(self) -> None:
        """MuJoCo refuses such meshes; the triangle is cut up, and looks as before."""
        uv = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        [_, lone] = finished(ready(BODY, Mesh(vertices=LONE.vertices, faces=LONE.faces, uv=uv))).root.visuals
        assert len(lone.mesh.vertices) == 4
        assert lone.mesh.uv is not None
        assert exact(lone.mesh.vertices)
        assert lone.mesh.uv[3] == pytest.approx([1 / 3, 1 / 3])
        normals, areas = face_normals(lone.mesh.vertices, lone.mesh.faces.astype(np.int64))
        assert areas.sum() == pytest.approx(0.005, rel=1e-5)
        assert normals == pytest.approx(np.broadcast_to(normals[0], (3, 3)), abs=1e-5)


class TestWords:
    def test_labels_and_provenance(self) -> None:
        state = ready()
        state = state.replace(guesses=state.guessed("scale", "1", 0.5, "reason"))
        asset, told = finished(state, "mug"), brief("mug")
        assert re.fullmatch(r"mug_[0-9a-f]{10}", asset.id)
        assert asset.labels.category == "mug"
        assert asset.labels.classes == told.classes
        assert asset.labels.qcode == told.category.qcode
        assert asset.labels.split is split_of("0" * 64)
        assert (asset.provenance.path, asset.provenance.sha256) == ("mug.obj", "0" * 64)
        assert asset.provenance.guesses == state.guesses
        assert asset.base is Base.FREE
        assert finished(ready(), "oven").base is (Base.FIXED if brief("oven").category.fixed else Base.FREE)
