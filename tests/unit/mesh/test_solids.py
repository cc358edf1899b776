"""Solids, surfaces and their forms: cuts, isosurfaces, deviation, open rooms, registration."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.ingest.collision.solid_proxy import isosurface
from casa_assets.mesh.registration import align, descriptor_distance, sampled_surface, shape_descriptor
from casa_assets.mesh.solid.deviation import deviation, excess, reference_surface
from casa_assets.mesh.solid.solids import hull_volume, hull_within_tolerance, solid_of, surface_of
from casa_assets.mesh.surface import is_closed, signed_volume
from casa_assets.mesh.voxels import closed_shares, open_rooms
from casa_assets.model.record import Vec3
from tests.support.mesh.meshes import lathe
from tests.support.mesh.raw_models import MUG, joined, turned
from tests.support.mesh.solids import block, box, welded

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


def test_a_lean_hull_is_small_and_close() -> None:
    ball = np.random.default_rng(0).normal(size=(3000, 3))
    ball *= 0.05 / np.linalg.norm(ball, axis=1, keepdims=True)
    lean = hull_within_tolerance(ball, 40, 0.0005)
    assert len(lean) <= 40
    assert 0.8 * hull_volume(ball) < hull_volume(lean) <= hull_volume(ball) * (1 + 1e-9)
    with pytest.raises(DegenerateShape):
        hull_within_tolerance(ball * [1, 1, 0], 40, 0.0005)


def test_a_box_that_is_too_large_sticks_out_by_that_much() -> None:
    of = reference_surface(*welded(BOX))
    larger = BOX.vertices * [1.0, 1.0, 1.5]  # the lid is lifted by 20 mm
    values, area = excess(larger, of)
    assert values.max() == pytest.approx(0.02, abs=1e-4)
    assert area == pytest.approx(2 * (0.1 * 0.06 + 0.1 * 0.06 + 0.06 * 0.06), rel=1e-6)
    found = deviation([larger], of, np.zeros(4))
    assert found.added_worst == pytest.approx(0.02, abs=1e-4)
    assert found.bare_worst == 0


ROOM_BOX = ((0.2, 0.12, 0.1), (0.0, 0.0, 0.05))


def hollowed(*cores: tuple[Vec3, Vec3]) -> tuple[Floats, Ints]:
    """A box without some boxes, each of a size and about a centre."""
    made = block(*ROOM_BOX)
    for core in cores:
        made -= block(*core)
    return surface_of(made)


CRATE = hollowed(((0.18, 0.1, 0.1), (0.0, 0.0, 0.06)))


def test_what_is_no_room(subtests: pytest.Subtests) -> None:
    for core in [
        ((0.18, 0.1, 0.1), (0.0, 0.0, 0.04)),
        ((0.18, 0.1, 0.08), (0.0, 0.0, 0.05)),
        ((0.18, 0.006, 0.1), (0.0, 0.0, 0.06)),
        ((0.05, 0.05, 0.02), (0.0, 0.0, 0.1)),
    ]:
        with subtests.test(core=core):
            assert open_rooms(*hollowed(core)).shares == ()


def test_faces_look_into_a_vessel_and_backs_into_a_gap() -> None:
    [facing] = open_rooms(*welded(turned(MUG, 32))).facing
    assert facing > 0.9
    points, faces = welded(box(*ROOM_BOX))
    top = (points[faces][:, :, 2] > 0.09).all(axis=1)
    [facing] = open_rooms(points, faces[~top]).facing
    assert facing < 0.1


@pytest.mark.parametrize(
    ("size", "center", "low", "high"),
    [
        pytest.param((0.18, 0.1, 0.045), (0.0, 0.0, 0.032), 0.4, 0.6, id="filled by half"),
        pytest.param((0.19, 0.11, 0.002), (0.0, 0.0, 0.099), 0.95, 1.0, id="a thin lid"),
        pytest.param((0.18, 0.01, 0.09), (0.0, 0.0, 0.055), 0.0, 0.3, id="a wall across"),
    ],
)
def test_what_shapes_fill_or_close_off(size: Vec3, center: Vec3, low: float, high: float) -> None:
    found = open_rooms(*CRATE)
    assert closed_shares(found, *CRATE) == [pytest.approx(0.0, abs=0.02)]
    points, faces = welded(box(size, center))
    both = np.concatenate([CRATE[0], points]), np.concatenate([CRATE[1], faces + len(CRATE[0])])
    [share] = closed_shares(found, *both)
    assert low <= share <= high


Surface = tuple[Floats, Ints]


def cuboid(x: float, y: float, z: float) -> Surface:
    mesh = box((x, y, z), (0.3, 0.1, 0.0))
    return mesh.vertices, mesh.faces.astype(np.int64)


def mug(handle: float = 0.03, height: float = 0.1) -> Surface:
    """A cup with a box for a handle."""
    cup = lathe([(0.0, 0.0), (0.04, 0.0), (0.04, height), (0.036, height), (0.036, 0.004), (0.0, 0.004)], 48)
    both = joined(cup, box((handle, 0.01, 0.06), (0.04 + handle / 2, 0.0, 0.05)))
    return both.vertices, both.faces.astype(np.int64)


def shuffled(surface: Surface, seed: int, factor: float = 1.0) -> Surface:
    """Turned, scaled and pushed; points and faces in another order."""
    rng = np.random.default_rng(seed)
    points, faces = surface
    turn = Rotation.random(random_state=rng).as_matrix()
    order = rng.permutation(len(points))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    fresh = (points @ turn.T * factor + rng.normal(size=3))[order]
    return fresh, np.roll(place[faces], 1, axis=1)[rng.permutation(len(faces))]


def finer(surface: Surface) -> Surface:
    """Every triangle cut into four, each with points of its own."""
    points, faces = surface
    a, b, c = (points[faces[:, k]] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def test_a_copy_has_the_same_form_and_lies_on_the_original(subtests: pytest.Subtests) -> None:
    forms = [mug(), cuboid(0.1, 0.2, 0.3), cuboid(0.2, 0.2, 0.2), cuboid(0.3, 0.3, 0.02)]
    for seed, own in product([1, 2], forms):
        with subtests.test(own=own, seed=seed):
            copy = finer(shuffled(own, seed, factor=37.0))
            first, second = shape_descriptor(*own), shape_descriptor(*copy)
            assert second.radius / first.radius == pytest.approx(37.0, rel=1e-4)
            assert descriptor_distance(first, second) < 0.02
            found = align(sampled_surface(*own), sampled_surface(*copy))
            assert found.p95 < 0.01
            assert found.p995 < 0.04
            assert np.linalg.det(found.turn) == pytest.approx(1.0)


def test_what_differs_does_not_lie_on_it(subtests: pytest.Subtests) -> None:
    for one, other in [
        (mug(), mug(height=0.135)),
        (mug(), mug(handle=0.045)),
        (cuboid(0.1, 0.2, 0.3), cuboid(0.1, 0.2, 0.33)),
        (cuboid(0.2, 0.2, 0.2), cuboid(0.2, 0.2, 0.23)),
    ]:
        with subtests.test(one=one, other=other):
            found = align(sampled_surface(*one), sampled_surface(*shuffled(other, 5)))
            assert found.p95 > 0.025 or found.p995 > 0.1
