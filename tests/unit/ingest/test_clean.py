"""Cleaning: a fault is made, counted, repaired and counted again; what has no fault stays bit for bit."""

from __future__ import annotations

import time
from itertools import product

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.clean import clean
from casa_assets.ingest.components import intersecting_components
from casa_assets.ingest.draft import Draft
from casa_assets.mesh.surface import backward_share, edge_counts, face_components, is_closed, signed_volume
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.meshes import box_mesh, lathe, some, texture
from tests.support.mesh.raw_models import MUG, category, codes, flipped, joined, moved, raw, turned, volume
from tests.support.mesh.solids import box, welded

pytestmark = pytest.mark.content("code", "ingest", keep=0)

BOX = box((1.0, 0.6, 0.3), (0.2, 0.0, 5.0))


def whole(draft: Draft) -> Mesh:
    return Mesh(vertices=draft.surface.vertices, faces=draft.surface.faces)


def test_normals_that_contradict_the_faces_are_left_out_and_others_stay() -> None:
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


class TestWinding:
    def test_inside_out_is_turned(self, subtests: pytest.Subtests) -> None:
        for mesh, share in product([BOX, turned(MUG)], [1.0, 0.5, 0.1]):
            with subtests.test(share=share, mesh=mesh):
                draft = clean(raw(flipped(mesh, share)))
                assert volume(whole(draft)) == pytest.approx(volume(mesh))
                assert is_closed(draft.surface.welded_faces)
                assert codes(draft.notes) == ["MSH011"]

    def test_the_inner_wall_of_a_hollow_body_looks_inwards(self, subtests: pytest.Subtests) -> None:
        walls = [BOX, flipped(box((0.4, 0.3, 0.1), (0.2, 0.0, 5.0)))]
        for inside_out, hollow in product([False, True], [joined(*walls), joined(*walls[::-1])]):
            with subtests.test(hollow=hollow, inside_out=inside_out):
                draft = clean(raw(flipped(hollow) if inside_out else hollow))
                assert volume(whole(draft)) == pytest.approx(0.18 - 0.012)
                assert codes(draft.notes) == ["MSH011"] * inside_out + ["MSH043"]

    @pytest.mark.parametrize("inwards", [False, True])
    def test_an_open_bowl_faces_outwards(self, inwards: bool) -> None:
        bowl = lathe([(0.0, 0.0), (0.05, 0.0), (0.08, 0.06)], 24)
        outward = bowl if signed_volume(bowl.vertices, bowl.faces.astype(np.int64)) > 0 else flipped(bowl)
        draft = clean(raw(flipped(outward) if inwards else outward))
        corners = draft.surface.vertices[draft.surface.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1) - [0, 0, 0.05]) > 0).all()
        assert codes(draft.notes) == ["MSH011"] * inwards + ["MSH022"]


def test_thousands_of_pieces_take_no_minutes() -> None:
    draw = np.random.default_rng(0)
    cubes = flipped(joined(*(moved(BOX, tuple(o), 0.01) for o in draw.random((4000, 3)))), 0.3)
    start = time.process_time()
    draft = clean(raw(cubes))
    assert time.process_time() - start < 5
    ids = draft.surface.welded_faces
    assert face_components(ids, int(ids.max()) + 1).max() > 3000
    assert volume(whole(draft)) == pytest.approx(4000 * 0.18e-6, rel=1e-3)


