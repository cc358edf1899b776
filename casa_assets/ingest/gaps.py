"""Close gaps: T-junctions, cracks a hair wide, and small holes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.ingest.draft import Draft, Surface, warning
from casa_assets.mesh.surface import connected_groups, directed_edges, edge_counts, picked
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Issue
from casa_assets.model.source import RawPart

# Largest distance of a corner from the edge that it lies on, as a share of the longest side and of the edge; choices.
MAX_OFF_SHARE, MAX_OFF_EDGE_SHARE = 2e-3, 0.1
# Each round cuts a face along one of its edges.
MAX_ROUNDS = 6
# With more open edges than these the mesh is loose triangles and is left as it is.
MAX_OPEN_EDGES = 20_000
# Largest width of a crack, as a share of the longest side, and of the shortest edge at its ends; choices.
MAX_WIDTH, MAX_WIDTH_OF_EDGE = 7e-3, 0.2
# Points whose joining closes nothing are left out and the rest is tried again, this many times.
ROUNDS = 4
# More pairs of near points than this, each counted twice, are not tried: they would take gigabytes.
MAX_PAIRS = 40_000_000
# All numbers below are choices.
# Largest side of the box around a small hole, as a share of the longest side of the mesh, and most edges of its rim.
MAX_HOLE_WIDTH, MAX_EDGES = 0.03, 24
# A rim of this many edges whose distances from its centre deviate by less than this share is round: drilled on purpose.
MIN_ROUND_EDGES, ROUND_DEVIATION = 6, 0.1
# A hole that was cut by a repair may be this many times wider, and with no more edges than these its rim may be bent.
CUT_WIDER, FEW_EDGES = 3, 8
# Distance, as a share of the largest width, below which a point of a rim is a corner that was cut out.
SAME_POINT_SHARE = 1e-3
# A side is missing where a rim lies in a plane, and all of the mesh behind it, to this share of the longest side.
SIDE_SHARE = 0.04
# Smallest cosine between a face of the fan and the mean normal: a fan must not fold.
MIN_FAN_COSINE = 0.2


@dataclass(frozen=True)
class _Cut:
    """A face, which of its edges (0 to 2), and the (K, 3) points on that edge from its start to its end."""

    face: int
    edge: int
    points_on_edge: Floats


def split_t_junctions(draft: Draft) -> Draft:
    """Split faces whose open edge is met all along by shorter ones, with a note; new vertices are between its ends."""
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
        reach = min(max_offset, MAX_OFF_EDGE_SHARE * float(length[row]))
        candidates, along = rim_points[nearby[row]], points[b] - points[a]
        fraction = (points[candidates] - points[a]) @ along / max(float(along @ along), 1e-300)
        distance = np.linalg.norm(points[candidates] - points[a] - fraction[:, None] * along, axis=1)
        is_inner = (fraction > 0) & (fraction < 1) & (candidates != a) & (candidates != b)
        is_on_edge = (distance <= reach) & is_inner
        on_edge = candidates[is_on_edge][np.argsort(fraction[is_on_edge], kind="stable")]
        chain = np.array([a, *on_edge, b])
        parts = np.sort(np.stack([chain[:-1], chain[1:]], axis=1), axis=1) @ np.array([len(points), 1])
        if len(on_edge) and open_keys.issuperset(parts.tolist()):
            faces_cut.add(edge // 3)
            cuts.append(_Cut(edge // 3, edge % 3, points[on_edge]))
    return cuts


def _cut(parts: tuple[RawPart, ...], cuts: list[_Cut]) -> tuple[RawPart, ...]:
    face_ends = np.cumsum([len(p.mesh.faces) for p in parts])
    cuts_of_part: dict[int, list[_Cut]] = {}
    for cut in cuts:
        i = int(np.searchsorted(face_ends, cut.face, side="right"))
        face = cut.face - int(face_ends[i]) + len(parts[i].mesh.faces)
        cuts_of_part.setdefault(i, []).append(replace(cut, face=face))
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


def close_cracks(surface: Surface, keep: Mask) -> tuple[Floats, list[Issue]]:
    """(V, 3) vertices, some moved where that makes open edges meet, and a note if so; `keep`: (F,) faces that count."""
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
    sums = [np.bincount(cluster, weights=points[:, k], minlength=len(points)) for k in range(3)]
    mean = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    cluster_of_vertex = cluster[place]
    is_moved = count[cluster_of_vertex] > 1
    moved_vertices = np.where(is_moved[:, None], mean[cluster_of_vertex], vertices)
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
    return np.asarray(ends[near[np.lexsort((near[:, 1], near[:, 0]))]].astype(np.int64))


def _within(points: Floats, reach: Floats) -> Ints:
    """(N, 2) pairs of points that lie within the (P,) reach of both.

    One search with the longest reach would pair each point of a finely divided rim with thousands of neighbours. So
    points are searched by powers of two of their reach, together with all whose reach is longer.
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
    label = connected_groups(count, pairs[:, 0], pairs[:, 1])
    first = np.full(int(label.max()) + 1, count, dtype=np.int64)
    np.minimum.at(first, label, np.arange(count))
    return np.asarray(first[label])


