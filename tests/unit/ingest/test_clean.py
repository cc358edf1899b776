"""Cleaning: what is dropped, what is turned, what is refused, and what has to stay."""

from __future__ import annotations

import time

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.topology import face_components, is_closed
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.meshes import box_mesh, lathe
from tests.support.mesh.raw_models import MUG, codes, flipped, joined, moved, raw, turned, volume

pytestmark = pytest.mark.content("code", "ingest", keep=0)

BOX = box_mesh((1.0, 0.6, 0.3), (0.2, 0.0, 5.0), shared=True)
SMALL = box_mesh((0.4, 0.3, 0.1), (0.2, 0.0, 5.0), shared=True)


def whole(draft: Draft) -> Mesh:
    return Mesh(vertices=draft.surface.vertices, faces=draft.surface.faces)


def closed(draft: Draft) -> bool:
    return is_closed(draft.surface.welded_faces)


class TestNormals:
    def test_that_contradict_the_faces_are_left_out_and_others_stay(self) -> None:
        away = BOX.vertices - BOX.vertices.mean(axis=0)
        outward = away / np.linalg.norm(away, axis=1, keepdims=True)
        good, bad = BOX.with_vertices(BOX.vertices, outward), BOX.with_vertices(BOX.vertices + 0.1, -outward)
        draft = clean(raw(good, bad))
        first, second = (part.mesh for part in draft.parts)
        assert first == good
        assert second == bad.with_vertices(bad.vertices)
        assert "MSH025" in codes(draft.notes)
        assert "MSH025" not in codes(clean(raw(good)).notes)


class TestFacesDropped:
    @pytest.mark.parametrize(
        ("points", "faces", "said"),
        [
            pytest.param([], BOX.faces[:5, [1, 2, 0]], "5 of 17", id="doubled"),
            pytest.param(
                [(BOX.vertices[0] + BOX.vertices[1]) / 2, BOX.vertices[1]],
                [[0, 0, 1], [2, 3, 2], [8, 9, 8], [0, 8, 9]],
                "4 of 16",
                id="degenerate",
            ),
            pytest.param([[1e6, 0, 0]], [], "", id="unused vertices"),
        ],
    )
    def test_what_adds_nothing(self, points: list[Floats], faces: Ints, said: str) -> None:
        mesh = Mesh(
            vertices=np.concatenate([BOX.vertices, np.reshape(points, (-1, 3))]),
            faces=np.concatenate([BOX.faces, np.reshape(faces, (-1, 3))]),
        )
        draft = clean(raw(mesh))
        assert draft.parts[0].mesh == BOX
        assert codes(draft.notes) == ["MSH010"] * bool(said)
        assert said in "".join(n.message for n in draft.notes)

    def test_reversed_doubles_of_a_closed_body(self) -> None:
        draft = clean(raw(Mesh(vertices=BOX.vertices, faces=np.concatenate([BOX.faces, BOX.faces[:, ::-1]]))))
        assert len(draft.parts[0].mesh.faces) == 12
        assert volume(whole(draft)) == pytest.approx(0.18)

    def test_other_columns_follow_their_vertices(self) -> None:
        uv = np.random.default_rng(0).random((10, 2))
        points = np.concatenate([np.full((2, 3), 7.0), BOX.vertices])
        colors = np.arange(40, dtype=np.uint8).reshape(10, 4)
        mesh = Mesh(vertices=points, faces=BOX.faces + 2, uv=uv, colors=colors)
        out = clean(raw(mesh)).parts[0].mesh
        assert out.uv is not None
        assert out.colors is not None
        assert (out.uv == uv[2:]).all()
        assert (out.colors == colors[2:]).all()


