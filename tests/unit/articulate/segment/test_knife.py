"""Blades: what they cut fits together again, and carries what hung on it."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.segment.cutting import CutPlane, cut_triangles
from casa_assets.articulate.segment.orthographic import FRONT, TOP
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import is_closed
from tests.unit.articulate.blocks import box

WIDE = np.full(3, 10.0)


def test_a_box_cut_across_stays_closed_and_keeps_its_surface() -> None:
    points, faces = box((0, 0, 0), (1, 1, 1))
    done = cut_triangles(points, faces, [CutPlane(FRONT, 0, 0.3, -WIDE, WIDE), CutPlane(TOP, 1, 0.6, -WIDE, WIDE)])
    after = done.interpolate(points)
    assert is_closed(done.faces)
    assert face_normals(after, done.faces)[1].sum() == pytest.approx(6.0)
    x = after[done.faces][:, :, 0]
    assert ((x.max(axis=1) <= 0.3 + 1e-12) | (x.min(axis=1) >= 0.3 - 1e-12)).all()
    y = after[done.faces][:, :, 1]
    assert ((y.max(axis=1) <= 0.6 + 1e-12) | (y.min(axis=1) >= 0.6 - 1e-12)).all()


def test_what_hangs_on_points_is_carried_along_the_edges() -> None:
    points, faces = box((0, 0, 0), (1, 2, 3))
    done = cut_triangles(points, faces, [CutPlane(FRONT, 2, 0.7, -WIDE, WIDE), CutPlane(FRONT, 0, 0.2, -WIDE, WIDE)])
    linear = points @ np.array([[1.0, 2.0], [0.5, -1.0], [3.0, 0.25]])
    assert np.allclose(
        done.interpolate(linear), done.interpolate(points) @ np.array([[1.0, 2.0], [0.5, -1.0], [3.0, 0.25]])
    )


def test_a_blade_cuts_within_its_limits_alone() -> None:
    points, faces = box((0, 0, 0), (1, 1, 1))
    low, high = np.array([0.0, 0.0, -0.1]), np.array([1.0, 1.0, 0.1])
    done = cut_triangles(points, faces, [CutPlane(FRONT, 0, 0.5, low, high)])
    after = done.interpolate(points)
    fresh = after[len(points) :]
    assert len(fresh)
    assert (fresh[:, 1] <= 0.1 + 1e-5).all()
    assert is_closed(done.faces)
