"""Orientation: whatever axis is up in the file, usual things stand as they should; and what cannot be known."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import UP_ROTATIONS, orient
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up
from tests.meshes import box_mesh
from tests.raw_models import BOTTLE, MUG, PLATE, category, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest.pose", keep=0)

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
THINGS = {
    "mug": joined(turned(MUG), HANDLE),
    "bottle": turned(BOTTLE),
    "plate": turned(PLATE),
    "knife": knife(),
}
# What a file in which this axis is up makes of a thing that stands: file from asset.
FILES = {axis: turn.T for axis, turn in UP_ROTATIONS.items()}


def points(state: Draft) -> np.ndarray:
    return state.surface.vertices


def in_file(mesh: Mesh, axis: str) -> Mesh:
    return moved(mesh, matrix=FILES[axis])


def up_axis(state: Draft) -> str:
    return next(g.value for g in state.guesses if g.subject == "up_axis")


def test_the_candidates_are_the_six_rotations() -> None:
    for axis, turn in UP_ROTATIONS.items():
        assert np.linalg.det(turn) == pytest.approx(1)
        assert turn @ turn.T == pytest.approx(np.eye(3))
        named = np.eye(3)["xyz".index(axis[-1])] * (-1 if "minus" in axis else 1)
        assert turn @ named == pytest.approx([0, 0, 1])


def test_the_front_of_gltf_becomes_the_front_of_an_asset() -> None:
    assert UP_ROTATIONS["y"] @ [0, 0, 1] == pytest.approx([0, -1, 0])
    assert UP_ROTATIONS["y"] @ [1, 0, 0] == pytest.approx([1, 0, 0])


def test_usual_axes_of_files_that_state_none(subtests: pytest.Subtests) -> None:
    for form in ["obj", "ply", "unknown"]:
        for axis in ["y", "z"]:
            for name in ["mug", "bottle"]:
                with subtests.test(name=name, axis=axis, form=form):
                    out = orient(draft(in_file(THINGS[name], axis), up=None, form=form), category(name))
                    assert points(out) == pytest.approx(THINGS[name].vertices)
                    assert up_axis(out) == axis
                    assert out.up == "z"


def test_flat_things_lie_flat(subtests: pytest.Subtests) -> None:
    for axis in ["y", "z"]:
        for name in ["plate", "knife"]:
            with subtests.test(name=name, axis=axis):
                out = orient(draft(in_file(THINGS[name], axis), up=None, form="obj"), category(name))
                assert np.ptp(points(out), axis=0)[2] == pytest.approx(np.ptp(THINGS[name].vertices, axis=0)[2])


def test_a_mug_stands_from_any_usual_pose_where_nothing_is_stated(subtests: pytest.Subtests) -> None:
    """With x up it takes more than an opening: no exporter writes that."""
    for axis in ["y", "z", "minus_y", "minus_z"]:
        with subtests.test(axis=axis):
            out = orient(draft(in_file(THINGS["mug"], axis), up=None, form="obj"), category("mug"))
            assert points(out) == pytest.approx(THINGS["mug"].vertices)


def test_the_height_is_right_from_any_pose(subtests: pytest.Subtests) -> None:
    for name, axis in [(name, axis) for name in ("bottle", "plate") for axis in UP_ROTATIONS] + [
        ("knife", a) for a in UP_ROTATIONS if a[-1] != "x"
    ]:
        with subtests.test(name=name, axis=axis):
            out = orient(draft(in_file(THINGS[name], axis), up=None, form="obj"), category(name))
            assert np.ptp(points(out), axis=0)[2] == pytest.approx(np.ptp(THINGS[name].vertices, axis=0)[2])


def test_the_stated_axis_is_obeyed_where_it_is_right(subtests: pytest.Subtests) -> None:
    for stated, axis in [(Up.X, "x"), (Up.Y, "y"), (Up.Z, "z")]:
        for name in list(THINGS):
            with subtests.test(name=name, stated=stated, axis=axis):
                out = orient(draft(in_file(THINGS[name], axis), up=stated, form="glb"), category(name))
                assert points(out) == pytest.approx(THINGS[name].vertices)


def test_things_without_a_usual_pose_keep_the_stated_axis(subtests: pytest.Subtests) -> None:
    for axis in ["y", "z", "x"]:
        with subtests.test(axis=axis):
            orange = box_mesh((0.07, 0.08, 0.09), (0, 0, 0), shared=True)
            out = orient(draft(in_file(orange, axis), up=Up(axis), form="glb"), category("orange"))
            assert up_axis(out) == axis
            assert points(out) == pytest.approx(orange.vertices)


def test_a_sealed_body_is_not_turned_over_against_the_stated_axis() -> None:
    """A symmetric block shows no opening and no foot: which end is up is the file's word alone."""
    block = box_mesh((0.06, 0.06, 0.12), (0, 0, 0), shared=True)
    out = orient(draft(in_file(block, "y"), up=Up.Y, form="glb"), category("can"))
    assert up_axis(out) == "y"


def test_generated_meshes_are_y_up_whatever_the_format() -> None:
    cube = box_mesh((0.08, 0.08, 0.08), (0, 0, 0), shared=True)
    assert up_axis(orient(draft(cube, up=None, form="ply"), category("object"), generated=True)) == "y"
    assert up_axis(orient(draft(cube, up=None, form="ply"), category("object"))) == "z"


def test_normals_turn_with_the_faces() -> None:
    split = moved(box_mesh((0.05, 0.06, 0.1), (0, 0, 0)), matrix=FILES["y"])
    mesh = box_mesh((0.05, 0.06, 0.1), (0, 0, 0))
    assert mesh.normals is not None
    given = split.with_vertices(split.vertices, mesh.normals @ FILES["y"].T)
    out = orient(draft(given, up=Up.Y, form="glb"), category("object")).parts[0].mesh
    assert out.normals == pytest.approx(mesh.normals)


def test_confidence_is_a_probability_and_falls_without_a_statement() -> None:
    mug = in_file(THINGS["mug"], "y")
    stated = orient(draft(mug, up=Up.Y, form="glb"), category("mug")).guesses[0].confidence
    silent = orient(draft(mug, up=None, form="obj"), category("mug")).guesses[0].confidence
    assert 0.5 < silent <= stated <= 1


def test_the_origin_tells_which_end_of_a_symmetric_body_is_its_foot(subtests: pytest.Subtests) -> None:
    for axis in ["y", "minus_y", "z"]:
        with subtests.test(axis=axis):
            can = box_mesh((0.066, 0.066, 0.12), (0, 0, 0.06), shared=True)
            out = orient(draft(in_file(can, axis), up=Up.Y, form="glb"), category("can"))
            assert up_axis(out) == axis
            assert points(out)[:, 2].min() == pytest.approx(0, abs=1e-9)
