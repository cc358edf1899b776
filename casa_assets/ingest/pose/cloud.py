"""Sample points on a mesh and wrap it in its hull, as input of the pose estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.measure import solid_moments
from casa_assets.geometry.solid.coverage import samples_with_faces
from casa_assets.geometry.solid.hull import convex_hull

SAMPLES = 16000


@dataclass(frozen=True)
class SurfaceSample:
    """A surface in the axes and units of its file, moved to its hull's centre and scaled to a longest side of 1.

    Attributes:
        samples: (N, 3) points spread evenly over the surface.
        shell, triangles: its hull, (M, 3) points and (F, 3) outward faces; the hull's centre of mass is the origin.
        volume: of the hull.
    """

    samples: Floats
    shell: Floats
    triangles: Ints
    volume: float

    def turned(self, turn: Floats) -> tuple[Floats, Floats]:
        """Samples and hull points after a rotation (3, 3)."""
        return self.samples @ turn.T, self.shell @ turn.T


def sample_surface(points: Floats, faces: Ints) -> SurfaceSample:
    """Spread points over a surface and wrap it.

    Args:
        points: (P, 3) finite. faces: (F, 3).
    Raises:
        DegenerateShape: the points span no volume.
    """
    longest = float(np.ptp(points, axis=0).max())
    if not np.isfinite(longest) or longest <= 0:
        raise DegenerateShape("the points have no extent")
    small = (points - points.mean(axis=0)) / longest
    shell, triangles = convex_hull(small)
    volume, center, _ = solid_moments(shell, triangles)
    samples = samples_with_faces(small, faces, SAMPLES)[0]
    return SurfaceSample(samples - center, shell - center, triangles, max(volume, 1e-9))


def plan_axes(points: Floats) -> tuple[float, float, float]:
    """Direction (0 <= radians < pi) of the long side of the smallest rectangle around (N, 2) points, and its sides."""
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
