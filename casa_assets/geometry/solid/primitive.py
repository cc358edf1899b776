"""The smallest box, sphere, cylinder or capsule around a convex cloud, and how well it fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Sphere
from casa_assets.model.pose import Pose


@dataclass(frozen=True)
class Fit:
    """A primitive around a cloud: its pose (cloud frame from shape frame) and hull volume over its volume, <= 1."""

    shape: Box | Sphere | Cylinder | Capsule
    pose: Pose
    ratio: float


def best_primitive(points: Floats) -> Fit | None:
    """Return the primitive that encloses (N, 3) hull vertices most tightly, or None if they span no volume.

    Spheres win ties over cylinders over boxes: fewer numbers, cheaper contacts.
    """
    volume = hull_volume(points)
    if volume <= 0:
        return None
    fits = [_sphere(points, volume)]
    for frame in _frames(points):
        fits += [_cylinder(points, frame, volume), _capsule(points, frame, volume), _box(points, frame, volume)]
    best = max(range(len(fits)), key=lambda i: (round(fits[i].ratio, 3), -i))
    return fits[best]


def _frames(points: Floats) -> list[Floats]:
    """Rotations (cloud from shape) worth trying: the three axes as z, and those of the covariance."""
    x, y, z = np.eye(3)
    axes = [np.stack([x, y, z], axis=1), np.stack([y, z, x], axis=1), np.stack([z, x, y], axis=1)]
    _, vectors = np.linalg.eigh(np.cov(points.T))
    for k in range(3):
        a, b, c = (vectors[:, (k + i) % 3] for i in (1, 2, 0))
        a, b, c = (v * np.sign(v[np.argmax(np.abs(v))]) for v in (a, b, c))
        axes.append(np.stack([np.cross(b, c), b, c], axis=1))
    return axes


def _pose(frame: Floats, center: Floats) -> Pose:
    matrix = np.eye(4)
    matrix[:3, :3] = frame
    matrix[:3, 3] = frame @ center
    return Pose.from_matrix(matrix)


def _sphere(points: Floats, volume: float) -> Fit:
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    for _ in range(64):  # Ritter: pull the centre towards the farthest point by ever less
        gap = points - center
        far = int(np.argmax(np.einsum("ij,ij->i", gap, gap)))
        radius = float(np.linalg.norm(gap[far]))
        near = np.sqrt(np.partition(np.einsum("ij,ij->i", gap, gap), -2)[-2])
        center = center + gap[far] / max(radius, 1e-30) * (radius - float(near)) / 2
    radius = float(np.linalg.norm(points - center, axis=1).max())
    matrix = np.eye(4)
    matrix[:3, 3] = center
    return Fit(Sphere(radius=radius), Pose.from_matrix(matrix), volume / (4 / 3 * np.pi * radius**3))


def _around_z(points: Floats, frame: Floats) -> tuple[Floats, Floats, float]:
    """Local points, centre of the enclosing circle in (x, y) with mid z, its radius."""
    local = points @ frame
    low, high = local.min(axis=0), local.max(axis=0)
    center = (low + high) / 2
    radius = float(np.linalg.norm(local[:, :2] - center[:2], axis=1).max())
    return local, center, radius


def _cylinder(points: Floats, frame: Floats, volume: float) -> Fit:
    local, center, radius = _around_z(points, frame)
    height = float(np.ptp(local[:, 2]))
    size = np.pi * radius**2 * height
    return Fit(Cylinder(radius=radius, height=max(height, 1e-9)), _pose(frame, center), volume / max(size, 1e-300))


def _capsule(points: Floats, frame: Floats, volume: float) -> Fit:
    local, center, radius = _around_z(points, frame)
    off = np.linalg.norm(local[:, :2] - center[:2], axis=1)
    dome = np.sqrt(np.maximum(radius**2 - off**2, 0.0))
    straight = 2 * max(float((np.abs(local[:, 2] - center[2]) - dome).max()), 1e-9)
    size = np.pi * radius**2 * straight + 4 / 3 * np.pi * radius**3
    return Fit(Capsule(radius=radius, height=straight), _pose(frame, center), volume / size)


def _box(points: Floats, frame: Floats, volume: float) -> Fit:
    local = points @ frame
    low, high = local.min(axis=0), local.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    shape = Box(size=(float(size[0]), float(size[1]), float(size[2])))
    return Fit(shape, _pose(frame, (low + high) / 2), volume / float(size.prod()))
