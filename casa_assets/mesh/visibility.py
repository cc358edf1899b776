"""Find the faces of a surface that are visible from outside, and from which side, by depth images of sampled points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import face_normals

# Points that are strewn, pixels along the longest side, and directions from which the pictures are taken besides those
# along the axes: so many points fall into a pixel that next to no gap shows what lies behind.
SAMPLES = 60_000
PIXELS = 40
DIRECTIONS = 24
# Cosine to the line of sight below which a face is seen too much from its edge to say which side is seen.
GRAZING_COSINE = 0.2
# How much deeper than the nearest point of its pixel a point may lie and still be seen, in pixels.
DEPTH_TOLERANCE_PX = 1.0


@dataclass(frozen=True)
class Visibility:
    """Result of rendering a surface from all around.

    Attributes:
        samples: (N, 3) points evenly over the area. face: (N,) the face of each.
        front, back: (N,) seen from its front, or with its back where no front lies as near, from some direction.
        behind: (D,) share of the silhouette that shows backs of faces, by direction.
        away: (D, 3) unit vectors, from the viewer to the thing.
    """

    samples: Floats
    face: Ints
    front: Mask
    back: Mask
    behind: Floats
    away: Floats


def measure_visibility(points: Floats, faces: Ints, count: int = SAMPLES) -> Visibility:
    """Measure how much of the faces, whose fronts are counterclockwise, is visible from outside, at `count` points."""
    samples, face = samples_with_faces(points, faces, count)
    normals = face_normals(points, faces)[0][face]
    cell = float(np.ptp(samples, axis=0).max()) / PIXELS
    front, back = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    away = np.concatenate([fibonacci_directions(DIRECTIONS), np.eye(3), -np.eye(3)])
    behind = np.zeros(len(away))
    for i, sight in enumerate(away):
        pixel, depth = _project(samples, sight, cell)
        nearest = np.full(int(pixel.max()) + 1, np.inf)
        np.minimum.at(nearest, pixel, depth)
        seen = depth <= nearest[pixel] + DEPTH_TOLERANCE_PX * cell
        facing = -(normals @ sight)
        ahead = np.zeros(len(nearest), dtype=bool)
        ahead[pixel[seen & (facing > 0)]] = True
        bare = seen & (facing < -GRAZING_COSINE) & ~ahead[pixel]
        front |= seen & (facing > GRAZING_COSINE)
        back |= bare
        showing = np.zeros(len(nearest), dtype=bool)
        showing[pixel[bare]] = True
        behind[i] = showing.sum() / np.isfinite(nearest).sum()
    return Visibility(samples, face, front, back, behind, away)


def fibonacci_directions(count: int) -> Floats:
    """(count, 3) unit vectors all around, evenly spread. Ref: Gonzalez 2010, the Fibonacci lattice."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def _project(samples: Floats, sight: Floats, cell: float) -> tuple[Ints, Floats]:
    """Pixel of each point, counted in one row, and its depth along the line of sight."""
    beside = np.cross(sight, np.eye(3)[int(np.argmin(np.abs(sight)))])
    beside /= np.linalg.norm(beside)
    plane = samples @ np.stack([beside, np.cross(sight, beside)], axis=1)
    at = np.floor((plane - plane.min(axis=0)) / max(cell, 1e-300)).astype(np.int64)
    width = int(at[:, 0].max()) + 1
    return at[:, 1] * width + at[:, 0], samples @ sight
