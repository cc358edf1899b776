"""Split a surface into connected pieces, with the bounding box of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.topology import face_components


@dataclass(frozen=True)
class Pieces:
    """Pieces of a surface joined over shared points, numbered by their first face.

    Attributes:
        points: (P, 3) welded. ids: (F, 3) faces that count. label: (F,) piece of each.
        low, high: (N, 3) boxes. size: (N,) longest side of each.
    """

    points: Floats
    ids: Ints
    label: Ints
    low: Floats
    high: Floats
    size: Floats

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.size)

    def faces(self, piece: int) -> Ints:
        """(K, 3) faces of one piece."""
        of_piece: Ints = self.ids[self.label == piece]
        return of_piece

    def spread(self, some: Mask) -> Floats:
        """(3,) sides of the box around some pieces; zero where there are none."""
        if not some.any():
            return np.zeros(3)
        sides: Floats = self.high[some].max(axis=0) - self.low[some].min(axis=0)
        return sides


def pieces_of(vertices: Floats, faces: Ints, place: Ints) -> Pieces:
    """Pieces of some faces.

    Args:
        vertices: (V, 3). faces: (F, 3). place: (V,) welded point of each vertex.
    """
    ids = place[faces]
    points = np.zeros((int(place.max()) + 1, 3))
    points[ids.ravel()] = vertices[faces.ravel()]
    label = face_components(ids, len(points))
    count = int(label.max()) + 1
    corners = points[ids]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    return Pieces(points, ids, label, low, high, (high - low).max(axis=1))


def box_gaps(low: Floats, high: Floats) -> Floats:
    """(N, N) distance between every two of N boxes, 0 where they meet."""
    apart: Floats = np.linalg.norm(
        np.maximum(0, np.maximum(low[:, None] - high[None], low[None] - high[:, None])), axis=2
    )
    return apart
