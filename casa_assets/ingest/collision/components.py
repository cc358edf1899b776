"""Convex pieces of a mesh: of its connected components, and of what convex decomposition finds."""

from __future__ import annotations

import io
import json
import os
import resource
import subprocess
import sys
from dataclasses import asdict, dataclass

import manifold3d
import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.core.system import lower_limit
from casa_assets.errors import DegenerateShape
from casa_assets.ingest.components import split_components
from casa_assets.mesh.solid.deviation import distances_outside, reference_surface, surface_samples
from casa_assets.mesh.solid.solids import Solid, closed_solid, convex_hull, solid_of, surface_of, without_voids
from casa_assets.mesh.surface import face_normals, signed_volume
from casa_assets.mesh.topology import consistent_winding, face_components, fill_holes
from casa_assets.mesh.voxels import Grid, voxelise

# Thickness that a flat part is given, metres: about the thinnest that contacts hold.
SHEET_M = 0.001


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


# Component solids -----------------------------------------------------------------------------------------------------

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
FAR_RATIO = 0.012


@dataclass(frozen=True)
class AssembledSolid:
    """Solid that a surface was made into, by which steps, and the share of its area in sheets, without volume."""

    solid: Solid
    steps: tuple[str, ...]
    sheet_share: float = 0.0


def assemble_solid(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """Build the solid of a surface, wound any way, from its components; None if too many, or without a volume.

    `grid`: voxels of the surface; a lid is put on an opening only where it is filled.
    """
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
    lids = _new_faces(filled[1], single_sided)
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


def _new_faces(faces: Ints, old: Ints) -> Ints:
    """Faces whose three points, in any order, are not those of an old face."""
    base = int(max(faces.max(), old.max())) + 1
    keys = [(np.sort(f, axis=1) * np.array([base * base, base, 1])).sum(axis=1) for f in (faces, old)]
    return faces[~np.isin(*keys)]


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


@dataclass(frozen=True)
class Budget:
    """Limits of a decomposition.

    Attributes:
        hulls: most hulls. hull_vertices: most vertices of each.
        voxels: cubes that V-HACD works on.
        threshold: CoACD's concavity threshold, 0..1 of the longest side.
        cpu_s: CPU seconds (not wall: a busy machine must not change the outcome). memory_bytes: address space.
    """

    hulls: int
    hull_vertices: int = 64
    threshold: float = 0.05
    voxels: int = 400_000
    cpu_s: int = 20
    memory_bytes: int = 6_000_000_000


class DecompositionFailed(Exception):
    """The child died or ran out of its budget; says how."""


def decompose(method: str, vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    """Vertices of each hull, metres, by `coacd` (needs a closed manifold) or `vhacd` (takes any triangles).

    Raises DecompositionFailed: exit code or signal of the child, and its last words.
    """
    if not len(faces) or not np.isfinite(vertices).all() or not np.ptp(vertices, axis=0).max() > 0:
        raise DecompositionFailed(f"{method} was not tried: the mesh has no extent, or coordinates that are no numbers")
    lowest, extent = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    stream = io.BytesIO()
    np.savez(stream, vertices=(vertices - lowest) / extent, faces=faces, budget=np.array(json.dumps(asdict(budget))))
    command = [sys.executable, "-m", "casa_assets.ingest.collision.components", method]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
    # No limit by the clock: a busy machine would change the outcome. The worker pool ends what hangs.
    process = subprocess.run(command, input=stream.getvalue(), capture_output=True, env=environment, check=False)
    if process.returncode != 0:
        last_line = process.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or ["no words"]
        raise DecompositionFailed(f"{method} ended with {process.returncode}: {last_line[0][:200]}")
    with np.load(io.BytesIO(process.stdout)) as hulls:
        clouds = [hulls[f"arr_{i}"] * extent + lowest for i in range(len(hulls.files))]
    return [cloud for cloud in clouds if np.isfinite(cloud).all()]


def _coacd(vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    import coacd

    coacd.set_log_level("off")
    # Its search is kept short: with the defaults a dish rack of wires takes minutes, and is not kept open then either.
    parts = coacd.run_coacd(
        coacd.Mesh(vertices, faces.astype(np.int32)),
        threshold=min(max(budget.threshold, 0.01), 0.5),
        max_convex_hull=budget.hulls,
        preprocess_mode="off",
        mcts_nodes=10,
        mcts_iterations=20,
        mcts_max_depth=2,
        decimate=True,
        max_ch_vertex=budget.hull_vertices,
        seed=0,
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


def _vhacd(vertices: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    import vhacdx

    parts = vhacdx.compute_vhacd(
        vertices,
        faces.astype(np.uint32),
        maxConvexHulls=budget.hulls,
        resolution=budget.voxels,
        maxNumVerticesPerCH=budget.hull_vertices,
        minimumVolumePercentErrorAllowed=1.0,
        asyncACD=False,
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


def main() -> int:
    """The child: limits itself, reads, decomposes, writes."""
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as data:
        vertices, faces = data["vertices"], data["faces"]
        budget = Budget(**json.loads(str(data["budget"])))
    lower_limit(resource.RLIMIT_CPU, budget.cpu_s, budget.cpu_s + 5)
    lower_limit(resource.RLIMIT_AS, budget.memory_bytes, budget.memory_bytes)
    # The libraries print to standard output, so that is sent to standard error and the pipe is kept for the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    hulls = {"coacd": _coacd, "vhacd": _vhacd}[sys.argv[1]](vertices, faces, budget)
    packed = io.BytesIO()
    np.savez(packed, *hulls)
    with os.fdopen(answer, "wb") as out:
        out.write(packed.getvalue())
    return 0


if __name__ == "__main__":
    sys.exit(main())
