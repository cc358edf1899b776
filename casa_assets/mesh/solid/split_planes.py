"""Score cutting planes of a solid without cutting it, by the hulls of what would lie on either side."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import connected_groups, directed_edges

# With more pieces than these on one side that side is taken as one.
MOST_PIECES = 24
# Steps in which normals and offsets (of the longest side) of faces at hollow edges are counted as one plane.
NORMAL_STEP = 0.05
OFFSET_STEP = 0.01
# An edge is hollow where its faces turn towards each other by more than this sine.
CONCAVE_SINE = 0.3
MIN_PIECE_SHARE = 1e-5


@dataclass(frozen=True)
class EdgeGraph:
    """Vertices and edges of a closed surface: (P, 3) points and (E, 2) edges, each once."""

    points: Floats
    edges: Ints


@dataclass(frozen=True)
class Plane:
    """Places x with normal . x = offset; the normal has unit length, metres."""

    normal: Floats
    offset: float


def edge_graph(points: Floats, faces: Ints) -> EdgeGraph:
    """The points and edges of a closed surface, (P, 3) and (F, 3)."""
    ends = np.sort(directed_edges(faces), axis=1)
    key = np.unique(ends[:, 0] * len(points) + ends[:, 1])
    return EdgeGraph(points, np.stack([key // len(points), key % len(points)], axis=1))


def split_hull_volume(of: EdgeGraph, plane: Plane) -> tuple[float, int]:
    """Volume of the hulls, m^3, and their number, if a plane cut the solid and every piece got one hull."""
    above = of.points @ plane.normal - plane.offset
    side = above > 0
    if side.all() or not side.any():
        return np.inf, 1
    first, second = of.edges.T
    through = side[first] != side[second]
    kept = ~through
    label = connected_groups(len(above), first[kept], second[kept])
    one, other = first[through], second[through]
    share = above[one] / (above[one] - above[other])
    met = of.points[one] + share[:, None] * (of.points[other] - of.points[one])
    total, count = 0.0, 0
    for high in (True, False):
        ends = label[np.where(side[one] == high, one, other)]
        for points in _pieces(of.points, label, side == high, met, ends, plane.normal):
            total += float(manifold3d.Manifold.hull_points(points).volume())
            count += 1
    return total, count


def _pieces(
    points: Floats, label: Ints, here: npt.NDArray[np.bool_], met: Floats, ends: Ints, normal: Floats
) -> list[Floats]:
    """Points of each piece on one side: shells of the surface that the cut closes together are one."""
    shells = np.unique(label[here])
    if len(shells) == 1 or len(shells) > MOST_PIECES:
        return [np.concatenate([points[here], met])]
    across = np.linalg.svd(normal[None])[2][1:]
    flat = met @ across.T
    boxes = np.full((len(shells), 4), np.nan)
    for k, shell in enumerate(shells):
        mine = flat[ends == shell]
        if len(mine):
            boxes[k] = [*mine.min(axis=0), *mine.max(axis=0)]
    # A loop within another is the hole of what the cut closes.
    low, high = boxes[:, :2], boxes[:, 2:]
    within = (low[:, None] >= low[None]).all(axis=2) & (high[:, None] <= high[None]).all(axis=2)
    _, group = connected_components(coo_matrix(within), directed=False)
    out = []
    for g in range(int(group.max()) + 1):
        mine = shells[group == g]
        out.append(np.concatenate([points[here & np.isin(label, mine)], met[np.isin(ends, mine)]]))
    return out


def concave_edge_planes(points: Floats, faces: Ints, most: int) -> list[Plane]:
    """At most `most` planes of faces at concave edges, those with the longest edges first: built things part there."""
    normals, areas = face_normals(points, faces)
    directed = directed_edges(faces)
    ends = np.sort(directed, axis=1)
    order = np.lexsort(ends.T[::-1])
    pairs = order.reshape(-1, 2) if len(order) % 2 == 0 else np.zeros((0, 2), dtype=np.int64)
    pairs = pairs[(ends[pairs[:, 0]] == ends[pairs[:, 1]]).all(axis=1)]
    left, right = pairs[:, 0] % len(faces), pairs[:, 1] % len(faces)
    along = points[directed[pairs[:, 0], 1]] - points[directed[pairs[:, 0], 0]]
    turn = np.einsum("ij,ij->i", np.cross(normals[left], normals[right]), along)  # sine times length; < 0 where hollow
    length = np.linalg.norm(along, axis=1)
    hollow = turn < -CONCAVE_SINE * length
    face = np.concatenate([left[hollow], right[hollow]])
    if not len(face):
        return []
    weight = np.concatenate([-turn[hollow]] * 2)
    lying = areas[face] > 0
    face, weight = face[lying], weight[lying]
    longest = float(np.ptp(points, axis=0).max())
    # Of each normal the largest component by magnitude, the first of equals, is made positive.
    leading = np.argmax(np.abs(normals[face]).round(6), axis=1)
    side = np.where(normals[face, leading] < 0, -1.0, 1.0)
    normal = normals[face] * side[:, None]
    # A hair before the face: what is cut right along it keeps a film of it.
    offset = np.einsum("ij,ij->i", normal, points[faces[face, 0]]) + side * MIN_PIECE_SHARE * longest
    steps = np.column_stack([normal / NORMAL_STEP, offset / (OFFSET_STEP * longest)]).round().astype(np.int64)
    kinds, first, kind = np.unique(steps, axis=0, return_index=True, return_inverse=True)
    total = np.bincount(kind.ravel(), weights=weight, minlength=len(kinds)).round(9)
    best = np.lexsort([np.arange(len(kinds)), -total])[:most]
    return [Plane(normal[first[k]].round(9), round(float(offset[first[k]]), 9)) for k in best]
