"""Simplification: few enough faces, the same outline, uv that still belong to their vertices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from casa_assets.ingest.simplify import simplified, simplify
from casa_assets.mesh.surface import signed_volume
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.meshes import box_mesh, lathe
from tests.support.mesh.raw_models import codes, draft, moved

SPHERE = [(0.05 * np.sin(t), -0.05 * np.cos(t)) for t in np.linspace(0, np.pi, 60)]
FINE = lathe([(float(r), float(z)) for r, z in SPHERE], 120)


def rows(mesh: Mesh) -> set[bytes]:
    """Position and uv of every vertex, bit for bit."""
    columns = [mesh.vertices] + ([mesh.uv] if mesh.uv is not None else [])
    return {row.tobytes() for row in np.column_stack(columns)}


def test_the_limit_is_kept_and_vertices_are_those_of_the_input(subtests: pytest.Subtests) -> None:
    for with_uv in [True, False]:
        for limit in [4000, 1500]:
            with subtests.test(limit=limit, with_uv=with_uv):
                mesh = FINE if with_uv else Mesh(vertices=FINE.vertices, faces=FINE.faces)
                out = simplify(draft(mesh), limit)
                few = out.parts[0].mesh
                assert 0.5 * limit < len(few.faces) <= 1.1 * limit
                assert (few.uv is not None) == with_uv
                assert rows(few) <= rows(mesh)
                assert codes(out.notes) == ["MSH015"]


def test_the_shape_and_the_seams_of_uv_stay() -> None:
    few = simplified(FINE, 1500)
    assert few.bounds == pytest.approx(FINE.bounds, abs=1e-3)
    volumes = [abs(signed_volume(m.vertices, m.faces.astype(np.int64))) for m in (few, FINE)]
    assert volumes[0] == pytest.approx(volumes[1], rel=0.02)
    away, _ = cKDTree(FINE.vertices).query(few.vertices[few.faces].mean(axis=1))
    assert away.max() < 0.01
    assert few.uv is not None
    assert np.ptp(few.uv[few.faces][:, :, 0], axis=1).max() < 0.5  # no face runs back over the whole picture
    assert simplified(FINE, 1500) == few


@pytest.mark.parametrize("pieces", [4, 16])
def test_no_face_shows_two_pieces_of_a_texture(pieces: int) -> None:
    # Each face is in the cell of a square of pieces that its middle lies in; with 16 the seams give way.
    middles = (FINE.vertices[FINE.faces].mean(axis=1)[:, :2] / 0.1 + 0.5).clip(0, 0.999)
    cell = np.repeat((middles * pieces).astype(int), 3, axis=0)
    places = FINE.vertices[FINE.faces.ravel()]
    uv = (cell + 0.5 + 0.4 * np.sin(40 * places[:, :2])) / pieces
    mesh = Mesh(vertices=places, faces=np.arange(len(places)).reshape(-1, 3), uv=uv)
    few = simplified(mesh, 1500)
    assert few.uv is not None
    assert len(few.faces) <= 1500
    shown = np.floor(few.uv[few.faces] * pieces)
    assert (shown == shown[:, :1]).all()


def test_parts_share_the_limit_and_small_ones_survive() -> None:
    crumb = moved(box_mesh((0.01, 0.01, 0.01), (0, 0, 0), shared=True), (0.2, 0, 0))
    out = simplify(draft(FINE, moved(FINE, (0.5, 0, 0), 0.5), crumb), 3000)
    counts = [len(p.mesh.faces) for p in out.parts]
    assert sum(counts) < 3600
    assert counts[2] == 12
    assert min(counts) > 0


def test_a_sheet_with_faces_in_both_directions_keeps_both_sides() -> None:
    both = Mesh(vertices=FINE.vertices, faces=np.concatenate([FINE.faces, FINE.faces[:, ::-1]]), uv=FINE.uv)
    few = simplified(both, 3000)
    assert 2000 < len(few.faces) <= 3000
    assert {tuple(sorted(f)) for f in few.faces[: len(few.faces) // 2].tolist()} == {
        tuple(sorted(f)) for f in few.faces[len(few.faces) // 2 :].tolist()
    }


def test_something_is_left_of_faulty_meshes(subtests: pytest.Subtests) -> None:
    for faces in [[[0, 0, 1], [1, 1, 1]], [[0, 1, 2]], [[0, 1, 2], [0, 1, 3], [0, 1, 4], [1, 0, 4]]]:
        with subtests.test(faces=faces):
            places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1e6, 0, 0]], dtype=np.float64)
            few = simplified(Mesh(vertices=places, faces=np.array(faces, dtype=np.int32)), 12)
            assert 0 < len(few.faces) <= len(faces)
            assert np.ptp(few.vertices[few.faces]) <= 1
