"""Orientation: the file's word, usual poses, what lies or stands on its head, handles and fronts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import orient
from casa_assets.ingest.up_axis import UP_ROTATIONS
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up, UpAxis, UserOverride
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import BOTTLE, MUG, PLATE, category, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest", keep=0)

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
THINGS = {"mug": joined(turned(MUG), HANDLE), "bottle": turned(BOTTLE), "plate": turned(PLATE), "knife": knife()}
MUG_AND_BOTTLE = ("mug", "bottle")
# What a file in which this axis is up makes of a thing that stands: file from asset.
FILES = {axis: turn.T for axis, turn in UP_ROTATIONS.items()}


def points(state: Draft) -> np.ndarray:
    return state.surface.vertices


def in_file(mesh: Mesh, axis: str) -> Mesh:
    return moved(mesh, matrix=FILES[axis])


def up_axis(state: Draft) -> str:
    return next(g.value for g in state.guesses if g.subject == "up_axis")


def test_the_front_of_gltf_becomes_the_front_of_an_asset() -> None:
    assert UP_ROTATIONS["y"] @ [0, 0, 1] == pytest.approx([0, -1, 0])
    assert UP_ROTATIONS["y"] @ [1, 0, 0] == pytest.approx([1, 0, 0])


UNSTATED = [
    # A mug, a bottle with the usual axes of files. With x up it takes more than an opening: no exporter writes that.
    *((name, axis, None, form, True) for form in ("obj", "ply", "unknown") for axis in "yz" for name in MUG_AND_BOTTLE),
    *(("mug", axis, None, "obj", True) for axis in ("minus_y", "minus_z")),
    # The height alone is right from any pose; a knife with x up is none of them.
    *((name, axis, None, "obj", False) for name in ("bottle", "plate") for axis in UP_ROTATIONS),
    *(("knife", axis, None, "obj", False) for axis in UP_ROTATIONS if axis[-1] != "x"),
]
STATED = [(name, axis, Up(axis), "glb", True) for axis in "xyz" for name in THINGS]


def test_usual_things_stand_as_they_should(subtests: pytest.Subtests) -> None:
    for name, axis, stated, form, is_exact in [*UNSTATED, *STATED]:
        with subtests.test(name=name, axis=axis, stated=stated, form=form):
            out, usual = orient(draft(in_file(THINGS[name], axis), up=stated, form=form), category(name)), THINGS[name]
            assert np.ptp(points(out), axis=0)[2] == pytest.approx(np.ptp(usual.vertices, axis=0)[2])
            if is_exact:
                assert points(out) == pytest.approx(usual.vertices)
                assert up_axis(out) == axis
                assert out.up == "z"


def test_the_origin_tells_which_end_of_a_symmetric_body_is_its_foot(subtests: pytest.Subtests) -> None:
    for axis in ["y", "minus_y", "z"]:
        with subtests.test(axis=axis):
            can = box_mesh((0.066, 0.066, 0.12), (0, 0, 0.06), shared=True)
            out = orient(draft(in_file(can, axis), up=Up.Y, form="glb"), category("can"))
            assert up_axis(out) == axis
            assert points(out)[:, 2].min() == pytest.approx(0, abs=1e-9)


Floats = npt.NDArray[np.float64]

CUP = joined(turned(MUG), HANDLE)
# Its rim is far wider than its foot.
BOWL = [(0.0, 0.006), (0.02, 0.006), (0.072, 0.07), (0.075, 0.07), (0.022, 0.0), (0.0, 0.0)]
LYING_THINGS = {"mug": CUP, "bottle": turned(BOTTLE), "plate": turned(PLATE), "bowl": turned(BOWL)}


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
        for name in list(LYING_THINGS):
            with subtests.test(name=name, turn=turn):
                out = posed(LYING_THINGS[name], turn, name)
                assert up_of(LYING_THINGS[name], out) == pytest.approx([0, 0, 1], abs=1e-6)


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


def test_the_wide_side_with_most_relief_is_the_face() -> None:
    knob = box_mesh((0.02, 0.04, 0.04), (0.04, 0.0, 0.05), shared=True)
    box = joined(box_mesh((0.06, 0.19, 0.3), (0, 0, 0), shared=True), knob)
    vertices = posed(box, np.eye(3), "cereal", up=None).surface.vertices
    assert np.ptp(vertices[:-8], axis=0) == pytest.approx((0.19, 0.06, 0.3))
    assert (vertices[-8:].mean(axis=0) - vertices[:-8].mean(axis=0))[1] == pytest.approx(-0.04)


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
