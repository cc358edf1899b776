"""Rotations of many things at once have the digits that `Pose` has of each."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.checks.readers.facts import canonical, quaternions_of, rotations_of
from casa_assets.model.pose import Pose

HALF = np.sqrt(0.5)
# Half turns, where w is 0 and another number tells the sign; turns whose largest number is each of the four; -0.0.
SPECIAL = [
    (1.0, 0.0, 0.0, 0.0),
    (-1.0, 0.0, -0.0, 0.0),
    (0.0, -1.0, 0.0, 0.0),
    (0.0, 0.0, -1.0, 0.0),
    (-0.0, 0.0, 0.0, -1.0),
    (0.0, -HALF, HALF, 0.0),
    (HALF, -HALF, -0.0, 0.0),
    (0.1, 0.9, 0.3, 0.3),
    (0.1, 0.2, 0.9, 0.3),
    (0.1, 0.2, 0.3, -0.9),
    (2.0, 0.0, 0.0, 2.0),
]


@pytest.fixture(scope="module")
def quaternions() -> np.ndarray:
    drawn = np.random.default_rng(5).normal(size=(300, 4))
    return np.concatenate([SPECIAL, drawn, drawn / np.linalg.norm(drawn, axis=1, keepdims=True)])


def test_quaternions_are_those_of_poses(quaternions: np.ndarray) -> None:
    poses = [Pose(quaternion=tuple(q)) for q in quaternions.tolist()]
    found = canonical(quaternions)
    assert found.tobytes() == np.array([pose.quaternion for pose in poses]).tobytes()


def test_matrices_are_those_of_poses_and_lead_back_as_theirs_do(quaternions: np.ndarray) -> None:
    poses = [Pose(quaternion=tuple(q)) for q in quaternions.tolist()]
    matrices = rotations_of(quaternions)
    assert np.array_equal(matrices, [pose.rotation for pose in poses])
    back = [Pose.from_matrix(matrix).quaternion for matrix in matrices]
    assert quaternions_of(matrices).tobytes() == np.array(back).tobytes()


def test_what_is_no_rotation_is_refused_as_by_poses(subtests: pytest.Subtests) -> None:
    for matrix in [np.diag([1.0, 1.0, -1.0]), np.diag([1.0, 1.0, 1.1]), np.zeros((3, 3))]:
        with subtests.test(matrix=matrix):
            with pytest.raises(ValueError, match="not a proper rotation"):
                Pose.from_matrix(matrix)
            with pytest.raises(ValueError, match="not a proper rotation"):
                quaternions_of(np.array([np.eye(3), matrix]))
