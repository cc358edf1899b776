"""Boxes with eased edges, turned bodies, balls."""

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

EDGE_RADIUS = 0.0015  # metres; the edge of a board that does not cut the hand


def box(size: Vec3, at: Vec3 = (0.0, 0.0, 0.0), ease: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box about `at` whose edges are rounded with radius `ease` in `steps` facets (0: sharp); its collider is a box.

    One facet is shaded like a round edge; take 3 or more where the radius is over about 6 mm.
    """
    half = np.array(size) / 2
    if half.min() <= 0:
        raise ValueError(f"a box needs a positive size, got {size}")
    radius = min(ease, 0.98 * float(half.min()))
    if radius <= 0:
        points, faces = _rounded(0)
        solid = points * half
    else:
        directions, faces = _rounded(steps)
        corners = np.repeat(_SIGNS, len(directions) // 8, axis=0)
        solid = corners * (half - radius) + directions * radius
    middle = np.array(at)
    return Solid(solid + middle, faces, shapes=((Box(size=size), Pose(position=at)),))


def board(low: Vec3, high: Vec3, ease: float = EDGE_RADIUS, steps: int = 1) -> Solid:
    """A box between two corners; rounding as in `box`."""
    _, at = box_shape(low, high)
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    return box(size, at.position, ease, steps)


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
    line = [(max(0.0, float(r)), float(z)) for r, z in profile]
    if line[0][0] > 0 and not closed:
        line.insert(0, (0.0, line[0][1]))
    if line[-1][0] > 0 and not closed:
        line.append((0.0, line[-1][1]))
    count = segments or circle_segments(max(r for r, _ in line))
    angles = np.arange(count) * 2 * np.pi / count
    points: list[Floats] = []
    rings: list[Ints] = []
    total = 0
    for r, z in line:
        ring = np.array([[0.0, 0.0, z]]) if r == 0 else _ring(r, z, angles)
        points.append(ring)
        rings.append(np.arange(total, total + len(ring)))
        total += len(ring)
    if closed:
        rings, line = [*rings, rings[0]], [*line, line[0]]
    faces, spread = _stitch(rings, line, count)
    return Solid(np.concatenate(points), faces, uv_m=spread, crease_deg=crease_deg)


def circle_segments(radius: float) -> int:
    """Number of segments of a circle whose chords stay within half a millimetre of it; radius in metres."""
    if radius <= 0.0006:
        return 8
    need = math.pi / math.acos(1 - 0.0004 / max(radius, 0.001)) if radius > 0.0004 else 8
    return int(min(64, max(12, 4 * math.ceil(need / 4))))


def _ring(r: float, z: float, angles: Floats) -> Floats:
    return np.stack([r * np.cos(angles), r * np.sin(angles), np.full(len(angles), z)], axis=1)


def _stitch(rings: Sequence[Ints], line: Sequence[Vec2], count: int) -> tuple[Ints, Floats]:
    """Faces between neighbouring rings, and their texture coordinates: round the body and along the profile."""
    faces: list[tuple[int, int, int]] = []
    spread: list[tuple[Vec2, Vec2, Vec2]] = []
    run = 0.0
    for low, high, (r0, z0), (r1, z1) in zip(rings, rings[1:], line, line[1:], strict=False):
        length = math.hypot(r1 - r0, z1 - z0)
        if length == 0 or (len(low) == 1 and len(high) == 1):
            continue
        step = 2 * math.pi / count
        arc = step * (r0 + r1) / 2
        for i in range(count):
            j = (i + 1) % count
            a, b = (low[0], low[0]) if len(low) == 1 else (low[i], low[j])
            c, d = (high[0], high[0]) if len(high) == 1 else (high[i], high[j])
            # A band narrows towards one rim: both rims keep their own length about the band's middle.
            m, w0, w1 = (i + 0.5) * arc, step * r0 / 2, step * r1 / 2
            ua, ub, uc, ud = m - w0, m + w0, m - w1, m + w1
            if len(low) > 1:
                faces.append((int(a), int(b), int(c if len(high) == 1 else d)))
                spread.append(((ua, run), (ub, run), (m if len(high) == 1 else ud, run + length)))
            if len(high) > 1:
                faces.append((int(a), int(d), int(c)))
                spread.append(((m if len(low) == 1 else ua, run), (ud, run + length), (uc, run + length)))
        run += length
    return np.array(faces, dtype=np.int64), np.array(spread, dtype=np.float64)


def rod(radius: float, length: float, ease: float = 0.001, axis: str = "z") -> Solid:
    """A cylinder about the origin along an axis, its rims rounded; its collider is a cylinder."""
    e = min(ease, 0.9 * radius, 0.45 * length)
    h = length / 2
    profile = [(radius - e, -h), (radius, -h + e), (radius, h - e), (radius - e, h)]
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
