"""Forms stay the same under turns, scales, other triangles and other orders; overlays tell copies from the rest."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.mesh.registration import (
    align,
    descriptor_distance,
    sampled_surface,
    shape_descriptor,
)
from tests.support.mesh.meshes import box_mesh, lathe

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Surface = tuple[Floats, Ints]
SAME = 0.01


def box(x: float, y: float, z: float) -> Surface:
    mesh = box_mesh((x, y, z), (0.3, 0.1, 0.0), shared=True)
    return mesh.vertices, mesh.faces.astype(np.int64)


def mug(handle: float = 0.03, height: float = 0.1) -> Surface:
    """A cup with a box for a handle."""
    cup = lathe([(0.0, 0.0), (0.04, 0.0), (0.04, height), (0.036, height), (0.036, 0.004), (0.0, 0.004)], 48)
    grip = box_mesh((handle, 0.01, 0.06), (0.04 + handle / 2, 0.0, 0.05), shared=True)
    points = np.concatenate([cup.vertices, grip.vertices])
    faces = np.concatenate([cup.faces, grip.faces + len(cup.vertices)]).astype(np.int64)
    return points, faces


def moved(surface: Surface, seed: int, factor: float = 1.0) -> Surface:
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


EVERY = {"mug": mug(), "box": box(0.1, 0.2, 0.3), "cube": box(0.2, 0.2, 0.2), "tray": box(0.3, 0.3, 0.02)}


def test_a_copy_has_the_same_form_and_lies_on_the_original(subtests: pytest.Subtests) -> None:
    for seed in [1, 2]:
        for name in sorted(EVERY):
            with subtests.test(name=name, seed=seed):
                own, copy = EVERY[name], finer(moved(EVERY[name], seed, factor=37.0))
                first, second = shape_descriptor(*own), shape_descriptor(*copy)
                assert second.radius / first.radius == pytest.approx(37.0, rel=1e-4)
                assert descriptor_distance(first, second) < 0.02
                found = align(sampled_surface(*own), sampled_surface(*copy))
                assert found.p95 < SAME
                assert found.p995 < 4 * SAME
                assert np.linalg.det(found.turn) == pytest.approx(1.0)


def test_what_differs_does_not_lie_on_it(subtests: pytest.Subtests) -> None:
    for one, other in [
        (mug(), mug(height=0.135)),
        (mug(), mug(handle=0.045)),
        (box(0.1, 0.2, 0.3), box(0.1, 0.2, 0.33)),
        (box(0.2, 0.2, 0.2), box(0.2, 0.2, 0.23)),
    ]:
        with subtests.test(one=one, other=other):
            found = align(sampled_surface(*one), sampled_surface(*moved(other, 5)))
            assert found.p95 > 0.025 or found.p995 > 0.1


def test_the_same_surface_gives_the_same_numbers() -> None:
    assert shape_descriptor(*mug()) == shape_descriptor(*mug())
    one, other = (align(sampled_surface(*mug()), sampled_surface(*moved(mug(), 3))) for _ in range(2))
    assert (one.p95, one.p995) == (other.p95, other.p995)
