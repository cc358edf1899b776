"""Evidence for poses and fronts: rain, feet, handles; and things that are handed in the wrong way up."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import orient
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up, UpAxis, UserOverride
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import BOTTLE, MUG, PLATE, category, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest.pose", keep=0)

Floats = npt.NDArray[np.float64]

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
CUP = joined(turned(MUG), HANDLE)
# Its rim is far wider than its foot.
BOWL = [(0.0, 0.006), (0.02, 0.006), (0.072, 0.07), (0.075, 0.07), (0.022, 0.0), (0.0, 0.0)]
THINGS = {"mug": CUP, "bottle": turned(BOTTLE), "plate": turned(PLATE), "bowl": turned(BOWL)}


def spin(axis: int, degrees: float) -> Floats:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


def posed(mesh: Mesh, turn: Floats, name: str, up: Up | None = Up.Z) -> Draft:
    return orient(draft(moved(mesh, matrix=turn), up=up, form="glb" if up else "obj"), category(name))


def up_of(before: Mesh, after: Draft) -> Floats:
    """Where the z axis of the mesh went."""
    a, b = before.vertices, after.surface.vertices
    left, _, right = np.linalg.svd((b - b.mean(axis=0)).T @ (a - a.mean(axis=0)))
    flip = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    result: Floats = (left @ flip @ right)[:, 2]
    return result


def test_what_lies_or_stands_on_its_head_is_righted_against_the_files_word(subtests: pytest.Subtests) -> None:
    for turn in [spin(0, 180), spin(0, 90), spin(1, 90), spin(1, -90)]:
        for name in list(THINGS):
            with subtests.test(name=name, turn=turn):
                out = posed(THINGS[name], turn, name)
                assert up_of(THINGS[name], out) == pytest.approx([0, 0, 1], abs=1e-6)


def test_what_somebody_let_fall_is_righted(subtests: pytest.Subtests) -> None:
    for name in list(THINGS):
        with subtests.test(name=name):
            turn = spin(0, 37) @ spin(2, 52) @ spin(1, 20)
            out = posed(THINGS[name], turn, name, up=None)
            assert up_of(THINGS[name], out)[2] > np.cos(np.radians(3))


def test_the_handle_points_to_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 30, 90, 145, 180, 270]:
        with subtests.test(degrees=degrees):
            out = posed(CUP, spin(2, degrees), "mug")
            handle = out.surface.vertices[-8:].mean(axis=0) - out.surface.vertices[:-8].mean(axis=0)
            assert handle[0] > 0.03
            assert abs(handle[1]) < 0.006
            assert next(g for g in out.guesses if g.subject == "front").confidence > 0.6


def test_a_knife_lies_along_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 20, 90, 130]:
        with subtests.test(degrees=degrees):
            x, y, z = np.ptp(posed(knife(), spin(2, degrees), "knife").surface.vertices, axis=0)
            assert x > 0.3
            assert y < 0.04
            assert z < y


def test_the_wide_side_of_a_box_is_its_face() -> None:
    box = box_mesh((0.06, 0.19, 0.3), (0, 0, 0), shared=True)
    x, y, z = np.ptp(posed(box, np.eye(3), "cereal", up=None).surface.vertices, axis=0)
    assert (x, y, z) == pytest.approx((0.19, 0.06, 0.3))


def test_a_ruling_is_obeyed_exactly() -> None:
    given = draft(moved(CUP, matrix=spin(0, 180)), up=Up.Z, form="glb")
    out = orient(given, category("mug"), override=UserOverride(up=UpAxis.Z, turn_deg=90))
    assert out.surface.vertices == pytest.approx(moved(CUP, matrix=spin(2, 90) @ spin(0, 180)).vertices)
    assert [g.confidence for g in out.guesses] == [1.0, 1.0]


def test_what_nobody_knows_rests_on_a_side_that_it_can_rest_on() -> None:
    brick = box_mesh((0.05, 0.08, 0.1), (0, 0, 0), shared=True)
    out = orient(draft(moved(brick, matrix=spin(0, 35)), up=None, form="obj"), category("object"))
    height = np.ptp(out.surface.vertices, axis=0)[2]
    assert np.isclose(height, [0.05, 0.08, 0.1], atol=1e-6).any()


def test_a_sheet_is_refused() -> None:
    flat = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
    with pytest.raises(Rejected) as error:
        orient(draft(flat), category("plate"))
    assert error.value.code == "MSH002"
