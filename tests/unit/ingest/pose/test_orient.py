"""Orientation: whatever axis is up in the file, usual things stand as they should; and what cannot be known."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import UP_ROTATIONS, orient
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import BOTTLE, MUG, PLATE, category, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest.pose", keep=0)

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
THINGS = {
    "mug": joined(turned(MUG), HANDLE),
    "bottle": turned(BOTTLE),
    "plate": turned(PLATE),
    "knife": knife(),
}
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


def test_a_sealed_body_is_not_turned_over_against_the_stated_axis() -> None:
    """A symmetric block shows no opening and no foot: which end is up is the file's word alone."""
    block = box_mesh((0.06, 0.06, 0.12), (0, 0, 0), shared=True)
    out = orient(draft(in_file(block, "y"), up=Up.Y, form="glb"), category("can"))
    assert up_axis(out) == "y"


def test_generated_meshes_are_y_up_whatever_the_format() -> None:
    cube = box_mesh((0.08, 0.08, 0.08), (0, 0, 0), shared=True)
    assert up_axis(orient(draft(cube, up=None, form="ply"), category("object"), generated=True)) == "y"
    assert up_axis(orient(draft(cube, up=None, form="ply"), category("object"))) == "z"


def test_the_origin_tells_which_end_of_a_symmetric_body_is_its_foot(subtests: pytest.Subtests) -> None:
    for axis in ["y", "minus_y", "z"]:
        with subtests.test(axis=axis):
            can = box_mesh((0.066, 0.066, 0.12), (0, 0, 0.06), shared=True)
            out = orient(draft(in_file(can, axis), up=Up.Y, form="glb"), category("can"))
            assert up_axis(out) == axis
            assert points(out)[:, 2].min() == pytest.approx(0, abs=1e-9)
