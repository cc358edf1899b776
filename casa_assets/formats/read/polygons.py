"""Polygons of any number of corners, concave ones too as far as that is cheap -> triangles, and parts of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.formats.read.raw_parts import Bytes, ReadPart, check_face_count, merged_corners
from casa_assets.formats.read.text import Notes
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material

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
        # along the diagonal 0-2, or 1-3 where that would fold the quad over
        with np.errstate(invalid="ignore", over="ignore"):
            a = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
            b = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 0])
            folds = (a * b).sum(axis=1) < 0.0
        halves = np.where(folds[:, None, None], [[0, 1, 3], [1, 2, 3]], [[0, 1, 2], [0, 2, 3]])
        return halves.reshape(-1, 3), np.repeat(np.arange(count), 2), 0
    concave = np.flatnonzero(~_is_convex(points))
    pieces = np.tile(fan(corners), (count, 1, 1))
    fanned, left = 0, MAX_TESTS
    for p in concave:
        ears, tests = _clip(points[p], left)
        left -= tests
        if ears is None:
            fanned += 1
        else:
            pieces[p] = ears
    return pieces.reshape(-1, 3), np.repeat(np.arange(count), corners - 2), fanned


def _area_vectors(points: Floats) -> Floats:
    """(P, 3) normals of polygons, twice their area long (Newell)."""
    return np.asarray(np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1))


def _is_convex(points: Floats) -> npt.NDArray[np.bool_]:
    """(P,) whether all corners of a polygon turn the same way; True if that cannot be determined."""
    with np.errstate(invalid="ignore", over="ignore"):
        local = points - points[:, :1]
        normal = _area_vectors(local)
        edge = np.roll(local, -1, axis=1) - local
        turn = np.cross(edge, np.roll(edge, -1, axis=1))
        along = (turn * normal[:, None, :]).sum(axis=2)
        slack = 1e-9 * np.abs(along).max(axis=1, keepdims=True)
        return np.asarray(~(along < -slack).any(axis=1))


def _clip(points: Floats, most_tests: int) -> tuple[Ints | None, int]:
    """(n-2, 3) triangles of one concave polygon by ear clipping, or None if it crosses itself or takes too long.

    Returns:
        The triangles, and how many corners were tested for being ears.
    """
    n = len(points)
    if n > MAX_CLIPPED_CORNERS or not np.isfinite(points).all():
        return None, 0
    points = points - points[0]
    normal = _area_vectors(points[None])[0]
    axis = int(np.argmax(np.abs(normal)))
    flat = points[:, ((1, 2), (2, 0), (0, 1))[axis]]  # in the plane of the polygon, counter-clockwise
    flat = flat if normal[axis] > 0 else flat * np.array([1.0, -1.0])
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


def cut_polygons(
    points: Floats, corners: Ints, counts: Ints, limits: Mapping[str, float], notes: Notes, name: str
) -> tuple[Ints, Ints]:
    """Triangles of polygons; those with fewer than three corners or with points that do not exist are dropped.

    Args:
        points: (P, 3), any unit.
        corners: (C,) point of each corner, polygon after polygon.
        counts: (N,) corners of each polygon; where they claim more corners than there are, the last ones are dropped.
    Returns:
        (T, 3) places in `corners`, and (T,) polygon of each triangle, ascending.
    Raises:
        Rejected: TOO_LARGE.
    """
    counts = np.clip(counts, 0, len(corners) + 1)
    starts = np.concatenate(([0], np.cumsum(counts)))[:-1]
    is_whole = (counts >= 3) & (starts + counts <= len(corners))
    check_face_count(int((counts[is_whole] - 2).sum()), limits, name)
    is_bad = np.concatenate(([0], np.cumsum((corners < 0) | (corners >= len(points)))))
    is_whole[is_whole] = is_bad[(starts + counts)[is_whole]] == is_bad[starts[is_whole]]
    dropped = int((~is_whole).sum())
    if dropped:
        message = f"{dropped} faces with fewer than three corners or missing vertices were dropped"
        notes.add(codes.FACE_DROPPED, name, message)
    places, owner, fanned = cut_whole(points, corners, starts, counts, is_whole)
    if fanned:
        message = f"{fanned} concave or crossed faces were cut as fans; triangulate them first"
        notes.add(codes.POLYGON_FAN, name, message)
    return places, owner


def cut_whole(
    points: Floats, corners: Ints, starts: Ints, counts: Ints, is_whole: npt.NDArray[np.bool_]
) -> tuple[Ints, Ints, int]:
    """Triangles of the polygons that are whole, in the order of the polygons.

    Args:
        starts: (N,) place of the first corner of each polygon in `corners`; the others as for `cut_polygons`.
        is_whole: (N,) whether a polygon has three corners or more, all of which exist.
    Returns:
        (T, 3) places in `corners`, (T,) polygon of each triangle, and how many could only be cut as a fan.
    """
    places: list[Ints] = [np.zeros((0, 3), dtype=np.int64)]
    owners: list[Ints] = [np.zeros(0, dtype=np.int64)]
    fanned = 0
    for size in np.unique(counts[is_whole]):
        chosen = np.flatnonzero(is_whole & (counts == size))
        at = starts[chosen][:, None] + np.arange(size)
        local, polygon, fans = triangulate(points[corners[at]])
        fanned += fans
        places.append(at[polygon[:, None], local])
        owners.append(chosen[polygon])
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(places)[order], owner[order], fanned


def strip(count: int) -> Ints:
    """(T, 3) corners of the triangles of a strip, every second one turned, so that all face the same way."""
    i = np.arange(max(0, count - 2))
    odd = i % 2
    return np.column_stack((i + odd, i + 1 - odd, i + 2))


def fan(count: int) -> Ints:
    """(T, 3) corners of the triangles around the first corner."""
    i = np.arange(max(0, count - 2))
    return np.column_stack((np.zeros_like(i), i + 1, i + 2))


def part_of_corners(
    name: str,
    points: Floats,
    corners: Ints,
    triangles: Ints,
    material: Material,
    uv: Floats | None = None,
    normals: Floats | None = None,
    colors: Bytes | None = None,
) -> ReadPart:
    """ReadPart of triangles whose texture coordinates, normals and colours are given per corner.

    Args:
        points: (P, 3). corners: (C,) point of each corner. triangles: (T, 3) places in `corners`.
        uv, normals, colors: (C, 2), (C, 3), (C, 4) uint8, or None.
    """
    picked = triangles.reshape(-1)
    extra = [values[picked] for values in (uv, normals, colors) if values is not None]
    if not len(picked) or not extra:
        return ReadPart(name, points, corners[triangles], material)
    columns = [corners[picked]]
    for values in extra:  # the same number for equal rows, by their bits, so that NaN equals itself
        rows = np.ascontiguousarray(values)
        whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).reshape(-1)
        columns.append(np.unique(whole, return_inverse=True)[1].reshape(-1).astype(np.int64))
    first, faces = merged_corners(columns)
    chosen = picked[first]
    return ReadPart(
        name=name,
        vertices=points[corners[chosen]],
        faces=faces,
        material=material,
        uv=None if uv is None else uv[chosen],
        normals=None if normals is None else normals[chosen],
        colors=None if colors is None else colors[chosen],
    )
