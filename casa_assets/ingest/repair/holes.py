"""Close small holes of torn meshes by a fan of faces whose attributes are those of the rim."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.asset.mesh import Mesh

# All numbers below are choices.
# Largest side of the box around a small hole, as a share of the longest side of the mesh, and most edges of its rim.
MAX_WIDTH = 0.03
MAX_EDGES = 24
# A rim of so many edges whose distances from its centre deviate by less than this share is round: drilled on purpose.
MIN_ROUND_EDGES = 6
ROUND_DEVIATION = 0.1
# A hole that was cut by a repair may be so many times wider, and with no more edges than these its rim may be bent.
CUT_WIDER = 3
FEW_EDGES = 8
# Distance, as a share of the largest width, below which a point of a rim is a corner that was cut out.
SAME_POINT_SHARE = 1e-3
# A side is missing where a rim lies in a plane, and all of the mesh behind it, to this share of the longest side.
SIDE_SHARE = 0.04
# Smallest cosine between a face of the fan and the mean normal: a fan must not fold.
MIN_FAN_COSINE = 0.2


def close_holes(draft: Draft, cut: Floats | None = None) -> Draft:
    """Close the small holes of the parts, with a note where there were some.

    Texture coordinates, normals and colours of the new vertex are means over the rim. Larger openings stay, and round
    ones, which are meant.

    Args:
        cut: (N, 3) corners of faces that were cut out just before: a hole whose rim lies there is closed, round or not.
    """
    points, place = draft.surface.points, draft.surface.point_of_vertex
    max_width = MAX_WIDTH * float(np.ptp(points, axis=0).max())
    cut_points = None if cut is None or not len(cut) else cKDTree(cut)
    rims = [
        rim
        for rim in boundary_loops(draft.surface.faces, place)
        if _is_torn(points[place[rim[:, 0]]], max_width, cut_points)
    ]
    if not rims:
        return draft
    message = f"{len(rims)} small holes of {sum(len(rim) for rim in rims)} edges were closed"
    return _closed(draft, rims).replace(notes=draft.noted(warning("MSH041", "holes", message)))


def close_missing_sides(draft: Draft) -> Draft:
    """Close flat sides that are missing altogether, such as the side that an object rested on when it was scanned.

    Only for objects that are full by their kind: a box without its lid may be meant to be open. A note is added if
    sides were closed; the new faces have the colours of the rim.
    """
    points, place = draft.surface.points, draft.surface.point_of_vertex
    rims = [
        rim for rim in boundary_loops(draft.surface.faces, place) if _is_missing_side(points[place[rim[:, 0]]], points)
    ]
    if not rims:
        return draft
    what = "a flat side that was missing was" if len(rims) == 1 else f"{len(rims)} flat sides that were missing were"
    message = f"{what} closed; a thing of this kind is full"
    return _closed(draft, rims).replace(notes=draft.noted(warning("MSH026", "sides", message)))


def _closed(draft: Draft, rims: list[Ints]) -> Draft:
    """The draft with a fan in each of the rims."""
    points, place = draft.surface.points, draft.surface.point_of_vertex
    parts = list(draft.parts)
    starts = np.cumsum([0] + [len(p.mesh.vertices) for p in parts])
    for rim in rims:
        middle = points[place[rim[:, 0]]].mean(axis=0)
        part_index = np.searchsorted(starts, rim[:, 0], side="right") - 1
        for i in np.unique(part_index):
            part = parts[int(i)]
            mesh = _with_fan(part.mesh, rim[part_index == i] - starts[i], middle)
            parts[int(i)] = part.replace(mesh=mesh)
    return draft.replace(parts=tuple(parts))


def boundary_loops(faces: Ints, place: Ints) -> list[Ints]:
    """Boundary loops of a surface, against the direction of its faces; loops that branch are left out.

    Args:
        faces: (F, 3) vertices. place: (V,) welded point of each vertex.
    Returns:
        For each loop (K, 2) vertices, start and end of each edge.
    """
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edge_points, count = place[edges], int(place.max()) + 1
    forward, backward = edge_points[:, 0] * count + edge_points[:, 1], edge_points[:, 1] * count + edge_points[:, 0]
    open_edges = edges[~np.isin(backward, forward)][:, ::-1]
    open_edges = open_edges[np.lexsort((place[open_edges[:, 1]], place[open_edges[:, 0]]))]
    starts = place[open_edges[:, 0]].tolist()
    edge_from: dict[int, int] = {}
    branching: set[int] = set()
    for i, start in enumerate(starts):
        if start in edge_from:
            branching.add(start)
        edge_from[start] = i
    loops, done = [], np.zeros(len(open_edges), dtype=bool)
    for start_edge in range(len(open_edges)):
        loop: list[int] = []
        edge = start_edge
        while not done[edge]:
            done[edge] = True
            loop.append(edge)
            end = int(place[open_edges[edge, 1]])
            if end in branching or end not in edge_from:
                break
            edge = edge_from[end]
        is_whole = (
            bool(loop)
            and edge == start_edge
            and place[open_edges[loop[-1], 1]] == starts[start_edge]
            and len(loop) >= 3
        )
        if is_whole and starts[start_edge] not in branching:
            loops.append(open_edges[loop])
    return loops


def _is_torn(rim: Floats, max_width: float, cut_points: cKDTree | None) -> bool:
    """True if a hole is a tear: small, not round unless it was cut out before, and flat enough for a fan.

    Args:
        rim: (K, 3) points. cut_points: corners of the faces that were cut out before.
    """
    was_cut_out = cut_points is not None and float(cut_points.query(rim)[0].max()) <= SAME_POINT_SHARE * max_width
    if len(rim) > MAX_EDGES or float(np.ptp(rim, axis=0).max()) > (CUT_WIDER if was_cut_out else 1) * max_width:
        return False
    middle = rim.mean(axis=0)
    distance = np.linalg.norm(rim - middle, axis=1)
    if was_cut_out and len(rim) <= FEW_EDGES:
        return True
    if not was_cut_out and len(rim) >= MIN_ROUND_EDGES and distance.std() < ROUND_DEVIATION * distance.mean():
        return False
    return _fan_normal(rim) is not None


def _is_missing_side(rim: Floats, points: Floats) -> bool:
    """True if a rim is that of a flat side, and all of the mesh lies on one side of it.

    Args:
        rim: (K, 3) points. points: (P, 3) of the mesh.
    """
    longest = float(np.ptp(points, axis=0).max())
    normal = _fan_normal(rim)
    if normal is None or float(np.ptp(rim, axis=0).max()) <= MAX_WIDTH * longest:
        return False
    height = (points - rim.mean(axis=0)) @ normal
    is_flat = float(np.ptp(rim @ normal)) <= SIDE_SHARE * longest
    return is_flat and float(height.max()) <= SIDE_SHARE * longest


def _fan_normal(rim: Floats) -> Floats | None:
    """Mean normal of the fan that closes a rim of (K, 3) points; None if the fan would fold."""
    fronts = _fronts(np.stack([rim, np.roll(rim, -1, axis=0)], axis=1), rim.mean(axis=0))
    mean = _mean_direction(fronts)
    if mean is None:
        return None
    unfolded = bool((fronts @ mean > MIN_FAN_COSINE * np.linalg.norm(fronts, axis=1)).all())
    return mean if unfolded else None


def _with_fan(mesh: Mesh, edges: Ints, middle: Floats) -> Mesh:
    """The mesh with a face from each of the (K, 2) edges to a new vertex.

    If a normal of the rim looks away from the new faces, as on a rim between two sides of an object, the new faces get
    separate vertices and normals.
    """
    rim = edges.ravel()
    if mesh.normals is not None and not _looks_along(mesh, edges, middle):
        used, local = np.unique(rim, return_inverse=True)
        edges = local.reshape(-1, 2) + len(mesh.vertices)
        mesh = _with_copies(mesh, used, _flat_normal(mesh.vertices[rim.reshape(-1, 2)], middle))
        rim = edges.ravel()
    center_index = len(mesh.vertices)
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
        faces=np.vstack([mesh.faces, np.column_stack([edges, np.full(len(edges), center_index)])]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[rim].mean(axis=0)]),
        normals=normals,
        colors=colors,
    )


def _looks_along(mesh: Mesh, edges: Ints, middle: Floats) -> bool:
    """True if every normal of a rim lies on the side to which the faces of its fan look."""
    assert mesh.normals is not None
    fronts = _fronts(mesh.vertices[edges], middle)
    return bool((np.einsum("kej,kj->ke", mesh.normals[edges], fronts) > 0).all())


def _fronts(edges: Floats, middle: Floats) -> Floats:
    """(K, 3) normals, as long as twice the area, of the faces of a fan over (K, 2, 3) edges."""
    found: Floats = np.cross(edges[:, 1] - edges[:, 0], middle - edges[:, 0])
    return found


def _flat_normal(edges: Floats, middle: Floats) -> Floats:
    """Unit normal of a fan over (K, 2, 3) edges; up where it has none."""
    found = _mean_direction(_fronts(edges, middle))
    return np.array([0.0, 0.0, 1.0]) if found is None else found


def _mean_direction(vectors: Floats) -> Floats | None:
    """Unit vector along the sum of (K, 3) vectors; None if they cancel out."""
    total = vectors.sum(axis=0)
    length = float(np.linalg.norm(total))
    if length <= 0:
        return None
    unit: Floats = total / length
    return unit


def _with_copies(mesh: Mesh, vertices: Ints, normal: Floats) -> Mesh:
    """The mesh with copies of some vertices behind its own, all with one normal."""
    assert mesh.normals is not None
    return Mesh(
        vertices=np.vstack([mesh.vertices, mesh.vertices[vertices]]),
        faces=mesh.faces,
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[vertices]]),
        normals=np.vstack([mesh.normals, np.tile(normal, (len(vertices), 1))]),
        colors=None if mesh.colors is None else np.vstack([mesh.colors, mesh.colors[vertices]]),
    )
