"""Build one solid from the components of a surface: open ones get lids, sheets get a thickness."""

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

# All numbers below are choices.
# With more components, or more faces of sheets, making the solid on a grid is quicker.
MAX_COMPONENTS = 200
MAX_SHEET_FACES = 600
# Thickness that a sheet is given: the larger of this, metres, and this share of the longest side.
SHEET_M = 0.001
SHEET_RATIO = 0.008
# A lid is accepted if the grid is filled at this share of its samples.
FILLED_LID_SHARE = 0.9
# A solid whose mean wall is thinner than this share of the longest side is a sheet with two faces.
FLAT_WALL_RATIO = 1e-3
# Share of the voxels enclosed by the surface that the solid has to cover, unless they are fewer than FEW_VOXELS.
MIN_ENFILLED_LID_SHARE = 0.8
FEW_VOXELS = 50
# Samples on the surface, and the share of them that may lie farther from the solid than FAR_RATIO of the longest side.
SAMPLES = 2000
MAX_FAR_SHARE = 0.01
FAR_RATIO = 0.012


@dataclass(frozen=True)
class AssembledSolid:
    """Solid that a surface was made into.

    Attributes:
        steps: what was done for that, in words. sheet_share: share of the area that was sheets without a volume.
    """

    solid: Solid
    steps: tuple[str, ...]
    sheet_share: float = 0.0


def assemble_solid(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """Build the solid of a surface from its components; None where there are too many, or no volume.

    Args:
        points: (P, 3) welded, metres. faces: (F, 3), any winding.
        grid: voxels of the surface; a lid is put on an opening only where the grid is filled.
    """
    longest = float(np.ptp(points, axis=0).max())
    label = face_components(faces, len(points))
    count = int(label.max()) + 1
    if count > MAX_COMPONENTS:
        return None
    order = np.argsort(label, kind="stable")
    solids: list[Solid] = []
    sheets: list[Ints] = []
    closed_count = 0
    for face_rows in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        used, local = np.unique(faces[face_rows], return_inverse=True)
        closed = _closed(points[used], local.reshape(-1, 3), grid, longest)
        if closed is None:
            sheets.append(faces[face_rows])
        else:
            solids.append(closed[0])
            closed_count += closed[1]
    sheet_faces = _unique_faces(np.concatenate(sheets)) if sheets else np.zeros((0, 3), dtype=np.int64)
    if len(sheet_faces) > MAX_SHEET_FACES:
        return None
    sheet_thickness_m = max(SHEET_M, SHEET_RATIO * longest)
    solids += _plates(points, sheet_faces, sheet_thickness_m)
    if not solids:
        return None
    united = without_voids(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    steps = [f"put together from {count} pieces"] if count > 1 else []
    steps += [f"lids on {closed_count}"] if closed_count else []
    steps += [f"{1000 * sheet_thickness_m:.2g} mm for {len(sheet_faces)} lone faces"] if len(sheet_faces) else []
    sheet_share = sum(float(face_normals(points, face_rows)[1].sum()) for face_rows in sheets) / float(
        face_normals(points, faces)[1].sum()
    )
    return AssembledSolid(united, tuple(steps), sheet_share) if united.volume() > 0 else None


def covers_surface(solid: Solid, points: Floats, faces: Ints, grid: Grid | None) -> bool:
    """True if the surface lies on or in a solid, and the solid covers the voxels that the surface encloses."""
    surface = reference_surface(*surface_of(solid))
    samples = surface_samples(points, faces, SAMPLES)
    if float((distances_outside(samples, surface) > FAR_RATIO * surface.longest).mean()) > MAX_FAR_SHARE:
        return False
    inner = np.zeros((0, 3)) if grid is None else np.argwhere(grid.solid & ~grid.skin)
    if grid is None or len(inner) < FEW_VOXELS:
        return True
    enclosed_points = grid.origin + inner[:: max(1, len(inner) // SAMPLES)] * grid.cell
    return float((distances_outside(enclosed_points, surface) < grid.cell).mean()) >= MIN_ENFILLED_LID_SHARE


def _closed(points: Floats, faces: Ints, grid: Grid, longest: float) -> tuple[Solid, bool] | None:
    """A component as a solid, and whether it got lids; None if it is a sheet, or a lid is not accepted."""
    solid = _solid_either_way(points, faces, longest)
    if solid is not None:
        return solid, False
    single_sided = consistent_winding(_unique_faces(faces))[0]
    filled = fill_holes(points, single_sided, np.inf, most_torn=1.0)
    if filled is None:
        return None
    solid = _solid_either_way(*filled, longest)
    return (
        (solid, True)
        if solid is not None and _is_filled(filled[0], _new_faces(filled[1], single_sided), grid)
        else None
    )


def _solid_either_way(points: Floats, faces: Ints, longest: float) -> Solid | None:
    """A closed surface as a solid, whichever way its faces are wound; None if it is open or has no thickness."""
    for wound in (faces, faces[:, ::-1]):
        solid = solid_of(points, wound)
        if solid is not None and not _is_flat(solid, longest):
            return solid
    return None


def _is_flat(solid: Solid, longest: float) -> bool:
    return 2 * float(solid.volume()) < FLAT_WALL_RATIO * longest * float(solid.surface_area())


def _new_faces(faces: Ints, old: Ints) -> Ints:
    """Faces that are not among the old ones."""
    base = int(max(faces.max(), old.max())) + 1
    keys = [(np.sort(f, axis=1) * np.array([base * base, base, 1])).sum(axis=1) for f in (faces, old)]
    return faces[~np.isin(*keys)]


def _is_filled(points: Floats, lids: Ints, grid: Grid) -> bool:
    """True if the grid is filled where the lids are."""
    if not len(lids):
        return True
    samples = surface_samples(points, lids, SAMPLES)
    at = np.clip(np.round((samples - grid.origin) / grid.cell).astype(int), 0, np.array(grid.solid.shape) - 1)
    return float(grid.solid[tuple(at.T)].mean()) >= FILLED_LID_SHARE


def _unique_faces(faces: Ints) -> Ints:
    """Faces over the same three points once."""
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return faces[np.sort(first)]


def _plates(points: Floats, faces: Ints, thickness_m: float) -> list[Solid]:
    """Each face as a plate of a thickness, with the face in its middle."""
    normals, areas = face_normals(points, faces)
    plates = []
    for corners, normal, area in zip(points[faces], normals, areas, strict=True):
        if area > 0:
            corners_of_plate = np.concatenate([corners + normal * thickness_m / 2, corners - normal * thickness_m / 2])
            hull = manifold3d.Manifold.hull_points(corners_of_plate)
            if not hull.is_empty() and hull.volume() > 0:
                plates.append(hull)
    return plates