class TestWinding:
    def test_inside_out_is_turned(self, subtests: pytest.Subtests) -> None:
        for mesh in [BOX, turned(MUG)]:
            for share in [1.0, 0.5, 0.1]:
                with subtests.test(share=share, mesh=mesh):
                    draft = clean(raw(flipped(mesh, share)))
                    assert volume(whole(draft)) == pytest.approx(volume(mesh))
                    assert closed(draft)
                    assert codes(draft.notes) == ["MSH011"]

    def test_the_inner_wall_of_a_hollow_body_looks_inwards(self, subtests: pytest.Subtests) -> None:
        for inside_out in [False, True]:
            for inner_first in [False, True]:
                with subtests.test(inner_first=inner_first, inside_out=inside_out):
                    walls = [BOX, flipped(SMALL)]
                    hollow = joined(*(walls[::-1] if inner_first else walls))
                    draft = clean(raw(flipped(hollow) if inside_out else hollow))
                    assert volume(whole(draft)) == pytest.approx(0.18 - 0.012)
                    assert codes(draft.notes) == (["MSH011", "MSH043"] if inside_out else ["MSH043"])

    def test_an_inverted_fruit_in_a_bowl_is_turned(self) -> None:
        fruit = box_mesh((0.02, 0.02, 0.02), (0.0, 0.0, 0.05), shared=True)
        draft = clean(raw(turned(MUG), flipped(fruit)))
        assert volume(draft.parts[1].mesh) > 0
        assert codes(draft.notes) == ["MSH011"]

    @pytest.mark.parametrize("inwards", [False, True])
    def test_an_open_bowl_faces_outwards(self, inwards: bool) -> None:
        bowl = lathe([(0.0, 0.0), (0.05, 0.0), (0.08, 0.06)], 24)
        outward = bowl if signed_volume(bowl.vertices, bowl.faces.astype(np.int64)) > 0 else flipped(bowl)
        draft = clean(raw(flipped(outward) if inwards else outward))
        corners = draft.surface.vertices[draft.surface.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        away = corners.mean(axis=1) - [0, 0, 0.05]
        assert (np.einsum("ij,ij->i", normals, away) > 0).all()
        assert codes(draft.notes) == (["MSH011", "MSH022"] if inwards else ["MSH022"])

    def test_normals_go_where_faces_were_turned(self) -> None:
        split = box_mesh((1, 1, 1), (0, 0, 0))
        assert clean(raw(split)).parts[0].mesh.normals is not None
        inverted = Mesh(vertices=split.vertices, faces=split.faces[:, ::-1], normals=split.normals)
        assert clean(raw(inverted)).parts[0].mesh.normals is None


class TestRefused:
    @pytest.mark.parametrize(
        ("points", "faces"),
        [
            (np.zeros((3, 3)), [[0, 1, 2]]),
            ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]]),
            (np.full((3, 3), 5.0), [[0, 1, 2]]),
            (BOX.vertices, np.empty((0, 3))),
        ],
    )
    def test_without_area(self, points: Floats, faces: Ints) -> None:
        with pytest.raises(Rejected) as error:
            clean(raw(Mesh(vertices=points, faces=faces)))
        assert error.value.code == "MSH001"

    @pytest.mark.parametrize("tilt", [0.0, 0.7])
    def test_flat(self, tilt: float) -> None:
        grid = np.array([[x, y * np.cos(tilt), y * np.sin(tilt)] for x in range(4) for y in range(4)])
        faces = [
            f for i in range(3) for j in range(3) for k in [4 * i + j] for f in ((k, k + 1, k + 5), (k, k + 5, k + 4))
        ]
        with pytest.raises(Rejected) as error:
            clean(raw(Mesh(vertices=grid, faces=faces)))
        assert error.value.code == "MSH002"


def test_thousands_of_pieces_take_no_minutes() -> None:
    draw = np.random.default_rng(0)
    cubes = flipped(joined(*(moved(BOX, tuple(o), 0.01) for o in draw.random((4000, 3)))), 0.3)
    start = time.process_time()
    draft = clean(raw(cubes))
    assert time.process_time() - start < 5
    ids = draft.surface.welded_faces
    assert face_components(ids, int(ids.max()) + 1).max() > 3000
    assert volume(whole(draft)) == pytest.approx(4000 * 0.18e-6, rel=1e-3)