def sphere(steps: int = 24) -> Mesh:
    """A closed ball of radius 0.05 m about the origin."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, steps // 2 + 1)
    return turned([(0.05 * float(np.cos(a)) if abs(a) < 1.57 else 0.0, 0.05 * float(np.sin(a))) for a in angles], steps)


def welded_mesh(mesh: Mesh) -> Mesh:
    points, faces = welded(mesh)
    return Mesh(vertices=points, faces=faces)


def open_edges(draft: Draft) -> int:
    return int((edge_counts(draft.surface.welded_faces)[1] == 1).sum())


def without(mesh: Mesh, *rows: int) -> Mesh:
    return mesh.replace(faces=np.delete(mesh.faces, rows, axis=0))


def bottomless(mesh: Mesh) -> Mesh:
    """Without the faces that lie lowest."""
    mids = mesh.vertices[mesh.faces].mean(axis=1)
    return mesh.replace(faces=mesh.faces[mids[:, 2] > mids[:, 2].min() + 1e-6])


@settings(max_examples=10, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.01, 0.2), st.floats(0.005, 0.1)), min_size=2, max_size=6),
    st.integers(5, 40),
    st.integers(0, 2**32 - 1),
)
def test_sound_meshes_stay_bit_for_bit(rings: list[tuple[float, float]], steps: int, seed: int) -> None:
    heights = np.cumsum([h for _, h in rings])
    profile = [(0.0, 0.0), *((r, float(z)) for (r, _), z in zip(rings, heights, strict=True))]
    mesh = welded_mesh(turned([*profile, (0.0, float(heights[-1]) + 0.02)], steps))
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    mesh = moved(mesh, (0.3, -2.0, 0.7), matrix=q if np.linalg.det(q) > 0 else -q)
    draft = clean(raw(mesh), category("mug"))
    assert draft.parts[0].mesh.vertices.tobytes() == mesh.vertices.tobytes()
    assert draft.parts[0].mesh.faces.tobytes() == mesh.faces.tobytes()
    assert draft.notes == ()


class TestCracks:
    @pytest.mark.parametrize("shift", [1e-5, 1e-4, 3e-4])
    def test_between_all_faces_are_closed(self, shift: float) -> None:
        ball = sphere(16)
        soup = Mesh(vertices=ball.vertices[ball.faces.ravel()], faces=np.arange(3 * len(ball.faces)).reshape(-1, 3))
        noise = np.random.default_rng(0).uniform(-shift / 2, shift / 2, soup.vertices.shape)
        cracked = soup.with_vertices(soup.vertices + noise)
        assert (edge_counts(welded(cracked)[1])[1] == 1).sum() > 600
        draft = clean(raw(cracked))
        assert open_edges(draft) == 0
        assert codes(draft.notes) == ["MSH040"]
        assert volume(draft.parts[0].mesh) == pytest.approx(volume(ball), rel=0.03)

    def test_wide_gaps_large_openings_and_lone_sheets_stay(self) -> None:
        bowl = turned([(0.0, 0.0), (0.05, 0.0), (0.08, 0.06)])
        draft = clean(raw(bowl))
        assert np.array_equal(draft.parts[0].mesh.vertices, bowl.vertices)
        assert codes(draft.notes) == ["MSH022"]
        assert "MSH040" not in codes(clean(raw(without(BOX, 0, 1), without(moved(BOX, (1.05, 0, 0)), 2, 3))).notes)


class TestHoles:
    def test_a_missing_face_is_closed_and_looks_like_its_surroundings(self) -> None:
        ball = lathe([(0.05 * float(np.sin(a)), -0.05 * float(np.cos(a))) for a in np.linspace(0, np.pi, 65)], 128)
        ball = Mesh(
            vertices=ball.vertices,
            faces=ball.faces if volume(welded_mesh(ball)) > 0 else ball.faces[:, ::-1],
            uv=ball.uv,
            colors=np.full((len(ball.vertices), 4), 77, dtype=np.uint8),
        )
        whole = clean(raw(ball))
        gap = len(ball.faces) // 2
        draft = clean(raw(without(ball, gap, gap + 1)))
        assert codes(whole.notes) == ["MSH010"]
        assert codes(draft.notes) == ["MSH010", "MSH041"]
        assert open_edges(draft) == 0
        mesh = draft.parts[0].mesh
        uv = some(mesh.uv)
        assert (some(mesh.colors)[-1] == 77).all()
        fan = mesh.faces[mesh.faces.max(axis=1) == len(mesh.vertices) - 1]
        corners = fan[fan != len(mesh.vertices) - 1]
        assert (uv[corners].min(axis=0) <= uv[-1]).all()
        assert (uv[-1] <= uv[corners].max(axis=0)).all()
        assert volume(welded_mesh(mesh)) == pytest.approx(volume(welded_mesh(ball)), rel=1e-3)

    def test_drilled_holes_stay(self) -> None:
        ball = welded_mesh(sphere(64))
        pole = int(np.argmax(ball.vertices[:, 2]))
        draft = clean(raw(ball.replace(faces=ball.faces[~(ball.faces == pole).any(axis=1)])))
        assert codes(draft.notes) == ["MSH022"]
        assert open_edges(draft) == 64

    def test_a_missing_side_of_a_full_thing_is_closed_and_that_of_another_stays(self) -> None:
        torn = bottomless(BOX)
        assert open_edges(clean(raw(torn))) == 4
        assert open_edges(clean(raw(torn), category("crate"))) == 4
        draft = clean(raw(torn), category("cereal"))
        assert codes(draft.notes) == ["MSH026"]
        assert open_edges(draft) == 0
        assert volume(welded_mesh(draft.parts[0].mesh)) == pytest.approx(volume(BOX))

    def test_new_faces_have_normals_of_their_own_where_those_of_the_rim_look_elsewhere(self) -> None:
        split = box_mesh((1.0, 0.6, 0.3), (0.2, 0.0, 5.0))
        mesh = clean(raw(bottomless(split)), category("cereal")).parts[0].mesh
        assert volume(welded_mesh(mesh)) == pytest.approx(volume(BOX))
        assert backward_share(mesh.vertices, mesh.faces, some(mesh.normals), 0.5) == 0
        assert np.isin(some(split.normals), mesh.normals).all()


class TestExtras:
    def test_a_bent_backdrop_goes_and_a_bent_shell_stays(self) -> None:
        profile = [(-1.0, 0.0), (0.5, 0.0), (0.8, 0.1), (1.0, 0.4), (1.0, 1.5)]
        points = [(x, y, z) for x, z in profile for y in (-1.0, 1.0)]
        faces = [f for k in range(0, 8, 2) for f in ((k, k + 2, k + 1), (k + 1, k + 2, k + 3))]
        sheet = Mesh(vertices=points, faces=faces)
        mug = moved(turned(MUG), (0, 0, 0.001), 5.0)
        draft = clean(raw(sheet, mug))
        assert [p.name for p in draft.parts] == ["part_1"]
        assert codes(draft.notes) == ["MSH012"]
        assert len(clean(raw(lathe([(0.7, -0.5), (0.7, 1.5)], 24), mug)).parts) == 2
        assert len(clean(raw(turned([(0.0, -0.05), (0.6, -0.05), (1.2, 0.6)]), mug)).parts) == 2

    def test_a_stand_goes_where_the_rest_is_what_it_is_said_to_be(self) -> None:
        slab = box((0.4, 0.4, 0.03), (0.0, 0.0, -0.015))
        bottle = turned([(0.0, 0.0), (0.035, 0.0), (0.035, 0.2), (0.013, 0.25), (0.0, 0.25)])
        draft = clean(raw(slab, bottle), category("bottled_water"))
        assert [p.name for p in draft.parts] == ["part_1"]
        assert "MSH012" in codes(draft.notes)
        assert len(clean(raw(slab, bottle)).parts) == 2
        assert len(clean(raw(slab, moved(BOX, (-0.04, 0.0, -0.97), 0.2)), category("object")).parts) == 2

    def test_specks_go_chains_and_sprinkles_stay(self) -> None:
        ball = sphere()
        far = [moved(ball, (0.09 + 0.005 * k, 0.02 * k, 0.0), 0.01) for k in range(3)]
        near = moved(ball, (0.051, 0.0, 0.0), 0.01)
        chain = [moved(ball, (0.0, 0.0, 0.0505 + 0.001 * k), 0.0101) for k in range(12)]
        draft = clean(raw(ball, *far, near, *chain))
        assert [n.message[:2] for n in draft.notes] == ["3 "]
        assert codes(draft.notes) == ["MSH013"]
        assert len(draft.parts) == 14


class TestHidden:
    @pytest.mark.parametrize(
        "inner",
        [
            moved(BOX, (0.1, 0.0, 2.5), 0.5),
            Mesh(vertices=[[0, 0, 5.0], [0.3, 0, 5.0], [0.3, 0.1, 5.05]], faces=[[0, 1, 2]]),
        ],
        ids=["box", "scrap"],
    )
    def test_what_is_sealed_up_goes(self, inner: Mesh) -> None:
        draft = clean(raw(BOX, inner))
        assert [p.name for p in draft.parts] == ["part_0"]
        assert draft.parts[0].mesh == BOX
        assert codes(draft.notes) == ["MSH042"]

    @pytest.mark.parametrize(
        ("material", "colors"),
        [
            (Material(id="alpha", base_color=(1, 1, 1, 0.3)), None),
            (Material(id="picture", base_color_texture=texture("glass", np.full((2, 2, 4), 90, dtype=np.uint8))), None),
            (Material(id="colours"), np.full((8, 4), 90, dtype=np.uint8)),
        ],
    )
    def test_what_is_seen_through_glass_stays(self, material: Material, colors: npt.NDArray[np.uint8] | None) -> None:
        glass = Mesh(vertices=BOX.vertices, faces=BOX.faces, uv=np.zeros((8, 2)), colors=colors)
        model = raw(glass, moved(BOX, (0.1, 0.0, 2.5), 0.5))
        jar, jam = model.parts
        assert len(clean(model.replace(parts=(jar.replace(material=material), jam))).parts) == 2


def test_an_open_patch_that_shows_its_back_is_turned() -> None:
    """Patches that meet at an edge of three faces: parity says nothing of one by the other."""
    ball = welded_mesh(sphere(24))
    upper = ball.vertices[ball.faces].mean(axis=1)[:, 2] > 0
    ring = np.unique(ball.faces[upper].ravel()[np.isin(ball.faces[upper].ravel(), ball.faces[~upper].ravel())])
    fin = ball.vertices[ring] * 1.2
    order = ring[np.argsort(np.arctan2(ball.vertices[ring][:, 1], ball.vertices[ring][:, 0]))]
    start = len(ball.vertices)
    where = {int(p): start + k for k, p in enumerate(ring)}
    fins = [
        f
        for a, b in zip(order, np.roll(order, -1), strict=True)
        for f in ((a, b, where[int(b)]), (a, where[int(b)], where[int(a)]))
    ]
    faces = np.concatenate([ball.faces[upper][:, ::-1], ball.faces[~upper], np.array(fins)])
    mesh = clean(raw(Mesh(vertices=np.vstack([ball.vertices, fin]), faces=faces))).parts[0].mesh
    corners = mesh.vertices[mesh.faces[: len(ball.faces)]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0).all()


@pytest.mark.parametrize("is_stitched", [False, True])
def test_a_corner_on_the_middle_of_an_edge(is_stitched: bool) -> None:
    """A box, one side of which is cut in two at a corner that its neighbour does not have.

    What held the edges together may have been a face without area.
    """
    cube = box((0.2, 0.2, 0.2))
    a, b, c = cube.faces[0]
    points = np.vstack([cube.vertices, cube.vertices[[a, b]].mean(axis=0)])
    sliver = [(a, b, 8)] * is_stitched
    mesh = Mesh(vertices=points, faces=[*cube.faces[1:], (a, 8, c), (8, b, c), *sliver], uv=points[:, :2])
    assert (edge_counts(mesh.faces.astype(np.int64))[1] == 1).sum() == (0 if is_stitched else 3)
    draft = clean(raw(mesh))
    assert codes(draft.notes) == ["MSH010"] * is_stitched + ["MSH044"]
    assert open_edges(draft) == 0
    out = draft.parts[0].mesh
    assert volume(out) == pytest.approx(0.008)
    assert np.allclose(some(out.uv), out.vertices[:, :2])


def test_a_fin_on_a_scan_is_cut_out() -> None:
    ball = welded_mesh(sphere(256))
    face = ball.faces[len(ball.faces) // 2]
    foot, new = ball.vertices[face[:2]], len(ball.vertices)
    finned = Mesh(
        vertices=np.vstack([ball.vertices, foot * 1.02, foot.mean(axis=0) * 1.04]),
        faces=np.vstack([ball.faces, [[face[0], face[1], new], [face[1], new + 1, new], [new, new + 1, new + 2]]]),
    )
    draft = clean(raw(finned))
    assert codes(draft.notes) == ["MSH045"]
    assert (edge_counts(draft.surface.welded_faces)[1] == 2).all()
    assert volume(welded_mesh(draft.parts[0].mesh)) == pytest.approx(volume(ball), rel=2e-3)


@pytest.mark.parametrize("fin", [[[0, 1, 8]], [[0, 1, 8], [8, 1, 9]]])
def test_a_face_or_two_that_stand_off_are_taken_away(fin: list[list[int]]) -> None:
    points = np.vstack([BOX.vertices, [2, 2, 7], [2, 2, 8], [3, 2, 8]])
    draft = clean(raw(Mesh(vertices=points, faces=np.vstack([BOX.faces, *fin]))))
    assert codes(draft.notes) == ["MSH046"]
    assert draft.parts[0].mesh == BOX


CUP = turned(MUG, 24)
CROSSED_BOX = box((0.1, 0.1, 0.1))


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (joined(CUP, moved(CUP, (0.03, 0.01, 0.0))), ["MSH050"]),
        (CUP, []),
        (joined(CUP, moved(CUP, (0.5, 0.0, 0.0))), []),
        (joined(CROSSED_BOX, moved(CROSSED_BOX, (0.1, 0.0, 0.0))), []),
        (joined(CROSSED_BOX, moved(CROSSED_BOX, scale=0.9)), []),
        (joined(CUP, moved(CROSSED_BOX, (0.05, 0.0, 0.05), 0.3)), []),
    ],
)
def test_what_is_said(mesh: Mesh, said: list[str]) -> None:
    assert codes(tuple(intersecting_components(*welded(mesh)))) == said
