"""Split a triangle mesh into fragments: connected pieces of surface that no border of a moving part crosses.

Two faces belong together when they share an edge and a material: makers often give a door, its knobs and handles
materials of their own even where the mesh is one piece. Where more than two faces share an edge, solids touch each
other: those faces are paired so that each pair bounds one wedge of solid, which separates touching boxes again after
welding.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.segment.triangle_soup import TriangleSoup
from casa_assets.core.typing import Ints
from casa_assets.geometry.mesh.topology import merge_rows

Bools = npt.NDArray[np.bool_]

# More faces round one edge than these are a fault of the mesh, which says nothing about solids.
MAX_FACES_AT_EDGE = 12
# Faces whose directions round an edge differ by less, radians, count as lying on each other.
SAME_ANGLE = 1e-3


def fragment_labels(soup: TriangleSoup) -> Ints:
    """Return the (F,) fragment of each face, by first face; -1 without area; duplicates as their original."""
    alive = (soup.duplicate_of == np.arange(len(soup.faces))) & (soup.areas > 0.0)
    index = np.flatnonzero(alive)
    if not len(index):
        return np.full(len(soup.faces), -1, dtype=np.int64)
    left, right = _joined(soup, index)
    alike = soup.material_index[index[left]] == soup.material_index[index[right]]
    left, right = left[alike], right[alike]
    graph = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(len(index), len(index)))
    _, label = connected_components(graph, directed=False)
    _, ordered = merge_rows(label[:, None].astype(np.float64))
    found = np.full(len(soup.faces), -1, dtype=np.int64)
    found[index] = ordered
    return np.where(soup.areas > 0.0, found[soup.duplicate_of], -1)


def _joined(soup: TriangleSoup, index: Ints) -> tuple[Ints, Ints]:
    """Return pairs of places in `index` of faces that belong to one fragment."""
    faces = soup.faces[index]
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    forward = directed[:, 0] < directed[:, 1]
    ends = np.sort(directed, axis=1)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner, forward = ends[order], owner[order], forward[order]
    new = np.ones(len(ends), dtype=bool)
    new[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    start = np.flatnonzero(new)
    size = np.diff(np.append(start, len(ends)))
    pair = start[size == 2]
    left, right = [owner[pair]], [owner[pair + 1]]
    for at, count in zip(start[size > 2].tolist(), size[size > 2].tolist(), strict=True):
        if count <= MAX_FACES_AT_EDGE and count % 2 == 0:
            rows = slice(at, at + count)
            a, b = _wedges(soup, index, ends[at], owner[rows], forward[rows])
            left.append(a)
            right.append(b)
    return np.concatenate(left), np.concatenate(right)


def _wedges(soup: TriangleSoup, index: Ints, ends: Ints, owner: Ints, forward: Bools) -> tuple[Ints, Ints]:
    """Pair the faces around an edge so that each pair bounds one wedge of solid; none where windings contradict."""
    none = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    a, b = soup.points[ends[0]], soup.points[ends[1]]
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    middle = soup.points[soup.faces[index[owner]]].sum(axis=1) - a - b
    away = middle - a
    away -= np.outer(away @ along, along)
    x = away[0] / max(float(np.linalg.norm(away[0])), 1e-300)
    y = np.cross(along, x)
    angle = np.arctan2(away @ y, away @ x)
    angle = np.round(np.mod(angle + SAME_ANGLE / 2, 2 * np.pi) / SAME_ANGLE)
    # Seen along the edge, an outward face that runs forward has matter at smaller angles: it ends a wedge, and a
    # backward one begins it. Of faces that lie on each other, ends come before beginnings.
    order = np.lexsort((~forward, angle))
    ahead = forward[order]
    if (ahead[1:] == ahead[:-1]).any():
        return none
    ring = owner[order]
    begin = np.flatnonzero(~ahead)
    return ring[begin], ring[(begin + 1) % len(ring)]
