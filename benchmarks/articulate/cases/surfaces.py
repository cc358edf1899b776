"""Changes of how a surface is stored or sampled; which part a face belongs to stays as it was.

Each takes a labelled mesh and a random generator and returns a labelled mesh; lengths are shares of the diagonal.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from opengl_decimate import SimplifyOptions, collapse_sequence
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from benchmarks.articulate.cases.labelled import LabelledMesh
from casa_assets.articulate.segment.orthographic import render_depth
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.deviation import fibonacci_directions
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import face_components, weld

# Vertices closer than this share of the longest side are at one position: exporters write six digits or more.
SAME_POSITION = 1e-6
# Cosine between the normals of two faces that a modeller drew as one flat face.
FLAT_COSINE = 0.9999
# The same for one smooth face: exporters split at angles over 30 degrees.
SMOOTH_COSINE = 0.866
# Jitter of the vertices, root of the mean square, share of the diagonal.
NOISE = (0.001, 0.002)
# Share of the area that is missing, the number of holes, and how much of a face counts for where a hole ends.
MISSING, HOLES = (0.02, 0.04), (6, 14)
# Share of the faces that stay, and the error that simplification may make, share of a part's size.
KEPT, SIMPLIFY_ERROR = (0.25, 0.5), 0.004
# Points stay where they are, and none on a border goes.
OPTIONS = SimplifyOptions(target_ratio=1.0, placement="endpoint", lock_boundary=True)
# Faces beyond which no side is halved any more.
MOST_FACES = 60_000
# Triangles of a face of which some sides are halved, over its corners (0 to 2) and the middles of the sides that
# begin there (3 to 5).
_HALVES = {
    (True, False, False): ((0, 3, 2), (3, 1, 2)),
    (True, True, False): ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    (True, True, True): ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}
# Directions from which the outside is looked at, pixels along the longer side of each picture, and how far behind the
# picture a point of a face may lie and still be seen, share of the diagonal.
LOOKS, LOOK_PX, SEEN_DEPTH = 40, 320, 0.002
# A part with less of its area to be seen than this is not to be found any more.
LEAST_SEEN = 0.04


def double_faces(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Each face once more with reversed winding; of half the meshes only in a random half of the components."""
    rows = np.arange(len(mesh.faces))
    if rng.random() < 0.5:
        label = face_components(mesh.faces, len(mesh.points))
        rows = np.flatnonzero((rng.random(int(label.max()) + 1) < 0.5)[label])
    back = mesh.faces[rows][:, ::-1]
    if rng.random() < 0.5:  # with vertices of their own, where normals are stored by vertex
        doubled = mesh.added(mesh.points, back, mesh.part[rows])
        return replace(doubled, handle=np.concatenate([mesh.handle, mesh.handle[rows]]))
    return replace(
        mesh,
        faces=np.concatenate([mesh.faces, back]),
        part=np.concatenate([mesh.part, mesh.part[rows]]),
        handle=np.concatenate([mesh.handle, mesh.handle[rows]]),
    )


