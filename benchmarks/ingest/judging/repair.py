"""How sound a surface is, by arithmetic that no repair uses; and what trimesh makes of one."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.mesh.solid.deviation import measure_visibility
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import edge_counts, face_components, weld

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Surface = tuple[Floats, Ints]

# What floats: a piece this small beside the largest one, and this far from everything else, as parts of the largest.
SPECK, APART = 0.05, 0.03
# Points for saying which side of a surface is seen.
STREWN = 20_000


@dataclass(frozen=True)
class Soundness:
    """Numbers of one surface.

    Attributes:
        faces: their number. closed: every edge has two faces, once each way. open_edges, fins: edges with one face, and
            with more than two. broken: faces without area, or named twice the same way round.
        agree: share of the edges of two faces that run both ways. front: share of what shows only one of its sides that
            shows its front.
        pieces, floating: connected pieces, and small ones that touch nothing. longest: side of the box around it.
    """

    faces: int
    closed: bool
    open_edges: int
    fins: int
    broken: int
    agree: float
    front: float
    pieces: int
    floating: int
    longest: float


def soundness(surface: Surface) -> Soundness:
    """Measure a surface; vertices at one place are one point."""
    vertices, faces = surface
    points, place = weld(vertices)
    ids = place[faces]
    _, areas = face_normals(points, ids)
    longest = float(np.ptp(vertices[faces].reshape(-1, 3), axis=0).max())
    whole = areas > (1e-7 * longest) ** 2
    turn = (np.argmin(ids, axis=1)[:, None] + np.arange(3)) % 3
    doubled = len(ids) - len(np.unique(np.take_along_axis(ids, turn, axis=1), axis=0))
    ids = ids[whole]
    _, uses, balance = edge_counts(ids)
    two = uses == 2
    label = face_components(ids, len(points))
    found = measure_visibility(points, ids, STREWN)
    shown = found.front ^ found.back
    return Soundness(
        faces=len(faces),
        closed=bool(two.all() and (balance == 0).all()),
        open_edges=int((uses == 1).sum()),
        fins=int((uses > 2).sum()),
        broken=int((~whole).sum()) + doubled,
        agree=float((balance[two] == 0).mean()) if two.any() else 1.0,
        front=float((found.front & ~found.back).sum() / shown.sum()) if shown.any() else 1.0,
        pieces=int(label.max()) + 1,
        floating=_floating(points, ids, label),
        longest=longest,
    )


def _floating(points: Floats, ids: Ints, label: Ints) -> int:
    """Small pieces of which no corner comes near the corners, edges or faces of another piece."""
    count = int(label.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, points[ids].min(axis=1))
    np.maximum.at(high, label, points[ids].max(axis=1))
    size = (high - low).max(axis=1)
    if count == 1 or count > 3000:
        return 0
    floating = 0
    mids = points[ids].mean(axis=1)
    for piece in np.flatnonzero(size < SPECK * size.max()):
        others = label != piece
        cloud = np.concatenate([points[np.unique(ids[others])], mids[others]])
        gap = float(cKDTree(cloud).query(points[np.unique(ids[~others])])[0].min())
        floating += gap > max(APART * float(size.max()), 3 * float(size[piece]))
    return floating


def trimesh_repaired(surface: Surface) -> tuple[Surface, float]:
    """What trimesh's own cleaning and repair make of a surface, and the CPU seconds it took."""
    import trimesh

    vertices, faces = surface
    before = time.process_time()
    mesh = trimesh.Trimesh(vertices=vertices.copy(), faces=faces.copy(), process=True)
    mesh.update_faces(mesh.unique_faces() & mesh.nondegenerate_faces())
    mesh.remove_unreferenced_vertices()
    trimesh.repair.fix_normals(mesh, multibody=True)
    trimesh.repair.fill_holes(mesh)
    seconds = time.process_time() - before
    return (np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)), seconds
