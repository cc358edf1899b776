"""Labelled cases: changes keep the truth, and drawings have joints that open outward."""

import numpy as np
import pytest

from benchmarks.articulate.cases.changes import CHANGES, changed
from benchmarks.articulate.cases.fuse import fused
from benchmarks.articulate.cases.labelled import FRONTS, LabelledMesh, read_case, write_case
from benchmarks.articulate.cases.manners import MANNERS, in_manner
from benchmarks.articulate.cases.parts import outward
from benchmarks.articulate.cases.plain.draw import KINDS, draw
from benchmarks.articulate.cases.surfaces import by_position
from casa_assets.mesh.topology import face_components, weld

# What changes how faces are stored, and leaves every surface where it is.
STORED_OTHERWISE = ("split_groups", "loose_pieces", "axes")


def areas(mesh: LabelledMesh) -> dict[int, float]:
    """Area of each part."""
    return {row["id"]: float(mesh.areas[mesh.part == row["id"]].sum()) for row in mesh.parts}


@pytest.fixture(scope="module")
def cabinet() -> LabelledMesh:
    """A cabinet with doors and drawers that stand before it, with boxes behind the drawers."""
    mesh = draw("cabinet", 2, 13)
    assert {row["type"] for row in mesh.parts} == {"door", "drawer"}
    return mesh


def test_change_leaves_every_part_its_faces_and_the_file_says_which(
    subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory
) -> None:
    for kind in ["cabinet", "microwave"]:
        for change in list(CHANGES):
            with subtests.test(change=change, kind=kind):
                tmp_path = tmp_path_factory.mktemp("case")
                mesh = draw(kind, 2, 3)
                after = changed(mesh, change, seed=1)
                write_case(tmp_path / "case", after)
                again = read_case(tmp_path / "case")
                assert [row["id"] for row in again.parts] == [row["id"] for row in mesh.parts]
                np.testing.assert_array_equal(again.part, after.part)
                before, now = areas(mesh), areas(again)
                if change not in {"empty_inside", "holes"}:  # these may take a whole part away
                    assert all(now[k] > 0 for k in before)
                for row in again.parts:
                    cloud = again.points[again.faces[again.part == row["id"]]].reshape(-1, 3)
                    if len(cloud):
                        np.testing.assert_allclose(row["bbox"], [cloud.min(axis=0), cloud.max(axis=0)])


def test_change_of_how_faces_are_stored_keeps_their_area(subtests: pytest.Subtests, cabinet: LabelledMesh) -> None:
    for change in STORED_OTHERWISE:
        with subtests.test(change=change):
            after = changed(cabinet, change, seed=1)
            share = after.diagonal / cabinet.diagonal
            assert {k: v / share**2 for k, v in areas(after).items()} == pytest.approx(areas(cabinet))


def test_double_faces_at_most_double_a_part(cabinet: LabelledMesh) -> None:
    before, after = areas(cabinet), areas(changed(cabinet, "double_faces", seed=1))
    assert sum(after.values()) > sum(before.values())
    assert all(1 - 1e-9 <= after[k] / before[k] <= 2 + 1e-9 for k in before)


def test_touching_parts_are_one_piece_with_a_sheet_of_the_body_once_positions_are_one(cabinet: LabelledMesh) -> None:
    def joined_to_body(mesh: LabelledMesh) -> int:
        whole = by_position(mesh)
        piece = face_components(whole.faces, len(whole.points))
        body = set(piece[whole.part == 0].tolist())
        return sum(bool(set(piece[whole.part == row["id"]].tolist()) & body) for row in whole.parts)

    assert joined_to_body(changed(cabinet, "touching", seed=1)) == len(cabinet.parts)


def test_split_groups_keep_positions_but_no_common_vertices(cabinet: LabelledMesh) -> None:
    after = changed(cabinet, "split_groups", seed=1)
    count = lambda m: int(face_components(m.faces, len(m.points)).max()) + 1  # noqa: E731
    assert count(after) > count(cabinet)
    assert len(weld(after.points)[0]) == len(weld(cabinet.points)[0])


def test_drawn_fronts_open_outward(subtests: pytest.Subtests) -> None:
    for kind in list(KINDS):
        with subtests.test(kind=kind):
            for index in range(6):
                mesh = draw(kind, 5, index)
                assert mesh.parts
                for row in mesh.parts:
                    joint = row["joint"]
                    cloud = mesh.points[mesh.faces[mesh.part == row["id"]]].reshape(-1, 3)
                    assert len(cloud), row["name"]
                    assert np.linalg.norm(joint["axis"]) == pytest.approx(1.0)
                    if row["type"] in FRONTS and joint["range"][0] == 0.0 and joint["type"] == "revolute":
                        arm = cloud.mean(axis=0) - np.array(joint["origin"])
                        way = np.cross(joint["axis"], arm)
                        middle = (mesh.points.min(axis=0) + mesh.points.max(axis=0)) / 2
                        assert way @ (cloud.mean(axis=0) - middle) > 0 or kind == "laptop"
                    if row["type"] == "drawer":
                        np.testing.assert_allclose(outward(mesh, row), [0, -1, 0], atol=1e-9)


def test_manner_is_the_same_for_the_same_seed(subtests: pytest.Subtests, cabinet: LabelledMesh) -> None:
    for manner in list(MANNERS):
        with subtests.test(manner=manner):
            one, names = in_manner(cabinet, manner, seed=3)
            two, again = in_manner(cabinet, manner, seed=3)
            assert names == again
            np.testing.assert_array_equal(one.points, two.points)
            np.testing.assert_array_equal(one.part, two.part)


def test_fused_shell_shows_every_front(cabinet: LabelledMesh) -> None:
    mesh, shell = fused(cabinet)
    assert all(row["visible"] > 0.1 for row in mesh.parts)
    assert {row["id"] for row in mesh.parts} <= set(shell.part.tolist())
