"""Sheets that are seen from both sides get faces on both, and nothing else does."""

from __future__ import annotations

import numpy as np

from casa_assets.ingest.draft import Draft
from casa_assets.ingest.texture import add_back_faces
from casa_assets.mesh.solid.deviation import measure_visibility
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import MatterFill
from casa_assets.model.source import RawPart
from tests.support.hostile.untrusted_inputs import carton, kind_of, loose, without_side
from tests.support.mesh.meshes import lathe

ROW = kind_of(loose(carton()))
BOWL = lathe([(0.06, 0.05), (0.05, 0.02), (0.03, 0.0), (0.0, 0.0)], 32)
MISSING = 0.5


def of(mesh: Mesh) -> RawPart:
    return RawPart(name="part", mesh=mesh, material=Material(id="look"))


def after(mesh: Mesh, build: MatterFill) -> Draft:
    return add_back_faces(Draft(parts=(of(mesh),)), ROW.replace(build=build), MISSING)


def behind(draft: Draft) -> float:
    return float(measure_visibility(draft.surface.vertices, draft.surface.faces).behind.mean())


def test_a_bowl_without_a_thickness_is_seen_from_within() -> None:
    assert behind(Draft(parts=(of(BOWL),))) > 0.2
    made = after(BOWL, MatterFill.VESSEL)
    assert behind(made) < 0.01
    assert [n.code for n in made.notes] == ["MSH060"]
    mesh = made.parts[0].mesh
    assert len(mesh.faces) == 2 * len(BOWL.faces)
    assert mesh.uv is not None
    assert mesh.normals is not None
    corners = mesh.vertices[mesh.faces]
    fronts = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", fronts, mesh.normals[mesh.faces[:, 0]]) > 0).all()


def test_a_full_thing_without_a_side_stays_open_to_be_found() -> None:
    open_box = without_side(carton(), (0, 0, -1))
    assert after(open_box, MatterFill.FILLED).parts[0].mesh == open_box
    assert after(open_box, MatterFill.HOLLOW).parts[0].mesh != open_box
