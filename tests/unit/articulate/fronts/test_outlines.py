"""Pieces of a side that are no fronts by their outline: half a face, and the face of a case with its controls."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.fronts.fronts import select_opening_panels
from casa_assets.articulate.fronts.panels import Panel, find_panels
from casa_assets.articulate.plan import Frame
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from tests.unit.articulate.blocks import box


def split_box(triangles: int) -> MeasuredFragments:
    """A box of which so many of the two triangles of its front are a fragment of their own."""
    points, faces = box((-0.4, -0.3, -0.2), (0.4, 0.3, 0.2))
    frame = Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0 / float(np.linalg.norm(np.ptp(points, axis=0))))
    mesh = weld_triangles(points, faces).in_frame(frame)
    label = np.zeros(len(faces), dtype=np.int64)
    label[np.flatnonzero(mesh.normals[:, 1] < -0.9)[:triangles]] = 1
    return measure_fragments(mesh, label)


def panels_of_front(measured: MeasuredFragments) -> list[Panel]:
    return [p for p in find_panels(measured) if 1 in p.members]


def test_half_a_face_is_no_panel() -> None:
    assert len(panels_of_front(split_box(2))) == 1
    assert not panels_of_front(split_box(1))


def test_the_face_of_a_case_with_controls_does_not_open() -> None:
    measured = split_box(2)
    (panel,) = panels_of_front(measured)
    panel.controls = 2
    assert not select_opening_panels(measured, [panel], [])
