"""Mouldings: a profile swept round the inside of a room, or along a straight piece with mitred ends."""

from __future__ import annotations

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.slab import offset_sides
from casa_assets.families.kit.solids.solid import Solid


def room_moulding(loop: Floats, profile: Floats) -> Solid:
    """A moulding along all walls, mitred at every corner.

    Args:
        loop: (N, 2) corners of the room, counter-clockwise, metres.
        profile: (M, 2) closed outline, counter-clockwise: distance from the wall, and z.
    Returns:
        A closed ring whose colliders are the hulls of its N sides; its picture's height runs along each side.
    """
    n, m = len(loop), len(profile)
    rings = np.stack([np.column_stack([offset_sides(loop, [d] * n), np.full(n, z)]) for d, z in profile])
    points = rings.transpose(1, 0, 2).reshape(-1, 3)  # corner by corner
    run = np.roll(loop, -1, axis=0) - loop
    run /= np.linalg.norm(run, axis=1)[:, None]
    perimeter = _perimeter(profile)
    faces: list[tuple[int, int, int]] = []
    uv_m: list[Floats] = []
    for k in range(n):
        for i in range(m):
            a, b = k * m + i, k * m + (i + 1) % m
            d, c = (k + 1) % n * m + i, (k + 1) % n * m + (i + 1) % m
            quad = [a, b, c, d]
            along = points[quad, :2] @ run[k]
            flat = np.column_stack([[perimeter[i], perimeter[i + 1], perimeter[i + 1], perimeter[i]], along])
            faces += [(a, d, c), (a, c, b)]
            uv_m += [flat[[0, 3, 2]], flat[[0, 2, 1]]]
    body = Solid(points, np.array(faces, dtype=np.int64), uv_m=np.array(uv_m), crease_deg=40.0).oriented_outwards()
    sides = [np.concatenate([points[k * m : (k + 1) * m], np.roll(points, -m, axis=0)[k * m : (k + 1) * m]])
             for k in range(n)]  # fmt: skip
    return body.with_colliders_of(
        *(Solid(cloud, np.zeros((0, 3), dtype=np.int64)).with_hull_collider() for cloud in sides)
    )


def straight_moulding(profile: Floats, length: float, left: float, right: float) -> Solid:
    """A moulding along x from 0 to `length`, measured at y = 0.

    Args:
        profile: (M, 2) closed outline, counter-clockwise: distance from the wall (towards -y), and z.
        left, right: how much farther than at the wall an end reaches out, per metre of distance from the wall: 0 for a
            square cut, 1 for a mitre around an outer corner, -1 for one in an inner corner.
    Returns:
        A solid without collision shapes: unless some are added, its hull is taken. Its picture's height runs along x.
    """
    m = len(profile)
    d, z = profile[:, 0], profile[:, 1]
    ends = [np.column_stack([x, -d, z]) for x in (-left * d, length + right * d)]
    points = np.concatenate(ends)
    perimeter = _perimeter(profile)
    faces: list[tuple[int, int, int]] = []
    uv_m: list[Floats] = []
    for i in range(m):
        j = (i + 1) % m
        flat = np.column_stack([perimeter[[i, i + 1, i + 1, i]], points[[i, j, j + m, i + m], 0]])
        faces += [(i, j, j + m), (i, j + m, i + m)]
        uv_m += [flat[[0, 1, 2]], flat[[0, 2, 3]]]
    cap = np.asarray(manifold3d.triangulate([profile]), dtype=np.int64)
    for first, slope, order in ((0, left, [2, 1, 0]), (m, right, [0, 1, 2])):
        section = np.column_stack([d * np.hypot(1.0, slope), z])
        for t in cap[:, order]:
            faces.append((int(t[0]) + first, int(t[1]) + first, int(t[2]) + first))
            uv_m.append(section[t])
    body = Solid(points, np.array(faces, dtype=np.int64), uv_m=np.array(uv_m), crease_deg=40.0)
    return body.oriented_outwards()


def _perimeter(profile: Floats) -> Floats:
    """(M + 1,) length along the outline up to each point, metres."""
    steps = np.linalg.norm(np.roll(profile, -1, axis=0) - profile, axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
