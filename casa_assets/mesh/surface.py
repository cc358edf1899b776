"""Triangle surfaces: welding, components, winding, small holes; volume, area, centre and inertia; shading normals."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy  # which loads its parts when they are first used

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.asset.parts import Mesh

# Vertices closer than this part of the longest extent are one point. Float32 files carry about 1e-7.
WELD_RELATIVE = 1e-6
# A closed component is inside out where its volume is below this share of the cube of its longest side: one that is
# flat has no inside, and rounding gives it either sign.
MIN_NEGATIVE_VOLUME = 1e-9
# Faces around tangled edges are taken out this many times, as each time may tear open some more.
ROUNDS = 3
# More torn edges than this share are no small damage.
MAX_TORN_SHARE = 0.02
# Ref: Blender's default auto-smooth angle.
CREASE_DEG = 30.0


def weld(vertices: Floats, relative: float = WELD_RELATIVE) -> tuple[Floats, Ints]:
    """(P, 3) first vertex in each cell of a grid, a `relative` part of the extent, by first use; (V,) point of each."""
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    cell = max(extent * relative, 1e-30)
    keys = np.round((vertices - vertices.min(axis=0)) / cell).astype(np.int64) if len(vertices) else vertices
    return _unique_rows(vertices, keys)


def _unique_rows(vertices: Floats, keys: Floats | Ints) -> tuple[Floats, Ints]:
    if not len(vertices):
        return vertices, np.empty(0, dtype=np.int64)
    order = np.lexsort(keys.T[::-1])
    ordered = keys[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    first = np.full(int(new.sum()), len(vertices), dtype=np.int64)
    np.minimum.at(first, group, np.arange(len(vertices)))
    rank = np.argsort(first, kind="stable")
    place = np.empty_like(rank)
    place[rank] = np.arange(len(rank))
    return vertices[first[rank]], place[group]


def merge_rows(rows: Floats) -> tuple[Ints, Ints]:
    """Indices of the first of each set of equal rows, in order of first use, and the set of each row."""
    values, place = _unique_rows(np.arange(len(rows), dtype=np.float64)[:, None], rows)
    return values[:, 0].astype(np.int64), place


def face_components(faces: Ints, count: int) -> Ints:
    """(F,) component of each face over `count` points, connected through shared points; numbered by first face."""
    if not len(faces):
        return np.empty(0, dtype=np.int64)
    rows = np.concatenate([faces[:, 0], faces[:, 1]])
    cols = np.concatenate([faces[:, 1], faces[:, 2]])
    label = connected_groups(count, rows, cols)[faces[:, 0]]
    return merge_rows(label[:, None].astype(np.float64))[1]


def component_boxes(corners: Floats, label: Ints) -> tuple[Floats, Floats]:
    """(N, 3) lower and upper corners of the box around each component of (F, 3, 3) corners of faces; (F,) labels."""
    count = int(label.max()) + 1
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label, corners.min(axis=1))
    np.maximum.at(upper, label, corners.max(axis=1))
    return lower, upper


def connected_groups(count: int, left: Ints, right: Ints) -> Ints:
    """(N,) group of each of `count` things, of which those at the same place of `left` and `right` belong together."""
    graph = scipy.sparse.coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(count, count))
    return np.asarray(scipy.sparse.csgraph.connected_components(graph, directed=False)[1].astype(np.int64))


def manifold_patches(ids: Ints) -> Ints:
    """(F,) patch of each of (F, 3) faces, at least one: patches are joined over edges of exactly two faces."""
    left, right, _ = _two_face_edges(ids)
    return connected_groups(len(ids), left, right)


def _two_face_edges(faces: Ints) -> tuple[Ints, Ints, Mask]:
    """(E,) the two faces of each edge that has two, the first by number first; (E,) both run along it the same way."""
    directed = directed_edges(faces)
    owner = np.tile(np.arange(len(faces)), 3)
    forward = directed[:, 0] < directed[:, 1]
    ends = np.sort(directed, axis=1)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner, forward = ends[order], owner[order], forward[order]
    start = np.flatnonzero(np.r_[True, (ends[1:] != ends[:-1]).any(axis=1)])
    pair = start[np.diff(np.r_[start, len(ends)]) == 2]
    return owner[pair], owner[pair + 1], forward[pair] == forward[pair + 1]


def directed_edges(faces: Ints) -> Ints:
    """(3F, 2) edges of (F, 3) faces in their winding: the first edge of every face, then the second, then the third."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def edge_counts(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """(E, 2) undirected edges with ascending ends; (E,) faces that use each; (E,) uses forward minus backward."""
    directed = directed_edges(faces)
    forward = directed[:, 0] < directed[:, 1]
    ends = np.sort(directed, axis=1)
    key = ends[:, 0] * (int(faces.max()) + 1 if len(faces) else 1) + ends[:, 1]
    _, index, inverse = np.unique(key, return_index=True, return_inverse=True)
    uses = np.bincount(inverse)
    balance = np.bincount(inverse, weights=np.where(forward, 1.0, -1.0)).astype(np.int64)
    return ends[index], uses.astype(np.int64), balance


def is_closed(faces: Ints) -> bool:
    """True where every edge is used by exactly two faces, once each way: the surface bounds a volume."""
    if not len(faces):
        return False
    _, uses, balance = edge_counts(faces)
    return bool((uses == 2).all() and (balance == 0).all())


def consistent_winding(faces: Ints) -> tuple[Ints, Mask]:
    """Turn faces so that neighbours over a two-face edge run against each other; the first of each patch stays.

    Returns (F, 3) faces; (F,) which were turned.
    """
    count = len(faces)
    turned = np.zeros(count, dtype=bool)
    if count < 2:
        return faces, turned
    left, right, clash = _two_face_edges(faces)
    if not clash.any():
        return faces, turned
    # Two faces may share several edges: the first decides.
    _, at = np.unique(left * count + right, return_index=True)
    left, right, clash = left[at], right[at], clash[at]
    turned = _turns(left, right, clash, count)
    out = faces.copy()
    out[turned] = out[turned][:, ::-1]
    return out, turned


def _turns(left: Ints, right: Ints, clash: Mask, count: int) -> Mask:
    """(F,) parity of (E,) clashes between neighbours `left`, `right` on the way to the first face of the patch."""
    # One more node, joined to the first face of each patch, makes one tree of all patches.
    _, first = np.unique(connected_groups(count, left, right), return_index=True)
    ends = np.concatenate([left, first]), np.concatenate([right, np.full(len(first), count)])
    # Weight 1 keeps the relative direction, 2 turns it.
    weight = np.concatenate([np.where(clash, 2, 1), np.ones(len(first), dtype=np.int64)]).astype(np.int8)
    graph = scipy.sparse.coo_matrix(
        (np.tile(weight, 2), (np.concatenate(ends), np.concatenate(ends[::-1]))), shape=(count + 1,) * 2
    )
    graph = graph.tocsr()
    _, before = scipy.sparse.csgraph.breadth_first_order(graph, count, directed=True)
    before[count] = count
    step = np.asarray(graph[before[:count], np.arange(count)]).ravel()
    parity = np.append(step == 2, False)
    while (before != count).any():  # each round doubles the length of the way that is summed up
        parity = parity ^ parity[before]
        before = before[before]
    return parity[:count]


def inside_out_faces(points: Floats, faces: Ints) -> Mask:
    """(F,) True for faces on closed components of negative volume that are not the lining of another one."""
    if not len(faces):
        return np.zeros(0, dtype=bool)
    component = face_components(faces, len(points))
    corners = points[faces] - points.mean(axis=0)
    lower, upper = component_boxes(corners, component)
    tetrahedra = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volume = np.bincount(component, weights=tetrahedra)
    least = -MIN_NEGATIVE_VOLUME * (upper - lower).max(axis=1) ** 3
    size = (upper - lower).prod(axis=1)
    found = []
    for k in np.flatnonzero(closed_components(faces, component, len(points)) & (volume < least)):
        # The inner wall of a hollow thing winds inwards: it lies in the bounds of a larger component.
        within = (lower <= lower[k]).all(axis=1) & (upper >= upper[k]).all(axis=1)
        if not (within & (size > size[k])).any():
            found.append(k)
    return np.isin(component, found)


def closed_components(faces: Ints, component: Ints, points: int) -> Mask:
    """(C,) whether each edge of a component is used by two faces, once each way."""
    of_point = np.zeros(points, dtype=np.int64)
    of_point[faces] = component[:, None]
    ends, uses, balance = edge_counts(faces)
    closed = np.ones(int(component.max()) + 1, dtype=bool)
    closed[of_point[ends[(uses != 2) | (balance != 0), 0]]] = False
    return closed


def fill_holes(
    points: Floats, faces: Ints, widest: float, most_torn: float = MAX_TORN_SHARE
) -> tuple[Floats, Ints] | None:
    """Close the small holes of a surface, each by a fan about its middle; return None if any holes are left.

    `points`: (P, 3) welded. `faces`: (F, 3), consistently wound. `widest`: longest side of the box around a hole.
    `most_torn`: maximum share of edges that are torn.
    """
    if not len(faces):
        return None
    kept = faces
    for _ in range(ROUNDS):
        _, uses, balance = edge_counts(kept)
        if ((uses != 2) | (balance != 0)).mean() > most_torn:
            return None
        tangled = faces_with(kept, (uses > 2) | ((uses == 2) & (balance != 0)))
        if not tangled.any():
            break
        kept = kept[~tangled]
        if not len(kept):
            return None
    loops = _loops(kept)
    if loops is None or any(float(np.ptp(points[loop], axis=0).max()) > widest for loop in loops):
        return None
    middles = [points[loop].mean(axis=0) for loop in loops]
    fans = [
        np.array([loop])
        if len(loop) == 3
        else np.stack([loop, np.roll(loop, -1), np.full(len(loop), len(points) + k)], axis=1)
        for k, loop in enumerate(loops)
    ]
    whole = np.concatenate([kept, *fans])
    return (np.concatenate([points, np.array(middles).reshape(-1, 3)]), whole) if is_closed(whole) else None


def faces_with(faces: Ints, marked: Mask) -> Mask:
    """(F,) faces with one of the edges that `edge_counts` lists and that are `marked`."""
    ends = np.sort(directed_edges(faces), axis=1)
    key = ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1]
    _, inverse = np.unique(key, return_inverse=True)
    return np.asarray(np.any(marked[inverse].reshape(3, -1), axis=0))


def _loops(faces: Ints) -> list[Ints] | None:
    """Return the closed loops of boundary edges, which have one face, wound opposite to it; None if one does not close.

    If two holes meet in a point, each loop continues around the hole along which it arrived.
    """
    directed = directed_edges(faces)
    count = int(faces.max()) + 1
    forth, back = directed[:, 0] * count + directed[:, 1], directed[:, 1] * count + directed[:, 0]
    open_ = np.sort(back[~np.isin(back, forth)])
    out: dict[int, list[int]] = {}
    for start, end in zip((open_ // count).tolist(), (open_ % count).tolist(), strict=True):
        out.setdefault(start, []).append(end)
    if any(len(ends) > 2 for ends in out.values()):
        return None
    meet = any(len(ends) == 2 for ends in out.values())
    third = dict(zip(forth.tolist(), np.roll(faces, 1, axis=1).T.ravel().tolist(), strict=True)) if meet else {}
    ways = {}
    for start, ends in out.items():
        for end in ends:
            onwards = out.get(end, [])
            if len(onwards) == 2:  # the faces on this side of the point end at the other hole
                onwards = [spot for spot in onwards if spot != _around(third, start, end, count)]
            if len(onwards) != 1:
                return None
            ways[start, end] = (end, onwards[0])
    loops = []
    while ways:
        first = min(ways)
        way, at = [first[0]], ways.pop(first)
        while at != first:
            if at not in ways:
                return None
            way.append(at[0])
            at = ways.pop(at)
        loops.append(np.array(way, dtype=np.int64))
    return loops


def _around(third: dict[int, int], before: int, spot: int, count: int) -> int:
    """End of the fan of faces that an open way from `before` to `spot` runs along end, going around that point.

    `third`: of each directed edge, first * count + second, the corner across from it. `count`: of the points.
    """
    for _ in range(len(third)):
        across = third[spot * count + before]
        if spot * count + across not in third:
            return across
        before = across
    return -1


def face_normals(points: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """(F, 3) unit normals (zero where the face has no area) and (F,) areas in units squared."""
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-300)[:, None], length / 2


def signed_volume(points: Floats, faces: Ints) -> float:
    """Volume that the surface bounds, positive where it winds outwards; meaningless where it is open."""
    corners = points[faces] - points.mean(axis=0)
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def winding_number(points: Floats, faces: Ints, spot: Floats) -> float:
    """Winding number of a closed surface about a (3,) point: 1 within an outward one, -1 within an inward one, else 0.

    Ref: solid angles of the triangles, Van Oosterom and Strackee 1983.
    """
    a, b, c = np.swapaxes(points[faces] - spot, 0, 1)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(above, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi))


def solid_moments(points: Floats, faces: Ints) -> tuple[float, Floats, Floats]:
    """Volume, centre and inertia of the solid inside a closed surface, at density 1.

    `points`: (P, 3) metres. `faces`: (F, 3), closed and outward. Returns volume m^3; (3,) centre, metres; (3, 3)
    inertia about the centre, m^5. Ref: sums over tetrahedra to a common apex, Tonon 2004 in covariance form.
    """
    apex = points.mean(axis=0)
    corners = points[faces] - apex
    det = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = float(det.sum() / 6)
    total = corners.sum(axis=1)
    center = (det[:, None] * total).sum(axis=0) / 24 / volume if volume else np.zeros(3)
    second = np.einsum("n,nki,nkj->ij", det, corners, corners) + np.einsum("n,ni,nj->ij", det, total, total)
    covariance = second / 120 - volume * np.outer(center, center)
    inertia = np.trace(covariance) * np.eye(3) - covariance
    return volume, center + apex, inertia


def backward_share(
    vertices: Floats, faces: npt.NDArray[np.integer[Any]], normals: Floats, least_cosine: float = 0.0
) -> float:
    """Share of the area whose normals, one per vertex, have less than the least cosine with the front of the face."""
    fronts, areas = face_normals(vertices, faces.astype(np.int64))
    behind = np.einsum("fkj,fj->fk", normals[faces], fronts) < least_cosine
    return float((behind.mean(axis=1) * areas).sum() / max(float(areas.sum()), 1e-300))


def shell_moments(points: Floats, faces: Ints) -> tuple[float, Floats, Floats]:
    """Area, centre and inertia of a thin surface, at area density 1: m^2, (3,) m, (3, 3) m^4."""
    corners = points[faces]
    _, area = face_normals(points, faces)
    whole = float(area.sum())
    mid = corners.mean(axis=1)
    center = (area[:, None] * mid).sum(axis=0) / whole
    local = corners - center
    total = local.sum(axis=1)
    second = np.einsum("n,nki,nkj->ij", area, local, local) + np.einsum("n,ni,nj->ij", area, total, total)
    covariance = second / 12
    return whole, center, np.trace(covariance) * np.eye(3) - covariance


def picked(mesh: Mesh, rows: npt.NDArray[np.integer[Any]], faces: npt.NDArray[np.integer[Any]]) -> Mesh:
    """A mesh of some vertices of a mesh with their texture coordinates, normals and colours; faces are over these."""
    columns = {name: getattr(mesh, name) for name in ("uv", "normals", "colors")}
    kept = {name: None if values is None else values[rows] for name, values in columns.items()}
    return Mesh(vertices=mesh.vertices[rows], faces=faces, **kept)


def with_normals(mesh: Mesh, crease_deg: float = CREASE_DEG) -> Mesh:
    """The mesh with unit vertex normals; vertices are split where faces meet at more than `crease_deg`.

    Uv seams stay, but do not break the shading: faces are neighbours where their positions meet.
    """
    faces = mesh.faces.astype(np.int64)
    _, place = weld(mesh.vertices)
    normals, areas = face_normals(mesh.vertices, faces)
    corner_point = place[faces].ravel()
    corner_face = np.repeat(np.arange(len(faces)), 3)
    smooth = _corner_normals(corner_point, corner_face, normals, areas, np.cos(np.radians(crease_deg)))
    index = faces.ravel()
    first, vertex = merge_rows(np.column_stack([index, np.round(smooth, 4)]))
    return picked(mesh, index[first], vertex.reshape(-1, 3)).replace(normals=smooth[first])


def _corner_normals(
    point: npt.NDArray[np.int64], face: npt.NDArray[np.int64], normals: Floats, areas: Floats, least_cosine: float
) -> Floats:
    """(3F, 3) unit normal of each corner: area-weighted mean over the faces at its point that bend gently."""
    order = np.argsort(point, kind="stable")
    count = np.bincount(point)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    summed = np.zeros((len(point), 3))
    here_face = face[order]
    here_start, here_count = start[point[order]], count[point[order]]
    for k in range(int(count.max()) if len(count) else 0):
        live = np.flatnonzero(here_count > k)
        other = here_face[here_start[live] + k]
        own = normals[here_face[live]]
        gentle = np.einsum("ij,ij->i", own, normals[other]) >= least_cosine
        summed[live[gentle]] += normals[other[gentle]] * areas[other[gentle], None]
    length = np.linalg.norm(summed, axis=1)
    flat = length <= 1e-300
    summed[flat] = normals[here_face[flat]]
    length = np.maximum(np.linalg.norm(summed, axis=1), 1e-300)
    out = np.empty_like(summed)
    out[order] = summed / length[:, None]
    out[np.linalg.norm(out, axis=1) < 0.5] = (0.0, 0.0, 1.0)
    return out
