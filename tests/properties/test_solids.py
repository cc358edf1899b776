"""Solids: volume, centre and inertia by the text book; hulls hold their points, primitives enclose them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import distances_outside_hulls, surface_samples
from casa_assets.mesh.solid.primitive import best_primitive, shape_bounds, tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_planes, hull_volume, small_hull
from casa_assets.mesh.surface import (
    face_normals,
    is_closed,
    shell_moments,
    signed_volume,
    solid_moments,
    winding_number,
)
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from tests.properties.strategies import Floats, Ints, closed, cloud, lengths, poses, quick, seeds


def box_inertia(x: float, y: float, z: float) -> np.ndarray:
    return np.diag([y * y + z * z, z * z + x * x, x * x + y * y]) / 12


@quick
@given(seeds)
def test_moving_the_points_moves_the_centre_alone(seed: int) -> None:
    points, faces = closed(seed)
    offset = np.random.default_rng(seed).uniform(-100, 100, 3)
    for moments in (solid_moments, shell_moments):
        size, center, inertia = moments(points, faces)
        size_2, center_2, inertia_2 = moments(points + offset, faces)
        assert size_2 == pytest.approx(size, rel=1e-9)
        assert center_2 == pytest.approx(center + offset, rel=1e-9)
        assert inertia_2 == pytest.approx(inertia, rel=1e-7, abs=1e-9 * np.trace(inertia))


@quick
@given(lengths, lengths, lengths, poses())
def test_box(x: float, y: float, z: float, pose: Pose) -> None:
    volume, center, inertia = solid_moments(*tessellate(Box(size=(x, y, z)), pose))
    assert volume == pytest.approx(x * y * z, rel=1e-9)
    assert center == pytest.approx(np.array(pose.position), abs=1e-9)
    wanted = pose.rotation @ (box_inertia(x, y, z) * volume) @ pose.rotation.T
    assert inertia == pytest.approx(wanted, rel=1e-7, abs=1e-8 * np.trace(wanted))


def test_sphere_and_cylinder_converge_to_the_formulas() -> None:
    r, h = 0.3, 0.5
    errors = []
    for steps in (32, 64, 128):
        volume, _, inertia = solid_moments(*tessellate(Sphere(radius=r), Pose(), steps))
        misses = [1 - volume / (4 / 3 * np.pi * r**3), np.abs(inertia / volume - np.eye(3) * 0.4 * r * r).max() / r**2]
        volume, _, inertia = solid_moments(*tessellate(Cylinder(radius=r, height=h), Pose(), steps))
        wanted = np.diag([(3 * r * r + h * h) / 12] * 2 + [r * r / 2])
        misses += [1 - volume / (np.pi * r * r * h), np.abs(inertia / volume - wanted).max() / r**2]
        volume, _, _ = solid_moments(*tessellate(Capsule(radius=r, height=h), Pose(), steps))
        errors.append([*misses, 1 - volume / (np.pi * r * r * h + 4 / 3 * np.pi * r**3)])
    table = np.array(errors)
    assert (table > 0).all()  # inscribed surfaces are too small
    assert (table[-1] < 2e-3).all()
    assert (table[:-1] / table[1:] > 3.5).all()  # twice the steps, a quarter of the error


@quick
@given(seeds)
def test_a_surface_goes_once_round_what_is_in_it(seed: int) -> None:
    points, faces = closed(seed)
    middle = points.mean(axis=0)
    assert winding_number(points, faces, middle) == pytest.approx(1)
    assert winding_number(points, faces[:, ::-1], middle) == pytest.approx(-1)
    assert winding_number(points, faces, points.max(axis=0) + 0.1) == pytest.approx(0, abs=1e-9)


counts = st.integers(8, 300)


def outside(points: Floats, surface: tuple[Floats, Ints]) -> float:
    """How far the points lie outside a convex surface at most, relative to its size."""
    normals, _ = face_normals(*surface)
    offsets = np.einsum("ij,ij->i", normals, surface[0][surface[1][:, 0]])
    return float((points @ normals.T - offsets).max() / np.ptp(surface[0], axis=0).max())


@quick
@given(seeds, counts)
def test_a_hull_is_closed_convex_and_holds_its_points(seed: int, count: int) -> None:
    points = cloud(seed, count)
    shell, faces = convex_hull(points)
    assert is_closed(faces)
    assert len(shell) - len(faces) / 2 == 2  # Euler: one closed ball
    assert signed_volume(shell, faces) > 0
    assert outside(points, (shell, faces)) < 1e-9
    assert {tuple(p) for p in shell} <= {tuple(p) for p in points}


@quick
@given(seeds, st.integers(100, 600), st.sampled_from([32, 64]))
def test_a_small_hull_lies_inside_and_reaches_the_bounds(seed: int, count: int, limit: int) -> None:
    draw = np.random.default_rng(seed)
    ball = draw.normal(size=(count, 3))
    points = ball / np.linalg.norm(ball, axis=1)[:, None] * draw.uniform(1e-4, 2.0, 3)
    whole, few = convex_hull(points), small_hull(points, limit)
    assert len(few[0]) <= limit
    assert is_closed(few[1])
    assert outside(few[0], whole) < 1e-9
    assert {tuple(p) for p in few[0]} <= {tuple(p) for p in whole[0]}
    assert few[0].min(axis=0) == pytest.approx(points.min(axis=0))
    assert few[0].max(axis=0) == pytest.approx(points.max(axis=0))
    assert signed_volume(*few) > 0.6 * signed_volume(*whole)


@pytest.mark.parametrize(
    "points",
    [
        np.empty((0, 3)),
        np.zeros((1, 3)),
        np.zeros((50, 3)),
        np.eye(3),
        np.outer(np.arange(20), [1.0, 2.0, 3.0]),
        np.column_stack([np.random.default_rng(0).random((50, 2)), np.zeros(50)]),
    ],
    ids=["none", "one", "same", "three", "line", "plane"],
)
def test_what_spans_no_volume_is_refused(points: Floats) -> None:
    for make in (convex_hull, small_hull, hull_planes):
        with pytest.raises(DegenerateShape):
            make(points)
    assert hull_volume(points) == 0
    assert len(points) < 2 or best_primitive(points) is None


@quick
@given(seeds, counts)
def test_primitives_enclose_what_they_stand_for(seed: int, count: int) -> None:
    points, _ = convex_hull(cloud(seed, count))
    fit = best_primitive(points)
    assert fit is not None
    local = fit.pose.inverse().apply(points)
    shape, slack = fit.shape, 1e-7 * float(np.ptp(points, axis=0).max())
    across, up = np.linalg.norm(local[:, :2], axis=1), np.abs(local[:, 2])
    if isinstance(shape, Sphere):
        assert np.linalg.norm(local, axis=1).max() <= shape.radius + slack
    elif isinstance(shape, Box):
        assert (np.abs(local) <= np.array(shape.size) / 2 + slack).all()
    elif isinstance(shape, Cylinder):
        assert across.max() <= shape.radius + slack
        assert up.max() <= shape.height / 2 + slack
    else:
        above = np.maximum(up - shape.height / 2, 0)
        assert np.hypot(across, above).max() <= shape.radius + slack
    assert 0 < fit.ratio <= 1 + 1e-9


@st.composite
def shapes(draw: st.DrawFn) -> Shape:
    x, y, z = draw(lengths), draw(lengths), draw(lengths)
    points, faces = closed(draw(seeds))
    return draw(
        st.sampled_from(
            [
                Box(size=(x, y, z)),
                Sphere(radius=x),
                Cylinder(radius=x, height=y),
                Capsule(radius=x, height=y),
                Hull(mesh=Mesh(vertices=points, faces=faces)),
            ]
        )
    )


@quick
@given(shapes(), poses())
def test_bounds_hold_the_surface_and_touch_it(shape: Shape, pose: Pose) -> None:
    low, high = shape_bounds(shape, pose)
    points, faces = tessellate(shape, pose, steps=48)
    assert is_closed(faces)
    assert signed_volume(points, faces) > 0
    size = float((high - low).max())
    assert (points >= low - 1e-9 * size).all()
    assert (points <= high + 1e-9 * size).all()
    slack = 1e-9 * size if isinstance(shape, Box | Hull) else 5e-3 * size
    assert points.min(axis=0) == pytest.approx(low, abs=slack)
    assert points.max(axis=0) == pytest.approx(high, abs=slack)


@quick
@given(seeds)
def test_samples_lie_on_the_surface_and_a_hull_leaves_none_bare(seed: int) -> None:
    points, faces = closed(seed)
    samples = surface_samples(points, faces, 500)
    assert len(samples) == 500
    assert distances_outside_hulls(samples, [points]).max() < 1e-9
    shrunk = (points - points.mean(axis=0)) * 0.5 + points.mean(axis=0)
    assert distances_outside_hulls(samples, [shrunk]).min() > 0
    assert (distances_outside_hulls(samples, [shrunk, points]) < 1e-9).all()
