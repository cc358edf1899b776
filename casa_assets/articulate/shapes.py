"""Triangles of one link -> convex shapes that are touched: a hull where that is what they are, else boxes of a grid."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.errors import DegenerateShape
from casa_assets.geometry.hull import hull_volume, small_hull
from casa_assets.geometry.voxel import voxelise
from casa_assets.model.mesh import Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box, Hull, Shape

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

# What fills this part of its hull is touched as its hull.
FULL = 0.8
CELLS, THINNEST_M = 28, 0.002
MOST_BOXES = 40


def shapes_of(points: Floats, faces: Ints, most: int = MOST_BOXES) -> list[tuple[Shape, Pose]]:
    """Shapes that cover a surface and leave its cavities open.

    Args:
        points: (P, 3) metres. faces: (F, 3) over them. most: how many boxes at most.
    """
    used, local = np.unique(faces, return_inverse=True)
    cloud, triangles = points[used], local.reshape(-1, 3)
    extent = np.ptp(cloud, axis=0)
    if extent.min() < THINNEST_M:
        return [_plate(cloud)]
    grid = voxelise(cloud, triangles, cells=CELLS)
    if grid.volume >= FULL * hull_volume(cloud):
        return [_hull(cloud)]
    return _boxes(grid.skin | grid.solid, grid.origin, grid.cell, cloud, most)


def _plate(cloud: Floats) -> tuple[Shape, Pose]:
    """A box round something flat, at least as thick as contacts hold."""
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    size = np.maximum(high - low, THINNEST_M)
    x, y, z = (_seven(v) for v in size)
    return Box(size=(x, y, z)), Pose(position=_vec((low + high) / 2))


def _hull(cloud: Floats) -> tuple[Shape, Pose]:
    try:
        points, faces = small_hull(cloud.astype(np.float32).astype(np.float64))
    except DegenerateShape:
        return _plate(cloud)
    return Hull(mesh=Mesh(vertices=points, faces=faces)), Pose()


def _boxes(solid: Bools, origin: Floats, cell: float, cloud: Floats, most: int) -> list[tuple[Shape, Pose]]:
    """Cells of a grid gathered into boxes, the largest first; clipped to the box round the surface."""
    left = solid.copy()
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    out: list[tuple[Shape, Pose]] = []
    while left.any() and len(out) < most:
        a, b = _largest(left)
        left[a[0] : b[0], a[1] : b[1], a[2] : b[2]] = False
        start = np.maximum(origin + (a - 0.5) * cell, low)
        stop = np.minimum(origin + (b - 0.5) * cell, high)
        if (stop - start).min() <= 1e-4:
            continue
        x, y, z = (_seven(v) for v in stop - start)
        out.append((Box(size=(x, y, z)), Pose(position=_vec((start + stop) / 2))))
    return out or [_hull(cloud)]


def _largest(solid: Bools) -> tuple[Ints, Ints]:
    """A large box of full cells: grown from a full cell along the axes in each order, the best of some seeds."""
    cells = np.argwhere(solid)
    best: tuple[int, Ints, Ints] = (0, cells[0], cells[0] + 1)
    for seed in cells[np.linspace(0, len(cells) - 1, 12).astype(int)]:
        for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            a, b = seed.copy(), seed + 1
            for axis in order:
                _grow(solid, a, b, axis)
            volume = int(np.prod(b - a))
            if volume > best[0]:
                best = (volume, a, b)
    return best[1], best[2]


def _grow(solid: Bools, a: Ints, b: Ints, axis: int) -> None:
    """Extend a box both ways along an axis while all new cells are full; in place."""
    for step in (-1, 1):
        while True:
            at = a[axis] - 1 if step < 0 else b[axis]
            if not 0 <= at < solid.shape[axis]:
                break
            window = [slice(int(p), int(q)) for p, q in zip(a, b, strict=True)]
            window[axis] = slice(int(at), int(at) + 1)
            if not solid[tuple(window)].all():
                break
            if step < 0:
                a[axis] -= 1
            else:
                b[axis] += 1


def _vec(values: Floats) -> tuple[float, float, float]:
    x, y, z = (_seven(v) for v in values)
    return (x, y, z)


def _seven(value: float) -> float:
    return float(f"{float(value):.7g}")
