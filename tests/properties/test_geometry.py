"""Poses are a group and agree with their matrices; solids have volume, centre and inertia by the text book.

Hulls hold their points, primitives enclose them. Welding, components and winding do not depend on the order of faces
and vertices; voxels find the volume.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.deviation import distances_outside_hulls, surface_samples
from casa_assets.mesh.solid.primitive import best_primitive, shape_bounds, tessellate
from casa_assets.mesh.solid.solids import closed_solid, convex_hull, hull_planes, hull_volume, small_hull, union
from casa_assets.mesh.surface import (
    consistent_winding,
    face_components,
    face_normals,
    is_closed,
    shell_moments,
    signed_volume,
    solid_moments,
    weld,
    winding_number,
)
from casa_assets.mesh.voxels import voxelise
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from tests.support.mesh.meshes import some

quick = settings(max_examples=25, database=None, suppress_health_check=[HealthCheck.too_slow])
seeds = st.integers(0, 10**6)
lengths = st.floats(1e-3, 10.0)
quaternions = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: bool(np.linalg.norm(q) > 1e-3))
poses = st.builds(Pose, position=st.tuples(*[st.floats(-10, 10)] * 3), quaternion=quaternions)


def turn(seed: int) -> Floats:
    """A (3, 3) rotation."""
    matrix: Floats = Rotation.random(random_state=seed).as_matrix()
    return matrix


def cloud(seed: int, count: int) -> Floats:
    """(count, 3) points of uneven spread."""
    draw = np.random.default_rng(seed)
    spread: Floats = draw.normal(size=(count, 3)) * draw.uniform(0.1, 2.0, 3) @ turn(seed).T + draw.normal(size=3)
    return spread


def closed(seed: int, count: int = 24) -> tuple[Floats, Ints]:
    """A closed, outward, convex surface."""
    return convex_hull(cloud(seed, count))


CLOSE = 1e-12


def gap(a: Pose, b: Pose) -> float:
    return float(np.abs(a.matrix - b.matrix).max())


@quick
@given(poses, poses, poses)
def test_poses_are_a_group(a: Pose, b: Pose, c: Pose) -> None:
    assert gap((a @ b) @ c, a @ (b @ c)) < 100 * CLOSE
    assert gap(a @ a.inverse(), Pose()) < 100 * CLOSE
    assert gap(a.inverse() @ a, Pose()) < 100 * CLOSE


@quick
@given(poses)
def test_matrix_and_back(pose: Pose) -> None:
    assert gap(Pose.from_matrix(pose.matrix), pose) < CLOSE
    assert np.abs(np.array(Pose.from_matrix(pose.matrix).quaternion) - pose.quaternion).max() < 1e-7


@quick
@given(quaternions)
def test_quaternions_are_unit_and_turn_as_those_of_scipy(quaternion: tuple[float, float, float, float]) -> None:
    w, x, y, z = quaternion
    pose = Pose(quaternion=quaternion)
    assert np.abs(pose.rotation - Rotation.from_quat([x, y, z, w]).as_matrix()).max() < CLOSE
    assert abs(np.linalg.norm(pose.quaternion) - 1) < CLOSE
    assert pose.quaternion[0] >= 0
    assert Pose(quaternion=pose.quaternion).quaternion == pose.quaternion
    assert Pose.from_json(pose.to_json()) == pose


@quick
@given(poses, poses, seeds)
def test_apply_is_a_homomorphism_and_keeps_distances(a: Pose, b: Pose, seed: int) -> None:
    points = cloud(seed, 5)
    moved = (a @ b).apply(points)
    assert np.abs(moved - a.apply(b.apply(points))).max() < 1e-10
    flat = np.column_stack([points, np.ones(5)])
    assert np.abs(a.apply(points) - (flat @ a.matrix.T)[:, :3]).max() < 1e-11
    assert np.linalg.norm(moved[1:] - moved[0], axis=1) == pytest.approx(np.linalg.norm(points[1:] - points[0], axis=1))


@quick
@given(seeds)
def test_what_is_no_rotation_is_refused(seed: int) -> None:
    for wrong in (turn(seed) * 1.01, -turn(seed), turn(seed) @ np.diag([1, 1, -1]), np.zeros((3, 3))):
        with pytest.raises(ValueError, match="rotation"):
            Pose.from_matrix(wrong)


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
@given(lengths, lengths, lengths, poses)
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
    fit = some(best_primitive(points))
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
        assert np.hypot(across, np.maximum(up - shape.height / 2, 0)).max() <= shape.radius + slack
    assert 0 < fit.ratio <= 1 + 1e-9


def hull(seed: int) -> Hull:
    points, faces = closed(seed)
    return Hull(mesh=Mesh(vertices=points, faces=faces))


boxes = st.builds(lambda *size: Box(size=size), lengths, lengths, lengths)
round_shapes = [st.builds(kind, radius=lengths, height=lengths) for kind in (Cylinder, Capsule)]
shapes = st.one_of(boxes, st.builds(Sphere, radius=lengths), *round_shapes, seeds.map(hull))


@quick
@given(shapes, poses)
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


def torus() -> tuple[Floats, Ints]:
    """A closed, outward surface with a hole."""
    u, v = np.meshgrid(np.arange(24), np.arange(12), indexing="ij")
    a, b = u * 2 * np.pi / 24, v * 2 * np.pi / 12
    reach = 0.1 + 0.03 * np.cos(b)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), 0.03 * np.sin(b)], axis=-1).reshape(-1, 3)
    next_u, next_v = (u + 1) % 24, (v + 1) % 12
    here, right, above, both = u * 12 + v, next_u * 12 + v, u * 12 + next_v, next_u * 12 + next_v
    return points, np.stack([here, right, both, here, both, above], axis=-1).reshape(-1, 3)


def several(seed: int, count: int) -> tuple[Floats, Ints]:
    """Closed surfaces side by side."""
    points, faces = [], []
    for i in range(count):
        some, own = closed(seed + i, 12)
        faces.append(own + sum(len(p) for p in points))
        points.append(some + 100.0 * i)
    return np.concatenate(points), np.concatenate(faces)


@quick
@given(seeds, st.integers(1, 5))
def test_weld_undoes_the_splitting_of_vertices(seed: int, count: int) -> None:
    points, faces = several(seed, count)
    split = points[faces[np.random.default_rng(seed).permutation(len(faces))]].reshape(-1, 3)
    welded, place = weld(split)
    assert len(welded) == len(points)
    assert np.abs(welded[place] - split).max() <= 1e-6 * np.ptp(points)
    assert is_closed(place.reshape(-1, 3))


@quick
@given(seeds, st.integers(1, 6))
def test_components_do_not_depend_on_the_order_of_faces(seed: int, count: int) -> None:
    points, faces = several(seed, count)
    order = np.random.default_rng(seed).permutation(len(faces))
    straight, shuffled = face_components(faces, len(points)), face_components(faces[order], len(points))
    assert straight.max() + 1 == shuffled.max() + 1 == count
    assert len({*zip(straight[order].tolist(), shuffled.tolist(), strict=True)}) == count
    _, first = np.unique(shuffled, return_index=True)
    assert (np.diff(first) > 0).all()  # numbered by first face


@quick
@given(seeds, st.integers(1, 4), st.booleans())
def test_random_turns_are_undone(seed: int, count: int, holed: bool) -> None:
    points, faces = torus() if holed else several(seed, count)
    draw = np.random.default_rng(seed)
    order = draw.permutation(len(faces))
    flipped = draw.random(len(faces)) < 0.5
    mixed = faces[order].copy()
    mixed[flipped] = mixed[flipped][:, ::-1]
    restored, turned = consistent_winding(mixed)
    assert is_closed(restored)
    label = face_components(restored, len(points))
    wrong = turned ^ flipped  # all of a piece, or none of it
    assert all(len(set(wrong[label == k].tolist())) == 1 for k in range(label.max() + 1))
    assert not turned[np.unique(label, return_index=True)[1]].any()
    assert abs(signed_volume(points, restored[label == 0])) > 0


PLAIN = [
    (Box(size=(1.0, 0.7, 0.4)), 0.28),
    (Sphere(radius=0.5), np.pi / 6),
    (Cylinder(radius=0.3, height=1), np.pi * 0.09),
]


@pytest.mark.parametrize(("shape", "exact"), PLAIN, ids=lambda x: getattr(x, "kind", ""))
@pytest.mark.parametrize("tilt", [(1, 0, 0, 0), (0.9, 0.3, 0.2, 0.1)], ids=["straight", "tilted"])
def test_voxels_find_the_volume(shape: Shape, exact: float, tilt: tuple[float, float, float, float]) -> None:
    points, faces = tessellate(shape, Pose(position=(3.0, -2.0, 1.0), quaternion=tilt), steps=64)
    for bridge in (False, True):
        grid = voxelise(points, faces, 64, bridge=bridge)
        assert grid.volume == pytest.approx(exact, rel=0.05)
        centers = grid.origin + np.argwhere(grid.solid) * grid.cell
        assert (centers > points.min(axis=0) - grid.cell).all()
        assert (centers < points.max(axis=0) + grid.cell).all()


def test_what_bounds_no_volume_is_no_solid() -> None:
    points, faces = tessellate(Box(size=(1, 1, 1)), Pose())
    assert closed_solid(points, faces[1:]) is None
    assert closed_solid(points, faces[:, ::-1]) is None
    assert closed_solid(points, np.concatenate([faces, faces[:, ::-1]])) is None
    assert union([]) is None
