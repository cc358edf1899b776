"""Prisms, tubes and mitred frames: outlines extruded straight, along a path, or round a rectangle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.families.kit.solids.slab import stack_rings
from casa_assets.families.kit.solids.solid import Placed, Solid, concatenate
from casa_assets.model.asset.shape import Box, Capsule, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3


def circle(radius: float, count: int = 16) -> Floats:
    """(count, 2) points of a circle, counter-clockwise."""
    angles = np.arange(count) * 2 * np.pi / count
    return np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)


def rectangle(width: float, height: float, radius: float = 0.0, steps: int = 3) -> Floats:
    """(N, 2) outline of a rectangle about the origin with rounded corners, counter-clockwise."""
    w, h = width / 2, height / 2
    r = min(radius, 0.98 * w, 0.98 * h)
    corners = ((w - r, h - r, 0.0), (-w + r, h - r, 90.0), (-w + r, -h + r, 180.0), (w - r, -h + r, 270.0))
    if r <= 0:
        return np.array([(w, h), (-w, h), (-w, -h), (w, -h)])
    turns = np.linspace(0.0, 90.0, steps + 1)
    return np.array(
        [
            (x + r * math.cos(math.radians(a + t)), y + r * math.sin(math.radians(a + t)))
            for x, y, a in corners
            for t in turns
        ]
    )


def inset(outline: Floats, by: float) -> Floats:
    """(N, 2) outline moved inwards by metres along its mitres; the number of points stays."""
    forward = np.roll(outline, -1, axis=0) - outline
    forward /= np.linalg.norm(forward, axis=1)[:, None]
    normal = np.stack([-forward[:, 1], forward[:, 0]], axis=1)  # inwards where counter-clockwise
    before = np.roll(normal, 1, axis=0)
    mitre = normal + before
    mitre /= np.maximum(np.einsum("ij,ij->i", mitre, normal), 0.2)[:, None]
    return np.asarray(outline + by * mitre)


def prism(outline: Floats, height: float, chamfer: float = 0.001, holes: Sequence[Floats] = ()) -> Solid:
    """An outline in x, y extruded along z from 0 to `height`.

    Args:
        outline: (N, 2) simple polygon, metres, counter-clockwise.
        chamfer: chamfer of the rims of the outer outline and of the holes (0: sharp).
        holes: (M, 2) outlines inside it, counter-clockwise.
    Returns:
        A solid without collision shapes: unless some are added, its hull is taken.
    """
    e = min(chamfer, 0.45 * height)
    levels = [(0.0, 0.0), (height, 0.0)] if e <= 0 else [(0.0, e), (e, 0.0), (height - e, 0.0), (height, e)]
    loops = [np.asarray(outline, dtype=np.float64), *(np.asarray(h, dtype=np.float64)[::-1] for h in holes)]
    return stack_rings(
        [
            [np.column_stack([inset(loop, cut) if cut else loop, np.full(len(loop), z)]) for z, cut in levels]
            for loop in loops
        ],
        50.0,
    )


def round_corners(path: Sequence[Vec3], radius: float, steps: int = 5) -> Floats:
    """(N, 3) path whose corners are rounded with a bend radius, metres."""
    line = np.array(path, dtype=np.float64)
    out = [line[0]]
    for before, corner, after in zip(line, line[1:], line[2:], strict=False):
        a, b = before - corner, after - corner
        la, lb = float(np.linalg.norm(a)), float(np.linalg.norm(b))
        a, b = a / la, b / lb
        half = math.acos(float(np.clip(a @ b, -1, 1))) / 2
        reach = min(radius / max(math.tan(half), 1e-6), 0.49 * la, 0.49 * lb)
        if reach < 1e-6 or half > math.pi / 2 - 1e-3:
            out.append(corner)
            continue
        r = reach * math.tan(half)
        middle = corner + (a + b) / np.linalg.norm(a + b) * r / math.sin(half)
        u = corner + a * reach - middle
        w = corner + b * reach - middle
        sweep = math.acos(float(np.clip(u @ w / (r * r), -1, 1)))
        for t in np.linspace(0.0, 1.0, steps + 1):
            out.append(middle + (math.sin((1 - t) * sweep) * u + math.sin(t * sweep) * w) / math.sin(sweep))
    out.append(line[-1])
    return np.array(out)


def tube(path: Sequence[Vec3], section: float | Floats, bend: float = 0.0, up: Vec3 = (0.0, 0.0, 1.0)) -> Solid:
    """A cross-section swept along a path, its ends closed flat.

    Args:
        path: corner points, metres.
        section: radius of a round one, or (N, 2) outline, counter-clockwise: x across, y towards `up`.
        bend: radius with which corners are rounded; 0 mitres them.
        up: direction that the section's y points to as far as it can.
    Returns:
        A solid with a capsule (round) or box (outline) as collider for each straight piece of `path`.
    """
    line = round_corners(path, bend) if bend > 0 else np.array(path, dtype=np.float64)
    outline = circle(section, _sides(section)) if isinstance(section, float) else np.asarray(section)
    n, m = len(outline), len(line)
    forward = np.diff(line, axis=0)
    lengths = np.linalg.norm(forward, axis=1)
    forward /= lengths[:, None]
    run = np.concatenate([[0.0], np.cumsum(lengths)])
    perimeter = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1))])
    rings: list[Floats] = []
    across, upward = _frame(forward[0], np.array(up, dtype=np.float64))
    for k in range(m):
        arrive, leave = forward[max(k - 1, 0)], forward[min(k, m - 2)]
        if k > 0:
            across, upward = _carried(across, upward, forward[max(k - 2, 0)] if k > 1 else arrive, arrive)
        plane = arrive + leave
        plane /= np.linalg.norm(plane)
        flat = outline[:, :1] * across + outline[:, 1:] * upward
        # The ring lies in the plane that halves the corner: points slide along the arriving direction.
        slide = -(flat @ plane) / float(arrive @ plane)
        rings.append(line[k] + flat + slide[:, None] * arrive)
    faces: list[tuple[int, int, int]] = []
    uv_m: list[tuple[Vec2, Vec2, Vec2]] = []
    for k in range(m - 1):
        # At a mitre the corners of a ring lie before or behind its middle: each face keeps its true length.
        starts = run[k] + (rings[k] - line[k]) @ forward[k]
        ends = run[k] + (rings[k + 1] - line[k]) @ forward[k]
        for i in range(n):
            j = (i + 1) % n
            a, b, c, d = k * n + i, k * n + j, (k + 1) * n + j, (k + 1) * n + i
            u0, u1 = float(perimeter[i]), float(perimeter[i + 1])
            faces += [(a, b, c), (a, c, d)]
            va, vb, vc, vd = (float(v) for v in (starts[i], starts[j], ends[j], ends[i]))
            uv_m += [((u0, va), (u1, vb), (u1, vc)), ((u0, va), (u1, vc), (u0, vd))]
    cap = np.asarray(manifold3d.triangulate([outline]), dtype=np.int64)
    for t in cap:
        low = [(float(x), float(y)) for x, y in outline[t]]
        faces += [(int(t[2]), int(t[1]), int(t[0])), tuple(int(i) + (m - 1) * n for i in t)]  # type: ignore[list-item]
        uv_m += [(low[2], low[1], low[0]), (low[0], low[1], low[2])]
    crease = 40.0 if isinstance(section, float) else 50.0
    shapes = _straight(path, section, up)
    return Solid(np.concatenate(rings), np.array(faces, dtype=np.int64), shapes, np.array(uv_m), crease)


def _sides(radius: float) -> int:
    return 8 if radius < 0.002 else 12 if radius < 0.008 else 20


def _frame(forward: Floats, up: Floats) -> tuple[Floats, Floats]:
    """Across and upward unit vectors of a section that is swept along `forward`."""
    if abs(float(forward @ up)) > 0.99:
        up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    across = np.cross(up, -forward)
    across /= np.linalg.norm(across)
    # Seen from ahead a counter-clockwise outline must stay counter-clockwise, so that the faces look outwards.
    return across, np.cross(forward, across)


def _carried(across: Floats, upward: Floats, before: Floats, now: Floats) -> tuple[Floats, Floats]:
    """Axes of the section after the smallest rotation that takes one direction to the next."""
    axis = np.cross(before, now)
    sine, cosine = float(np.linalg.norm(axis)), float(before @ now)
    if sine < 1e-9:
        return across, upward
    axis /= sine

    def rotated(v: Floats) -> Floats:
        return np.asarray(v * cosine + np.cross(axis, v) * sine + axis * float(axis @ v) * (1 - cosine))

    return rotated(across), rotated(upward)


def _straight(path: Sequence[Vec3], section: float | Floats, up: Vec3) -> tuple[Placed, ...]:
    """A capsule or box for each straight piece."""
    out: list[Placed] = []
    line = np.array(path, dtype=np.float64)
    for k, (a, b) in enumerate(pairwise(line)):
        length = float(np.linalg.norm(b - a))
        if length < 1e-6:
            continue
        forward = (b - a) / length
        if isinstance(section, float):  # a capsule is round beyond its ends: free ends are drawn in
            pull = min(section, 0.45 * length)
            a, b = a + forward * pull * (k == 0), b - forward * pull * (k == len(line) - 2)
            length = float(np.linalg.norm(b - a))
        across, upward = _frame(forward, np.array(up, dtype=np.float64))
        shape: Shape
        if isinstance(section, float):
            shape, middle = Capsule(radius=section, height=length), (a + b) / 2
        else:
            lower, upper = section.min(axis=0), section.max(axis=0)
            shape = Box(size=(float(upper[0] - lower[0]), float(upper[1] - lower[1]), length))
            center = (lower + upper) / 2
            middle = (a + b) / 2 + across * center[0] + upward * center[1]
        turned = np.stack([across, upward, forward], axis=1)
        if np.linalg.det(turned) < 0:
            turned[:, 0] *= -1
        pose = Pose.from_matrix(turned)
        out.append((shape, Pose(position=tuple(float(v) for v in middle), quaternion=pose.quaternion)))
    return tuple(out)


def mitred_frame(width: float, height: float, profile: Floats) -> Solid:
    """A profile swept around a rectangle in the plane x, z, mitred: a moulding, a picture frame.

    Args:
        width, height: of the rectangle that the profile's origin runs along, metres; its middle is the origin.
        profile: (N, 2) closed outline, counter-clockwise: x away from the rectangle's middle, y out of the front.
    Returns:
        A solid without collision shapes; four straight mitred sides.
    """
    w, h = width / 2, height / 2
    corners = ((w, -h, 1, -1), (w, h, 1, 1), (-w, h, -1, 1), (-w, -h, -1, -1))
    p = np.asarray(profile, dtype=np.float64)
    n = len(p)
    rings = [np.stack([x + sx * p[:, 0], -p[:, 1], z + sz * p[:, 0]], axis=1) for x, z, sx, sz in corners]
    sides = []
    for k in range(4):
        a, b = rings[k], rings[(k + 1) % 4]
        i = np.arange(n)
        j = np.roll(i, -1)
        faces = [np.stack([i, n + i, n + j], axis=1), np.stack([i, n + j, j], axis=1)]
        cap = np.asarray(manifold3d.triangulate([p]), dtype=np.int64)
        faces += [cap, cap[:, ::-1] + n]
        sides.append(Solid(np.concatenate([a, b]), np.concatenate(faces).astype(np.int64)).oriented_outwards())
    return concatenate(sides)
