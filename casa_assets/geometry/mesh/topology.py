"""Topology of triangle meshes: welding, connected components, closedness, winding."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from casa_assets.core.typing import Floats, Ints

# Vertices closer than this part of the longest extent are one point. Float32 files carry about 1e-7.
WELD_RELATIVE = 1e-6


def weld(vertices: Floats, relative: float = WELD_RELATIVE) -> tuple[Floats, Ints]:
    """Merge vertices that lie in one cell of a fine grid.

    Args:
        vertices: (V, 3) any unit.
        relative: cell size as a part of the longest extent.
    Returns:
        (P, 3) the first vertex of each cell, ordered by first use; (V,) index of each vertex's point.
    """
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    cell = max(extent * relative, 1e-30)
    keys = np.round((vertices - vertices.min(axis=0)) / cell).astype(np.int64) if len(vertices) else vertices
    return _unique_rows(vertices, keys)


def _unique_rows(vertices: Floats, keys: npt.NDArray[np.generic]) -> tuple[Floats, Ints]:
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
    """(F,) component of each face, connected through shared points; numbered by first face.

    Args:
        faces: (F, 3) indices of welded points. count: number of points.
    """
    if not len(faces):
        return np.empty(0, dtype=np.int64)
    rows = np.concatenate([faces[:, 0], faces[:, 1]])
    cols = np.concatenate([faces[:, 1], faces[:, 2]])
    graph = coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, cols)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    found = label[faces[:, 0]].astype(np.int64)
    _, place = merge_rows(found[:, None].astype(np.float64))
    return place


def connected_groups(count: int, left: Ints, right: Ints) -> Ints:
    """(N,) group of each of `count` things, of which those at the same place of `left` and `right` belong together."""
    graph = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(count, count))
    found: Ints = connected_components(graph, directed=False)[1].astype(np.int64)
    return found


def manifold_patches(ids: Ints) -> Ints:
    """(F,) patch of each face: patches are joined over edges of exactly two faces.

    Args:
        ids: (F, 3) indices of welded points, at least one face.
    """
    directed = np.sort(directed_edges(ids), axis=1)
    owner = np.tile(np.arange(len(ids)), 3)
    key = directed[:, 0] * (int(ids.max()) + 1) + directed[:, 1]
    order = np.argsort(key, kind="stable")
    key, owner = key[order], owner[order]
    start = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    pair = start[np.diff(np.r_[start, len(key)]) == 2]
    links = coo_matrix((np.ones(len(pair), dtype=np.int8), (owner[pair], owner[pair + 1])), shape=(len(ids),) * 2)
    patch: Ints = connected_components(links, directed=False)[1].astype(np.int64)
    return patch


def directed_edges(faces: Ints) -> Ints:
    """(3F, 2) edges of (F, 3) faces in their winding: the first edge of every face, then the second, then the third."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def edge_counts(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Undirected edges of a face set.

    Returns:
        (E, 2) edges with ascending ends; (E,) how many faces use each; (E,) uses forward minus uses backward.
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


def consistent_winding(faces: Ints) -> tuple[Ints, npt.NDArray[np.bool_]]:
    """Turn faces so that neighbours over a two-face edge run against each other.

    The first face of each connected patch keeps its direction.

    Returns:
        (F, 3) faces; (F,) which were turned.
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


def _turns(left: Ints, right: Ints, clash: npt.NDArray[np.bool_], count: int) -> npt.NDArray[np.bool_]:
    """(F,) parity of the clashes on the way from each face to the first face of its patch.

    Args:
        left, right: (E,) faces that are neighbours, each pair once. clash: (E,) they run the same way.
    """
    # One more node, joined to the first face of each patch, makes one tree of all patches.
    links = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(count, count))
    _, label = connected_components(links, directed=False)
    _, first = np.unique(label, return_index=True)
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