def by_position(mesh: LabelledMesh) -> LabelledMesh:
    """Vertices at one position become one; faces that this collapses are left out."""
    points, place = weld(mesh.points, SAME_POSITION)
    faces = place[mesh.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return replace(mesh, points=points, faces=faces).with_faces(whole)


def split_groups(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Faces of a part are one component only where they are connected and flat, or of half the meshes smooth."""
    left, right, _ = _flat_pairs(mesh, FLAT_COSINE if rng.random() < 0.5 else SMOOTH_COSINE)
    count = len(mesh.faces)
    graph = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(count, count))
    return _apart(mesh, connected_components(graph, directed=False)[1].astype(np.int64))


def loose_pieces(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Each quad, two triangles of one plane, has vertices of its own; what has no partner is a triangle."""
    left, right, length = _flat_pairs(mesh, FLAT_COSINE)
    group = np.arange(len(mesh.faces))
    taken = np.zeros(len(mesh.faces), dtype=bool)
    for i in np.argsort(-length, kind="stable").tolist():  # the diagonal of a quad is its longest edge
        a, b = int(left[i]), int(right[i])
        if not (taken[a] or taken[b]):
            taken[a] = taken[b] = True
            group[b] = group[a]
    return _apart(mesh, group)


def noise(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Positions jittered; vertices at one position move together."""
    _, place = weld(mesh.points, SAME_POSITION)
    spread = float(rng.uniform(*NOISE)) * mesh.diagonal / np.sqrt(3.0)
    moved = rng.normal(0.0, spread, (int(place.max()) + 1, 3))
    return mesh.with_points(mesh.points + moved[place])


def holes(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Patches of faces are missing; large faces are cut small first, so that a patch is no whole door."""
    fine = refined(mesh, 0.03 * mesh.diagonal)
    centers, areas = fine.points[fine.faces].mean(axis=1), fine.areas
    wanted, count = float(rng.uniform(*MISSING)) * areas.sum(), int(rng.integers(*HOLES))
    seeds = centers[rng.choice(len(centers), count, p=areas / areas.sum())]
    gone = np.zeros(len(centers), dtype=bool)
    for seed in seeds:
        order = np.argsort(np.linalg.norm(centers - seed, axis=1), kind="stable")
        gone[order[np.cumsum(areas[order]) <= wanted / count]] = True
    return fine.with_faces(~gone)


def refined(mesh: LabelledMesh, length: float) -> LabelledMesh:
    """Sides that are longer are halved until none is, or there are MOST_FACES; faces on both sides follow."""
    while len(mesh.faces) < MOST_FACES:
        ends = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2)
        long = np.linalg.norm(mesh.points[ends[..., 0]] - mesh.points[ends[..., 1]], axis=2) > length
        if not long.any():
            break
        size = len(mesh.points)
        keys = ends.min(axis=2) * size + ends.max(axis=2)
        halved = np.unique(keys[long])
        middle = np.where(long, size + np.searchsorted(halved, keys), -1)
        pieces, source = [mesh.faces[~long.any(axis=1)]], [np.flatnonzero(~long.any(axis=1))]
        for pattern, triangles in _HALVES.items():
            for turn in range(3):
                chosen = (np.roll(long, -turn, axis=1) == np.array(pattern)).all(axis=1)
                if pattern == (True, True, True) and turn:
                    continue
                rows = np.flatnonzero(chosen)
                six = np.concatenate([np.roll(mesh.faces, -turn, axis=1), np.roll(middle, -turn, axis=1)], axis=1)[rows]
                pieces += [six[:, list(t)] for t in triangles]
                source += [rows] * len(triangles)
        origin = np.concatenate(source)
        order = np.argsort(origin, kind="stable")
        mesh = LabelledMesh(
            np.concatenate([mesh.points, (mesh.points[halved // size] + mesh.points[halved % size]) / 2]),
            np.concatenate(pieces)[order],
            mesh.part[origin[order]],
            mesh.handle[origin[order]],
            mesh.truth,
        )
    return mesh


def decimated(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Each part simplified by itself to a share of its faces; borders between parts stay."""
    share = float(rng.uniform(*KEPT))
    whole = by_position(mesh)
    pieces = []
    for number in np.unique(whole.part).tolist():
        rows = np.flatnonzero(whole.part == number)
        used, at = np.unique(whole.faces[rows], return_inverse=True)
        points = whole.points[used]
        sequence = collapse_sequence({"POSITION": points}, at.ravel(), OPTIONS)
        error = SIMPLIFY_ERROR * float(np.ptp(points, axis=0).max())
        steps = sequence.steps_for(target_count=max(4, int(share * len(rows))), target_error=error)
        pieces.append((used[sequence.state(steps)[3]], number))
    faces = np.concatenate([f for f, _ in pieces])
    part = np.concatenate([np.full(len(f), n, dtype=np.int64) for f, n in pieces])
    return LabelledMesh(whole.points, faces, part, np.zeros(len(faces), dtype=bool), mesh.truth)


def empty_inside(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Only faces that are seen from outside; a part of which hardly anything is left goes with all its faces."""
    seen = seen_faces(mesh.points, mesh.faces)
    areas = mesh.areas
    for row in mesh.parts:
        mine = mesh.part == row["id"]
        if areas[mine & seen].sum() < LEAST_SEEN * areas[mine].sum():
            seen &= ~mine
    return mesh.with_faces(seen)


def seen_faces(points: Floats, faces: Ints) -> Mask:
    """(F,) faces of which a corner, the middle of a side or the centre is seen from some direction around."""
    diagonal = float(np.linalg.norm(np.ptp(points[faces].reshape(-1, 3), axis=0)))
    corners = points[faces]
    inner = 0.96 * corners + 0.04 * corners.mean(axis=1, keepdims=True)
    middles = (inner + np.roll(inner, -1, axis=1)) / 2
    samples = np.concatenate([inner, middles, corners.mean(axis=1, keepdims=True)], axis=1)
    looks = np.concatenate([fibonacci_directions(LOOKS), np.eye(3), -np.eye(3)])
    shown, close = np.zeros(len(faces), dtype=np.int64), np.zeros(len(faces), dtype=bool)
    for view in looks:
        right = np.cross(view, np.eye(3)[int(np.argmin(np.abs(view)))])
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(view, right), view])
        image = render_depth(points, faces, axes, LOOK_PX)
        shown += np.bincount(image.face[image.face >= 0].ravel(), minlength=len(faces))
        flat = samples.reshape(-1, 3) @ axes.T
        row, column = image.rows_columns(flat[:, :2])
        behind = flat[:, 2] - (points @ axes[2]).min() - image.depth[row, column]
        close |= (behind < SEEN_DEPTH * diagonal).reshape(len(faces), -1).any(axis=1)
    small = face_normals(points, faces)[1] < (diagonal / LOOK_PX) ** 2
    return (shown > 2) | (small & close)


def _apart(mesh: LabelledMesh, group: Ints) -> LabelledMesh:
    """Vertices of their own for each group of faces."""
    keys = np.repeat(group, 3) * len(mesh.points) + mesh.faces.ravel()
    found, at = np.unique(keys, return_inverse=True)
    return replace(mesh, points=mesh.points[found % len(mesh.points)], faces=at.reshape(-1, 3).astype(np.int64))


def _flat_pairs(mesh: LabelledMesh, cosine: float) -> tuple[Ints, Ints, Floats]:
    """Pairs of faces of one part that share an edge by position and whose normals differ little; the edges' lengths."""
    points, place = weld(mesh.points, SAME_POSITION)
    ids = place[mesh.faces]
    ends = np.sort(np.stack([ids, np.roll(ids, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(ids)), 3)
    edge = ends[:, 0] * len(points) + ends[:, 1]
    order = np.argsort(edge, kind="stable")
    first = np.flatnonzero(edge[order][1:] == edge[order][:-1])
    left, right = face[order[first]], face[order[first + 1]]
    normals, _ = face_normals(mesh.points, mesh.faces)
    alike = ((normals[left] * normals[right]).sum(axis=1) > cosine) & (mesh.part[left] == mesh.part[right])
    first = first[alike]
    a, b = ends[order[first]].T
    return left[alike], right[alike], np.linalg.norm(points[a] - points[b], axis=1)
