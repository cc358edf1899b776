"""Where a hand can take a thing: body, rim and handle, and none where it is too wide."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.ingest.assemble import assemble, grasp
from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.mesh.grasps import antipodal_grasps
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Grasp, GraspFeature, Mesh
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category, FrontRule, MatterFill
from casa_assets.model.source import RawPart, Source, SourceKind
from tests.support.asset.asset_parts import CARDBOARD, box_inertial
from tests.support.hostile.untrusted_inputs import carton, cup, kind_of, loose
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import joined
from tests.support.mesh.solids import box

OPENING = 0.08
LOW = (0.06, 0.06, 0.12)
ROW = kind_of(loose(carton()))


def draft(size: Vec3, *meshes: Mesh) -> Draft:
    """Parts at rest on the ground with the mass of a box of that size."""
    parts = tuple(RawPart(name=f"part_{i}", mesh=mesh, material=Material(id="look")) for i, mesh in enumerate(meshes))
    inertial = box_inertial(0.2, size, (0.0, 0.0, size[2] / 2))
    return Draft(parts=parts, inertial=inertial, colliders=(PlacedShape(shape=Box(size=size)),))


def found(size: Vec3, *meshes: Mesh, row: Category = ROW) -> dict[GraspFeature, Grasp]:
    return {g.feature: g for g in grasp(draft(size, *meshes), row, OPENING).grasps}


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

    def test_what_is_not_taken(self, subtests: pytest.Subtests) -> None:
        """The edges of a low board could be taken, were it not for the floor under them."""
        for size, row in [((0.12, 0.12, 0.12), ROW), ((0.3, 0.2, 0.01), ROW), (LOW, ROW.replace(fixed=True))]:
            with subtests.test(size=size):
                assert found(size, carton(size), row=row) == {}

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
        made = grasp(draft(LOW, carton()), ROW, OPENING)
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
