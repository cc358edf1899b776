"""Signed distance field of a torn surface on a grid: closed pieces are filled, lone sheets get a wall."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.voxel import Grid
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.solid.coverage import samples_with_faces

MAX_SAMPLES = 300_000
# Cubes on either side of the surface in which distances are taken.
BAND_CELLS = 2
# How many cubes off the surface one looks whether there is matter: the skin of the grid ends before that.
PROBE_CELLS = 1.8
# Half the wall that a lone sheet gets, in cubes: the thinnest that the grid carries.
SHEET_HALF_CELLS = 0.6


def signed_distance_field(points: Floats, faces: Ints, grid: Grid) -> Floats:
    """(X, Y, Z) signed distances at voxel centres, metres, positive within matter; coarse away from the surface.

    Args:
        points: (P, 3). faces: (F, 3), any winding, open or not. grid: of that surface.
    """
    normals, areas = face_normals(points, faces)
    count = int(min(MAX_SAMPLES, max(2000, 4 * areas.sum() / grid.cell**2)))
    samples, face = samples_with_faces(points, faces, count)
    ahead, behind = (_is_full(samples + s * PROBE_CELLS * grid.cell * normals[face], grid) for s in (1, -1))
    field = np.where(grid.solid, grid.cell, -grid.cell)
    near = np.argwhere(ndimage.binary_dilation(grid.skin, iterations=BAND_CELLS))
    places = grid.origin + near * grid.cell
    distance, nearest = cKDTree(samples).query(places)
    level = np.einsum("ij,ij->i", places - samples[nearest], normals[face[nearest]])
    # Matter lies behind the surface, ahead of it where it is wound the wrong way round, or on both sides.
    inner = np.where(behind[nearest], -level, level)
    full = grid.solid[tuple(near.T)] & ~grid.skin[tuple(near.T)]
    skin = grid.skin[tuple(near.T)]
    both = ahead[nearest] & behind[nearest] & grid.solid[tuple(near.T)]
    signed = np.where(full | both | (skin & (inner > 0)), distance, -distance)
    lone = ~ahead[nearest] & ~behind[nearest]
    field[tuple(near.T)] = np.where(lone & ~full, SHEET_HALF_CELLS * grid.cell - distance, signed)
    inner = np.zeros(field.shape, dtype=bool)
    inner[1:-1, 1:-1, 1:-1] = True
    closed: Floats = np.where(inner, field, np.minimum(field, -grid.cell / 2))
    return closed


def _is_full(places: Floats, grid: Grid) -> npt.NDArray[np.bool_]:
    at = np.clip(np.round((places - grid.origin) / grid.cell).astype(int), 0, np.array(grid.solid.shape) - 1)
    where = tuple(at.T)
    found: npt.NDArray[np.bool_] = grid.solid[where] & ~grid.skin[where]
    return found