def _useless_points(ids: Ints, cluster: Ints) -> Mask:
    """(P,) points whose joining to (P,) `cluster` closes no edge, collapses a face, or makes an edge of three faces."""
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
    a, b, c = merged_faces.T
    is_folded = (a == b) | (b == c) | (c == a)
    is_harmful[merged_faces[is_folded].ravel()] = True
    return np.asarray(moved & (is_harmful[cluster] | ~is_useful[cluster]))


def close_holes(draft: Draft, cut: Floats | None = None) -> Draft:
    """Close the small holes of the parts, with a note where there were some.

    Texture coordinates, normals and colours of the new vertex are means over the rim. Larger openings stay, and round
    ones, which are meant, unless their rim is at (N, 3) corners of faces that were cut out just before.
    """
    points, place = draft.surface.points, draft.surface.point_of_vertex
    max_width = MAX_HOLE_WIDTH * float(np.ptp(points, axis=0).max())
    cut_points = None if cut is None or not len(cut) else cKDTree(cut)
    loops = boundary_loops(draft.surface.faces, place)
    rims = [rim for rim in loops if _is_torn(points[place[rim[:, 0]]], max_width, cut_points)]
    if not rims:
        return draft
    message = f"{len(rims)} small holes of {sum(len(rim) for rim in rims)} edges were closed"
    return _closed(draft, rims).replace(notes=draft.noted(warning("MSH041", "holes", message)))


def close_missing_sides(draft: Draft) -> Draft:
    """Close flat sides that are missing altogether, such as the side that an object rested on when it was scanned.

    Only for objects that are full by their kind: a box without its lid may be meant to be open. A note is added if
    sides were closed; the new faces have the colours of the rim.
    """
    points, place = draft.surface.points, draft.surface.point_of_vertex
    loops = boundary_loops(draft.surface.faces, place)
    rims = [rim for rim in loops if _is_missing_side(points[place[rim[:, 0]]], points)]
    if not rims:
        return draft
    what = "a flat side that was missing was" if len(rims) == 1 else f"{len(rims)} flat sides that were missing were"
    note = warning("MSH026", "sides", f"{what} closed; a thing of this kind is full")
    return _closed(draft, rims).replace(notes=draft.noted(note))


def _closed(draft: Draft, rims: list[Ints]) -> Draft:
    points, place = draft.surface.points, draft.surface.point_of_vertex
    parts = list(draft.parts)
    starts = np.cumsum([0] + [len(p.mesh.vertices) for p in parts])
    for rim in rims:
        middle = points[place[rim[:, 0]]].mean(axis=0)
        part_index = np.searchsorted(starts, rim[:, 0], side="right") - 1
        for i in np.unique(part_index):
            part = parts[int(i)]
            mesh = _with_fan(part.mesh, rim[part_index == i] - starts[i], middle)
            parts[int(i)] = part.replace(mesh=mesh)
    return draft.replace(parts=tuple(parts))


def boundary_loops(faces: Ints, place: Ints) -> list[Ints]:
    """(K, 2) vertices of the edges of boundary loops that do not branch, against their faces; place: (V,) of weld."""
    edges = directed_edges(faces)
    edge_points, count = place[edges], int(place.max()) + 1
    forward, backward = edge_points[:, 0] * count + edge_points[:, 1], edge_points[:, 1] * count + edge_points[:, 0]
    open_edges = edges[~np.isin(backward, forward)][:, ::-1]
    open_edges = open_edges[np.lexsort((place[open_edges[:, 1]], place[open_edges[:, 0]]))]
    starts = place[open_edges[:, 0]].tolist()
    edge_from: dict[int, int] = {}
    branching: set[int] = set()
    for i, start in enumerate(starts):
        if start in edge_from:
            branching.add(start)
        edge_from[start] = i
    loops, done = [], np.zeros(len(open_edges), dtype=bool)
    for start_edge in range(len(open_edges)):
        loop: list[int] = []
        edge = start_edge
        while not done[edge]:
            done[edge] = True
            loop.append(edge)
            end = int(place[open_edges[edge, 1]])
            if end in branching or end not in edge_from:
                break
            edge = edge_from[end]
        is_whole = len(loop) >= 3 and edge == start_edge and place[open_edges[loop[-1], 1]] == starts[start_edge]
        if is_whole and starts[start_edge] not in branching:
            loops.append(open_edges[loop])
    return loops


