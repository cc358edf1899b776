"""Solids out of fields and torn meshes, cut, measured, and what they would hold."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.errors import DegenerateShape
from casa_assets.ingest.collision.solid_proxy import isosurface
from casa_assets.mesh.solid.deviation import deviation, excess, reference_surface
from casa_assets.mesh.solid.solids import (
    hull_planes,
    hull_volume,
    hull_within_tolerance,
    solid_of,
    without_voids,
)
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.topology import is_closed
from tests.support.mesh.raw_models import MUG, flipped, joined, moved, turned
from tests.support.mesh.solids import box, solid, welded

POINTS, FACES = welded(turned(MUG, 32))
BOX = box((0.1, 0.06, 0.04), (0.0, 0.0, 0.02))


class TestIsosurface:
    def test_a_ball_has_the_volume_of_a_ball(self) -> None:
        grid = np.stack(np.meshgrid(*[np.arange(24.0)] * 3, indexing="ij"), axis=-1) - 11.3
        points, faces = isosurface(8.0 - np.linalg.norm(grid, axis=-1), np.array([1.0, 2.0, 3.0]), 0.5)
        assert is_closed(faces)
        assert signed_volume(points, faces) == pytest.approx(4 / 3 * np.pi * 4**3, rel=0.03)
        assert points.mean(axis=0) == pytest.approx(np.array([1.0, 2.0, 3.0]) + 0.5 * 11.3, abs=0.1)

    def test_noise_is_a_manifold_too(self) -> None:
        field = np.full((12, 12, 12), -1.0)
        field[1:-1, 1:-1, 1:-1] = np.random.default_rng(3).normal(size=(10, 10, 10))
        points, faces = isosurface(field, np.zeros(3), 1.0)
        assert is_closed(faces)
        assert solid_of(points, faces) is not None


class TestCutting:
    def test_what_is_sealed_in_is_filled_and_what_lies_beside_is_kept(self) -> None:
        room = flipped(moved(BOX, scale=0.5, offset=(0.0, 0.0, 0.01)))
        whole = without_voids(solid(joined(BOX, room, moved(BOX, (0.3, 0.0, 0.0)))))
        assert whole.volume() == pytest.approx(2 * 0.1 * 0.06 * 0.04, rel=1e-6)

    def test_a_lean_hull_is_small_and_close(self) -> None:
        ball = np.random.default_rng(0).normal(size=(3000, 3))
        ball *= 0.05 / np.linalg.norm(ball, axis=1, keepdims=True)
        lean = hull_within_tolerance(ball, 40, 0.0005)
        assert len(lean) <= 40
        assert 0.8 * hull_volume(ball) < hull_volume(lean) <= hull_volume(ball) * (1 + 1e-9)
        with pytest.raises(DegenerateShape):
            hull_within_tolerance(ball * [1, 1, 0], 40, 0.0005)


class TestDeviation:
    def test_a_box_that_is_too_large_sticks_out_by_that_much(self) -> None:
        of = reference_surface(*welded(BOX))
        larger = BOX.vertices * [1.0, 1.0, 1.5]  # the lid is lifted by 20 mm
        values, area = excess(larger, of)
        assert values.max() == pytest.approx(0.02, abs=1e-4)
        assert area == pytest.approx(2 * (0.1 * 0.06 + 0.1 * 0.06 + 0.06 * 0.06), rel=1e-6)
        found = deviation([larger], of, np.zeros(4))
        assert found.added_worst == pytest.approx(0.02, abs=1e-4)
        assert found.bare_worst == 0

    def test_the_joint_between_two_shapes_is_no_surface(self) -> None:
        of = reference_surface(*welded(BOX))
        left = BOX.vertices * [0.5, 1, 1] - [0.025, 0, 0]
        right = BOX.vertices * [0.5, 1, 1] + [0.025, 0, 0]
        _, alone = excess(left, of)
        _, beside = excess(left, of, [hull_planes(right)])
        assert alone - beside == pytest.approx(0.06 * 0.04, rel=0.05)
