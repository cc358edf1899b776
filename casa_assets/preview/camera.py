"""Fit a camera to the points that a picture has to show."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats


@dataclass(frozen=True)
class View:
    """Direction, size and quality of a picture.

    Attributes:
        azimuth_deg: 0 looks at the front (which faces -y), positive walks round to the thing's right side (+x).
        elevation_deg: above the horizon; at least 12, or the end of the floor comes into sight.
        size_px: width and height.
        fill: fraction of the frame that the thing spans, in its wider direction.
        field_of_view_deg: full vertical angle; small ones flatten like a long lens.
        passes: drawings that are averaged; more make softer shadows and smoother edges.
    """

    azimuth_deg: float = 35.0
    elevation_deg: float = 25.0
    size_px: int = 512
    fill: float = 0.80
    field_of_view_deg: float = 22.0
    passes: int = 18


@dataclass(frozen=True)
class Camera:
    """A fitted camera.

    Attributes:
        position: (3,) metres, world frame.
        right, up, forward: (3,) unit vectors, world frame.
        half: tangent of half the field of view.
    """

    position: Floats
    right: Floats
    up: Floats
    forward: Floats
    half: float

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """(x, y, depth) of (N, 3) world points: x right and y up in -1..1 within the frame, depth in metres."""
        local = points - self.position
        depth = local @ self.forward
        return local @ self.right / (depth * self.half), local @ self.up / (depth * self.half), depth


def fit(points: Floats, view: View) -> Camera:
    """The camera that sees all points, centred, as large as `view.fill` allows.

    Args:
        points: (N, 3) metres, world frame.
        view: direction and fill.
    """
    azimuth, elevation = math.radians(view.azimuth_deg), math.radians(view.elevation_deg)
    flat = math.cos(elevation)
    forward = np.array([-math.sin(azimuth) * flat, math.cos(azimuth) * flat, -math.sin(elevation)])
    right = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    up = np.cross(right, forward)
    half = math.tan(math.radians(view.field_of_view_deg) / 2.0)
    slope = half * view.fill
    x, y, z = points @ right, points @ up, points @ forward
    # |x - center| <= slope * (z + distance) for all points is linear in (center, distance): two walls that meet.
    distance = max(float(np.max(v - slope * z) + np.max(-v - slope * z)) / (2.0 * slope) for v in (x, y))
    distance = max(distance, 1e-6 - float(z.min()))
    across, along = (_middle(v, z + distance) for v in (x, y))
    return Camera(right * across + up * along - forward * distance, right, up, forward, half)


def _middle(across: Floats, depth: Floats) -> float:
    """Camera position across its view that puts the outermost points equally far from the frame, metres."""
    center = 0.0
    for _ in range(12):
        seen = (across - center) / depth
        center += float((seen.max() + seen.min()) / 2.0 * depth.mean())
    return center
