"""Legs and rails of furniture: bars between two points."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.loft import loft
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import circle, rectangle, tube
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.model.asset.shape import Cylinder
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3


def point_between(a: Vec3, b: Vec3, share: float) -> Vec3:
    """The point at a share of the way from a (0) to b (1)."""
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share


def round_bar(a: Vec3, b: Vec3, radius: float) -> Solid:
    """A round bar from a to b; its collider is a cylinder."""
    solid = tube([a, b], radius)
    axis = np.array(b) - np.array(a)
    length = float(np.linalg.norm(axis))
    middle = (np.array(a) + np.array(b)) / 2
    x, y, z = (float(v) for v in middle)
    shape = Cylinder(radius=radius, height=length)
    return solid.with_shapes((shape, Pose(position=(x, y, z), quaternion=_onto(axis / length))))


def square_bar(a: Vec3, b: Vec3, width: float, depth: float, up: Vec3 = (0.0, 1.0, 0.0)) -> Solid:
    """A square-edged bar from a to b: `depth` along `up`, `width` across; its collider is a box."""
    return tube([a, b], rectangle(width, depth, min(width, depth) * 0.12, 1), up=up)


def tapered_leg(a: Vec3, b: Vec3, start: float, end: float, sides: int = 20) -> Solid:
    """A round leg whose radius goes from `start` at a to `end` at b; its collider is a cylinder of the mean radius."""
    axis = np.array(b) - np.array(a)
    length = float(np.linalg.norm(axis))
    ring = circle(1.0, sides)
    start_ring = np.column_stack([ring * start, np.zeros(sides)])
    end_ring = np.column_stack([ring * end, np.full(sides, length)])
    points, faces = convex_hull(np.concatenate([start_ring, end_ring]))
    x, y, z = a
    pose = Pose(position=(x, y, z), quaternion=_onto(axis / length))
    shape = (Cylinder(radius=(start + end) / 2, height=length), Pose(position=(0.0, 0.0, length / 2)))
    return Solid(points, faces, (shape,), crease_deg=40.0).transformed(pose)


def bowed_slat(size: Vec3, at: Vec3, bow: float, steps: int = 8) -> Solid:
    """A board bowed backwards (+y) in its middle: width x, thickness y, height z; its collider is the bounding box."""
    w, t, h = size
    xs = np.linspace(-w / 2, w / 2, steps + 1)
    ys = bow * (1 - (2 * xs / w) ** 2)
    front = np.column_stack([xs, ys - t / 2])
    back = np.column_stack([xs, ys + t / 2])[::-1]
    outline = np.concatenate([front, back])
    bottom = np.column_stack([outline, np.full(len(outline), -h / 2)])
    top = np.column_stack([outline, np.full(len(outline), h / 2)])
    solid = loft([bottom, top], 40.0)
    return solid.with_box_collider().translated(*at)


def _onto(direction: Floats) -> tuple[float, float, float, float]:
    """Quaternion that takes z to a unit vector."""
    x, y, z = (float(v) for v in direction)
    if z < -1 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    w = 1.0 + z
    n = math.sqrt(w * w + x * x + y * y)
    return (w / n, -y / n, x / n, 0.0)
