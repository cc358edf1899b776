"""Split a surface into connected components, with the bounding box of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.topology import face_components


@dataclass(frozen=True)
class Components:
    """Components of a surface, connected over shared points and numbered by their first face.

    Attributes:
        points: (P, 3) welded. faces: (F, 3). label: (F,) component of each face.
        lower, upper: (N, 3) corners of the bounding boxes. longest_side: (N,) of each box.
    """

    points: Floats
    faces: Ints
    label: Ints
    lower: Floats
    upper: Floats
    longest_side: Floats

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.longest_side)

    def faces_of(self, component: int) -> Ints:
        """(K, 3) faces of one component."""
        faces: Ints = self.faces[self.label == component]
        return faces

    def surface_of(self, component: int) -> tuple[Floats, Ints]:
        """(P, 3) points and (F, 3) faces of one component alone."""
        used, local = np.unique(self.faces_of(component), return_inverse=True)
        return self.points[used], local.reshape(-1, 3)

    def extents_of(self, rows: Mask) -> Floats:
        """(3,) sides of the box around some components; zero if no components are given."""
        if not rows.any():
            return np.zeros(3)
        sides: Floats = self.upper[rows].max(axis=0) - self.lower[rows].min(axis=0)
        return sides


def split_components(vertices: Floats, faces: Ints, place: Ints) -> Components:
    """Split some faces of a surface into components.

    Args:
        vertices: (V, 3). faces: (F, 3). place: (V,) welded point of each vertex.
    """
    ids = place[faces]
    points = np.zeros((int(place.max()) + 1, 3))
    points[ids.ravel()] = vertices[faces.ravel()]
    label = face_components(ids, len(points))
    lower, upper = component_boxes(points[ids], label)
    return Components(points, ids, label, lower, upper, (upper - lower).max(axis=1))


def component_boxes(corners: Floats, label: Ints) -> tuple[Floats, Floats]:
    """(N, 3) lower and upper corners of the box around each component of some faces.

    Args:
        corners: (F, 3, 3) of the faces. label: (F,) component of each.
    """
    count = int(label.max()) + 1
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label, corners.min(axis=1))
    np.maximum.at(upper, label, corners.max(axis=1))
    return lower, upper


def box_gaps(lower: Floats, upper: Floats) -> Floats:
    """(N, N) distance between every two of N boxes, 0 where they meet."""
    gaps: Floats = np.linalg.norm(
        np.maximum(0, np.maximum(lower[:, None] - upper[None], lower[None] - upper[:, None])), axis=2
    )
    return gaps
