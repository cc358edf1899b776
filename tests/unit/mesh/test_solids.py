"""Solids out of fields and torn meshes, cut, measured, and what they would hold."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.errors import DegenerateShape
from casa_assets.ingest.collision.rings import radius_spread, upright_axis, wall_profile
from casa_assets.ingest.collision.solid_proxy import isosurface, signed_distance_field
from casa_assets.mesh.solid.deviation import deviation, distances_outside, excess, reference_surface
from casa_assets.mesh.solid.solids import (
    Solid,
    connected_parts,
    hull_planes,
    hull_points,
    hull_volume,
    hull_within_tolerance,
    revolve_profile,
    section_contours,
    solid_of,
    split_by_plane,
    volume_of_hull,
    without_voids,
)
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.topology import fill_holes, is_closed
from casa_assets.mesh.voxels import fillable_volume, voxelise
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.raw_models import MUG, flipped, joined, moved, turned
from tests.support.mesh.solids import block, box, solid, welded

POINTS, FACES = welded(turned(MUG, 32))
CUP = Mesh(vertices=POINTS, faces=FACES)
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

    def test_nothing_positive_is_nothing(self) -> None:
        points, faces = isosurface(np.full((4, 4, 4), -1.0), np.zeros(3), 1.0)
        assert points.shape == (0, 3)
        assert faces.shape == (0, 3)


class TestField:
    def made(self, mesh: Mesh, bridge: bool = False) -> Solid:
        faces = mesh.faces.astype(np.int64)
        grid = voxelise(mesh.vertices, faces, 48, bridge=bridge)
        found = solid_of(*isosurface(signed_distance_field(mesh.vertices, faces, grid), grid.origin, grid.cell))
        assert found is not None
        return found

    def test_a_closed_box_keeps_its_volume_whichever_way_it_is_wound(self) -> None:
        for mesh in (BOX, flipped(BOX), flipped(BOX, 0.5)):
            assert self.made(mesh).volume() == pytest.approx(0.1 * 0.06 * 0.04, rel=0.05)

    def test_a_sheet_becomes_a_thin_wall_that_keeps_its_opening(self) -> None:
        made = self.made(turned([(0.05, 0.05), (0.05, 0.0), (0.0, 0.0)], 48))
        area = 2 * np.pi * 0.05 * 0.05 + np.pi * 0.05**2
        assert 0.001 * area < made.volume() < 0.004 * area

    def test_a_box_without_a_lid_is_full_where_that_is_known(self) -> None:
        open_box = Mesh(vertices=BOX.vertices, faces=BOX.faces[2:])
        assert self.made(open_box, bridge=True).volume() == pytest.approx(0.1 * 0.06 * 0.04, rel=0.1)


class TestMend:
    def test_only_a_small_hole_is_closed(self) -> None:
        torn = np.delete(FACES, [40], axis=0)
        found = fill_holes(POINTS, torn, 0.1)
        assert found is not None
        assert is_closed(found[1])
        assert signed_volume(*found) == pytest.approx(signed_volume(POINTS, FACES), rel=1e-6)
        assert fill_holes(POINTS, torn, 0.001) is None, "a wide hole stays an opening"
        assert fill_holes(POINTS, FACES[::2], 1.0) is None, "much that is torn"


class TestCutting:
    def test_two_halves_are_the_whole(self) -> None:
        beyond_, before = split_by_plane(solid(BOX), np.array([1.0, 0.0, 0.0]), 0.02)
        assert beyond_.volume() == pytest.approx(0.03 * 0.06 * 0.04)
        assert before.volume() == pytest.approx(0.07 * 0.06 * 0.04)

    def test_what_is_sealed_in_is_filled_and_what_lies_beside_is_kept(self) -> None:
        room = flipped(moved(BOX, scale=0.5, offset=(0.0, 0.0, 0.01)))
        whole = without_voids(solid(joined(BOX, room, moved(BOX, (0.3, 0.0, 0.0)))))
        assert whole.volume() == pytest.approx(2 * 0.1 * 0.06 * 0.04, rel=1e-6)

    def test_parts_are_sorted_and_crumbs_left_out(self) -> None:
        both = solid(joined(moved(BOX, (0.3, 0, 0), 0.5), BOX, moved(BOX, (0.6, 0, 0), 0.01)))
        found = connected_parts(both, 1e-8)
        assert [p.volume() for p in found] == pytest.approx([2.4e-4, 3e-5])

    def test_the_section_of_a_cup_has_two_circles(self) -> None:
        rings = section_contours(solid(CUP), 0.05)
        assert sorted(float(np.linalg.norm(r, axis=1).max()) for r in rings) == pytest.approx([0.036, 0.04], rel=1e-3)

    def test_a_turned_profile_stands_upright(self) -> None:
        found = revolve_profile(np.array([[0.0, 0.1], [0.02, 0.1], [0.02, 0.3], [0.0, 0.3]]), 64)
        assert found.volume() == pytest.approx(np.pi * 0.02**2 * 0.2, rel=5e-3)
        assert found.bounding_box()[2::3] == pytest.approx((0.1, 0.3))

    def test_a_lean_hull_is_small_and_close(self) -> None:
        ball = np.random.default_rng(0).normal(size=(3000, 3))
        ball *= 0.05 / np.linalg.norm(ball, axis=1, keepdims=True)
        lean = hull_within_tolerance(ball, 40, 0.0005)
        assert len(lean) <= 40
        assert 0.8 * hull_volume(ball) < hull_volume(lean) <= hull_volume(ball) * (1 + 1e-9)
        with pytest.raises(DegenerateShape):
            hull_within_tolerance(ball * [1, 1, 0], 40, 0.0005)

    def test_the_hull_around_two_solids(self) -> None:
        pair = [solid(BOX), solid(moved(BOX, (0.2, 0, 0)))]
        assert volume_of_hull(pair) == pytest.approx(0.3 * 0.06 * 0.04)
        assert np.ptp(hull_points(pair), axis=0) == pytest.approx([0.3, 0.06, 0.04])


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

    def test_a_box_that_fits_adds_nothing(self) -> None:
        of = reference_surface(*welded(BOX))
        assert excess(BOX.vertices, of)[0].max() < 1e-5
        assert distances_outside(np.array([[0.0, 0.0, 0.02]]), of)[0] == 0

    def test_the_joint_between_two_shapes_is_no_surface(self) -> None:
        of = reference_surface(*welded(BOX))
        left = BOX.vertices * [0.5, 1, 1] - [0.025, 0, 0]
        right = BOX.vertices * [0.5, 1, 1] + [0.025, 0, 0]
        _, alone = excess(left, of)
        _, beside = excess(left, of, [hull_planes(right)])
        assert alone - beside == pytest.approx(0.06 * 0.04, rel=0.05)

    def test_no_shapes_are_refused(self) -> None:
        with pytest.raises(DegenerateShape):
            deviation([], reference_surface(*welded(BOX)), np.zeros(1))


class TestRevolution:
    def test_the_axis_of_a_mug_is_found_in_spite_of_its_handle(self) -> None:
        handle = box((0.03, 0.01, 0.05), (0.055, 0.0, 0.05))
        mug = moved(joined(CUP, handle), (0.3, -0.2, 0.1))
        center, share = upright_axis(mug.vertices, mug.faces.astype(np.int64))
        assert center == pytest.approx([0.3, -0.2], abs=1e-4)
        assert 0.7 < share < 1

    def test_a_flat_thing_has_no_axis(self) -> None:
        sheet = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 2]])
        assert upright_axis(sheet.vertices, sheet.faces.astype(np.int64))[1] == 0

    def test_walls_begin_and_end_where_they_do(self) -> None:
        seen = wall_profile(solid(CUP), np.zeros(2))
        floor, wall = seen.heights < 0.006, seen.heights > 0.006
        assert (seen.inner[floor] == 0).all()
        assert seen.inner[wall] == pytest.approx(0.036, rel=6e-3)
        assert seen.outer == pytest.approx(0.04, rel=6e-3)
        assert max(radius_spread(row) for row in seen.outer) < 0.01

    def test_a_square_is_not_round(self) -> None:
        square = wall_profile(block((0.1, 0.1, 0.04)), np.zeros(2))
        assert radius_spread(square.outer[10]) > 0.1


class TestWater:
    def test_an_upright_cup_is_full_to_the_rim_and_a_turned_one_holds_nothing(self) -> None:
        for turn, share in ((1.0, 1.0), (-1.0, 0.0)):
            cup = POINTS * [1, 1, turn]
            grid = voxelise(cup, FACES, 64)
            held = fillable_volume(grid.solid).sum() * grid.cell**3
            assert held == pytest.approx(share * np.pi * 0.036**2 * 0.089, rel=0.12, abs=1e-9)

    def test_a_cup_with_a_hole_in_its_wall_is_full_up_to_there(self) -> None:
        grid = voxelise(POINTS, FACES, 64)
        pierced = grid.solid.copy()
        height = round((0.05 - grid.origin[2]) / grid.cell)
        pierced[grid.solid.shape[0] // 2 :, grid.solid.shape[1] // 2, height] = False
        held = fillable_volume(pierced)
        assert held[:, :, height - 2].any()
        assert not held[:, :, height + 1 :].any()
