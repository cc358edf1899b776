"""Topology of triangle meshes: welding, components, winding, closed parts that wind inwards, small holes."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from casa_assets.core.numeric import Floats, Ints, Mask

# Vertices closer than this part of the longest extent are one point. Float32 files carry about 1e-7.
WELD_RELATIVE = 1e-6


def weld(vertices: Floats, relative: float = WELD_RELATIVE) -> tuple[Floats, Ints]:
    """Merge vertices that lie in one cell of a grid, whose cell size is a `relative` part of the longest extent.

    Returns (P, 3) the first vertex of each cell, ordered by first use; (V,) index of each vertex's point.
    """
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
    count = int(label.max(initial=-1)) + 1
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label, corners.min(axis=1))
    np.maximum.at(upper, label, corners.max(axis=1))
    return lower, upper


def connected_groups(count: int, left: Ints, right: Ints) -> Ints:
    """(N,) group of each of `count` things, of which those at the same place of `left` and `right` belong together."""
    graph = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1].astype(np.int64))


def manifold_patches(ids: Ints) -> Ints:
    """(F,) patch of each of (F, 3) faces, at least one: patches are joined over edges of exactly two faces."""
    directed = np.sort(directed_edges(ids), axis=1)
    owner = np.tile(np.arange(len(ids)), 3)
    key = directed[:, 0] * (int(ids.max()) + 1) + directed[:, 1]
    order = np.argsort(key, kind="stable")
    key, owner = key[order], owner[order]
    start = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    pair = start[np.diff(np.r_[start, len(key)]) == 2]
    return connected_groups(len(ids), owner[pair], owner[pair + 1])


def directed_edges(faces: Ints) -> Ints:
    """(3F, 2) edges of (F, 3) faces in their winding: the first edge of every face, then the second, then the third."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def edge_counts(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Undirected edges of a face set.

    Returns (E, 2) edges with ascending ends; (E,) how many faces use each; (E,) uses forward minus uses backward.
    """
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
    """Turn faces so that neighbours over a two-face edge run against each other.

    The first face of each connected patch keeps its direction.

    Returns (F, 3) faces; (F,) which were turned.
    """
    count = len(faces)
    turned = np.zeros(count, dtype=bool)
    if count < 2:
        return faces, turned
    directed = directed_edges(faces)
    owner = np.tile(np.arange(count), 3)
    forward = directed[:, 0] < directed[:, 1]
    ends = np.sort(directed, axis=1)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner, forward = ends[order], owner[order], forward[order]
    same = (ends[1:] == ends[:-1]).all(axis=1)
    start = np.flatnonzero(np.r_[True, ~same])
    size = np.diff(np.r_[start, len(ends)])
    pair = start[size == 2]
    left, right = owner[pair], owner[pair + 1]
    clash = forward[pair] == forward[pair + 1]
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
    """(F,) parity of the clashes on the way from each face to the first face of its patch.

    `left`, `right`: (E,) neighbouring faces, each pair once. `clash`: (E,) they run the same way.
    """
    # One more node, joined to the first face of each patch, makes one tree of all patches.
    _, first = np.unique(connected_groups(count, left, right), return_index=True)
    ends = np.concatenate([left, first]), np.concatenate([right, np.full(len(first), count)])
    # Weight 1 keeps the relative direction, 2 turns it.
    weight = np.concatenate([np.where(clash, 2, 1), np.ones(len(first), dtype=np.int64)]).astype(np.int8)
    graph = coo_matrix((np.tile(weight, 2), (np.concatenate(ends), np.concatenate(ends[::-1]))), shape=(count + 1,) * 2)
    graph = graph.tocsr()
    _, before = breadth_first_order(graph, count, directed=True)
    before[count] = count
    step = np.asarray(graph[before[:count], np.arange(count)]).ravel()
    parity = np.append(step == 2, False)
    while (before != count).any():  # each round doubles the length of the way that is summed up
        parity = parity ^ parity[before]
        before = before[before]
    return parity[:count]


# Inside out -----------------------------------------------------------------------------------------------------------

# A closed component is inside out where its volume is below this share of the cube of its longest side: one that is
# flat has no inside, and rounding gives it either sign.
MIN_NEGATIVE_VOLUME = 1e-9


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


# Hole filling ---------------------------------------------------------------------------------------------------------

# Faces around tangled edges are taken out this many times, as each time may tear open some more.
ROUNDS = 3
# More torn edges than this share are no small damage.
MAX_TORN_SHARE = 0.02


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
