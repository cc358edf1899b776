"""Rotate an object that is not aligned with its file axes so that its walls run along the axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.typing import Floats

# Angle within which a face lies along an axis; bins in which directions of walls are counted.
ALIGNED_RAD, DIRECTION_BIN_RAD = np.radians(1.5), np.radians(0.25)
REFINEMENT_RAD = (ALIGNED_RAD, ALIGNED_RAD / 3, ALIGNED_RAD / 10)
# Directions of the largest surfaces that are tried as the floor.
MAX_TILTS = 12
# A further rotation is taken if it aligns so much more of the surface, or that share of what is not aligned: round
# objects keep their axes.
MIN_GAIN, MIN_GAIN_OF_REST = 0.05, 0.25


def align_walls(mesh: WeldedMesh, kept_directions: Sequence[Sequence[float]] = ()) -> Floats:
    """Return a (3, 3) proper rotation whose rows are directions of the file that the walls of an object run along.

    The axes of the file stay where they serve; then they are turned about one of themselves, then about the normal of
    a large face.

    Args:
        kept_directions: directions of which one is kept exactly as a row, such as the known up; empty to keep none.
    """
    weight = mesh.areas / max(float(mesh.areas.sum()), 1e-300)
    tiers = (
        [np.asarray(f, dtype=np.float64) / np.linalg.norm(f) for f in kept_directions],
        [] if kept_directions else [np.eye(3)[k] for k in (2, 1, 0)],
        [] if kept_directions else _largest(mesh.normals, weight),
    )
    best = np.eye(3)
    if kept_directions and max(float(np.abs(f).max()) for f in tiers[0]) < 1.0 - 1e-9:
        best = _turned(mesh.normals, weight, tiers[0][0])
    share = _along(mesh.normals, weight, best)
    for tier in tiers:
        found = [_turned(mesh.normals, weight, axis) for axis in tier]
        shares = [_along(mesh.normals, weight, r) for r in found]
        if not found:
            continue
        k = int(np.argmax(np.round(shares, 9)))
        if shares[k] > share + max(MIN_GAIN, MIN_GAIN_OF_REST * (1.0 - share)):
            best, share = found[k], shares[k]
    return best


def _along(normals: Floats, weight: Floats, rotation: Floats) -> float:
    """Return the share of the surface that lies along the axes."""
    found: Floats = np.abs(normals @ rotation.T).max(axis=1)
    return float(weight[found > np.cos(ALIGNED_RAD)].sum())


def _turned(normals: Floats, weight: Floats, axis: Floats) -> Floats:
    """Return the axes rotated about one direction so that most walls along it lie along the other two."""
    first = np.eye(3)[int(np.argmin(np.abs(axis) + np.array([0.0, 1e-6, 2e-6])))]
    x = first - axis * float(first @ axis)
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)
    wall = np.abs(normals @ axis) < np.sin(ALIGNED_RAD)
    quarter = np.pi / 2
    angle = np.mod(np.arctan2(normals[wall] @ y, normals[wall] @ x), quarter)
    bins = round(quarter / DIRECTION_BIN_RAD)
    count = np.bincount(np.minimum((angle / DIRECTION_BIN_RAD).astype(np.int64), bins - 1), weight[wall], bins)
    wide = sum(np.roll(count, k) for k in (-2, -1, 0, 1, 2))
    peak = (int(np.argmax(np.round(wide, 12))) + 0.5) * DIRECTION_BIN_RAD
    turn = peak
    for within in REFINEMENT_RAD:
        off = np.mod(angle - turn + quarter / 2, quarter) - quarter / 2
        share = np.where(np.abs(off) < within, weight[wall], 0.0)
        turn += float(off @ share) / max(float(share.sum()), 1e-300)
    a = np.cos(turn) * x + np.sin(turn) * y
    rows = np.stack([a, np.cross(axis, a), axis])
    return _near_axes(rows)


def _near_axes(rows: Floats) -> Floats:
    """Order and orient three directions so that they are nearest to the file axes, as a proper rotation."""
    orders = [(a, b, c) for a in range(3) for b in range(3) for c in range(3) if len({a, b, c}) == 3]
    sums = [sum(abs(float(rows[o[i], i])) for i in range(3)) for o in orders]
    order = orders[int(np.argmax(np.round(sums, 9)))]
    found = rows[list(order)]
    found = found * np.where(np.diag(found) < 0, -1.0, 1.0)[:, None]
    if np.linalg.det(found) < 0:
        found[int(np.argmin(np.round(np.diag(found), 9)))] *= -1.0
    return found


def _largest(normals: Floats, weight: Floats) -> list[Floats]:
    """Return the directions that most surface faces, opposite ones merged, the largest first."""
    sign = np.where(normals[:, 2] < -1e-6, -1.0, 1.0)
    level = np.abs(normals[:, 2]) <= 1e-6
    sign = np.where(level & (normals[:, 1] < -1e-6), -1.0, sign)
    cells = np.round(normals * sign[:, None] * 40).astype(np.int64)
    _, place = np.unique(cells, axis=0, return_inverse=True)
    place = place.reshape(-1)
    area = np.bincount(place, weight)
    ranked = np.lexsort((np.arange(len(area)), -np.round(area, 12)))[:MAX_TILTS]
    out = []
    for cell in ranked.tolist():
        rows = place == cell
        mean = (normals[rows] * (sign[rows] * weight[rows])[:, None]).sum(axis=0)
        for within in REFINEMENT_RAD:
            mean /= max(float(np.linalg.norm(mean)), 1e-300)
            along = normals @ mean
            share = np.where(np.abs(along) > np.cos(within), weight, 0.0) * np.sign(along)
            mean = (normals * share[:, None]).sum(axis=0)
            if not mean.any():
                break
        else:
            out.append(mean / np.linalg.norm(mean))
    return out
