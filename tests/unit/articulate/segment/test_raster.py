"""Pictures of triangles: every pixel centre that a triangle covers, at its depth, the nearest in front."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.segment import orthographic
from casa_assets.articulate.segment.orthographic import BACK, FRONT, LEFT, SIDES, TOP, render_depth
from tests.unit.articulate.blocks import box, together


def test_a_box_fills_its_rectangle_from_every_side() -> None:
    vertices, faces, _ = together(box((0, 0, 0), (2, 1, 4)))
    for side, (width, height) in ((FRONT, (32, 64)), (LEFT, (16, 64)), (TOP, (64, 32))):
        picture = render_depth(vertices, faces, SIDES[side], 64)
        assert picture.face.shape == (height, width)
        assert (picture.face >= 0).all()
        assert picture.depth == pytest.approx(0.0, abs=1e-6)


def test_the_nearer_thing_is_seen_and_the_other_from_behind() -> None:
    vertices, faces, owner = together(box((0, 0, 0), (1, 0.1, 1)), box((0, 0.5, 0), (1, 0.6, 1)))
    assert set(owner[render_depth(vertices, faces, SIDES[FRONT], 32).face.ravel()].tolist()) == {0}
    assert set(owner[render_depth(vertices, faces, SIDES[BACK], 32).face.ravel()].tolist()) == {1}


def test_two_triangles_cover_a_pixel_grid_once() -> None:
    """Neighbouring triangles leave no hole, at any angle."""
    for angle in np.linspace(0, np.pi, 7):
        c, s = np.cos(angle), np.sin(angle)
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1.0]]) @ np.array([[c, s], [-s, c]])
        vertices = np.stack([square[:, 0], np.zeros(4), square[:, 1]], axis=1)
        picture = render_depth(vertices, np.array([[0, 1, 2], [0, 2, 3]]), SIDES[FRONT], 128)
        area = float((picture.face >= 0).sum()) * picture.pixel**2
        assert area == pytest.approx(4.0, rel=0.02)


def test_the_picture_does_not_depend_on_how_much_is_written_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces, _ = together(box((0, 0, 0), (2, 1, 4)), box((0.3, -0.4, 1.1), (1.1, 0.2, 2.7)))
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    whole = render_depth(vertices @ turn.T, faces, SIDES[FRONT], 64)
    monkeypatch.setattr(orthographic, "CHUNK", 150)
    parted = render_depth(vertices @ turn.T, faces, SIDES[FRONT], 64)
    assert (whole.face == parted.face).all()
    assert (whole.depth == parted.depth).all()
