"""Convex hulls, and hulls of few vertices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.measure import signed_volume

# SciPy loads slowly; it is imported where it is used, since many runs import this module and compute no hull.
if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

# What is so much above the lowest point, as a share of the longest side, is as low.
LEVEL_SHARE = 1e-6


def convex_hull(points: Floats) -> tuple[Floats, Ints]:
    """Hull of a point cloud.

    Args:
        points: (N, 3).
    Returns:
        (M, 3) hull vertices in order of input; (F, 3) outward triangles.
    Raises:
        DegenerateShape: the points span no volume.
    """
    hull, _, _ = _qhull(points)
    index = np.sort(hull.vertices)
    place = np.full(len(points), -1, dtype=np.int64)
    place[index] = np.arange(len(index))
    faces = place[hull.simplices]
    inward = np.einsum("ij,ij->i", _cross(points[index], faces), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    # Each triangle starts at its lowest index, and they are sorted: Qhull's own order is not part of its promise.
    start = np.argmin(faces, axis=1)
    faces = np.stack([faces[np.arange(len(faces)), (start + k) % 3] for k in range(3)], axis=1)
    return points[index], faces[np.lexsort(faces.T[::-1])]


def hull_planes(points: Floats) -> Floats:
    """(F, 4) planes of the hull's faces: outward unit normal and offset; normal . x + offset is negative within.

    Raises:
        DegenerateShape: the points span no volume.
    """
    hull, center, scale = _qhull(points)
    planes: Floats = hull.equations.copy()
    planes[:, 3] = planes[:, 3] * scale - planes[:, :3] @ center
    return planes


def _qhull(points: Floats) -> tuple[ConvexHull, Floats, float]:
    """Qhull's hull of the points brought to unit size, and the corner and size that they were brought from."""
    from scipy.spatial import ConvexHull, QhullError

    extent = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    if len(points) < 4 or extent.max() <= 0:
        raise DegenerateShape("fewer than four distinct points span no volume")
    scale, center = float(extent.max()), points.min(axis=0)
    try:
        return ConvexHull((points - center) / scale), center, scale
    except QhullError as error:
        raise DegenerateShape("the points lie in a plane or on a line") from error


def _cross(points: Floats, faces: Ints) -> Floats:
    corners = points[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def hull_volume(points: Floats) -> float:
    """Volume of the hull of (N, 3) points; zero where they span none."""
    try:
        return signed_volume(*convex_hull(points))
    except DegenerateShape:
        return 0.0


def small_hull(points: Floats, limit: int = 64) -> tuple[Floats, Ints]:
    """Hull of at most `limit` vertices: grown from the outermost points, always by the point that sticks out most.

    If the full hull has a flat bottom to rest level on, so has this one.

    Args:
        points: (N, 3). limit: maximum number of vertices.
    Returns:
        As `convex_hull`; it lies inside the full hull and touches it in every vertex.
    Raises:
        DegenerateShape: the points span no volume.
    """
    from scipy.spatial import ConvexHull, QhullError

    cloud, faces = convex_hull(points)
    if len(cloud) <= limit:
        return cloud, faces
    # Distances are taken in a frame in which the cloud is as wide in every direction: however thin it is, it spans a
    # volume there. What is equally far but for the last bits, as in every round shape, has to be so on every machine.
    even, stretch = _evened(cloud)
    reach = float(np.ptp(cloud, axis=0).max())
    chosen = list(dict.fromkeys([*_outermost(cloud), *_standing(cloud, reach)]))[:limit]
    while len(chosen) < limit:
        try:
            planes = ConvexHull(even[chosen]).equations
        except QhullError:  # what is outermost in a thin cloud may lie in one plane
            chosen = sorted({*chosen, *_outermost(even)})[:limit]
            planes = ConvexHull(even[chosen]).equations
        true = np.linalg.norm(planes[:, :3] @ stretch, axis=1)
        outside = (((even @ planes[:, :3].T + planes[:, 3]) / true).max(axis=1) / reach).round(9)
        farthest = int(np.argmax(outside))
        if outside[farthest] <= 1e-6:
            break
        chosen.append(farthest)
    return convex_hull(cloud[sorted(chosen)])


def _evened(cloud: Floats) -> tuple[Floats, Floats]:
    """(N, 3) the cloud whitened to unit covariance, rounded, and the symmetric (3, 3) whitening matrix.

    The symmetric root is used because it does not depend on the choice of axes where the principal axes are ambiguous.
    """
    spread, axes = np.linalg.eigh(np.cov(cloud.T))
    least = 1e-12 * float(spread[-1])
    stretch: Floats = (axes / np.sqrt(np.maximum(spread, least))) @ axes.T
    return ((cloud - cloud.mean(axis=0)) @ stretch).round(9), stretch


def _outermost(cloud: Floats) -> list[int]:
    """Indices of the extreme points in 26 directions, ascending."""
    return sorted({int(i) for d in _directions() for s in [(cloud @ d).round(9)] for i in (s.argmax(), s.argmin())})


def _standing(cloud: Floats, reach: float) -> list[int]:
    """Indices of the corners of what is lowest, by the eight directions of a compass; ascending."""
    lowest = np.flatnonzero(cloud[:, 2] <= cloud[:, 2].min() + LEVEL_SHARE * reach)
    compass = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)], dtype=np.float64)
    return sorted({int(lowest[(cloud[lowest, :2] @ d).round(9).argmax()]) for d in compass})


def _directions() -> Floats:
    """(13, 3) half of the 26 directions of a cube's faces, edges and corners."""
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
    return grid[14:]
