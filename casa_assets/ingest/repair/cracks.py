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

# Largest width of a crack, as a share of the longest side, and of the shortest edge at its ends; choices.
MAX_WIDTH = 7e-3
MAX_WIDTH_OF_EDGE = 0.2
# Points whose joining closes nothing are left out and the rest is tried again, so many times.
ROUNDS = 4
# More pairs of near points than this, each counted twice, are not tried: they would take gigabytes.
MAX_PAIRS = 40_000_000


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
    open_before = int((uses == 1).sum())
    if not open_before:
        return vertices, []
    points = np.zeros((int(place.max()) + 1, 3))
    points[ids.ravel()] = vertices[surface.faces[keep].ravel()]
    pairs = _close_pairs(points, ids, edges, uses)
    cluster = np.arange(len(points))
    for _ in range(ROUNDS):
        if not len(pairs):
            break
        cluster = _clusters(pairs, len(points))
        is_useless = _useless_points(ids, cluster)[pairs].any(axis=1)
        if not is_useless.any():
            break
        pairs = pairs[~is_useless]
    if not len(pairs):
        return vertices, []
    cluster = _clusters(pairs, len(points))
    open_after = int((edge_counts(cluster[ids])[1] == 1).sum())
    if _useless_points(ids, cluster).any() or open_after >= open_before:
        return vertices, []
    count = np.bincount(cluster, minlength=len(points))
    position_sum = np.stack(
        [np.bincount(cluster, weights=points[:, k], minlength=len(points)) for k in range(3)], axis=1
    )
    cluster_of_vertex = cluster[place]
    is_moved = count[cluster_of_vertex] > 1
    moved_vertices = np.where(
        is_moved[:, None], (position_sum / np.maximum(count, 1)[:, None])[cluster_of_vertex], vertices
    )
    message = f"cracks along {open_before - open_after} of {open_before} open edges were closed"
    return moved_vertices, [warning("MSH040", "seams", message)]


def _close_pairs(points: Floats, ids: Ints, edges: Ints, uses: Ints) -> Ints:
    """(N, 2) ends of open edges that lie within a crack's width of each other."""
    ends = np.unique(edges[uses == 1])
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    shortest = np.full(len(points), np.inf)
    for k in range(2):
        np.minimum.at(shortest, edges[:, k], length)
    used = points[np.unique(ids)]
    reach = np.minimum(MAX_WIDTH * float(np.ptp(used, axis=0).max()), MAX_WIDTH_OF_EDGE * shortest[ends])
    near = _within(points[ends], reach)
    ordered: Ints = ends[near[np.lexsort((near[:, 1], near[:, 0]))]].astype(np.int64)
    return ordered


def _within(points: Floats, reach: Floats) -> Ints:
    """(N, 2) pairs of points that lie within the reach of both.

    One search with the longest reach would pair each point of a finely divided rim with thousands of neighbours. So
    points are searched by powers of two of their reach, together with all whose reach is longer.

    Args:
        points: (P, 3). reach: (P,) of each, in the same unit.
    """
    pairs_by_level = [np.zeros((0, 2), dtype=np.int64)]
    level = np.floor(np.log2(np.maximum(reach, np.finfo(np.float64).tiny))).astype(np.int64)
    for lowest_level in np.unique(level):
        candidates = np.flatnonzero(level >= lowest_level)
        tree, radius = cKDTree(points[candidates]), float(reach[level == lowest_level].max())
        if len(candidates) ** 2 > MAX_PAIRS and tree.count_neighbors(tree, radius) > MAX_PAIRS:
            continue  # a cloud of loose faces and no crack
        pairs = candidates[tree.query_pairs(radius, output_type="ndarray")]
        pairs = pairs[level[pairs].min(axis=1) == lowest_level]
        distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        pairs_by_level.append(pairs[distance <= reach[pairs].min(axis=1)])
    return np.concatenate(pairs_by_level)


def _clusters(pairs: Ints, count: int) -> Ints:
    """(P,) for each point the first point of its cluster, over pairs that are joined."""
    graph = coo_matrix((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    first = np.full(int(label.max()) + 1, count, dtype=np.int64)
    np.minimum.at(first, label, np.arange(count))
    found: Ints = first[label]
    return found


def _useless_points(ids: Ints, cluster: Ints) -> Mask:
    """(P,) points whose joining closes no edge, collapses a face, or makes a third face meet at an edge.

    Args:
        ids: (F, 3). cluster: (P,) the point that each point is joined to.
    """
    merged_faces = cluster[ids]
    moved = np.bincount(cluster, minlength=len(cluster))[cluster] > 1
    edges, uses, _ = edge_counts(ids)
    ends = np.sort(cluster[edges], axis=1)
    _, first, merged_of_edge = np.unique(ends[:, 0] * len(cluster) + ends[:, 1], return_index=True, return_inverse=True)
    total = np.bincount(merged_of_edge, weights=uses)
    max_uses = np.zeros(len(first))
    np.maximum.at(max_uses, merged_of_edge, uses)
    merged_edges = ends[first]
    is_useful, is_harmful = np.zeros(len(cluster), dtype=bool), np.zeros(len(cluster), dtype=bool)
    is_useful[merged_edges[(total == 2) & (max_uses == 1)].ravel()] = True
    is_harmful[merged_edges[(total > 2) & (max_uses <= 2)].ravel()] = True
    is_folded = (
        (merged_faces[:, 0] == merged_faces[:, 1])
        | (merged_faces[:, 1] == merged_faces[:, 2])
        | (merged_faces[:, 2] == merged_faces[:, 0])
    )
    is_harmful[merged_faces[is_folded].ravel()] = True
    is_useless: Mask = moved & (is_harmful[cluster] | ~is_useful[cluster])
    return is_useless