def _is_torn(rim: Floats, max_width: float, cut_points: cKDTree | None) -> bool:
    """True if a (K, 3) rim is that of a tear: small, not round unless it was cut out before, flat enough for a fan."""
    was_cut_out = cut_points is not None and float(cut_points.query(rim)[0].max()) <= SAME_POINT_SHARE * max_width
    if len(rim) > MAX_EDGES or float(np.ptp(rim, axis=0).max()) > (CUT_WIDER if was_cut_out else 1) * max_width:
        return False
    middle = rim.mean(axis=0)
    distance = np.linalg.norm(rim - middle, axis=1)
    if was_cut_out and len(rim) <= FEW_EDGES:
        return True
    if not was_cut_out and len(rim) >= MIN_ROUND_EDGES and distance.std() < ROUND_DEVIATION * distance.mean():
        return False
    return _fan_normal(rim) is not None


def _is_missing_side(rim: Floats, points: Floats) -> bool:
    """True if a (K, 3) rim is that of a flat side, and all (P, 3) points of the mesh lie on one side of it."""
    longest = float(np.ptp(points, axis=0).max())
    normal = _fan_normal(rim)
    if normal is None or float(np.ptp(rim, axis=0).max()) <= MAX_HOLE_WIDTH * longest:
        return False
    height = (points - rim.mean(axis=0)) @ normal
    is_flat = float(np.ptp(rim @ normal)) <= SIDE_SHARE * longest
    return is_flat and float(height.max()) <= SIDE_SHARE * longest


def _fan_normal(rim: Floats) -> Floats | None:
    """Mean normal of the fan that closes a rim of (K, 3) points; None if the fan would fold."""
    fronts = _fronts(np.stack([rim, np.roll(rim, -1, axis=0)], axis=1), rim.mean(axis=0))
    mean = _mean_direction(fronts)
    is_folded = mean is None or not (fronts @ mean > MIN_FAN_COSINE * np.linalg.norm(fronts, axis=1)).all()
    return None if is_folded else mean


def _with_fan(mesh: Mesh, edges: Ints, middle: Floats) -> Mesh:
    """The mesh with a face from each of the (K, 2) edges to a new vertex.

    If a normal of the rim looks away from the new faces, as between two sides of an object, these get separate ones.
    """
    rim = edges.ravel()
    if mesh.normals is not None:
        fronts = _fronts(mesh.vertices[edges], middle)
        if not (np.einsum("kej,kj->ke", mesh.normals[edges], fronts) > 0).all():
            normal = _mean_direction(fronts)
            used, local = np.unique(rim, return_inverse=True)
            mesh = _with_copies(mesh, used, np.array([0.0, 0.0, 1.0]) if normal is None else normal)
            edges = local.reshape(-1, 2) + len(mesh.vertices) - len(used)
            rim = edges.ravel()
    center_index = len(mesh.vertices)
    normals = None
    if mesh.normals is not None:
        mean = mesh.normals[rim].mean(axis=0)
        length = float(np.linalg.norm(mean))
        normals = np.vstack([mesh.normals, mean / length if length > 1e-6 else mesh.normals[rim[0]]])
    colors = None
    if mesh.colors is not None:
        colors = np.vstack([mesh.colors, np.rint(mesh.colors[rim].mean(axis=0)).astype(np.uint8)])
    return Mesh(
        vertices=np.vstack([mesh.vertices, middle]),
        faces=np.vstack([mesh.faces, np.column_stack([edges, np.full(len(edges), center_index)])]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[rim].mean(axis=0)]),
        normals=normals,
        colors=colors,
    )


def _fronts(edges: Floats, middle: Floats) -> Floats:
    """(K, 3) normals, as long as twice the area, of the faces of a fan over (K, 2, 3) edges."""
    return np.asarray(np.cross(edges[:, 1] - edges[:, 0], middle - edges[:, 0]))


def _mean_direction(vectors: Floats) -> Floats | None:
    """Unit vector along the sum of (K, 3) vectors; None if they cancel out."""
    total = vectors.sum(axis=0)
    length = float(np.linalg.norm(total))
    return np.asarray(total / length) if length > 0 else None


def _with_copies(mesh: Mesh, vertices: Ints, normal: Floats) -> Mesh:
    assert mesh.normals is not None
    normals = np.vstack([mesh.normals, np.tile(normal, (len(vertices), 1))])
    rows = np.concatenate([np.arange(len(mesh.vertices)), vertices])
    return picked(mesh, rows, mesh.faces).replace(normals=normals)
