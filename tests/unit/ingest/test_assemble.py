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
from casa_assets.model.asset.parts import Box, GraspFeature, Hull, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category, FrontRule, MatterFill
from casa_assets.model.source import Source, SourceKind
from tests.support.asset.asset_parts import CARDBOARD, box_inertial
from tests.support.hostile.untrusted_inputs import carton, cup, kind_of, loose
from tests.support.mesh.meshes import box_mesh, some
from tests.support.mesh.raw_models import Floats, brief, draft, joined, moved
from tests.support.mesh.solids import box

BODY, SHARED = (box_mesh((0.1, 0.2, 0.3), (1 / 3, -2 / 7, 0.7), shared=is_shared) for is_shared in (False, True))
TILT = Pose(position=(1 / 3, -2 / 7, 0.7), quaternion=(0.9, 0.1, 0.3, 0.2))
INERTIAL = Inertial(mass=1.5, center_of_mass=(1 / 3, -2 / 7, 0.7), inertia=(0.02, 0.02, 0.02, 0.0, 0.0, 0.0))


def ready(*meshes: Mesh, colliders: tuple[PlacedShape, ...] = (PlacedShape(shape=Hull(mesh=SHARED)),)) -> Draft:
    return draft(*(meshes or (BODY,))).replace(colliders=colliders, inertial=INERTIAL)


def finished(state: Draft) -> Asset:
    told = brief("can")
    return assemble(state, told.asset_id, told.category, told.classes, told.substance, told.source, told.sha256)


def exact(values: Floats) -> bool:
    """Every number is one that a float32 holds."""
    return bool((values.astype(np.float32).astype(np.float64) == values).all())


def test_origin_is_under_the_middle_and_the_bbox_holds_all_shapes_and_no_more() -> None:
    assert finished(ready()).bounds == pytest.approx(np.array([[-0.05, -0.1, 0.0], [0.05, 0.1, 0.3]]), abs=1e-7)
    placed = (PlacedShape(shape=Box(size=(0.1, 0.2, 0.3)), pose=TILT), PlacedShape(shape=Hull(mesh=SHARED)))
    asset = finished(ready(colliders=placed))
    [region] = asset.regions
    assert region.name == "bbox"
    bounds = some(link_bounds(asset.root))
    middle, half = np.array(region.pose.position), np.array(region.size) / 2
    assert np.array([middle - half, middle + half]) == pytest.approx(bounds, abs=1e-6)


class TestNumbers:
    def test_every_array_is_exact_in_float32(self) -> None:
        asset = finished(ready(BODY, moved(BODY, (0.01, 0.02, 1e-9), 0.9)))
        for visual in asset.root.visuals:
            assert exact(visual.mesh.vertices)
            assert exact(some(visual.mesh.normals))
            assert visual.mesh.uv is None or exact(visual.mesh.uv)
        hull = asset.root.colliders[0].shape
        assert isinstance(hull, Hull)
        assert exact(hull.mesh.vertices)

    def test_normals_are_unit_and_made_where_there_were_none(self) -> None:
        zero = Mesh(vertices=SHARED.vertices, faces=SHARED.faces, normals=np.zeros((8, 3)))
        for mesh in (BODY, Mesh(vertices=SHARED.vertices, faces=SHARED.faces), zero):
            [visual] = finished(ready(mesh)).root.visuals
            normals = some(visual.mesh.normals)
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
        corners = hull.mesh.vertices[hull.mesh.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        volumes = np.einsum("fd,fvd->fv", across, hull.mesh.vertices[None] - corners[:, :1])
        size = float(np.ptp(hull.mesh.vertices, axis=0).max())
        assert volumes.max() <= 1e-6 * size**3


OPENING = 0.08
ROW = kind_of(loose(carton()))


def grasped(size: Vec3, *meshes: Mesh, row: Category = ROW) -> Draft:
    """Parts at rest on the ground with the mass of a box of that size."""
    inertial = box_inertial(0.2, size, (0.0, 0.0, size[2] / 2))
    state = draft(*meshes).replace(inertial=inertial, colliders=(PlacedShape(shape=Box(size=size)),))
    return grasp(state, row, OPENING)


class TestGrasp:
    def test_a_mug_has_a_rim_and_a_handle(self) -> None:
        row = ROW.replace(build=MatterFill.VESSEL, front=FrontRule.HANDLE)
        # A cup with a bar beside it that two short ones join to it.
        bar = box_mesh((0.008, 0.012, 0.06), (0.07, 0.0, 0.045))
        arms = [box_mesh((0.034, 0.012, 0.008), (0.052, 0.0, z)) for z in (0.019, 0.071)]
        taken = {g.feature: g for g in grasped((0.08, 0.08, 0.09), cup(), bar, *arms, row=row).grasps}
        assert taken[GraspFeature.RIM].width == pytest.approx(0.006, abs=1e-3)
        assert taken[GraspFeature.RIM].center[2] > 0.055
        assert taken[GraspFeature.HANDLE].width == pytest.approx(0.012, abs=5e-3)
        assert taken[GraspFeature.HANDLE].center[0] > 0.05
        for one in taken.values():
            assert np.dot(one.closing, one.approach) == pytest.approx(0, abs=1e-5)
            assert np.linalg.norm(one.closing) == pytest.approx(1, abs=1e-5)

    def test_a_box_is_taken_by_its_body_from_above_and_the_asset_shows_it_as_a_site(self) -> None:
        made = grasped((0.06, 0.06, 0.12), carton())
        [body] = made.grasps
        assert body.feature is GraspFeature.BODY
        assert body.width == pytest.approx(0.06, abs=1e-4)
        assert body.approach == pytest.approx((0, 0, -1), abs=0.02)
        assert abs(body.closing[2]) < 0.02
        source = Source(kind=SourceKind.FOLDER, path="box.obj")
        (site,) = assemble(made, "carton_0123456789", ROW, ("carton",), CARDBOARD, source, "0" * 64).sites
        assert (site.name, site.kind) == ("grasp_body", "box")
        assert some(site.size)[0] == pytest.approx(0.06, abs=1e-4)
        assert site.pose.rotation @ [1, 0, 0] == pytest.approx(body.closing, abs=1e-5)
        assert site.pose.rotation @ [0, 0, 1] == pytest.approx(body.approach, abs=1e-5)


def test_fingers_need_room_behind_what_they_hold() -> None:
    """Two boxes 4 mm apart: no finger goes between them."""
    pair = joined(*(box((0.03, 0.03, 0.1), (x, 0.0, 0.05)) for x in (-0.017, 0.017)))
    across = [p for p in antipodal_grasps(pair.vertices, pair.faces.astype(int), OPENING) if abs(p.closing[0]) > 0.9]
    assert across
    assert min(p.width for p in across) > 0.06
