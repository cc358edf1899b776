"""Sample points on a mesh and compute its hull, as input of the pose estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.measure import solid_moments
from casa_assets.geometry.solid.coverage import samples_with_faces
from casa_assets.geometry.solid.hull import convex_hull

# Samples on a surface.
SAMPLES = 16000


@dataclass(frozen=True)
class SurfaceSample:
    """Samples and hull of a surface in file axes, scaled to a longest side of 1; origin at the hull's centre of mass.

    Attributes:
        samples: (N, 3) points spread evenly over the surface.
        hull_points, hull_faces: (M, 3) and (F, 3), wound so that the normals point outward.
        hull_volume: in the scaled units, cubed.
    """

    samples: Floats
    hull_points: Floats
    hull_faces: Ints
    hull_volume: float

    def rotated(self, rotation: Floats) -> tuple[Floats, Floats]:
        """Samples and hull points after a rotation (3, 3)."""
        return self.samples @ rotation.T, self.hull_points @ rotation.T


def sample_surface(points: Floats, faces: Ints) -> SurfaceSample:
    """Sample a surface and compute its hull.

    Args:
        points: (P, 3) finite. faces: (F, 3).
    Raises:
        DegenerateShape: the points span no volume.
    """
    longest = float(np.ptp(points, axis=0).max())
    if not np.isfinite(longest) or longest <= 0:
        raise DegenerateShape("the points have no extent")
    unit_points = (points - points.mean(axis=0)) / longest
    hull_points, hull_faces = convex_hull(unit_points)
    volume, center, _ = solid_moments(hull_points, hull_faces)
    samples = samples_with_faces(unit_points, faces, SAMPLES)[0]
    # Volumes are divided by that of the hull, so it is kept above zero.
    return SurfaceSample(samples - center, hull_points - center, hull_faces, max(volume, 1e-9))


def smallest_rectangle(points: Floats) -> tuple[float, float, float]:
    """Smallest rectangle around (N, 2) points: angle of its long side (0 <= radians < pi), long side, short side."""
    try:
        outline = points[ConvexHull(points).vertices]
    except QhullError:
        outline = points
    edges = np.roll(outline, -1, axis=0) - outline
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6))
    along = outline @ np.stack([np.cos(angles), np.sin(angles)])
    across = outline @ np.stack([-np.sin(angles), np.cos(angles)])
    long, wide = np.ptp(along, axis=0), np.ptp(across, axis=0)
    area = long * wide
    best = int(np.flatnonzero(area <= area.min() * (1 + 1e-6))[0])
    angle, a, b = float(angles[best]), float(long[best]), float(wide[best])
    if b > a * (1 + 1e-6):
        return (angle + np.pi / 2) % np.pi, b, a
    return angle % np.pi, a, b
