"""Hostile meshes through all stages: each becomes a sound asset or is rejected with a code the registry explains."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import MUG, built, codes, flipped, joined, moved, raw, turned

pytestmark = pytest.mark.content("code", "ingest", keep=0)

CUP = turned(MUG, 12)
BOX = box_mesh((0.08, 0.08, 0.1), (0, 0, 0.05), shared=True)
DRAW = np.random.default_rng(0)
BALL = turned([(0.04 * float(np.sin(t)), -0.04 * float(np.cos(t))) for t in np.linspace(0, np.pi, 9)], 12)
SHEET = Mesh(vertices=[[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
TRIANGLE = Mesh(vertices=[[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], faces=[[0, 1, 2]])


def soup(count: int, size: float) -> Mesh:
    """Loose triangles in a cube of 10 cm."""
    corners = DRAW.random((count, 1, 3)) * 0.1 + DRAW.normal(size=(count, 3, 3)) * size
    return Mesh(vertices=corners.reshape(-1, 3), faces=np.arange(3 * count).reshape(-1, 3))


def with_faces(mesh: Mesh, *faces: tuple[int, int, int], points: tuple[tuple[float, float, float], ...] = ()) -> Mesh:
    vertices = np.concatenate([mesh.vertices, np.array(points).reshape(-1, 3)])
    return Mesh(vertices=vertices, faces=np.concatenate([mesh.faces, np.array(faces)]))


REFUSED = {
    "single_triangle": (TRIANGLE, {"MSH002"}),
    "all_vertices_same": (Mesh(vertices=np.full((9, 3), 0.3), faces=[[0, 1, 2], [3, 4, 5], [6, 7, 8]]), {"MSH001"}),
    "line": (Mesh(vertices=np.outer(np.arange(6), [1, 2, 3]), faces=[[0, 1, 2], [3, 4, 5]]), {"MSH001"}),
    "needle": (box_mesh((1.0, 1e-6, 1e-6), (0, 0, 0), shared=True), {"MSH001", "MSH002"}),
    "sheet": (SHEET, {"MSH002"}),
    "sheet_on_both_sides": (with_faces(SHEET, (2, 1, 0), (3, 2, 0)), {"MSH002"}),
    "no_faces": (Mesh(vertices=SHEET.vertices, faces=np.empty((0, 3))), {"MSH001"}),
    "beyond_all_units": (moved(BOX, scale=1e40), {"MSH001", "MSH002", "MSH003"}),
}
BUILT = {
    "tiny_numbers": moved(BOX, scale=1e-9),
    "huge_numbers": moved(BOX, scale=1e10),
    "far_away": moved(BOX, (1e5, -1e5, 1e5)),
    "crumbs": joined(*(moved(BOX, tuple(o), 0.05) for o in (DRAW.random((40, 3)) * 0.1).tolist())),
    "two_overlapping": joined(BOX, moved(BOX, (0.03, 0.02, 0.01))),
    "fin": with_faces(BOX, (0, 1, 8), points=((0.1, 0.1, 0.1),)),
    "half_open_ball": Mesh(vertices=BALL.vertices, faces=BALL.faces[len(BALL.faces) // 2 :]),
    "nested_shells": joined(BALL, flipped(moved(BALL, scale=0.9))),
    "nested_the_wrong_way": joined(flipped(moved(BALL, scale=0.9)), flipped(BALL)),
    "random_winding": flipped(CUP, 0.5),
    "soup": soup(30, 0.03),
    "confetti": soup(300, 0.002),
    "needles": soup(100, 0.05).with_vertices(soup(100, 0.05).vertices * [1, 1e-3, 1]),
    "thin_card": box_mesh((0.1, 0.07, 0.0002), (0, 0, 0), shared=True),
    "wire": box_mesh((0.2, 0.001, 0.001), (0, 0, 0), shared=True),
    "two_touching_in_one_point": joined(BOX, moved(BOX, (0.08, 0.08, 0.1))),
    "an_unused_vertex_far_off": with_faces(BOX, (0, 1, 3), points=((1e9, 0, 0),)),
    "a_floater_far_off": joined(BOX, moved(TRIANGLE, (50, 0, 0), 0.01)),
}


def test_is_rejected_with_a_code(subtests: pytest.Subtests) -> None:
    for name, (mesh, wanted) in REFUSED.items():
        with subtests.test(name=name), pytest.raises(Rejected, match=f"^({'|'.join(wanted)}): "):
            built(raw(mesh), "mug")
        assert wanted <= registry.load().rejections.keys()


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.certify] * (n == "confetti")) for n in BUILT])
def test_becomes_an_asset(name: str) -> None:
    asset, notes = built(raw(BUILT[name]), "object")
    known = registry.load()
    assert set(codes(notes)) <= set(known.rejections)
    low, high = asset.bounds
    span = known.category("object").longest_m
    assert span.low / 1.3 <= (high - low).max() <= span.high * 1.3
    assert low[2] == pytest.approx(0, abs=1e-6)
    assert (low + high)[:2] == pytest.approx([0, 0], abs=1e-5)
    assert 1 <= len(asset.root.colliders) <= 32
    assert all(len(v.mesh.vertices) >= 4 for v in asset.root.visuals)
    # From a wire of 0.2 cubic centimetres to a box that two people carry; what is of no known kind has no usual mass.
    assert 1e-4 <= asset.mass <= 75.0


def test_the_same_input_gives_the_same_asset_and_a_lone_triangle_with_a_look_of_its_own_no_visual() -> None:
    model = raw(joined(CUP, moved(BOX, (0.05, 0, 0.03), 0.2)), moved(TRIANGLE, (0.0, 0.0, 0.03), 0.1), up=Up.Y)
    first, second = (built(model, "mug")[0] for _ in range(2))
    assert first.to_json() == second.to_json()
    assert all(len(v.mesh.vertices) >= 4 for v in first.root.visuals)
