"""How well convex shapes stand in for a mesh: overlap, distances both ways, and the room that an opening keeps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.spatial import ConvexHull, cKDTree

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import closed_solid, convex_hull, hull_volume, union
from casa_assets.mesh.voxels import Grid, OpenRooms, closed_shares, fillable_volume, open_rooms, voxelise

# Distances ------------------------------------------------------------------------------------------------------------

Surface = tuple[Floats, Ints]

# Points that a surface is found again by; of each query the triangles of this many nearest ones are measured exactly.
INDEX_POINTS = 60_000
NEAREST = 24


@dataclass(frozen=True)
class Ruler:
    """A surface that distances are taken to: (F, 3, 3) corners, points on it, and the face that each lies on."""

    corners: Floats
    tree: cKDTree
    face: Ints


def ruler(surface: Surface, seed: int = 0) -> Ruler:
    """Prepare a surface, (P, 3) points and (F, 3) faces, for distances to it."""
    points, faces = surface
    corners = points[faces]
    samples, face = sample(surface, INDEX_POINTS, seed)
    middles = corners.mean(axis=1)  # so that no small face is missed
    return Ruler(corners, cKDTree(np.concatenate([samples, middles])), np.concatenate([face, np.arange(len(faces))]))


def sample(surface: Surface, count: int, seed: int = 0) -> tuple[Floats, Ints]:
    """(count, 3) points spread over the area, and the face of each."""
    points, faces = surface
    corners = points[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(seed)
    face = rng.choice(len(faces), size=count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (corners[face, k] for k in range(3))
    return a + u[:, None] * (b - a) + v[:, None] * (c - a), face.astype(np.int64)


def distances(queries: Floats, to: Ruler) -> Floats:
    """(N,) distance of each query to the surface."""
    _, near = to.tree.query(queries, k=min(NEAREST, to.tree.n))
    faces = to.face[near]
    out = np.full(len(queries), np.inf)
    for k in range(faces.shape[1]):
        out = np.minimum(out, _to_triangle(queries, to.corners[faces[:, k]]))
    return out


def inside(queries: Floats, clouds: list[Floats]) -> npt.NDArray[np.bool_]:
    """(N,) whether each query lies in one of the convex shapes."""
    within = np.zeros(len(queries), dtype=bool)
    for cloud in clouds:
        planes = ConvexHull(cloud).equations
        rest = np.flatnonzero(~within)
        for start in range(0, len(rest), 4096):
            rows = rest[start : start + 4096]
            within[rows] = (queries[rows] @ planes[:, :3].T + planes[:, 3] <= 1e-9).all(axis=1)
    return within


def touchable(surface: Surface, clouds: list[Floats], slit: float, count: int) -> Floats:
    """(N, 3) points of the surface of a union, without the walls of slits between shapes that all but touch.

    Args:
        slit: widest gap that nothing can enter, metres. count: points drawn; N is at most that.
    """
    points, face = sample(surface, count)
    corners = surface[0][surface[1]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    free: Floats = points[~inside(points + slit * normals[face], clouds)]
    return free


def _to_triangle(p: Floats, corners: Floats) -> Floats:
    """(N,) exact distance of each point to its own triangle: to the face where it lies above it, else to an edge."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.einsum("ij,ij->i", normal, normal)
    safe = np.maximum(size, 1e-300)
    v = np.einsum("ij,ij->i", np.cross(p - a, c - a), normal) / safe
    w = np.einsum("ij,ij->i", np.cross(b - a, p - a), normal) / safe
    above = (v >= 0) & (w >= 0) & (v + w <= 1) & (size > 1e-300)
    height = np.abs(np.einsum("ij,ij->i", p - a, normal)) / np.sqrt(safe)
    edge = np.minimum(np.minimum(_to_edge(p, a, b), _to_edge(p, b, c)), _to_edge(p, c, a))
    return np.where(above, height, edge)


