"""Voxel grid of what a surface encloses, for surfaces that are too broken for exact volumes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from casa_assets.core.typing import Floats, Ints

# Points per side of a triangle at most, and points that are held in memory at once.
MOST_STEPS = 4096
SAMPLES_AT_ONCE = 1_000_000


@dataclass(frozen=True)
class Grid:
    """Cubes of side `cell` (m); cube (i, j, k) is centred on origin + (i, j, k) * cell.

    Attributes:
        solid: (X, Y, Z) what the surface encloses, itself included. skin: (X, Y, Z) what it passes through.
    """

    origin: Floats
    cell: float
    solid: npt.NDArray[np.bool_]
    skin: npt.NDArray[np.bool_]

    @property
    def volume(self) -> float:
        """Enclosed volume, m^3: skin cubes count half, for the surface passes through their middle on average."""
        inner = int((self.solid & ~self.skin).sum())
        return (inner + 0.5 * int((self.solid & self.skin).sum())) * self.cell**3

    def centers(self) -> Floats:
        """(N, 3) centres of the solid cubes."""
        return self.origin + np.argwhere(self.solid) * self.cell


def voxelise(points: Floats, faces: Ints, cells: int = 64, bridge: bool = False) -> Grid:
    """Voxel grid of everything that the surface encloses, flooding from outside.

    Args:
        points: (P, 3). faces: (F, 3), any winding, open or not.
        cells: cubes along the longest side.
        bridge: also fill what lies between two walls along at least two of the axes, so that a missing
            bottom or lid does not empty a thing that is known to be full.
    """
    low = points.min(axis=0)
    extent = np.ptp(points, axis=0)
    cell = float(extent.max()) / cells
    origin = low - 2 * cell
    shape = np.ceil(extent / cell).astype(int) + 5
    skin = _skin(points, faces, origin, cell, tuple(shape))
    solid = ndimage.binary_fill_holes(skin)
    if bridge:
        solid = ndimage.binary_fill_holes(solid | _between(skin))
    return Grid(origin, cell, solid, skin)


def skin_cells(points: Floats, faces: Ints, grid: Grid) -> npt.NDArray[np.bool_]:
    """(X, Y, Z) cubes of a grid that another surface, (P, 3) points and (F, 3) faces, passes through.

    Parts of the surface outside the grid are drawn onto its border.
    """
    return _skin(points, faces, grid.origin, grid.cell, grid.solid.shape)


def _skin(points: Floats, faces: Ints, origin: Floats, cell: float, shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """Cubes of a grid that a surface passes through."""
    skin = np.zeros(shape, dtype=bool)
    for samples in _samples(points, faces, cell * 0.5):
        at = np.clip(np.round((samples - origin) / cell).astype(int), 0, np.array(shape) - 1)
        skin[at[:, 0], at[:, 1], at[:, 2]] = True
    return skin


def _between(skin: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Cubes with skin on both sides along at least two of the axes."""
    votes = np.zeros(skin.shape, dtype=np.int8)
    for axis in range(3):
        ahead = np.maximum.accumulate(skin, axis=axis)
        behind = np.flip(np.maximum.accumulate(np.flip(skin, axis), axis=axis), axis)
        votes += (ahead & behind).astype(np.int8)
    return votes >= 2


def _samples(points: Floats, faces: Ints, spacing: float) -> Iterator[Floats]:
    """Points on the surface no farther apart than `spacing`, some at a time.

    Each triangle is cut into rows from its sharpest corner to the side across, which is its shortest: a needle
    costs as many points as it is long, not that number squared.
    """
    yield points
    corners = points[faces]
    across = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1), axis=2)  # side facing each
    sharpest = np.argmin(across, axis=1)
    turn = (sharpest[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn[:, :, None], axis=1)
    rows = np.clip(np.ceil(across.max(axis=1) / spacing), 1, MOST_STEPS).astype(int)
    columns = np.clip(np.ceil(across.min(axis=1) / spacing), 1, MOST_STEPS).astype(int)
    kinds, kind = np.unique(rows * (MOST_STEPS + 1) + columns, return_inverse=True)
    order = np.argsort(kind, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        along, side = divmod(int(kinds[kind[group[0]]]), MOST_STEPS + 1)
        s, t = (g.ravel() for g in np.meshgrid(np.arange(1, along + 1) / along, np.arange(side + 1) / side))
        weights = np.stack([1 - s, s * (1 - t), s * t], axis=1)
        most = max(1, SAMPLES_AT_ONCE // len(weights))
        for start in range(0, len(group), most):
            yield np.einsum("sk,nkd->nsd", weights, corners[group[start : start + most]]).reshape(-1, 3)


def boundary(grid: Grid) -> tuple[Floats, Ints]:
    """Surface of the solid cubes: (P, 3) corner points and (F, 3) outward triangles."""
    solid = np.pad(grid.solid, 1)
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            beyond = np.roll(solid, -1 if side else 1, axis=axis)
            cells = np.argwhere(solid & ~beyond) - 1
            corner = cells.copy()
            corner[:, axis] += side
            ring = [corner.copy() for _ in range(4)]
            ring[1][:, u] += 1
            ring[2][:, u] += 1
            ring[2][:, v] += 1
            ring[3][:, v] += 1
            quads.append(np.stack(ring if side else ring[::-1], axis=1))
    corners = np.concatenate(quads)
    keys, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    faces = np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]])
    return grid.origin + (keys - 0.5) * grid.cell, faces.astype(np.int64)
