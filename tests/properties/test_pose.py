"""Rigid transforms form a group, and agree with their matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from casa_assets.model.pose import Pose
from tests.properties.strategies import cloud, poses, quaternions, quick, seeds, turn

CLOSE = 1e-12


def gap(a: Pose, b: Pose) -> float:
    return float(np.abs(a.matrix - b.matrix).max())


@quick
@given(poses(), poses(), poses())
def test_poses_are_a_group(a: Pose, b: Pose, c: Pose) -> None:
    assert gap((a @ b) @ c, a @ (b @ c)) < 100 * CLOSE
    assert gap(a @ a.inverse(), Pose()) < 100 * CLOSE
    assert gap(a.inverse() @ a, Pose()) < 100 * CLOSE


@quick
@given(poses())
def test_matrix_and_back(pose: Pose) -> None:
    assert gap(Pose.from_matrix(pose.matrix), pose) < CLOSE
    assert np.abs(np.array(Pose.from_matrix(pose.matrix).quaternion) - pose.quaternion).max() < 1e-7


@quick
@given(quaternions())
def test_quaternions_are_of_unit_length_read_back_and_turn_as_those_of_another_library(
    quaternion: tuple[float, float, float, float],
) -> None:
    w, x, y, z = quaternion
    pose = Pose(quaternion=quaternion)
    assert np.abs(pose.rotation - Rotation.from_quat([x, y, z, w]).as_matrix()).max() < CLOSE
    assert abs(np.linalg.norm(pose.quaternion) - 1) < CLOSE
    assert pose.quaternion[0] >= 0
    assert Pose(quaternion=pose.quaternion).quaternion == pose.quaternion
    assert Pose.from_json(pose.to_json()) == pose


@quick
@given(poses(), poses(), seeds)
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
