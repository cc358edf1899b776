"""Boxes with rounded edges, surfaces of revolution, cylinders and spheres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.families.kit.solids.solid import Solid, axis_turn, box_shape
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.model.asset.shape import Box, Cylinder, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

EDGE_RADIUS = 0.0015  # metres, of the edges of boards; a choice


def box(size: Vec3, at: Vec3 = (0.0, 0.0, 0.0), edge_radius: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box about `at`; its collider is a box.

    Args:
        size: along x, y, z; all lengths are metres. edge_radius: of its rounded edges, 0 for sharp ones.
        steps: facets across an edge; one is shaded like a round edge, a radius over about 6 mm needs 3 or more.
    Raises:
        ValueError: a size is not positive.
    """
    half = np.array(size) / 2
    if half.min() <= 0:
        raise ValueError(f"a box needs a positive size, got {size}")
    radius = min(edge_radius, 0.98 * float(half.min()))
    directions, faces = _rounded(steps if radius > 0 else 0)
    if radius > 0:
        corners = np.repeat(_SIGNS, len(directions) // 8, axis=0)
        solid = corners * (half - radius) + directions * radius
    else:
        solid = directions * half
    center = np.array(at)
    return Solid(solid + center, faces, shapes=((Box(size=size), Pose(position=at)),))


def board(lower: Vec3, upper: Vec3, edge_radius: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box between two corners, metres; rounding as in `box`."""
    _, at = box_shape(lower, upper)
    size = (upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2])
    return box(size, at.position, edge_radius, steps)


_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@lru_cache(maxsize=16)
def _rounded(steps: int) -> tuple[Floats, Ints]:
    """Directions of the corners' points, octant by octant, and the faces of the box that they belong to."""
    if steps == 0:
        return _SIGNS, convex_hull(_SIGNS)[1]
    # Points of an octant of a sphere: rows of a subdivided triangle, pushed out to the sphere.
    weights = [(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]
    octant = np.array(weights, dtype=np.float64)
    octant = np.sin(octant / steps * math.pi / 2)
    octant /= np.linalg.norm(octant, axis=1)[:, None]
    directions = np.concatenate([octant * signs for signs in _SIGNS])
    template = np.repeat(_SIGNS, len(octant), axis=0) * 2.0 + directions
    hull, faces = convex_hull(template)
    assert len(hull) == len(template)
    return directions, faces


def lathe(profile: Sequence[Vec2], segments: int = 0, crease_deg: float = 40.0, closed: bool = False) -> Solid:
    """A surface of revolution about z.

    Args:
        profile: (radius, z) from the lower end to the upper one, metres; where an end is off the axis it is closed by a
            flat disc. A hollow body goes up outside and comes down inside.
        segments: points around; 0 chooses by radius.
        closed: the profile is a loop off the axis, counter-clockwise, and the body a ring.
    Returns:
        A solid without collision shape.
    """
    outline = [(max(0.0, float(r)), float(z)) for r, z in profile]
    if outline[0][0] > 0 and not closed:
        outline.insert(0, (0.0, outline[0][1]))
    if outline[-1][0] > 0 and not closed:
        outline.append((0.0, outline[-1][1]))
    count = segments or circle_segments(max(r for r, _ in outline))
    angles = np.arange(count) * 2 * np.pi / count
    points: list[Floats] = []
    rings: list[Ints] = []
    total = 0
    for r, z in outline:
        ring = np.array([[0.0, 0.0, z]]) if r == 0 else _ring(r, z, angles)
        points.append(ring)
        rings.append(np.arange(total, total + len(ring)))
        total += len(ring)
    if closed:
        rings, outline = [*rings, rings[0]], [*outline, outline[0]]
    faces, uv_m = _stitch(rings, outline, count)
    return Solid(np.concatenate(points), faces, uv_m=uv_m, crease_deg=crease_deg)


def circle_segments(radius: float) -> int:
    """Number of segments of a circle whose chords stay within half a millimetre of it; radius in metres."""
    if radius <= 0.0006:
        return 8
    need = math.pi / math.acos(1 - 0.0004 / max(radius, 0.001)) if radius > 0.0004 else 8
    return int(min(64, max(12, 4 * math.ceil(need / 4))))


def _ring(r: float, z: float, angles: Floats) -> Floats:
    return np.stack([r * np.cos(angles), r * np.sin(angles), np.full(len(angles), z)], axis=1)


def _stitch(rings: Sequence[Ints], outline: Sequence[Vec2], count: int) -> tuple[Ints, Floats]:
    """Faces between neighbouring rings, and their texture coordinates: round the body and along the profile."""
    faces: list[tuple[int, int, int]] = []
    uv_m: list[tuple[Vec2, Vec2, Vec2]] = []
    run = 0.0
    for ring0, ring1, (r0, z0), (r1, z1) in zip(rings, rings[1:], outline, outline[1:], strict=False):
        length = math.hypot(r1 - r0, z1 - z0)
        if length == 0 or (len(ring0) == 1 and len(ring1) == 1):
            continue
        step = 2 * math.pi / count
        arc = step * (r0 + r1) / 2
        for i in range(count):
            j = (i + 1) % count
            a, b = (ring0[0], ring0[0]) if len(ring0) == 1 else (ring0[i], ring0[j])
            c, d = (ring1[0], ring1[0]) if len(ring1) == 1 else (ring1[i], ring1[j])
            # A band narrows towards one rim: both rims keep their own length about the band's middle.
            m, w0, w1 = (i + 0.5) * arc, step * r0 / 2, step * r1 / 2
            ua, ub, uc, ud = m - w0, m + w0, m - w1, m + w1
            if len(ring0) > 1:
                faces.append((int(a), int(b), int(c if len(ring1) == 1 else d)))
                uv_m.append(((ua, run), (ub, run), (m if len(ring1) == 1 else ud, run + length)))
            if len(ring1) > 1:
                faces.append((int(a), int(d), int(c)))
                uv_m.append(((m if len(ring0) == 1 else ua, run), (ud, run + length), (uc, run + length)))
        run += length
    return np.array(faces, dtype=np.int64), np.array(uv_m, dtype=np.float64)


def rod(radius: float, length: float, edge_radius: float = 0.001, axis: str = "z") -> Solid:
    """A cylinder about the origin along an axis, its rims rounded; its collider is a cylinder."""
    r = min(edge_radius, 0.9 * radius, 0.45 * length)
    h = length / 2
    profile = [(radius - r, -h), (radius, -h + r), (radius, h - r), (radius - r, h)]
    solid = lathe(profile, crease_deg=50.0)
    return solid.with_shapes((Cylinder(radius=radius, height=length), Pose())).transformed(axis_rotation(axis))


def axis_rotation(axis: str) -> Pose:
    """Rotation that takes z to the axis of that name."""
    return {"x": axis_turn("y", math.pi / 2), "y": axis_turn("x", -math.pi / 2), "z": Pose()}[axis]


def ball(radius: float, steps: int = 12) -> Solid:
    """A sphere about the origin; its collider is a sphere."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, steps + 1)
    profile = [(float(radius * np.cos(t)), float(radius * np.sin(t))) for t in tilt]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    solid = lathe(profile, segments=2 * steps)
    return solid.with_shapes((Sphere(radius=radius), Pose()), crease_deg=60.0)
