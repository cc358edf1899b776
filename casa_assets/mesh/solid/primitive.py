"""Primitives: the smallest around points, their bounds at a pose, and their closed triangle surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.solids import convex_hull, hull_volume
from casa_assets.model.asset.asset import Link
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose


def tessellate(shape: Shape, pose: Pose, steps: int = 32) -> tuple[Floats, Ints]:
    """(P, 3) points and (F, 3) outward faces in the frame that `pose` leads to, metres; `steps` points per circle."""
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
        return np.asarray(signs * np.array(shape.size) / 2)
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


def shape_bounds(shape: Shape, pose: Pose) -> Floats:
    """(2, 3) lower and upper corner of a shape, metres, in the frame that `pose` (frame_from_shape) leads to."""
    center, axis = np.array(pose.position), pose.rotation[:, 2]
    if isinstance(shape, Box):
        half = np.abs(pose.rotation) @ (np.array(shape.size) / 2)
    elif isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Capsule):
        half = np.abs(axis) * shape.height / 2 + shape.radius
    elif isinstance(shape, Cylinder):
        # A disc of radius r with unit normal n reaches r * sqrt(1 - n_i^2) along axis i.
        half = np.abs(axis) * shape.height / 2 + shape.radius * np.sqrt(np.clip(1.0 - axis**2, 0.0, 1.0))
    else:
        points = pose.apply(shape.mesh.vertices)
        return np.array([points.min(axis=0), points.max(axis=0)])
    return np.array([center - half, center + half])


def link_bounds(link: Link, pose: Pose | None = None) -> Floats | None:
    """(2, 3) corners of all colliders, metres, None without any; in link frame or that of `pose` (frame_from_link)."""
    corners = np.array([shape_bounds(c.shape, (pose or Pose()) @ c.pose) for c in link.colliders])
    return box_around(corners) if len(corners) else None


def box_around(boxes: Floats) -> Floats:
    """(2, 3) corners of the box around (N, 2, 3) boxes."""
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


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
