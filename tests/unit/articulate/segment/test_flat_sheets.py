"""Holes of flat sheets: where a knob or a door was pulled out of the body, it is a fragment of its own."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.infer import best_score, needed_advantage
from casa_assets.articulate.segment.segmentations import Segmentation, find_flat_sheets, segmentations, split_at_holes
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_triangles
from tests.unit.articulate.blocks import box

# The corners of a square hole in the sheet that looks along -y, and those of the sheet.
INNER = [(0.3, 0.0, 0.3), (0.7, 0.0, 0.3), (0.7, 0.0, 0.7), (0.3, 0.0, 0.7)]
OUTER = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 0.0, 1.0)]


def pulled_out(height: float) -> tuple[WeldedMesh, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
    """A box whose front has a hole, out of which a block stands; and which faces are those of the block."""
    points, faces = box((0, 0, 0), (1, 1, 1))[:2]
    corners = points[faces]
    body = [c for c in corners if not (c[:, 1] == 0.0).all()]
    outer, inner = np.array(OUTER), np.array(INNER)
    raised = inner - (0.0, height, 0.0)
    ring = [(outer[k], outer[(k + 1) % 4], inner[(k + 1) % 4]) for k in range(4)]
    ring += [(outer[k], inner[(k + 1) % 4], inner[k]) for k in range(4)]
    wall = [(inner[k], inner[(k + 1) % 4], raised[(k + 1) % 4]) for k in range(4)]
    wall += [(inner[k], raised[(k + 1) % 4], raised[k]) for k in range(4)]
    block = [*wall, (raised[0], raised[1], raised[2]), (raised[0], raised[2], raised[3])]
    triangles = np.array([*body, *ring, *block])
    is_block = np.arange(len(triangles)) >= len(body) + len(ring)
    return weld_triangles(triangles.reshape(-1, 3), np.arange(triangles.size // 3).reshape(-1, 3)), is_block


def test_what_stands_out_of_a_hole_of_a_flat_sheet_is_a_fragment() -> None:
    mesh, is_block = pulled_out(0.1)
    assert int(mesh.fragment_labels.max()) == 0
    sheets = find_flat_sheets(mesh)
    assert np.flatnonzero(sheets.has_hole[sheets.sheet]).tolist() == list(range(10, 18))
    split = split_at_holes(mesh, sheets)
    assert len(np.unique(split)) == 2
    assert len(np.unique(split[is_block])) == 1


def test_what_stands_out_at_a_concave_crease_is_a_fragment() -> None:
    mesh, is_block = pulled_out(0.1)
    labels = segmentations(mesh)[Segmentation.CREASES]
    assert len(set(labels[is_block].tolist())) == 1
    assert set(labels[is_block].tolist()).isdisjoint(labels[~is_block].tolist())
    inset, is_block = pulled_out(-0.1)  # its rim is convex, and only its floor meets its walls at a concave crease
    assert len(set(segmentations(inset)[Segmentation.CREASES][is_block].tolist())) == 2


def test_a_block_without_a_hole_stays_whole() -> None:
    points, faces = box((0, 0, 0), (1, 2, 3))[:2]
    mesh = weld_triangles(points, faces)
    assert not find_flat_sheets(mesh).rims.size
    assert list(segmentations(mesh)) == [Segmentation.WELDED]


def test_another_plan_is_taken_where_it_is_clearly_better_than_the_first() -> None:
    assert best_score([1.0, 1.4]) == 0
    assert best_score([1.0, 1.7, 1.6]) == 1
    assert best_score([0.0]) == 0
    # Over a plan without any part a part that is rather sure is enough.
    assert best_score([0.0, 0.3], needed_advantage(0)) == 1
    assert best_score([0.1, 0.4], needed_advantage(1)) == 0
