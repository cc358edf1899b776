"""Welding, doubled faces, and fragments: solids that touch stay apart, whatever the file merged."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.segment.welded_mesh import weld_triangles
from tests.unit.articulate.blocks import box, drawers, microwave, together


def pure(label: np.ndarray, owner: np.ndarray) -> bool:
    """No fragment holds faces of two parts."""
    return all(len(set(owner[label == k].tolist())) == 1 for k in range(int(label.max()) + 1))


def test_boxes_that_share_a_face_stay_two_fragments() -> None:
    vertices, faces, owner = together(box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1)))
    mesh = weld_triangles(vertices, faces)
    assert len(mesh.points) == 12
    label = mesh.fragment_labels
    assert label.tolist() == owner.tolist()


def test_no_fragment_straddles_parts_and_none_is_split(subtests: pytest.Subtests) -> None:
    for make in [microwave, drawers]:
        with subtests.test(make=make.__name__):
            vertices, faces, owner = make()  # type: ignore[operator]
            label = weld_triangles(vertices, faces).fragment_labels
            assert pure(label, owner)
            assert int(label.max()) == int(owner.max())


def test_the_order_of_faces_does_not_matter() -> None:
    vertices, faces, owner = drawers()
    order = np.random.default_rng(1).permutation(len(faces))
    label = weld_triangles(vertices, faces[order]).fragment_labels
    assert pure(label, owner[order])
    assert int(label.max()) == int(owner.max())


def test_a_sheet_that_is_written_twice_is_one_fragment() -> None:
    vertices, faces, owner = microwave()
    both = np.concatenate([faces, faces[:, [0, 2, 1]]])
    label = weld_triangles(vertices, both).fragment_labels
    assert label[: len(faces)].tolist() == label[len(faces) :].tolist()
    assert pure(label, np.tile(owner, 2))
    assert int(label.max()) == int(owner.max())


def test_a_frame_turns_normals_and_scales_areas() -> None:
    vertices, faces, _ = together(box((0, 0, 0), (1, 2, 3)))
    mesh = weld_triangles(vertices, faces)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    placed = mesh.transformed(turn, np.array([0.5, 1.0, 1.5]), 2.0)
    assert np.ptp(placed.points, axis=0) == pytest.approx([4.0, 2.0, 6.0])
    assert placed.areas.sum() == pytest.approx(4 * mesh.areas.sum())
    corners = placed.points[placed.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.einsum("ij,ij->i", cross, placed.normals).min() > 0
