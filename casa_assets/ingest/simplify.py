"""Simplify meshes that have too many faces; texture seams and outlines stay."""

from __future__ import annotations

import numpy as np
from opengl_decimate import CollapseSequence, SimplifyOptions, collapse_sequence

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.draft import Draft, warning
from casa_assets.mesh.topology import connected_groups, directed_edges, merge_rows
from casa_assets.model.asset.parts import Mesh

# Largest error of the simplified surface, as a part of the mesh's extent.
TARGET_ERROR = 0.01
# The same while every seam of the texture keeps its line. Where that would cost more, as it does with a texture of many
# small pieces, points may also leave a seam; each side still keeps its own texture coordinates.
SEAM_ERROR = 0.005


def simplify(draft: Draft, limit: int) -> Draft:
    """Bring the number of faces down to about `limit`, each part by its share.

    Points and texture coordinates of the result are points and texture coordinates of the parts.
    """
    before = sum(len(p.mesh.faces) for p in draft.parts)
    if before <= limit:
        return draft
    parts = tuple(
        p.replace(mesh=simplified(p.mesh, max(12, int(len(p.mesh.faces) * limit / before)))) for p in draft.parts
    )
    after = sum(len(p.mesh.faces) for p in parts)
    note = warning("MSH015", "faces", f"simplified from {before} to {after} faces")
    return draft.replace(parts=parts, notes=draft.noted(note))


def simplified(mesh: Mesh, target: int) -> Mesh:
    """The mesh with about `target` faces (more where the error bound forbids it), over points that it has."""
    vertices, attributes, corners = _distinct(mesh)
    front, back = _sides(merge_rows(attributes["POSITION"])[1][corners])
    if not len(front):
        return mesh
    share = len(front) / (len(front) + np.count_nonzero(back >= 0))
    sequence, steps = _collapses(attributes, corners[front], max(1, int(target * share)))
    left = (sequence.removed_at < 0) | (sequence.removed_at >= steps)
    places, values = _ends(sequence, steps, corners[front], left)
    twin = back[left] >= 0
    point = sequence.vertex_point.astype(np.int64)
    behind = _vertices_behind(corners, point, front[back >= 0], back[back >= 0])
    places = np.concatenate([places, behind[places[twin]][:, ::-1]])
    values = np.concatenate([values, behind[values[twin]][:, ::-1]])
    return _mesh_of(mesh, vertices[places], vertices[values])


def _collapses(attributes: dict[str, Floats], corners: Ints, count: int) -> tuple[CollapseSequence, int]:
    """Collapses of edges to one of their ends, and how many of them leave `count` faces or what the bound allows."""
    ways = ((True, SEAM_ERROR), (False, TARGET_ERROR))
    for lock_seams, bound in ways if "TEXCOORD_0" in attributes else ways[1:]:
        options = SimplifyOptions(target_ratio=1.0, placement="endpoint", lock_seams=lock_seams)
        sequence = collapse_sequence(attributes, corners.ravel(), options)
        steps = sequence.steps_for(target_count=count, target_error=bound)
        if sequence.triangles_after(steps) <= count:
            break
    return sequence, steps


