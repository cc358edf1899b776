"""A closed solid for a torn surface: its signed distance field on a grid, and the zero level of that."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.collision.components import AssembledSolid, assemble_solid, covers_surface
from casa_assets.ingest.components import MAX_WALLED_FILL, MIN_SEALED_GROWTH, THIN_WALL_RATIO, SurfaceKind
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.solid.solids import (
    Solid,
    simplify_solid,
    solid_of,
    split_by_plane,
    surface_of,
    volume_of_hull,
    without_voids,
)
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import fill_holes
from casa_assets.mesh.voxels import Grid, voxelise

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
    return np.asarray(np.where(inner, field, np.minimum(field, -grid.cell / 2)))


# Isosurface -----------------------------------------------------------------------------------------------------------

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


# Voxels along the longest side of the grid on which a broken surface is made solid; a choice, as all numbers here.
CELLS = 72
# A hole wider than this share of the longest side is an opening and is not filled.
SMALL_HOLE = 0.05
# The grid is compared with something solid only if the thinnest side of its bounding box has so many voxels.
TELLING_CELLS = 12
# A solid made on the grid is simplified within this share of a voxel, which leaves about a tenth of its faces.
SMOOTH_CELLS = 0.3
# A solid made on the grid reaches beyond the bounding box of the surface and is cut off there, unless less than this
# share of it would be left.
MIN_KEPT_SHARE = 0.7
# A surface of which more than this share is sheets without a volume is an open sheet.
MIN_SHEET_SHARE = 0.5
# Radius of the ball, in voxels, that does not pass the windows of a lattice: its diameter is 8 % of the longest side.
WINDOW_CELLS = 2.5
# Windows take at least this share of the voxels of a lattice.
MIN_WINDOW_SHARE = 0.1
# Half the wall, in voxels, that is taken off a lattice, as the grid is that much too thick. The shortest way between
# two voxels that the ball does not fill is .33 longer than its radius: with less than that no bar is lost.
LATTICE_HALF_CELLS = 0.25


@dataclass(frozen=True)
class SolidProxy:
    """Solid that represents a surface.

    Attributes:
        solid: closed, outward, metres, without sealed cavities.
        kind: of the surface. message: the measurements behind it and the steps that were taken, in words.
        mean_wall_m: mean thickness, metres: twice the volume over the area.
    """

    solid: Solid
    kind: SurfaceKind
    message: str
    mean_wall_m: float


def solid_proxy(points: Floats, faces: Ints, is_full: bool) -> SolidProxy | None:
    """Build the solid that represents a surface, welded, metres, or return None if no volume can be made of it.

    `is_full`: known to be solid all through, so that openings and cavities are filled.
    """
    longest = float(np.ptp(points, axis=0).max())
    area = float(face_normals(points, faces)[1].sum())
    grid = voxelise(points, faces, CELLS, bridge=is_full)
    grid_is_fine_enough = not is_full or float(np.ptp(points, axis=0).min()) * CELLS > TELLING_CELLS * longest
    for build in (_closed, assemble_solid):
        assembled = build(points, faces, grid)
        if assembled is None:
            continue
        solid = without_voids(assembled.solid)
        if covers_surface(solid, points, faces, grid if grid_is_fine_enough else None):
            raw = None if assembled.sheet_share > MIN_SHEET_SHARE else assembled.solid
            solid = _within(solid, points[np.unique(faces)]) if assembled.sheet_share > 0 else solid
            return _classified(solid, raw, area, longest, list(assembled.steps))
    gridded = solid_of(*isosurface(signed_distance_field(points, faces, grid), grid.origin, grid.cell))
    if gridded is None:
        return None
    solid = _smoothed(gridded, grid, points[np.unique(faces)])
    exact = _closed(points, faces, grid)
    done = [f"made solid on a grid of {1000 * grid.cell:.2g} mm"]
    return _classified(solid, None if exact is None else exact.solid, area, longest, done)


def without_windows(points: Floats, faces: Ints) -> SolidProxy | None:
    """Build the solid of a lattice (a basket, a colander, a grille) with its windows closed: walls in place of bars.

    A window is an opening that a ball with a diameter of 8 % of the longest side cannot pass. Return None if few
    windows are found. `points`: (P, 3) welded, metres.
    """
    grid = voxelise(points, faces, CELLS)
    rim = int(WINDOW_CELLS) + 2
    matter = np.pad(grid.solid, rim)
    swept = ndimage.distance_transform_edt(~matter) > WINDOW_CELLS
    field = ndimage.distance_transform_edt(~swept) - WINDOW_CELLS - LATTICE_HALF_CELLS
    if int(((field > 0) & ~matter).sum()) < MIN_WINDOW_SHARE * int(matter.sum()):
        return None
    closed = solid_of(*isosurface(field * grid.cell, grid.origin - rim * grid.cell, grid.cell))
    if closed is None:
        return None
    solid = _smoothed(closed, grid, points[np.unique(faces)])
    area, longest = float(face_normals(points, faces)[1].sum()), float(np.ptp(points, axis=0).max())
    return _classified(solid, None, area, longest, ["windows closed"])


def _smoothed(solid: Solid, grid: Grid, points: Floats) -> Solid:
    """A solid that was made on a grid, simplified, without voids and within the bounding box of some points."""
    return _within(without_voids(simplify_solid(solid, SMOOTH_CELLS * grid.cell)), points)


def _within(solid: Solid, points: Floats) -> Solid:
    """Part of a solid within the bounding box of some points; all of it if too little would be left, as of a sheet."""
    rest = solid
    for axis in np.eye(3):
        rest = split_by_plane(rest, axis, float((points @ axis).min()))[0]
        rest = split_by_plane(rest, -axis, float((points @ -axis).min()))[0]
    return rest if rest.volume() > MIN_KEPT_SHARE * solid.volume() else solid


def _closed(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """The surface as a solid, small holes filled; None if it is not closed even then."""
    solid = solid_of(points, faces)
    if solid is not None:
        return AssembledSolid(solid, ())
    filled = fill_holes(points, faces, SMALL_HOLE * grid.cell * CELLS)
    solid = None if filled is None else solid_of(*filled)
    return None if solid is None else AssembledSolid(solid, ("small holes were closed",))


def _classified(solid: Solid, raw: Solid | None, area: float, longest: float, steps: list[str]) -> SolidProxy:
    """The proxy with its kind, which follows from the share of the hull filled, wall thickness and sealed volume.

    `raw`: the solid before sealed cavities were filled; None if the surface does not bound a solid.
    """
    volume = float(solid.volume())
    hull_fill = volume / max(volume_of_hull([solid]), 1e-30)
    mean_wall_m = 2 * volume / float(face_normals(*surface_of(solid))[1].sum())
    raw_volume = float(raw.volume()) if raw is not None else 0.0
    wall_ratio = 2 * (raw_volume if raw is not None else volume) / (area * longest)
    sealed_share = 1 - raw_volume / volume if raw is not None and volume > 0 else 0.0
    if raw is None:
        kind = SurfaceKind.SHEET if wall_ratio < THIN_WALL_RATIO else SurfaceKind.SOLID
    elif sealed_share > MIN_SEALED_GROWTH:
        kind = SurfaceKind.DOUBLE
        steps = [*steps, f"{sealed_share:.0%} of it was sealed off and was filled"]
    else:
        kind = SurfaceKind.WALLED if hull_fill < MAX_WALLED_FILL and wall_ratio < THIN_WALL_RATIO else SurfaceKind.SOLID
    message = f"{kind}: fills {hull_fill:.0%} of its hull, walls {wall_ratio:.3f} of its length"
    return SolidProxy(solid, kind, "; ".join([message, *steps]), mean_wall_m)
