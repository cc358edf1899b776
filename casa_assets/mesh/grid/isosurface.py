"""Signed distance field of a torn surface on a grid, and its zero level as a closed manifold."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.grid.voxels import Grid
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import face_normals

# Implicit field -------------------------------------------------------------------------------------------------------
# Closed pieces are filled, lone sheets get a wall.

MAX_SAMPLES = 300_000
# Cubes on either side of the surface in which distances are taken.
BAND_CELLS = 2
# How many cubes off the surface one looks whether there is matter: the skin of the grid ends before that.
PROBE_CELLS = 1.8
# Half the wall that a lone sheet gets, in cubes: the thinnest that the grid carries.
SHEET_HALF_CELLS = 0.6


def signed_distance_field(points: Floats, faces: Ints, grid: Grid) -> Floats:
    """(X, Y, Z) signed distances at voxel centres, metres, positive within matter; coarse away from the surface.

    The grid is of that surface, wound any way, open or not.
    """
    normals, areas = face_normals(points, faces)
    count = int(min(MAX_SAMPLES, max(2000, 4 * areas.sum() / grid.cell**2)))
    samples, face = samples_with_faces(points, faces, count)
    looks = [grid.cubes_at(samples + s * PROBE_CELLS * grid.cell * normals[face]) for s in (1, -1)]
    ahead, behind = (grid.solid[at] & ~grid.skin[at] for at in looks)
    field = np.where(grid.solid, grid.cell, -grid.cell)
    near = np.argwhere(ndimage.binary_dilation(grid.skin, iterations=BAND_CELLS))
    places = grid.origin + near * grid.cell
    distance, nearest = cKDTree(samples).query(places)
    level = np.einsum("ij,ij->i", places - samples[nearest], normals[face[nearest]])
    # Matter lies behind the surface, ahead of it where it is wound the wrong way round, or on both sides.
    inner = np.where(behind[nearest], -level, level)
    at = tuple(near.T)
    skin = grid.skin[at]
    full = grid.solid[at] & ~skin
    both = ahead[nearest] & behind[nearest] & grid.solid[at]
    signed = np.where(full | both | (skin & (inner > 0)), distance, -distance)
    lone = ~ahead[nearest] & ~behind[nearest]
    field[at] = np.where(lone & ~full, SHEET_HALF_CELLS * grid.cell - distance, signed)
    inner = np.zeros(field.shape, dtype=bool)
    inner[1:-1, 1:-1, 1:-1] = True
    closed: Floats = np.where(inner, field, np.minimum(field, -grid.cell / 2))
    return closed


# Isosurface -----------------------------------------------------------------------------------------------------------
# Extract the zero level of a field on a grid as a closed manifold, by marching tetrahedra.

# No vertex comes nearer to a corner of the grid than this share of an edge: slivers have no side.
MIN_EDGE_SHARE = 0.05


def isosurface(field: Floats, origin: Floats, cell: float) -> tuple[Floats, Ints]:
    """Triangulate the border of all that is positive: a manifold of outward faces, empty if nothing is positive.

    Args:
        field: (X, Y, Z) at the corners of a grid; its border has to be negative, or the surface is cut open there.
        origin: (3,) of the first corner. cell: distance between two, metres.
    Ref: Kuhn's six tetrahedra of a cube; neighbouring cubes share their diagonals, so that no gap opens.
    """
    shape = np.array(field.shape)
    within = field > 0
    near, far = slice(None, -1), slice(1, None)
    eight = np.stack([within[tuple(far if o else near for o in offset)] for offset in np.ndindex(2, 2, 2)])
    cubes = np.argwhere(eight.any(axis=0) & ~eight.all(axis=0))
    if not len(cubes):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    stride = np.array([shape[1] * shape[2], shape[2], 1])
    tetrahedra = np.concatenate([(cubes[:, None] + path) @ stride for path in _paths()])
    values = field.ravel()
    inner, outer = _crossed(tetrahedra, values > 0)
    ends = np.stack([np.minimum(inner, outer), np.maximum(inner, outer)], axis=-1).reshape(-1, 2)
    keys, place = np.unique(ends[:, 0] * values.size + ends[:, 1], return_inverse=True)
    first, second = keys // values.size, keys % values.size
    share = np.clip(values[first] / (values[first] - values[second]), MIN_EDGE_SHARE, 1 - MIN_EDGE_SHARE)
    at = np.stack(np.unravel_index(first, field.shape), axis=1)
    to = np.stack(np.unravel_index(second, field.shape), axis=1)
    points = origin + (at + share[:, None] * (to - at)) * cell
    faces = place.reshape(-1, 3)
    return points, _outward(points, faces, inner, outer, field.shape)


def _paths() -> list[Ints]:
    """The four corners of each tetrahedron: ways from one corner of a cube to the opposite one, an axis at a time."""
    out = []
    for order in permutations(range(3)):
        corners = [np.zeros(3, dtype=np.int64)]
        for axis in order:
            corners.append(corners[-1] + np.eye(3, dtype=np.int64)[axis])
        out.append(np.array(corners))
    return out


def _crossed(tetrahedra: Ints, within: Mask) -> tuple[Ints, Ints]:
    """(T, 3) for each triangle the inner and the outer end of the edges that its corners lie on."""
    inside = within[tetrahedra]
    order = np.argsort(~inside, axis=1, kind="stable")  # inner corners first
    ranked = np.take_along_axis(tetrahedra, order, axis=1)
    count = inside.sum(axis=1)
    one, two, three = (ranked[count == k] for k in (1, 2, 3))
    edges = [
        (one, ((0, 1), (0, 2), (0, 3))),
        (three, ((0, 3), (1, 3), (2, 3))),
        (two, ((0, 2), (0, 3), (1, 3))),
        (two, ((0, 2), (1, 3), (1, 2))),
    ]
    inner = np.concatenate([np.stack([rows[:, a] for a, _ in pairs], axis=1) for rows, pairs in edges])
    outer = np.concatenate([np.stack([rows[:, b] for _, b in pairs], axis=1) for rows, pairs in edges])
    return inner, outer


def _outward(points: Floats, faces: Ints, inner: Ints, outer: Ints, shape: tuple[int, ...]) -> Ints:
    """The faces turned so that they look from their inner ends to their outer ones."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    away = np.stack(np.unravel_index(outer, shape), axis=-1).mean(axis=1)
    away = away - np.stack(np.unravel_index(inner, shape), axis=-1).mean(axis=1)
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), away) < 0
    return np.where(wrong[:, None], faces[:, ::-1], faces)
