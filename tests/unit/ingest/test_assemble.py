"""The finished asset: places, numbers, names; and where a hand takes it."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.ingest.draft import Draft, PlacedShape, assemble, grasp
from casa_assets.mesh.grasps import antipodal_grasps
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.mesh.solid.solids import small_hull
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import Asset, Inertial
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Grasp, GraspFeature, Hull, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category, FrontRule, MatterFill
from casa_assets.model.source import RawPart, Source, SourceKind
from tests.support.asset.asset_parts import CARDBOARD, box_inertial
from tests.support.hostile.untrusted_inputs import carton, cup, kind_of, loose
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import Floats, brief, draft, joined, moved
from tests.support.mesh.solids import box

BODY = moved(box_mesh((0.1, 0.2, 0.3), (0, 0, 0)), (1 / 3, -2 / 7, 0.7))
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


OPENING = 0.08
LOW = (0.06, 0.06, 0.12)
ROW = kind_of(loose(carton()))


def resting(size: Vec3, *meshes: Mesh) -> Draft:
    """Parts at rest on the ground with the mass of a box of that size."""
    parts = tuple(RawPart(name=f"part_{i}", mesh=mesh, material=Material(id="look")) for i, mesh in enumerate(meshes))
    inertial = box_inertial(0.2, size, (0.0, 0.0, size[2] / 2))
    return Draft(parts=parts, inertial=inertial, colliders=(PlacedShape(shape=Box(size=size)),))


def found(size: Vec3, *meshes: Mesh, row: Category = ROW) -> dict[GraspFeature, Grasp]:
    return {g.feature: g for g in grasp(resting(size, *meshes), row, OPENING).grasps}


def mug() -> tuple[Mesh, ...]:
    """A cup with a bar beside it that two short ones join to it."""
    bar = box_mesh((0.008, 0.012, 0.06), (0.07, 0.0, 0.045))
    arms = [box_mesh((0.034, 0.012, 0.008), (0.052, 0.0, z)) for z in (0.019, 0.071)]
    return cup(), bar, *arms


class TestGrasp:
    def test_a_box_is_taken_by_its_body_from_above(self) -> None:
        taken = found(LOW, carton())
        assert list(taken) == [GraspFeature.BODY]
        body = taken[GraspFeature.BODY]
        assert body.width == pytest.approx(0.06, abs=1e-4)
        assert body.approach == pytest.approx((0, 0, -1), abs=0.02)
        assert abs(body.closing[2]) < 0.02

    def test_a_mug_has_a_rim_and_a_handle(self) -> None:
        row = ROW.replace(build=MatterFill.VESSEL, front=FrontRule.HANDLE)
        taken = found((0.08, 0.08, 0.09), *mug(), row=row)
        assert taken[GraspFeature.RIM].width == pytest.approx(0.006, abs=1e-3)
        assert taken[GraspFeature.RIM].center[2] > 0.055
        assert taken[GraspFeature.HANDLE].width == pytest.approx(0.012, abs=5e-3)
        assert taken[GraspFeature.HANDLE].center[0] > 0.05
        for one in taken.values():
            assert np.dot(one.closing, one.approach) == pytest.approx(0, abs=1e-5)
            assert np.linalg.norm(one.closing) == pytest.approx(1, abs=1e-5)

    def test_asset_shows_it_as_a_site(self) -> None:
        made = grasp(resting(LOW, carton()), ROW, OPENING)
        source = Source(kind=SourceKind.FOLDER, path="box.obj")
        asset = assemble(made, "carton_0123456789", ROW, ("carton",), CARDBOARD, source, "0" * 64)
        (site,) = asset.sites
        assert (site.name, site.kind) == ("grasp_body", "box")
        assert site.size is not None
        assert site.size[0] == pytest.approx(0.06, abs=1e-4)
        body = made.grasps[0]
        assert site.pose.rotation @ [1, 0, 0] == pytest.approx(body.closing, abs=1e-5)
        assert site.pose.rotation @ [0, 0, 1] == pytest.approx(body.approach, abs=1e-5)


def test_fingers_need_room_behind_what_they_hold() -> None:
    """Two boxes 4 mm apart: no finger goes between them."""
    pair = joined(*(box((0.03, 0.03, 0.1), (x, 0.0, 0.05)) for x in (-0.017, 0.017)))
    across = [p for p in antipodal_grasps(pair.vertices, pair.faces.astype(int), OPENING) if abs(p.closing[0]) > 0.9]
    assert across
    assert min(p.width for p in across) > 0.06
