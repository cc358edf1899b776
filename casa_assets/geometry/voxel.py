"""Solids on a grid: what a surface encloses when it is too broken for exact volumes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


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
    """Grid of everything that the surface encloses, flooding from outside.

    Args:
        points: (P, 3). faces: (F, 3), any winding, open or not.
        cells: cubes along the longest side.
        bridge: also fill what lies between two walls along all three axes, so that a missing
            bottom or lid does not empty a thing that is known to be full.
    """
    low = points.min(axis=0)
    extent = np.ptp(points, axis=0)
    cell = float(extent.max()) / cells
    origin = low - 2 * cell
    shape = np.ceil(extent / cell).astype(int) + 5
    at = np.round((_samples(points, faces, cell * 0.5) - origin) / cell).astype(int)
    skin = np.zeros(shape, dtype=bool)
    skin[at[:, 0], at[:, 1], at[:, 2]] = True
    solid = ndimage.binary_fill_holes(skin)
    if bridge:
        solid = ndimage.binary_fill_holes(solid | _between(skin))
    return Grid(origin, cell, solid, skin)


def _between(skin: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Cubes with skin on both sides along at least two of the axes."""
    votes = np.zeros(skin.shape, dtype=np.int8)
    for axis in range(3):
        ahead = np.maximum.accumulate(skin, axis=axis)
        behind = np.flip(np.maximum.accumulate(np.flip(skin, axis), axis=axis), axis)
        votes += (ahead & behind).astype(np.int8)
    return votes >= 2


def _samples(points: Floats, faces: Ints, spacing: float) -> Floats:
    """Points on the surface no farther apart than `spacing`: each triangle on its own barycentric lattice."""
    corners = points[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = np.clip(np.ceil(edges / spacing), 1, 4096).astype(int)
    out = [points]
    for count in np.unique(steps):
        some = corners[steps == count]
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        keep = i + j <= count
        u, v = i[keep] / count, j[keep] / count
        weights = np.stack([1 - u - v, u, v], axis=1)
        out.append(np.einsum("sk,nkd->nsd", weights, some).reshape(-1, 3))
    return np.concatenate(out)


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
