"""Weld arbitrary triangles into shared points, keeping an index back to the input faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import weld

Bools = npt.NDArray[np.bool_]

# Vertices closer than this part of the diagonal are one point. Ref: measured, parts of clean appliance meshes lie
# farther apart, float32 exports of one point nearer.
WELD_RELATIVE = 1e-5


@dataclass(frozen=True)
class TriangleSoup:
    """Welded triangles of all parts of a file as one set.

    Attributes:
        points: (P, 3) welded, any unit.
        faces: (F, 3) over the points, as many and in the order in which they came in; a triangle that welding
            collapses stays, with no area.
        normals: (F, 3) unit, zero where a face has no area. areas: (F,).
        duplicate_of: (F,) the first face with the same three points and the same side; itself where it is the first.
        tint: (F,) number of the material of each face; faces of two materials are not one piece of a thing.
    """

    points: Floats
    faces: Ints
    normals: Floats
    areas: Floats
    duplicate_of: Ints
    material_index: Ints

    @property
    def diagonal(self) -> float:
        """Return the diagonal of the box around all triangles."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0

    def transformed(self, rotation: Floats, origin: Floats, scale: float) -> TriangleSoup:
        """Return the triangles in another frame: `scale * rotation @ (point - origin)`; the rotation is proper."""
        points = (self.points - origin) @ rotation.T * scale
        return TriangleSoup(
            points, self.faces, self.normals @ rotation.T, self.areas * scale**2, self.duplicate_of, self.material_index
        )


def weld_triangles(vertices: Floats, faces: Ints, tint: Ints | None = None) -> TriangleSoup:
    """Weld triangles whose vertices nearly coincide.

    Args:
        vertices: (V, 3) finite. faces: (F, 3) within range. tint: (F,) materials, None where all have one.
    """
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    points, place = weld(vertices, WELD_RELATIVE * diagonal / max(extent, 1e-300))
    ids = place[faces]
    normals, areas = face_normals(points, ids)
    flat = (ids[:, 0] == ids[:, 1]) | (ids[:, 1] == ids[:, 2]) | (ids[:, 2] == ids[:, 0])
    areas = np.where(flat, 0.0, areas)
    plain = np.zeros(len(ids), dtype=np.int64)
    return TriangleSoup(points, ids, normals, areas, _twins(ids, len(points)), plain if tint is None else tint)


def _twins(faces: Ints, count: int) -> Ints:
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
    twin = np.empty(len(faces), dtype=np.int64)
    twin[order] = first[np.cumsum(new) - 1]
    return twin
