"""Volume, centre and inertia: formulas of the text book, and what turning and moving does to them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.surface import (
    shell_moments,
    solid_moments,
    winding_number,
)
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere
from casa_assets.model.pose import Pose
from tests.properties.strategies import closed, lengths, poses, quick, seeds, turn


def box_inertia(x: float, y: float, z: float) -> np.ndarray:
    return np.diag([y * y + z * z, z * z + x * x, x * x + y * y]) / 12


@quick
@given(seeds)
def test_turning_the_points_turns_the_tensor(seed: int) -> None:
    points, faces = closed(seed)
    rotation = turn(seed + 1)
    volume, center, inertia = solid_moments(points, faces)
    volume_2, center_2, inertia_2 = solid_moments(points @ rotation.T, faces)
    assert volume_2 == pytest.approx(volume, rel=1e-9)
    assert center_2 == pytest.approx(rotation @ center, abs=1e-9)
    assert inertia_2 == pytest.approx(rotation @ inertia @ rotation.T, rel=1e-9, abs=1e-9 * np.trace(inertia))


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
