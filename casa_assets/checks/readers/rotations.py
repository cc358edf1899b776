"""Rotations of many things at once, with the same digits as `Pose` has of one.

A kitchen has some thousand bodies and shapes, and a record of each costs more time than all that is computed of it.
"""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats

# As `Pose` has it: unit quaternions are left alone.
OFF_UNIT = 1e-12


def canonical(quaternions: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of length 1, w >= 0; where w is 0 the first that is not 0 is positive."""
    found = np.array(quaternions, dtype=np.float64).reshape(-1, 4)
    for row in np.flatnonzero(np.abs(np.linalg.norm(found, axis=1) - 1.0) > OFF_UNIT):
        found[row] /= np.linalg.norm(found[row])
    first = found[np.arange(len(found)), np.argmax(found != 0.0, axis=1)]
    found[first < 0.0] *= -1.0
    unsigned: Floats = found + 0.0  # turns -0.0 into 0.0
    return unsigned


def rotations_of(quaternions: Floats) -> Floats:
    """(N, 3, 3) rotation matrices of (N, 4) quaternions (w, x, y, z)."""
    w, x, y, z = canonical(quaternions).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    found: Floats = np.moveaxis(np.array(rows), 2, 0)
    return np.ascontiguousarray(found)


def quaternions_of(rotations: Floats) -> Floats:
    """(N, 4) quaternions (w, x, y, z) of (N, 3, 3) rotation matrices, w >= 0.

    Raises:
        ValueError: one is not a rotation.
    """
    r = rotations
    skew = np.abs(r @ r.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if skew > 1e-6 or (np.linalg.det(r) < 0).any():
        raise ValueError("matrix is not a proper rotation")
    # Ref: Shepperd 1978, the branch with the largest divisor.
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    branch = np.argmax(np.stack([trace, r[:, 0, 0], r[:, 1, 1], r[:, 2, 2]], axis=1), axis=1)
    v = np.stack([1 + trace, r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    for i in (1, 2, 3):
        at = np.flatnonzero(branch == i)
        a, b, c = i - 1, i % 3, (i + 1) % 3
        m = r[at]
        v[at, 0] = m[:, c, b] - m[:, b, c]
        v[at, 1 + a] = 1 + m[:, a, a] - m[:, b, b] - m[:, c, c]
        v[at, 1 + b] = m[:, b, a] + m[:, a, b]
        v[at, 1 + c] = m[:, c, a] + m[:, a, c]
    # Of each row by itself: a sum over an axis may differ from it in the last digit.
    lengths = np.array([np.linalg.norm(row) for row in v]).reshape(-1, 1)
    return canonical(v / lengths)
