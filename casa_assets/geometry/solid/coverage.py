"""Sample a surface, and measure how far the samples lie outside convex shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.solid.hull import hull_planes


def surface_samples(points: Floats, faces: Ints, count: int) -> Floats:
    """(count, 3) points spread evenly over the area, the same for the same surface."""
    return samples_with_faces(points, faces, count)[0]


def samples_with_faces(points: Floats, faces: Ints, count: int) -> tuple[Floats, Ints]:
    """(count, 3) points spread evenly over the area, the same for the same surface, and the face of each.

    Ref: systematic sampling of the cumulative area, and the R2 sequence (Roberts 2018) within the triangles.
    """
    face, u, v = barycentric_samples(points, faces, count)
    a, b, c = (points[faces[face, k]] for k in range(3))
    samples: Floats = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return samples, face


def barycentric_samples(points: Floats, faces: Ints, count: int) -> tuple[Ints, Floats, Floats]:
    """(count,) faces of the samples, and their weights of the second and of the third corner."""
    ends = np.cumsum(face_normals(points, faces)[1])
    at = (np.arange(count) + 0.5) / count * ends[-1]
    face = np.minimum(np.searchsorted(ends, at), len(faces) - 1)
    step = np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])
    u, v = (step % 1.0).T
    beyond = u + v > 1
    return face.astype(np.int64), np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)


def distances_outside_hulls(samples: Floats, clouds: Sequence[Floats]) -> Floats:
    """(N,) distance of each sample from the nearest hull, 0 within one; metres.

    Measured to the planes of the faces: exact over faces, a little short over edges and corners.

    Args:
        samples: (N, 3). clouds: vertices of each convex shape.
    Raises:
        DegenerateShape: a cloud spans no volume.
    """
    nearest = np.full(len(samples), np.inf)
    for cloud in clouds:
        planes = hull_planes(cloud)
        for start in range(0, len(samples), 4096):
            rows = slice(start, start + 4096)
            outside = (samples[rows] @ planes[:, :3].T + planes[:, 3]).max(axis=1)
            nearest[rows] = np.minimum(nearest[rows], np.maximum(outside, 0.0))
    return nearest
