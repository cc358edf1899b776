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

# Largest distance of a corner from the edge that it lies on, as a share of the longest side and of the edge; choices.
MAX_OFF_SHARE = 2e-3
MAX_OFF_EDGE_SHARE = 0.1
# Each round cuts a face along one of its edges.
MAX_ROUNDS = 6
# With more open edges than these the mesh is loose triangles and is left as it is.
MAX_OPEN_EDGES = 20_000


@dataclass(frozen=True)
class _Cut:
    """A face, which of its edges (0 to 2), and the (K, 3) points on that edge from its start to its end."""

    face: int
    edge: int
    points_on_edge: Floats


def split_t_junctions(draft: Draft) -> Draft:
    """Split faces whose open edge is met by shorter open edges, where all of it is met; a note says how many.

    Texture coordinates, normals and colours of a new vertex are those of its place on the edge.
    """
    total = 0
    for _ in range(MAX_ROUNDS):
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
    edge_points = np.stack([ids, np.roll(ids, -1, axis=1)], axis=2).reshape(-1, 2)
    edge_key = np.sort(edge_points, axis=1) @ np.array([len(points), 1])
    _, edge_of, uses = np.unique(edge_key, return_inverse=True, return_counts=True)
    open_edges = np.flatnonzero(uses[edge_of] == 1)
    if not 3 <= len(open_edges) <= MAX_OPEN_EDGES:
        return []
    open_keys = set(edge_key[open_edges].tolist())
    rim_points = np.unique(edge_points[open_edges])
    tree = cKDTree(points[rim_points])
    max_offset = MAX_OFF_SHARE * float(np.ptp(points, axis=0).max())
    first, second = points[edge_points[open_edges, 0]], points[edge_points[open_edges, 1]]
    length = np.linalg.norm(second - first, axis=1)
    nearby = tree.query_ball_point((first + second) / 2, length / 2, return_sorted=True)
    cuts: list[_Cut] = []
    faces_cut: set[int] = set()
    for row, edge in enumerate(open_edges.tolist()):
        if len(nearby[row]) < 3 or edge // 3 in faces_cut:
            continue
        a, b = edge_points[edge]
        on_edge = _points_on_edge(
            points, rim_points[nearby[row]], int(a), int(b), min(max_offset, MAX_OFF_EDGE_SHARE * float(length[row]))
        )
        if len(on_edge) and _are_all_open(np.array([a, *on_edge, b]), open_keys, len(points)):
            faces_cut.add(edge // 3)
            cuts.append(_Cut(edge // 3, edge % 3, points[on_edge]))
    return cuts


def _points_on_edge(points: Floats, candidates: Ints, a: int, b: int, max_offset: float) -> Ints:
    """Those of the candidates that lie on the edge from a to b, in that order."""
    along = points[b] - points[a]
    square = max(float(along @ along), 1e-300)
    fraction = (points[candidates] - points[a]) @ along / square
    distance = np.linalg.norm(points[candidates] - points[a] - fraction[:, None] * along, axis=1)
    is_on_edge = (distance <= max_offset) & (fraction > 0) & (fraction < 1) & (candidates != a) & (candidates != b)
    ordered: Ints = candidates[is_on_edge][np.argsort(fraction[is_on_edge], kind="stable")]
    return ordered


def _are_all_open(chain: Ints, open_keys: set[int], count: int) -> bool:
    edges = np.sort(np.stack([chain[:-1], chain[1:]], axis=1), axis=1)
    return all(k in open_keys for k in (edges @ np.array([count, 1])).tolist())


def _cut(parts: tuple[RawPart, ...], cuts: list[_Cut]) -> tuple[RawPart, ...]:
    face_ends = np.cumsum([len(p.mesh.faces) for p in parts])
    cuts_of_part: dict[int, list[_Cut]] = {}
    for cut in cuts:
        i = int(np.searchsorted(face_ends, cut.face, side="right"))
        cuts_of_part.setdefault(i, []).append(
            _Cut(cut.face - int(face_ends[i]) + len(parts[i].mesh.faces), cut.edge, cut.points_on_edge)
        )
    return tuple(
        p.replace(mesh=_with_cuts(p.mesh, cuts_of_part[i])) if i in cuts_of_part else p for i, p in enumerate(parts)
    )


def _with_cuts(mesh: Mesh, cuts: list[_Cut]) -> Mesh:
    """The mesh with each face that is cut replaced by a fan around the corner opposite to the cut edge."""
    columns = {n: getattr(mesh, n) for n in ("uv", "normals", "colors") if getattr(mesh, n) is not None}
    added: dict[str, list[npt.NDArray[np.generic]]] = {n: [] for n in columns}
    points_on_edge, faces, count = [], [], len(mesh.vertices)
    for cut in cuts:
        a, b, apex = (int(v) for v in np.roll(mesh.faces[cut.face], -cut.edge))
        first, along = mesh.vertices[a], mesh.vertices[b] - mesh.vertices[a]
        share = np.clip((cut.points_on_edge - first) @ along / max(float(along @ along), 1e-300), 0, 1)[:, None]
        for name, values in columns.items():
            added[name].append(_between(name, values[a], values[b], share))
        points_on_edge.append(cut.points_on_edge)
        chain = [a, *range(count, count + len(cut.points_on_edge)), b]
        count += len(cut.points_on_edge)
        faces += [(p, q, apex) for p, q in pairwise(chain)]
    rest = np.delete(mesh.faces, [cut.face for cut in cuts], axis=0)
    new_columns = {n: np.vstack([columns[n], *added[n]]) for n in columns}
    return Mesh(
        vertices=np.vstack([mesh.vertices, *points_on_edge]), faces=np.vstack([rest, np.array(faces)]), **new_columns
    )


def _between(
    name: str, start: npt.NDArray[np.generic], end: npt.NDArray[np.generic], fraction: Floats
) -> npt.NDArray[np.generic]:
    """(K, C) values of a column, interpolated at fractions (K, 1) of the way from one vertex to another."""
    mixed = (1 - fraction) * start.astype(np.float64) + fraction * end.astype(np.float64)
    if name == "colors":
        return np.rint(mixed).astype(np.uint8)
    if name == "normals":
        length = np.linalg.norm(mixed, axis=1, keepdims=True)
        return np.where(length > 1e-6, mixed / np.maximum(length, 1e-30), start)
    return mixed
