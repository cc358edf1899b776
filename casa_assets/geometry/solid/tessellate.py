"""Primitives as closed triangle surfaces, for unions and pictures."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose


def tessellate(shape: Shape, pose: Pose, steps: int = 32) -> tuple[Floats, Ints]:
    """(P, 3) points and (F, 3) outward faces of a shape, in the frame that `pose` leads to, metres.

    Args:
        steps: points around a circle.
    """
    if isinstance(shape, Hull | MeshShape):
        return pose.apply(shape.mesh.vertices), shape.mesh.faces.astype(np.int64)
    if isinstance(shape, Box | Cylinder):
        # All boxes have the same faces, and all cylinders.
        return pose.apply(_outline(shape, steps)), _faces(type(shape), steps)
    points, faces = convex_hull(_outline(shape, steps))
    return pose.apply(points), faces


@lru_cache
def _faces(kind: type[Box] | type[Cylinder], steps: int) -> Ints:
    """(F, 3) outward faces of the outline of a box or a cylinder; read-only."""
    shape = Box(size=(1.0, 1.0, 1.0)) if kind is Box else Cylinder(radius=1.0, height=1.0)
    _, faces = convex_hull(_outline(shape, steps))
    faces.setflags(write=False)
    return faces


def _outline(shape: Box | Sphere | Cylinder | Capsule, steps: int) -> Floats:
    if isinstance(shape, Box):
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
        corners: Floats = signs * np.array(shape.size) / 2
        return corners
    around = np.arange(steps) * 2 * np.pi / steps
    ring = np.stack([np.cos(around), np.sin(around), np.zeros(steps)], axis=1) * shape.radius
    if isinstance(shape, Cylinder):
        return np.concatenate([ring + np.array([0, 0, s * shape.height / 2]) for s in (-1, 1)])
    rise = np.linspace(0, np.pi / 2, steps // 4 + 1)
    half = shape.height / 2 if isinstance(shape, Capsule) else 0.0
    domes = []
    for tilt in rise:
        level = ring * np.cos(tilt)
        lift = np.array([0, 0, shape.radius * np.sin(tilt) + half])
        domes += [level + lift, level - lift]
    return np.concatenate(domes)
