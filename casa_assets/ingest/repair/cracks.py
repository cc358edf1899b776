"""Close cracks: open edges that run a hair apart are joined by moving their ends together."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.topology import edge_counts
from casa_assets.ingest.draft import Surface, warning
from casa_assets.model.issue import Issue

# A crack is narrower than this part of the longest side, and than that part of the shortest edge at its ends.
WIDEST = 7e-3
OF_EDGE = 0.2
# Points that are moved together in vain are let go, and the rest tried again, so many times.
ROUNDS = 4
# More pairs of near points than this, each counted twice, are not looked at: they would take gigabytes.
MOST_PAIRS = 40_000_000


def close_cracks(surface: Surface, keep: Mask) -> tuple[Floats, list[Issue]]:
    """Close cracks where that makes open edges meet; everything else stays in place.

    Args:
        keep: (F,) faces that count.
    Returns:
        (V, 3) vertices, some of them moved; a note where cracks were closed.
    """
    vertices, place = surface.vertices, surface.point_of_vertex
    ids = surface.welded_faces[keep]
    edges, uses, _ = edge_counts(ids)
    before = int((uses == 1).sum())
    if not before:
        return vertices, []
    points = np.zeros((int(place.max()) + 1, 3))
    points[ids.ravel()] = vertices[surface.faces[keep].ravel()]
    pairs = _close_pairs(points, ids, edges, uses)
    target = np.arange(len(points))
    for _ in range(ROUNDS):
        if not len(pairs):
            break
        target = _clusters(pairs, len(points))
        useless = _in_vain(ids, target)[pairs].any(axis=1)
        if not useless.any():
            break
        pairs = pairs[~useless]
    if not len(pairs):
        return vertices, []
    target = _clusters(pairs, len(points))
    after = int((edge_counts(target[ids])[1] == 1).sum())
    if _in_vain(ids, target).any() or after >= before:
        return vertices, []
    count = np.bincount(target, minlength=len(points))
    middle = np.stack([np.bincount(target, weights=points[:, k], minlength=len(points)) for k in range(3)], axis=1)
    at = target[place]
    moves = count[at] > 1
    out = np.where(moves[:, None], (middle / np.maximum(count, 1)[:, None])[at], vertices)
    message = f"cracks along {before - after} of {before} open edges were closed"
    return out, [warning("MSH040", "seams", message)]


def _close_pairs(points: Floats, ids: Ints, edges: Ints, uses: Ints) -> Ints:
    """(N, 2) ends of open edges that lie within a crack's width of each other."""
    ends = np.unique(edges[uses == 1])
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    shortest = np.full(len(points), np.inf)
    for k in range(2):
        np.minimum.at(shortest, edges[:, k], length)
    used = points[np.unique(ids)]
    reach = np.minimum(WIDEST * float(np.ptp(used, axis=0).max()), OF_EDGE * shortest[ends])
    near = _within(points[ends], reach)
    ordered: Ints = ends[near[np.lexsort((near[:, 1], near[:, 0]))]].astype(np.int64)
    return ordered


def _within(points: Floats, reach: Floats) -> Ints:
    """(N, 2) pairs of points that lie within the reach of both.

    One search with the longest reach would pair every point of a finely cut rim with thousands of its neighbours. So
    points of like reach are searched together, with all whose reach is longer.

    Args:
        points: (P, 3). reach: (P,) of each, in the same unit.
    """
    found = [np.zeros((0, 2), dtype=np.int64)]
    level = np.floor(np.log2(np.maximum(reach, np.finfo(np.float64).tiny))).astype(np.int64)
    for one in np.unique(level):
        mine = np.flatnonzero(level >= one)
        tree, radius = cKDTree(points[mine]), float(reach[level == one].max())
        if len(mine) ** 2 > MOST_PAIRS and tree.count_neighbors(tree, radius) > MOST_PAIRS:
            continue  # a cloud of loose faces that no crack runs through
        pairs = mine[tree.query_pairs(radius, output_type="ndarray")]
        pairs = pairs[level[pairs].min(axis=1) == one]
        apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        found.append(pairs[apart <= reach[pairs].min(axis=1)])
    return np.concatenate(found)


def _clusters(pairs: Ints, count: int) -> Ints:
    """(P,) for each point the first of those that it is joined with."""
    graph = coo_matrix((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    first = np.full(int(label.max()) + 1, count, dtype=np.int64)
    np.minimum.at(first, label, np.arange(count))
    found: Ints = first[label]
    return found


def _in_vain(ids: Ints, target: Ints) -> Mask:
    """(P,) points whose joining closes no edge, folds a face, or makes a third face meet at an edge."""
    new = target[ids]
    moved = np.bincount(target, minlength=len(target))[target] > 1
    edges, uses, _ = edge_counts(ids)
    ends = np.sort(target[edges], axis=1)
    _, first, of = np.unique(ends[:, 0] * len(target) + ends[:, 1], return_index=True, return_inverse=True)
    total = np.bincount(of, weights=uses)
    most = np.zeros(len(first))
    np.maximum.at(most, of, uses)
    after = ends[first]
    useful, harmful = np.zeros(len(target), dtype=bool), np.zeros(len(target), dtype=bool)
    useful[after[(total == 2) & (most == 1)].ravel()] = True
    harmful[after[(total > 2) & (most <= 2)].ravel()] = True
    folded = (new[:, 0] == new[:, 1]) | (new[:, 1] == new[:, 2]) | (new[:, 2] == new[:, 0])
    harmful[new[folded].ravel()] = True
    vain: Mask = moved & (harmful[target] | ~useful[target])
    return vain
