"""Split edges at T-junctions, so that the faces on both sides share their vertices."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints
from casa_assets.ingest.draft import Draft, Surface, warning
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawPart

# How far off an edge a corner may lie: of the longest side, and of the edge.
MAX_OFF_SHARE = 2e-3
MAX_OFF_EDGE_SHARE = 0.1
# A face is cut along one of its edges at a time.
ROUNDS = 6
# With more open edges than these it is a soup.
MOST_EDGES = 20_000


@dataclass(frozen=True)
class _Cut:
    """A face, which of its edges, and the places on that edge from its start to its end."""

    face: int
    edge: int
    places: Floats


def split_t_junctions(draft: Draft) -> Draft:
    """Split faces whose open edge is met by shorter open edges, where all of it is met; a note says how many.

    Texture coordinates, normals and colours of a new vertex are those of its place on the edge.
    """
    total = 0
    for _ in range(ROUNDS):
        cuts = _cuts(draft.surface)
        if not cuts:
            break
        total += len(cuts)
        draft = draft.replace(parts=_cut(draft.parts, cuts))
    if not total:
        return draft
    note = warning("MSH044", "edges", f"{total} edges were cut where corners of other faces end on them")
    return draft.replace(notes=draft.noted(note))


def _cuts(surface: Surface) -> list[_Cut]:
    """At most one cut of each face."""
    points, ids = surface.points, surface.welded_faces
    ends = np.stack([ids, np.roll(ids, -1, axis=1)], axis=2).reshape(-1, 2)
    key = np.sort(ends, axis=1) @ np.array([len(points), 1])
    _, of, uses = np.unique(key, return_inverse=True, return_counts=True)
    bare = np.flatnonzero(uses[of] == 1)
    if not 3 <= len(bare) <= MOST_EDGES:
        return []
    open_keys = set(key[bare].tolist())
    rim = np.unique(ends[bare])
    tree = cKDTree(points[rim])
    off = MAX_OFF_SHARE * float(np.ptp(points, axis=0).max())
    first, second = points[ends[bare, 0]], points[ends[bare, 1]]
    length = np.linalg.norm(second - first, axis=1)
    near = tree.query_ball_point((first + second) / 2, length / 2, return_sorted=True)
    found: list[_Cut] = []
    taken: set[int] = set()
    for row, edge in enumerate(bare.tolist()):
        if len(near[row]) < 3 or edge // 3 in taken:
            continue
        a, b = ends[edge]
        way = _on_the_way(points, rim[near[row]], int(a), int(b), min(off, MAX_OFF_EDGE_SHARE * float(length[row])))
        if len(way) and _all_met(np.array([a, *way, b]), open_keys, len(points)):
            taken.add(edge // 3)
            found.append(_Cut(edge // 3, edge % 3, points[way]))
    return found


def _on_the_way(points: Floats, some: Ints, a: int, b: int, off: float) -> Ints:
    """Those of some points that lie on the edge from a to b, in that order."""
    along = points[b] - points[a]
    square = max(float(along @ along), 1e-300)
    at = (points[some] - points[a]) @ along / square
    apart = np.linalg.norm(points[some] - points[a] - at[:, None] * along, axis=1)
    good = (apart <= off) & (at > 0) & (at < 1) & (some != a) & (some != b)
    ordered: Ints = some[good][np.argsort(at[good], kind="stable")]
    return ordered


def _all_met(way: Ints, open_keys: set[int], count: int) -> bool:
    ends = np.sort(np.stack([way[:-1], way[1:]], axis=1), axis=1)
    return all(k in open_keys for k in (ends @ np.array([count, 1])).tolist())


def _cut(parts: tuple[RawPart, ...], cuts: list[_Cut]) -> tuple[RawPart, ...]:
    ends = np.cumsum([len(p.mesh.faces) for p in parts])
    own: dict[int, list[_Cut]] = {}
    for cut in cuts:
        i = int(np.searchsorted(ends, cut.face, side="right"))
        own.setdefault(i, []).append(_Cut(cut.face - int(ends[i]) + len(parts[i].mesh.faces), cut.edge, cut.places))
    return tuple(p.replace(mesh=_with_cuts(p.mesh, own[i])) if i in own else p for i, p in enumerate(parts))


def _with_cuts(mesh: Mesh, cuts: list[_Cut]) -> Mesh:
    """The mesh with each face that is cut made a fan from its corner across."""
    columns = {n: getattr(mesh, n) for n in ("uv", "normals", "colors") if getattr(mesh, n) is not None}
    more: dict[str, list[npt.NDArray[np.generic]]] = {n: [] for n in columns}
    places, faces, count = [], [], len(mesh.vertices)
    for cut in cuts:
        a, b, across = (int(v) for v in np.roll(mesh.faces[cut.face], -cut.edge))
        first, along = mesh.vertices[a], mesh.vertices[b] - mesh.vertices[a]
        share = np.clip((cut.places - first) @ along / max(float(along @ along), 1e-300), 0, 1)[:, None]
        for name, values in columns.items():
            more[name].append(_between(name, values[a], values[b], share))
        places.append(cut.places)
        way = [a, *range(count, count + len(cut.places)), b]
        count += len(cut.places)
        faces += [(p, q, across) for p, q in pairwise(way)]
    rest = np.delete(mesh.faces, [cut.face for cut in cuts], axis=0)
    full = {n: np.vstack([columns[n], *more[n]]) for n in columns}
    return Mesh(vertices=np.vstack([mesh.vertices, *places]), faces=np.vstack([rest, np.array(faces)]), **full)


def _between(
    name: str, one: npt.NDArray[np.generic], other: npt.NDArray[np.generic], share: Floats
) -> npt.NDArray[np.generic]:
    """(K, C) values at shares of the way from one vertex to another."""
    mixed = (1 - share) * one.astype(np.float64) + share * other.astype(np.float64)
    if name == "colors":
        return np.rint(mixed).astype(np.uint8)
    if name == "normals":
        length = np.linalg.norm(mixed, axis=1, keepdims=True)
        return np.where(length > 1e-6, mixed / np.maximum(length, 1e-30), one)
    return mixed