def _to_edge(p: Floats, a: Floats, b: Floats) -> Floats:
    along = b - a
    t = np.einsum("ij,ij->i", p - a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    far: Floats = np.linalg.norm(p - a - np.clip(t, 0, 1)[:, None] * along, axis=1)
    return far


# Fit ------------------------------------------------------------------------------------------------------------------

Cubes = npt.NDArray[np.bool_]

SAMPLES = 20_000
SLIT_M = 0.001  # narrower gaps between shapes are not an outer surface
CELLS = 96  # cubes along the longest side, for what holds water
# The same for what can be touched from outside: a gap narrower than the promised 1.5 % of the longest side is closed.
SEEN_CELLS = 66
# A mesh that holds less water than this share of its hull is no container.
CONTAINER = 0.05
MARGIN = 0.05  # shapes may stick out of the mesh by this share of its longest side and still be on its grid


@dataclass(frozen=True)
class Truth:
    """A mesh, measured once for all tools.

    Attributes:
        mesh: welded, metres, z up. seen: (N, 3) points of its outer surface, walls of open cavities among them.
        solid: where it is closed. fillable_volume: cubes that hold water, None where it is no container.
        grid, box: the cubes, and the (2, 3) corners that they were laid between.
        rooms: open rooms. kept_rooms: indices without those of something full that only backs of faces look into.
    """

    mesh: Surface
    ruler: Ruler
    seen: Floats
    solid: Surface | None
    fillable_volume: Cubes | None
    grid: Grid
    box: Floats
    longest: float
    rooms: OpenRooms
    kept_rooms: tuple[int, ...]


@dataclass(frozen=True)
class Fit:
    """Shapes against the mesh that they stand in for; lengths in mm, None where it cannot be said.

    Attributes:
        volume_ratio, iou: union of the shapes against the closed mesh.
        bare_p95_mm, bare_max_mm: distance of the outer surface of the mesh to that of the shapes.
        phantom_p95_mm, phantom_max_mm: distance of the outer surface of the shapes to the mesh.
        kept: share of the room that would hold water where no shape is. held: share that the shapes hold water in.
        closed: largest share of an open room that the shapes fill or close off.
    """

    volume_ratio: float | None
    iou: float | None
    bare_p95_mm: float
    bare_max_mm: float
    phantom_p95_mm: float
    phantom_max_mm: float
    kept: float | None
    held: float | None
    closed: float | None


def truth(mesh: Surface, full: bool) -> Truth:
    """Measure a mesh.

    Args:
        mesh: (P, 3) welded points and (F, 3) faces, z up, metres.
        full: matter all through, so that an open bottom is no opening.
    """
    points, faces = mesh
    low, high = points.min(axis=0), points.max(axis=0)
    room = MARGIN * float((high - low).max())
    box = np.array([low - room, high + room])
    grid = _grid(points, faces, box, full)
    samples, _ = sample(mesh, SAMPLES)
    outer = voxelise(points, faces, SEEN_CELLS, bridge=full)
    held = None if full else fillable_volume(grid.solid)
    holds = held is not None and float(held.sum()) * grid.cell**3 >= CONTAINER * hull_volume(points)
    rooms = open_rooms(points, faces)
    return Truth(
        mesh,
        ruler(mesh),
        _seen(samples, outer),
        closed_solid(points, faces),
        held if holds else None,
        grid,
        box,
        float(np.ptp(points, axis=0).max()),
        rooms,
        rooms.kept(with_gaps=not full),
    )


def fit(clouds: Sequence[Floats], of: Truth) -> Fit | None:
    """Shapes against a mesh; None where the shapes have no volume.

    Args:
        clouds: vertices of each convex shape, frame of the mesh.
    """
    whole = union([convex_hull(cloud) for cloud in clouds])
    if whole is None:
        return None
    shape_grid = voxelise(*whole, SEEN_CELLS)
    skin = _seen(touchable(whole, list(clouds), SLIT_M, SAMPLES), shape_grid)
    bare = 1000 * distances(of.seen, ruler(whole))
    phantom = 1000 * distances(skin, of.ruler)
    ratio, iou = _overlap(whole, of.solid) if of.solid is not None else (None, None)
    kept, held = _room(list(clouds), whole, of, of.fillable_volume) if of.fillable_volume is not None else (None, None)
    closed = closed_shares(of.rooms, *whole) if of.kept_rooms else []
    return Fit(
        ratio,
        iou,
        float(np.percentile(bare, 95)),
        float(bare.max()),
        float(np.percentile(phantom, 95)),
        float(phantom.max()),
        kept,
        held,
        max(closed[k] for k in of.kept_rooms) if of.kept_rooms else None,
    )


def _seen(points: Floats, grid: Grid) -> Floats:
    """The points that the air around the grid comes near; what is sealed in does not count."""
    outside = ndimage.binary_dilation(~grid.solid, np.ones((3, 3, 3), dtype=bool))
    at = np.clip(np.round((points - grid.origin) / grid.cell).astype(int), 0, np.array(outside.shape) - 1)
    found: Floats = points[outside[at[:, 0], at[:, 1], at[:, 2]]]
    return found if len(found) else points


def _room(clouds: list[Floats], whole: Surface, of: Truth, room: Cubes) -> tuple[float, float]:
    kept = 1 - float(inside(of.grid.origin + np.argwhere(room) * of.grid.cell, clouds).mean())
    held = float((fillable_volume(_grid(*whole, of.box, full=False).solid) & room).sum() / room.sum())
    return kept, held


def _grid(points: Floats, faces: npt.NDArray[np.int64], box: Floats, full: bool) -> Grid:
    """Cubes over a box, (2, 3) corners, whatever part of it the surface takes up."""
    ends = np.concatenate([np.clip(points, *box), box])
    return voxelise(ends, faces, CELLS, bridge=full)


def _overlap(whole: Surface, solid: Surface) -> tuple[float, float]:
    """Volume of the shapes over that of the mesh, and intersection over union."""
    a, b = (_manifold(s) for s in (whole, solid))
    both = (a ^ b).volume()
    return a.volume() / b.volume(), both / (a.volume() + b.volume() - both)


def _manifold(surface: Surface) -> manifold3d.Manifold:
    points, faces = surface
    mesh = manifold3d.Mesh64(vert_properties=points, tri_verts=np.ascontiguousarray(faces, dtype=np.uint64))
    return manifold3d.Manifold(mesh)
