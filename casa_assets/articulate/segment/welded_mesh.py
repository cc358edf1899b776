"""Weld the triangles of a file into one mesh, and split it into fragments: connected pieces of surface.

Two faces belong to one fragment when they share an edge and a material: makers often give a door, its knobs and handles
materials of their own even where the mesh is one piece. Where more than two faces share an edge, solids touch each
other: those faces are paired so that each pair bounds one wedge of solid, which separates touching boxes again after
welding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.plan import Frame
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import merge_rows, weld
from casa_assets.model.ingest.source import RawModel

Bools = npt.NDArray[np.bool_]

# Vertices closer than this share of the diagonal are one point. Ref: measured, parts of clean appliance meshes lie
# farther apart, float32 exports of one point nearer.
WELD_RELATIVE = 1e-5
# Edges with more faces are faults of the mesh and join no fragments.
MAX_FACES_AT_EDGE = 12
# Faces whose directions around an edge differ by less, radians, lie on each other.
SAME_ANGLE = 1e-3


@dataclass(frozen=True)
class WeldedMesh:
    """All triangles of a file as one indexed mesh, in one frame, with what is derived from it once.

    Attributes:
        points: (P, 3) welded, any unit.
        faces: (F, 3) over the points, as many and in the order in which they came in; a triangle that welding
            collapses stays, with no area.
        normals: (F, 3) unit, zero where a face has no area. areas: (F,).
        duplicate_of: (F,) the first face with the same three points and the same side; itself where it is the first.
        material_index: (F,) number of the material of each face.
    """

    points: Floats
    faces: Ints
    normals: Floats
    areas: Floats
    duplicate_of: Ints
    material_index: Ints

    @cached_property
    def fragment_labels(self) -> Ints:
        """Return the (F,) fragment of each face, numbered by first face; -1 for faces without area."""
        alive = (self.duplicate_of == np.arange(len(self.faces))) & (self.areas > 0.0)
        index = np.flatnonzero(alive)
        labels = np.full(len(self.faces), -1, dtype=np.int64)
        if not len(index):
            return labels
        left, right = _adjacent_faces(self, index)
        alike = self.material_index[index[left]] == self.material_index[index[right]]
        left, right = left[alike], right[alike]
        graph = coo_matrix((np.ones(len(left), dtype=np.int8), (left, right)), shape=(len(index), len(index)))
        _, component = connected_components(graph, directed=False)
        _, labels[index] = merge_rows(component[:, None].astype(np.float64))
        return np.where(self.areas > 0.0, labels[self.duplicate_of], -1)

    @property
    def diagonal(self) -> float:
        """Return the diagonal of the box around all triangles."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0

    @property
    def footprint_center(self) -> Floats:
        """Return the (3,) middle of the footprint at the lowest point, in its frame: the origin of the asset."""
        lower, upper = self.points.min(axis=0), self.points.max(axis=0)
        return np.array([(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, lower[2]])

    def in_frame(self, frame: Frame) -> WeldedMesh:
        """Return a mesh that is in file axes and units in the frame, where its diagonal is 1."""
        return self.transformed(frame.rotation, np.array(frame.origin), frame.scale)

    def transformed(self, rotation: Floats, origin: Floats, scale: float) -> WeldedMesh:
        """Return the mesh in another frame: `scale * rotation @ (point - origin)`; the rotation is proper."""
        points = (self.points - origin) @ rotation.T * scale
        return WeldedMesh(
            points, self.faces, self.normals @ rotation.T, self.areas * scale**2, self.duplicate_of, self.material_index
        )


def weld_triangles(vertices: Floats, faces: Ints, materials: Ints | None = None) -> WeldedMesh:
    """Weld triangles whose vertices nearly coincide.

    Args:
        vertices: (V, 3) finite. faces: (F, 3) within range. materials: (F,) number of each, None where all have one.
    """
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    points, place = weld(vertices, WELD_RELATIVE * diagonal / max(extent, 1e-300))
    ids = place[faces]
    normals, areas = face_normals(points, ids)
    collapsed = (ids[:, 0] == ids[:, 1]) | (ids[:, 1] == ids[:, 2]) | (ids[:, 2] == ids[:, 0])
    areas = np.where(collapsed, 0.0, areas)
    if materials is None:
        materials = np.zeros(len(ids), dtype=np.int64)
    return WeldedMesh(points, ids, normals, areas, _first_duplicates(ids), materials)


def weld_model(model: RawModel, by_material: bool = True) -> WeldedMesh:
    """Weld all triangles of a model, part by part, in file axes and units.

    Args:
        by_material: parts of different materials are different fragments.
    """
    starts = np.cumsum([0, *(len(p.mesh.vertices) for p in model.parts[:-1])])
    faces = [p.mesh.faces.astype(np.int64) + s for p, s in zip(model.parts, starts, strict=True)]
    numbers: dict[str, int] = {}
    ids = ["" if p.material is None else p.material.id for p in model.parts]
    materials = [np.full(len(f), numbers.setdefault(k, len(numbers))) for f, k in zip(faces, ids, strict=True)]
    vertices = np.concatenate([p.mesh.vertices for p in model.parts])
    return weld_triangles(vertices, np.concatenate(faces), np.concatenate(materials) if by_material else None)


def _first_duplicates(faces: Ints) -> Ints:
    """Return the (F,) index of the first face that has the same points in the same winding."""
    if not len(faces):
        return np.empty(0, dtype=np.int64)
    start = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))
    turned = np.stack([faces[rows, (start + k) % 3] for k in range(3)], axis=1)
    order = np.lexsort((rows, turned[:, 2], turned[:, 1], turned[:, 0]))
    new = np.ones(len(faces), dtype=bool)
    new[1:] = (turned[order][1:] != turned[order][:-1]).any(axis=1)
    first = order[np.flatnonzero(new)]
    duplicate = np.empty(len(faces), dtype=np.int64)
    duplicate[order] = first[np.cumsum(new) - 1]
    return duplicate


def _adjacent_faces(mesh: WeldedMesh, index: Ints) -> tuple[Ints, Ints]:
    """Return pairs of places in `index` of faces that share an edge and bound one solid."""
    faces = mesh.faces[index]
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
            a, b = _wedges(mesh, index, ends[at], owner[rows], forward[rows])
            left.append(a)
            right.append(b)
    return np.concatenate(left), np.concatenate(right)


def _wedges(mesh: WeldedMesh, index: Ints, ends: Ints, owner: Ints, forward: Bools) -> tuple[Ints, Ints]:
    """Pair the faces around an edge so that each pair bounds one wedge of solid; none where windings contradict."""
    none = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    a, b = mesh.points[ends[0]], mesh.points[ends[1]]
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    middle = mesh.points[mesh.faces[index[owner]]].sum(axis=1) - a - b
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
