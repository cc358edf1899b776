"""How well convex shapes stand in for a mesh: overlap, distances both ways, and the room that an opening keeps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt
from scipy import ndimage

from benchmarks.ingest.judging import distance
from casa_assets.mesh.solid.solids import closed_solid, convex_hull, hull_volume, union
from casa_assets.mesh.voxels import Grid, OpenRooms, closed_shares, fillable_volume, open_rooms, voxelise

Floats = npt.NDArray[np.float64]
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

    mesh: distance.Surface
    ruler: distance.Ruler
    seen: Floats
    solid: distance.Surface | None
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


def truth(mesh: distance.Surface, full: bool) -> Truth:
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
    samples, _ = distance.sample(mesh, SAMPLES)
    outer = voxelise(points, faces, SEEN_CELLS, bridge=full)
    held = None if full else fillable_volume(grid.solid)
    holds = held is not None and float(held.sum()) * grid.cell**3 >= CONTAINER * hull_volume(points)
    rooms = open_rooms(points, faces)
    return Truth(
        mesh,
        distance.ruler(mesh),
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
    skin = _seen(distance.touchable(whole, list(clouds), SLIT_M, SAMPLES), shape_grid)
    bare = 1000 * distance.distances(of.seen, distance.ruler(whole))
    phantom = 1000 * distance.distances(skin, of.ruler)
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


def _room(clouds: list[Floats], whole: distance.Surface, of: Truth, room: Cubes) -> tuple[float, float]:
    kept = 1 - float(distance.inside(of.grid.origin + np.argwhere(room) * of.grid.cell, clouds).mean())
    held = float((fillable_volume(_grid(*whole, of.box, full=False).solid) & room).sum() / room.sum())
    return kept, held


def _grid(points: Floats, faces: npt.NDArray[np.int64], box: Floats, full: bool) -> Grid:
    """Cubes over a box, (2, 3) corners, whatever part of it the surface takes up."""
    ends = np.concatenate([np.clip(points, *box), box])
    return voxelise(ends, faces, CELLS, bridge=full)


def _overlap(whole: distance.Surface, solid: distance.Surface) -> tuple[float, float]:
    """Volume of the shapes over that of the mesh, and intersection over union."""
    a, b = (_manifold(s) for s in (whole, solid))
    both = (a ^ b).volume()
    return a.volume() / b.volume(), both / (a.volume() + b.volume() - both)


def _manifold(surface: distance.Surface) -> manifold3d.Manifold:
    points, faces = surface
    mesh = manifold3d.Mesh64(vert_properties=points, tri_verts=np.ascontiguousarray(faces, dtype=np.uint64))
    return manifold3d.Manifold(mesh)
