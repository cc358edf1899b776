"""Build a solid from a surface made of pieces: open pieces are closed, lone sheets get a thickness."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.voxel import Grid
from casa_assets.geometry.mesh.hole_filling import fill_holes
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import consistent_winding, face_components
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.geometry.solid.cutting import Solid, solid_of, surface_of, without_voids
from casa_assets.geometry.solid.deviation import distances_outside, reference_surface

# With more pieces, or more faces of sheets, a grid is quicker.
MOST_PIECES = 200
MOST_SHEETS = 600
# Thickness of what a sheet becomes: at least this, metres, and this share of the longest side.
SHEET_M = 0.001
SHEET_RATIO = 0.008
# Lids are put on where the grid has matter at this share of them.
CLOSED_SHARE = 0.9
# A solid whose mean wall is thinner than this share of the longest side is a sheet with two faces.
FLAT_WALL_RATIO = 1e-3
# Share of what the grid encloses, if it is more than a few cubes, that has to lie in the solid.
MIN_ENCLOSED_SHARE = 0.8
FEW_VOXELS = 50
# Samples, and how many of them may lie farther from the solid than this share of the longest side.
SAMPLES = 2000
MAX_FAR_SHARE = 0.01
FAR_RATIO = 0.012


@dataclass(frozen=True)
class AssembledSolid:
    """Solid that a surface was made into.

    Attributes:
        done: what was done for that, in words. lone: share of the surface that was sheets with nothing behind.
    """

    solid: Solid
    done: tuple[str, ...]
    lone: float = 0.0


def assemble_solid(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """Build the solid of a surface made of pieces; None where one of them cannot be made solid.

    Args:
        points: (P, 3) welded, metres. faces: (F, 3), any winding.
        grid: of that surface; openings that it knows nothing of stay open.
    """
    longest = float(np.ptp(points, axis=0).max())
    label = face_components(faces, len(points))
    count = int(label.max()) + 1
    if count > MOST_PIECES:
        return None
    order = np.argsort(label, kind="stable")
    solids: list[Solid] = []
    sheets: list[Ints] = []
    closed = 0
    for rows in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        used, local = np.unique(faces[rows], return_inverse=True)
        piece = _closed(points[used], local.reshape(-1, 3), grid, longest)
        if piece is None:
            sheets.append(faces[rows])
        else:
            solids.append(piece[0])
            closed += piece[1]
    lone = _once(np.concatenate(sheets)) if sheets else np.zeros((0, 3), dtype=np.int64)
    if len(lone) > MOST_SHEETS:
        return None
    thick = max(SHEET_M, SHEET_RATIO * longest)
    solids += _prisms(points, lone, thick)
    if not solids:
        return None
    whole = without_voids(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    done = [f"put together from {count} pieces"] if count > 1 else []
    done += [f"lids on {closed}"] if closed else []
    done += [f"{1000 * thick:.2g} mm for {len(lone)} lone faces"] if len(lone) else []
    share = sum(float(face_normals(points, rows)[1].sum()) for rows in sheets) / float(
        face_normals(points, faces)[1].sum()
    )
    return AssembledSolid(whole, tuple(done), share) if whole.volume() > 0 else None


def covers_surface(solid: Solid, points: Floats, faces: Ints, grid: Grid | None) -> bool:
    """True where the surface lies on or in a solid, and so does what a given grid knows it to enclose."""
    of = reference_surface(*surface_of(solid))
    samples = surface_samples(points, faces, SAMPLES)
    if float((distances_outside(samples, of) > FAR_RATIO * of.longest).mean()) > MAX_FAR_SHARE:
        return False
    inner = np.zeros((0, 3)) if grid is None else np.argwhere(grid.solid & ~grid.skin)
    if grid is None or len(inner) < FEW_VOXELS:
        return True
    places = grid.origin + inner[:: max(1, len(inner) // SAMPLES)] * grid.cell
    return float((distances_outside(places, of) < grid.cell).mean()) >= MIN_ENCLOSED_SHARE


def _closed(points: Floats, faces: Ints, grid: Grid, longest: float) -> tuple[Solid, bool] | None:
    """A piece as a solid, and whether lids were put on for that; None where it is a sheet, or a lid would be in air."""
    solid = _either_way(points, faces, longest)
    if solid is not None:
        return solid, False
    single = consistent_winding(_once(faces))[0]
    whole = fill_holes(points, single, np.inf, most_torn=1.0)
    if whole is None:
        return None
    solid = _either_way(*whole, longest)
    return (solid, True) if solid is not None and _is_matter(whole[0], _new(whole[1], single), grid) else None


def _either_way(points: Floats, faces: Ints, longest: float) -> Solid | None:
    """A closed surface as a solid, inside out or not; None where it is none, or one without thickness."""
    for turned in (faces, faces[:, ::-1]):
        solid = solid_of(points, turned)
        if solid is not None and not _is_flat(solid, longest):
            return solid
    return None


def _is_flat(solid: Solid, longest: float) -> bool:
    return 2 * float(solid.volume()) < FLAT_WALL_RATIO * longest * float(solid.surface_area())


def _new(faces: Ints, old: Ints) -> Ints:
    """Faces that are none of some others."""
    base = int(max(faces.max(), old.max())) + 1
    keys = [(np.sort(f, axis=1) * np.array([base * base, base, 1])).sum(axis=1) for f in (faces, old)]
    return faces[~np.isin(*keys)]


def _is_matter(points: Floats, lids: Ints, grid: Grid) -> bool:
    """The grid has matter wherever a lid is."""
    if not len(lids):
        return True
    samples = surface_samples(points, lids, SAMPLES)
    at = np.clip(np.round((samples - grid.origin) / grid.cell).astype(int), 0, np.array(grid.solid.shape) - 1)
    return float(grid.solid[tuple(at.T)].mean()) >= CLOSED_SHARE


def _once(faces: Ints) -> Ints:
    """Faces without the twins that look the other way."""
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return faces[np.sort(first)]


def _prisms(points: Floats, faces: Ints, thick: float) -> list[Solid]:
    """Each face as a plate that reaches as far before it as behind it."""
    normals, areas = face_normals(points, faces)
    out = []
    for corners, normal, area in zip(points[faces], normals, areas, strict=True):
        if area > 0:
            plate = np.concatenate([corners + normal * thick / 2, corners - normal * thick / 2])
            hull = manifold3d.Manifold.hull_points(plate)
            if not hull.is_empty() and hull.volume() > 0:
                out.append(hull)
    return out
