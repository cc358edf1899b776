"""Triangulate polygons, concave ones too as far as that is cheap."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints

# Ear clipping costs the square of the corners; beyond this a fan has to do.
MAX_CLIPPED_CORNERS = 3000
# Corners looked at for all polygons of one call, some 15 s of work; honest files stay a hundred times below.
MAX_TESTS = 300_000


def triangulate(points: Floats) -> tuple[Ints, Ints, int]:
    """Triangles of many polygons with the same number of corners.

    Args:
        points: (P, n, 3) corners in order, n >= 3, any unit.
    Returns:
        (T, 3) corner numbers in 0..n-1, (T,) polygon of each triangle in order, and the count of concave polygons that
        could only be cut as a fan.
    """
    count, corners = points.shape[:2]
    if corners == 3:
        return np.tile(np.arange(3), (count, 1)), np.arange(count), 0
    if corners == 4:
        return (*_quads(points), 0)
    fan = np.column_stack((np.zeros(corners - 2, dtype=np.int64), np.arange(1, corners - 1), np.arange(2, corners)))
    concave = np.flatnonzero(~_is_convex(points))
    pieces = np.tile(fan, (count, 1, 1))
    fanned, left = 0, MAX_TESTS
    for p in concave:
        ears, tests = _clip(points[p], left)
        left -= tests
        if ears is None:
            fanned += 1
        else:
            pieces[p] = ears
    return pieces.reshape(-1, 3), np.repeat(np.arange(count), corners - 2), fanned


def _quads(points: Floats) -> tuple[Ints, Ints]:
    """Split along the diagonal 0-2, or 1-3 where that would fold the quad over."""
    with np.errstate(invalid="ignore", over="ignore"):
        a = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        b = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 0])
        folds = (a * b).sum(axis=1) < 0.0
    straight, crossed = np.array([[0, 1, 2], [0, 2, 3]]), np.array([[0, 1, 3], [1, 2, 3]])
    return np.where(folds[:, None, None], crossed, straight).reshape(-1, 3), np.repeat(np.arange(len(points)), 2)


def _area_vectors(points: Floats) -> Floats:
    """(P, 3) normals of polygons, twice their area long (Newell)."""
    return np.asarray(np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1))


def _is_convex(points: Floats) -> npt.NDArray[np.bool_]:
    """(P,) whether all corners of a polygon turn the same way; true where that cannot be told."""
    with np.errstate(invalid="ignore", over="ignore"):
        local = points - points[:, :1]
        normal = _area_vectors(local)
        edge = np.roll(local, -1, axis=1) - local
        turn = np.cross(edge, np.roll(edge, -1, axis=1))
        along = (turn * normal[:, None, :]).sum(axis=2)
        slack = 1e-9 * np.abs(along).max(axis=1, keepdims=True)
        return np.asarray(~(along < -slack).any(axis=1))


def _clip(points: Floats, most_tests: int) -> tuple[Ints | None, int]:
    """(n-2, 3) triangles of one concave polygon by ear clipping, or None where it crosses itself or takes too long.

    Returns:
        The triangles, and how many corners were tested for being ears.
    """
    n = len(points)
    if n > MAX_CLIPPED_CORNERS or not np.isfinite(points).all():
        return None, 0
    flat = _flattened(points - points[0])
    left = list(range(n))
    triangles: list[tuple[int, int, int]] = []
    at, misses, tests = 0, 0, 0
    while len(left) > 3:
        tests += 1
        size = len(left)
        i, j, k = left[(at - 1) % size], left[at % size], left[(at + 1) % size]
        if _is_ear(flat, i, j, k, left):
            triangles.append((i, j, k))
            del left[at % size]
            at, misses = at % size, 0
        else:
            at, misses = at + 1, misses + 1
            if misses > size or tests > most_tests:
                return None, tests
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64), tests


def _flattened(points: Floats) -> Floats:
    """(n, 2) points in the plane of the polygon, counter-clockwise."""
    normal = _area_vectors(points[None])[0]
    axis = int(np.argmax(np.abs(normal)))
    u, v = ((1, 2), (2, 0), (0, 1))[axis]
    flat = points[:, [u, v]]
    return flat if normal[axis] > 0 else flat * np.array([1.0, -1.0])


def _is_ear(flat: Floats, i: int, j: int, k: int, left: list[int]) -> bool:
    a, b, c = flat[i], flat[j], flat[k]
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area < 0.0:
        return False
    others = flat[left]
    inside = np.ones(len(left), dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (q[0] - p[0]) * (others[:, 1] - p[1]) - (q[1] - p[1]) * (others[:, 0] - p[0]) > 0.0
    return not inside.any()
