"""Rigid transform: a position and a unit quaternion (w, x, y, z)."""

from __future__ import annotations

from typing import Self

import numpy as np
import numpy.typing as npt
from pydantic import field_validator

from casa_assets.model.record import Record, Vec3, Vec4

Matrix = npt.NDArray[np.float64]


class Pose(Record):
    """`a_from_b`: takes points in frame b to frame a. Compose right to left with `@`.

    Attributes:
        position: origin of b in a, metres. quaternion: rotation (w, x, y, z), normalised on entry, w >= 0.
    """

    position: Vec3 = (0.0, 0.0, 0.0)
    quaternion: Vec4 = (1.0, 0.0, 0.0, 0.0)

    @field_validator("quaternion")
    @classmethod
    def _unit(cls, quaternion: Vec4) -> Vec4:
        norm = float(np.linalg.norm(quaternion))
        if norm < 1e-9:
            raise ValueError("a quaternion of length zero has no direction")
        if abs(norm - 1.0) > 1e-12:  # leave unit quaternions alone, so that a round trip is exact
            quaternion = tuple(q / norm for q in quaternion)  # type: ignore[assignment]
        first = next(q for q in quaternion if q != 0.0)
        if quaternion[0] < 0 or (quaternion[0] == 0 and first < 0):
            quaternion = tuple(-q for q in quaternion)  # type: ignore[assignment]
        w, x, y, z = quaternion
        return (w + 0.0, x + 0.0, y + 0.0, z + 0.0)

    @classmethod
    def from_matrix(cls, matrix: Matrix) -> Self:
        """Pose of a (4, 4) or (3, 3) rigid matrix. Raises ValueError if it is not a rotation."""
        matrix = np.asarray(matrix, dtype=np.float64)
        r = matrix[:3, :3]
        if np.abs(r @ r.T - np.eye(3)).max() > 1e-6 or np.linalg.det(r) < 0:
            raise ValueError("matrix is not a proper rotation")
        # Ref: Shepperd 1978, the branch with the largest divisor.
        trace = float(np.trace(r))
        q = np.array([trace, r[0, 0], r[1, 1], r[2, 2]])
        i = int(np.argmax(q))
        if i == 0:
            v = np.array([1 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
        else:
            a, b, c = i - 1, i % 3, (i + 1) % 3
            v = np.empty(4)
            v[0] = r[c, b] - r[b, c]
            v[1 + a] = 1 + r[a, a] - r[b, b] - r[c, c]
            v[1 + b] = r[b, a] + r[a, b]
            v[1 + c] = r[c, a] + r[a, c]
        w, x, y, z = (float(n) for n in v / np.linalg.norm(v))
        p = matrix[:3, 3] if matrix.shape == (4, 4) else np.zeros(3)
        return cls(position=(float(p[0]), float(p[1]), float(p[2])), quaternion=(w, x, y, z))

    @property
    def rotation(self) -> Matrix:
        """(3, 3) rotation matrix."""
        w, x, y, z = self.quaternion
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    @property
    def matrix(self) -> Matrix:
        """(4, 4) homogeneous matrix."""
        m = np.eye(4)
        m[:3, :3] = self.rotation
        m[:3, 3] = self.position
        return m

    def __matmul__(self, other: Pose) -> Pose:
        """a_from_c = a_from_b @ b_from_c."""
        w1, x1, y1, z1 = self.quaternion
        w2, x2, y2, z2 = other.quaternion
        q = (
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        )
        p = self.apply(np.array([other.position]))[0]
        return Pose(position=(float(p[0]), float(p[1]), float(p[2])), quaternion=q)

    def inverse(self) -> Pose:
        """b_from_a."""
        w, x, y, z = self.quaternion
        p = -(self.rotation.T @ np.array(self.position))
        return Pose(position=(float(p[0]), float(p[1]), float(p[2])), quaternion=(w, -x, -y, -z))

    def apply(self, points: Matrix) -> Matrix:
        """Transform (N, 3) points from frame b to frame a, metres."""
        moved: Matrix = np.asarray(points) @ self.rotation.T + np.array(self.position)
        return moved