def _ends(sequence: CollapseSequence, steps: int, corners: Ints, left: Mask) -> tuple[Ints, Ints]:
    """Vertices that give corners their place, and those that give them everything else.

    The library gives a corner the vertex with the most similar texture coordinates at the place. Where pieces of the
    texture lie close to each other, that may be one of another piece, and the face would show all that lies in between.
    So of the vertices that a corner can be moved to along edges that have collapsed, without crossing a seam, it gets
    the one nearest to its new place.

    `corners`: (F, 3) vertices of the faces at the beginning. `left`: (F,) faces that are left. Returns two times (G,
    3), for the faces that are left.
    """
    _, roots, faces, moved = sequence.state(steps)
    places = moved.astype(np.int64)
    if "TEXCOORD_0" not in sequence.attributes:
        return places, places
    at, point = sequence.attributes["POSITION"], sequence.vertex_point
    _, side = merge_rows(np.column_stack([point, sequence.attributes["TEXCOORD_0"]]))
    cluster = roots[point]
    edges = directed_edges(corners)
    edges = side[edges[cluster[edges[:, 0]] == cluster[edges[:, 1]]]]
    reach = connected_groups(int(side.max()) + 1, edges[:, 0], edges[:, 1])[side]
    end = np.zeros((len(roots), 3))
    end[faces] = at[places]
    order = np.lexsort((((at - end[cluster]) ** 2).sum(axis=1), reach))
    nearest = order[np.flatnonzero(np.diff(reach[order], prepend=-1))][reach[corners[left]]]
    values = np.where(side[places] == side[nearest], places, nearest)
    return np.where(point[values] == point[places], values, places), values


def _mesh_of(mesh: Mesh, places: Ints, values: Ints) -> Mesh:
    """Faces of the given (F, 3) vertices, one of which gives the place of a corner and one everything else."""
    pairs, index = np.unique(np.stack([values.ravel(), places.ravel()], axis=1), axis=0, return_inverse=True)
    of = {name: getattr(mesh, name) for name in ("uv", "normals", "colors")}
    return Mesh(
        vertices=mesh.vertices[pairs[:, 1]],
        faces=index.reshape(-1, 3),
        **{name: None if array is None else array[pairs[:, 0]] for name, array in of.items()},
    )


def _distinct(mesh: Mesh) -> tuple[Ints, dict[str, Floats], Ints]:
    """Vertices without those equal to an earlier one.

    Returns:
        (N,) vertices; their attributes as glTF names them, lengths as parts of the extent; (F, 3) corners over these.
    """
    used = mesh.vertices[mesh.faces]
    low = used.min(axis=(0, 1))
    extent = max(float((used.max(axis=(0, 1)) - low).max()), 1e-30)
    places = np.round((mesh.vertices - low) / extent, 7)
    carried = {"TEXCOORD_0": mesh.uv, "NORMAL": mesh.normals, "COLOR_0": mesh.colors}
    values = {name: np.round(array.astype(np.float64), 6) for name, array in carried.items() if array is not None}
    first, place = merge_rows(np.column_stack([places, *values.values()]))
    attributes = {"POSITION": places[first]} | {name: array[first] for name, array in values.items()}
    return first, attributes, place[mesh.faces.astype(np.int64)]


def _sides(ids: Ints) -> tuple[Ints, Ints]:
    """(N,) faces with three different points, each once, and the face behind each that looks the other way, or -1.

    A sheet with faces in both directions has four faces at each edge, over which nothing could collapse.
    """
    ordered = np.sort(ids, axis=1)
    rows = np.flatnonzero((ordered[:, 1:] != ordered[:, :-1]).all(axis=1))
    first, place = merge_rows(ordered[rows].astype(np.float64))
    after_lowest = (ids[rows].argmin(axis=1) + 1) % 3
    forward = np.take_along_axis(ids[rows], after_lowest[:, None], axis=1)[:, 0] == ordered[rows, 1]
    back = np.full(len(first), -1, dtype=np.int64)
    reverse = np.flatnonzero(forward != forward[first][place])[::-1]  # of several the first is written last
    back[place[reverse]] = rows[reverse]
    return rows[first], back


def _vertices_behind(corners: Ints, point: Ints, front: Ints, back: Ints) -> Ints:
    """(N,) for each vertex, the vertex of a face behind at its place; the vertex itself if there is no such face."""
    found = np.arange(len(point))
    ahead, behind = (
        np.take_along_axis(corners[rows], np.argsort(point[corners[rows]], axis=1), axis=1) for rows in (front, back)
    )
    found[ahead.ravel()[::-1]] = behind.ravel()[::-1]
    return found
