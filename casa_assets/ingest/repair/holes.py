"""Close small holes of torn meshes by a fan of faces that takes its look from the rim."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.asset.mesh import Mesh

# A hole is small where the box around it is no larger than this part of the whole, and it has no more edges than these.
WIDEST = 0.03
MOST_EDGES = 24
# One of so many edges that are about equally far from its middle was drilled on purpose.
DRILLED_EDGES = 6
DRILLED_ROUND = 0.1
# What was cut out just before was surface, and may be so many times wider.
CUT_WIDER = 3
# It is closed however bent its rim is, where that has no more edges than these.
FEW_EDGES = 8
# Of the width of a hole, what two places may differ by and be the same.
SAME_PLACE_SHARE = 1e-3
# Least cosine between a face of the fan and their mean: a fan that folds is no surface.
LEAST_LEVEL = 0.2


def close_holes(draft: Draft, cut: Floats | None = None) -> Draft:
    """Close the small holes of the parts, with a note where there were some.

    A fan takes texture coordinates, normals and colours from the vertices at the rim. Larger openings stay, and round
    ones, which are meant.

    Args:
        cut: (N, 3) corners of faces that were cut out just before: a hole whose rim lies there is torn, round or not.
    """
    points, place = draft.surface.points, draft.surface.point_of_vertex
    widest = WIDEST * float(np.ptp(points, axis=0).max())
    ours = None if cut is None or not len(cut) else cKDTree(cut)
    torn = [
        rim for rim in boundary_loops(draft.surface.faces, place) if _is_torn(points[place[rim[:, 0]]], widest, ours)
    ]
    if not torn:
        return draft
    out = list(draft.parts)
    starts = np.cumsum([0] + [len(p.mesh.vertices) for p in out])
    for rim in torn:
        middle = points[place[rim[:, 0]]].mean(axis=0)
        owner = np.searchsorted(starts, rim[:, 0], side="right") - 1
        for i in np.unique(owner):
            part = out[int(i)]
            mesh = _with_fan(part.mesh, rim[owner == i] - starts[i], middle)
            out[int(i)] = part.replace(mesh=mesh)
    message = f"{len(torn)} small holes of {sum(len(rim) for rim in torn)} edges were closed"
    return draft.replace(parts=tuple(out), notes=draft.noted(warning("MSH041", "holes", message)))


def boundary_loops(faces: Ints, place: Ints) -> list[Ints]:
    """Boundary loops of a surface, against the direction of its faces; loops that branch are left out.

    Args:
        faces: (F, 3) vertices. place: (V,) welded point of each vertex.
    Returns:
        For each way (K, 2) vertices, start and end of each edge.
    """
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ends, count = place[directed], int(place.max()) + 1
    forth, back = ends[:, 0] * count + ends[:, 1], ends[:, 1] * count + ends[:, 0]
    bare = directed[~np.isin(back, forth)][:, ::-1]
    bare = bare[np.lexsort((place[bare[:, 1]], place[bare[:, 0]]))]
    starts = place[bare[:, 0]].tolist()
    row: dict[int, int] = {}
    branching: set[int] = set()
    for i, start in enumerate(starts):
        if start in row:
            branching.add(start)
        row[start] = i
    found, done = [], np.zeros(len(bare), dtype=bool)
    for first in range(len(bare)):
        way: list[int] = []
        at = first
        while not done[at]:
            done[at] = True
            way.append(at)
            end = int(place[bare[at, 1]])
            if end in branching or end not in row:
                break
            at = row[end]
        is_whole = bool(way) and at == first and place[bare[way[-1], 1]] == starts[first] and len(way) >= 3
        if is_whole and starts[first] not in branching:
            found.append(bare[way])
    return found


def _is_torn(rim: Floats, widest: float, cut: cKDTree | None) -> bool:
    """A small hole that nobody made: not round, or cut out by ourselves, and flat enough for a fan."""
    is_ours = cut is not None and float(cut.query(rim)[0].max()) <= SAME_PLACE_SHARE * widest
    if len(rim) > MOST_EDGES or float(np.ptp(rim, axis=0).max()) > (CUT_WIDER if is_ours else 1) * widest:
        return False
    middle = rim.mean(axis=0)
    off = np.linalg.norm(rim - middle, axis=1)
    if is_ours and len(rim) <= FEW_EDGES:
        return True
    if not is_ours and len(rim) >= DRILLED_EDGES and off.std() < DRILLED_ROUND * off.mean():
        return False
    count = len(rim)
    fan = np.stack([np.arange(count), (np.arange(count) + 1) % count, np.full(count, count)], axis=1)
    normals, areas = face_normals(np.vstack([rim, middle]), fan)
    mean = (areas[:, None] * normals).sum(axis=0)
    length = float(np.linalg.norm(mean))
    return length > 0 and bool((normals @ (mean / length) > LEAST_LEVEL).all())


def _with_fan(mesh: Mesh, edges: Ints, middle: Floats) -> Mesh:
    """The mesh with a face from each of the (K, 2) edges to a new vertex in the middle."""
    rim = edges.ravel()
    at = len(mesh.vertices)
    normals = None
    if mesh.normals is not None:
        mean = mesh.normals[rim].mean(axis=0)
        length = float(np.linalg.norm(mean))
        normals = np.vstack([mesh.normals, mean / length if length > 1e-6 else mesh.normals[rim[0]]])
    colors = None
    if mesh.colors is not None:
        colors = np.vstack([mesh.colors, np.rint(mesh.colors[rim].mean(axis=0)).astype(np.uint8)])
    return Mesh(
        vertices=np.vstack([mesh.vertices, middle]),
        faces=np.vstack([mesh.faces, np.column_stack([edges, np.full(len(edges), at)])]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[rim].mean(axis=0)]),
        normals=normals,
        colors=colors,
    )
