"""A closed solid for a torn surface: put together from its pieces, else the zero level of its signed distance field."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import manifold3d
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.errors import DegenerateShape
from casa_assets.ingest.components import (
    MAX_WALLED_FILL,
    MIN_SEALED_GROWTH,
    THIN_WALL_RATIO,
    SurfaceKind,
    split_components,
)
from casa_assets.mesh.solid.deviation import distances_outside, reference_surface, samples_with_faces, surface_samples
from casa_assets.mesh.solid.solids import (
    Solid,
    closed_solid,
    convex_hull,
    simplify_solid,
    solid_of,
    split_by_plane,
    surface_of,
    volume_of_hull,
    without_voids,
)
from casa_assets.mesh.surface import consistent_winding, face_components, face_normals, fill_holes, signed_volume
from casa_assets.mesh.voxels import Grid, voxelise

# Thickness that a flat part is given, metres: about the thinnest that contacts hold.
SHEET_M = 0.001
# All numbers below are choices.
# With more components than this assemble_solid gives up, and its caller makes the solid on a grid.
MAX_COMPONENTS = 200
# With more faces in sheets than this assemble_solid gives up as well.
MAX_SHEET_FACES = 600
# Thickness that a sheet is given where that is larger, as a share of the longest side.
SHEET_RATIO = 0.008
# A lid is accepted if the grid is filled at this share of its samples.
FILLED_LID_SHARE = 0.9
# A solid is a sheet with two faces if its mean wall thickness, 2 V / A (V its volume, A the area of its surface), is
# less than this share of the longest side.
FLAT_WALL_RATIO = 1e-3
# Smallest share of the voxels enclosed by the surface that the solid has to cover.
MIN_ENCLOSED_SHARE = 0.8
# With fewer enclosed voxels than this they are not compared.
FEW_VOXELS = 50
# Samples on a surface.
SAMPLES = 2000
# Largest share of the samples that may lie far from the solid.
MAX_FAR_SHARE = 0.01
# A sample lies far from the solid if its distance is more than this share of the longest side.
FAR_RATIO, MAX_SAMPLES = 0.012, 300_000
# Cubes on either side of the surface in which distances are taken.
BAND_CELLS = 2
# How many cubes off the surface one looks whether there is matter: the skin of the grid ends before that.
PROBE_CELLS = 1.8
# Half the wall that a lone sheet gets, in cubes: the thinnest that the grid carries.
SHEET_HALF_CELLS = 0.6
# No vertex comes nearer to a corner of the grid than this share of an edge: slivers have no side.
MIN_EDGE_SHARE = 0.05
# Voxels along the longest side of the grid on which a broken surface is made solid; a choice, as all numbers here.
CELLS = 72
# A hole wider than this share of the longest side is an opening and is not filled.
SMALL_HOLE = 0.05
# The grid is compared with something solid only if the thinnest side of its bounding box has this many voxels.
TELLING_CELLS = 12
# A solid made on the grid is simplified within this share of a voxel, which leaves about a tenth of its faces.
SMOOTH_CELLS = 0.3
# A solid made on the grid reaches beyond the bounding box of the surface and is cut to it, if this share is left.
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

# The corners of each tetrahedron of a cube: ways from one corner to the opposite one, an axis at a time.
STEPS = np.eye(3, dtype=np.int64)
PATHS = [np.cumsum([STEPS[0] * 0, *STEPS[list(order)]], axis=0) for order in permutations(range(3))]


@dataclass(frozen=True)
class ConnectedPart:
    """A connected part: its points and faces, the volume of its hull, how much of that it fills (0..1)."""

    points: Floats
    faces: Ints
    hull_volume: float
    hull_fill: float


def connected_parts(points: Floats, ids: Ints, max_parts: int) -> list[ConnectedPart]:
    """Connected parts that have a volume, largest first, without specks; none if more than `max_parts` are left."""
    components = split_components(points, ids, np.arange(len(points)))
    large = np.flatnonzero(components.longest_side > 0.02 * float(np.ptp(points, axis=0).max()))
    if components.count > 40 * max_parts or len(large) > max_parts:
        return []
    parts = [measure_part(*components.surface_of(int(k)), close_gaps=False) for k in large]
    return sorted((part for part in parts if part is not None), key=lambda p: -p.hull_volume)


def measure_part(points: Floats, faces: Ints, close_gaps: bool) -> ConnectedPart | None:
    """Measure a part; a flat one is given a thickness. Return None if it has no extent."""
    is_flat = thickness(points) < SHEET_M / 4
    if is_flat:
        normals, areas = face_normals(points, faces)
        if areas.sum() <= 0:
            return None
        off_center = points - points.mean(axis=0)
        normal = np.linalg.svd(off_center, full_matrices=False)[2][-1] if len(points) > 2 else normals[0]
        points = np.concatenate([points + normal * SHEET_M / 2, points - normal * SHEET_M / 2])
    try:
        hull, triangles = convex_hull(points)
    except DegenerateShape:
        return None
    hull_volume = signed_volume(hull, triangles)
    if is_flat:
        return ConnectedPart(hull, triangles, hull_volume, 1.0)
    solid = closed_solid(points, faces)
    if solid is not None and not (close_gaps and len(np.unique(face_components(faces, len(points)))) > 1):
        volume = signed_volume(*solid)
    else:
        volume = voxelise(points, faces, bridge=close_gaps).volume
    return ConnectedPart(points, faces, hull_volume, min(1.0, volume / hull_volume))


def thickness(points: Floats) -> float:
    """Extent along the direction of least spread, metres."""
    if len(points) < 4:
        return 0.0
    _, vectors = np.linalg.eigh(np.cov(points.T))
    return float(np.ptp(points @ vectors[:, 0]))


def any_nested(pieces: list[ConnectedPart]) -> bool:
    """A piece lies within the box of a hollow one: the two walls of a double shell, say, which belong together."""
    boxes = [(p.points.min(axis=0), p.points.max(axis=0), p.hull_fill) for p in pieces]
    return any(
        fill < 0.5 and i != j and bool((low <= inner[0]).all() and (inner[1] <= high).all())
        for i, (low, high, fill) in enumerate(boxes)
        for j, inner in enumerate(boxes)
    )


@dataclass(frozen=True)
class AssembledSolid:
    """Solid that a surface was made into, by which steps, and the share of its area in sheets, without volume."""

    solid: Solid
    steps: tuple[str, ...]
    sheet_share: float = 0.0


def assemble_solid(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """The solid of a surface from its components, lids where the grid is filled; None if too many, or no volume."""
    longest = float(np.ptp(points, axis=0).max())
    components = split_components(points, faces, np.arange(len(points)))
    if components.count > MAX_COMPONENTS:
        return None
    solids: list[Solid] = []
    sheets: list[Ints] = []
    lidded_count = 0
    for k in range(components.count):
        found = _component_solid(*components.surface_of(k), grid, longest)
        if found is None:
            sheets.append(components.faces_of(k))
        else:
            solids.append(found[0])
            lidded_count += found[1]
    sheet_faces = _unique_faces(np.concatenate(sheets)) if sheets else np.zeros((0, 3), dtype=np.int64)
    if len(sheet_faces) > MAX_SHEET_FACES:
        return None
    sheet_thickness_m = max(SHEET_M, SHEET_RATIO * longest)
    solids += _plates(points, sheet_faces, sheet_thickness_m)
    if not solids:
        return None
    united = without_voids(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    steps = [f"put together from {components.count} pieces"] if components.count > 1 else []
    steps += [f"lids on {lidded_count}"] if lidded_count else []
    steps += [f"{1000 * sheet_thickness_m:.2g} mm for {len(sheet_faces)} lone faces"] if len(sheet_faces) else []
    sheet_area = sum(float(face_normals(points, face_rows)[1].sum()) for face_rows in sheets)
    sheet_share = sheet_area / float(face_normals(points, faces)[1].sum())
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
    return float((distances_outside(enclosed_points, surface) < grid.cell).mean()) >= MIN_ENCLOSED_SHARE


def _component_solid(points: Floats, faces: Ints, grid: Grid, longest: float) -> tuple[Solid, bool] | None:
    """A component as a solid, and whether it got lids; None if it is a sheet, or a lid is not accepted."""
    solid = _solid_either_way(points, faces, longest)
    if solid is not None:
        return solid, False
    single_sided = consistent_winding(_unique_faces(faces))[0]
    # An opening of any width may get a lid, and any share of the edges may be open: the grid decides below.
    filled = fill_holes(points, single_sided, np.inf, most_torn=1.0)
    if filled is None:
        return None
    solid = _solid_either_way(*filled, longest)
    if solid is None:
        return None
    # Faces over three points that no face of the component has.
    base = int(max(filled[1].max(), single_sided.max())) + 1
    keys = [(np.sort(fs, axis=1) * np.array([base * base, base, 1])).sum(axis=1) for fs in (filled[1], single_sided)]
    lids = filled[1][~np.isin(*keys)]
    is_filled = grid.solid[grid.cubes_at(surface_samples(filled[0], lids, SAMPLES))] if len(lids) else np.ones(1)
    return (solid, True) if float(is_filled.mean()) >= FILLED_LID_SHARE else None


def _solid_either_way(points: Floats, faces: Ints, longest: float) -> Solid | None:
    """A closed surface as a solid, whichever way its faces are wound; None if it is open or has no thickness."""
    for wound in (faces, faces[:, ::-1]):
        solid = solid_of(points, wound)
        # 2 V / A, its mean wall thickness.
        if solid is not None and 2 * float(solid.volume()) >= FLAT_WALL_RATIO * longest * float(solid.surface_area()):
            return solid
    return None


def _unique_faces(faces: Ints) -> Ints:
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


def signed_distance_field(points: Floats, faces: Ints, grid: Grid) -> Floats:
    """(X, Y, Z) signed distances, metres, positive within matter, in the grid of a surface; coarse away from it."""
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


def isosurface(field: Floats, origin: Floats, cell: float) -> tuple[Floats, Ints]:
    """Triangulate the border of all that is positive: a manifold of outward faces, empty if nothing is positive.

    Ref: Kuhn's six tetrahedra of a cube; neighbouring cubes share their diagonals, so that no gap opens. `field`: (X,
    Y, Z) at the corners of a grid; its border has to be negative, or the surface is cut open there. `origin`: (3,) of
    the first corner. `cell`: distance between two, metres.
    """
    shape = np.array(field.shape)
    within = field > 0
    near, far = slice(None, -1), slice(1, None)
    eight = np.stack([within[tuple(far if o else near for o in offset)] for offset in np.ndindex(2, 2, 2)])
    cubes = np.argwhere(eight.any(axis=0) & ~eight.all(axis=0))
    if not len(cubes):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    stride = np.array([shape[1] * shape[2], shape[2], 1])
    tetrahedra = np.concatenate([(cubes[:, None] + path) @ stride for path in PATHS])
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
    # Faces look from their inner ends to their outer ones.
    a, b, c = (points[faces[:, k]] for k in range(3))
    away = np.stack(np.unravel_index(outer, field.shape), axis=-1).mean(axis=1)
    away = away - np.stack(np.unravel_index(inner, field.shape), axis=-1).mean(axis=1)
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), away) < 0
    return points, np.where(wrong[:, None], faces[:, ::-1], faces)


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


@dataclass(frozen=True)
class SolidProxy:
    """Solid that represents a surface.

    `solid`: closed, outward, metres, without sealed cavities. `kind`: of the surface. `message`: the measurements
    behind it and the steps that were taken, in words. `mean_wall_m`: twice the volume over the area.
    """

    solid: Solid
    kind: SurfaceKind
    message: str
    mean_wall_m: float


def solid_proxy(points: Floats, faces: Ints, is_full: bool) -> SolidProxy | None:
    """The solid that represents a surface, welded, metres, or None; `is_full`: openings and cavities are filled."""
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
    """The proxy with its kind; `raw`: the solid before sealed cavities were filled, None if the surface bounds none."""
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
