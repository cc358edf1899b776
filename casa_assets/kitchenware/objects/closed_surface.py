"""Closed surfaces of organic things: profiles turned about an axis, sheets, balls; lobes, bumps and bends of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from casa_assets.ext.arrays import Floats, Ints
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import Solid
from casa_assets.kitchenware.parts.decor.jars import GOLDEN_ANGLE


def run_along(line: Floats) -> Floats:
    """(N,) length of an open line from its first point to each of its (N, D) points."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def smooth_profile(points: Sequence[Vec2], count: int) -> Floats:
    """(count, 2) points, evenly far apart, of a smooth curve through some points from the lower end to the upper one.

    Args:
        points: (radius, height) in order; a curve may turn back, as round the hollow of a stem.
    """
    line = np.array(points, dtype=np.float64)
    run = run_along(line)
    fine = np.linspace(0.0, run[-1], 40 * count)
    curve = np.stack([PchipInterpolator(run, line[:, k])(fine) for k in (0, 1)], axis=1)
    length = run_along(curve)
    even = np.linspace(0.0, length[-1], count)
    found = np.stack([np.interp(even, length, curve[:, k]) for k in (0, 1)], axis=1)
    found[[0, -1]] = line[[0, -1]]
    return found


def turned(profile: Floats, around: int, crease_deg: float = 60.0) -> Solid:
    """A surface of revolution about z whose ends lie on the axis; one picture covers it from end to end.

    Args:
        profile: (N, 2) radius and height, metres; the first and last radius are 0.
        around: points around.
    """
    angles = np.arange(around) * 2 * np.pi / around
    inner = profile[1:-1]
    x, y = inner[:, :1] * np.cos(angles), inner[:, :1] * np.sin(angles)
    rings = np.stack([x, y, np.broadcast_to(inner[:, 1:], x.shape)], axis=2)
    points = np.concatenate([[[0.0, 0.0, profile[0, 1]]], rings.reshape(-1, 3), [[0.0, 0.0, profile[-1, 1]]]])
    run = run_along(profile)
    v = run / run[-1]
    u = np.arange(around + 1) / around
    last = len(points) - 1
    faces: list[tuple[int, int, int]] = []
    uv: list[tuple[Vec2, Vec2, Vec2]] = []
    for i in range(around):
        j, u0, u1 = (i + 1) % around, float(u[i]), float(u[i + 1])
        um = (u0 + u1) / 2
        faces.append((0, 1 + j, 1 + i))
        uv.append(((um, float(v[0])), (u1, float(v[1])), (u0, float(v[1]))))
        for k in range(len(inner) - 1):
            a, b, c, d = (1 + k * around + i, 1 + k * around + j, 1 + (k + 1) * around + j, 1 + (k + 1) * around + i)
            v0, v1 = float(v[k + 1]), float(v[k + 2])
            faces += [(a, b, c), (a, c, d)]
            uv += [((u0, v0), (u1, v0), (u1, v1)), ((u0, v0), (u1, v1), (u0, v1))]
        top = 1 + (len(inner) - 1) * around
        faces.append((last, top + i, top + j))
        uv.append(((um, float(v[-1])), (u0, float(v[-2])), (u1, float(v[-2]))))
    return Solid(points, np.array(faces, dtype=np.int64), crease_deg=crease_deg, picture_uv=np.array(uv))


def capped_rings(n: int, rings: int) -> Ints:
    """(F, 3) faces over a first point, `rings` rings of n points and a last point."""
    j = np.arange(n)
    k = (j + 1) % n
    faces = [np.stack([np.zeros(n, dtype=np.int64), 1 + k, 1 + j], axis=1)]
    for r in range(rings - 1):
        a, b, c, d = 1 + r * n + j, 1 + r * n + k, 1 + (r + 1) * n + k, 1 + (r + 1) * n + j
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    last, top = 1 + rings * n, 1 + (rings - 1) * n
    faces.append(np.stack([np.full(n, last), top + j, top + k], axis=1))
    return np.concatenate(faces).astype(np.int64)


def sheet(middle: Floats, thickness: float | Floats) -> Solid:
    """A closed body round a (N, M, 3) grid, thin at its border; its picture is the grid.

    Args:
        middle: grid whose first axis is the picture's u and whose second is its v, seen from the side it faces.
        thickness: metres, one for all or (N, M).
    """
    n, m = middle.shape[:2]
    along, across = np.gradient(middle, axis=0), np.gradient(middle, axis=1)
    normal = np.cross(along, across)
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)
    half = np.broadcast_to(np.asarray(thickness, dtype=np.float64) / 2, (n, m)).copy()
    border = np.ones((n, m), dtype=bool)
    border[1:-1, 1:-1] = False
    half[border] *= 0.5
    offset = normal * half[..., None]
    points = np.concatenate([(middle + offset).reshape(-1, 3), (middle - offset).reshape(-1, 3)])
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = index[:-1, :-1].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    top = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    rim = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    after = np.roll(rim, -1)
    sides = [np.stack([rim, rim + n * m, after + n * m], axis=1), np.stack([rim, after + n * m, after], axis=1)]
    faces = np.concatenate([top, top[:, ::-1] + n * m, *sides]).astype(np.int64)
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    return Solid(points, faces, crease_deg=75.0, picture_uv=np.concatenate([uv, uv])[faces]).oriented_outwards()


def ellipsoid(size: tuple[float, float, float], around: int = 8, along: int = 5) -> Solid:
    """A ball with few faces stretched to a size, metres; its picture runs round it and from end to end of x."""
    tilt = np.linspace(-np.pi / 2, np.pi / 2, along)
    profile = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
    profile[[0, -1], 0] = 0.0
    body = turned(profile, around, 80.0)
    return replace(body, points=body.points[:, [2, 0, 1]] * (np.array(size) / 2))


def lobed(points: Floats, count: int, depth: float, sharp: float, phase: float) -> Floats:
    """Points drawn in towards the z axis in `count` furrows, as peppers, tomatoes and pumpkins have them.

    Args:
        depth: of a furrow, by the radius. sharp: 1 for waves, more for narrow furrows between round lobes.
    """
    if count < 1 or depth <= 0:
        return points
    angle = np.arctan2(points[:, 1], points[:, 0])
    furrow = np.abs(np.sin(0.5 * count * angle + phase))
    share = 1.0 - depth * (1.0 - furrow ** (1.0 / sharp))
    return np.column_stack([points[:, :2] * share[:, None], points[:, 2]])


def bumped(points: Floats, amount: float, waves: float, rng: np.random.Generator) -> Floats:
    """Points moved from the middle of their box by smooth random waves, so that no two members are alike.

    Args:
        amount: by the distance from the middle. waves: over the largest side.
    """
    if amount <= 0:
        return points
    middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, float(np.ptp(points, axis=0).max())
    away = points - middle
    total = random_waves(away, waves, size, 7, rng)
    found: Floats = middle + away * (1.0 + amount * total[:, None] / 3.0)
    return found


def random_waves(points: Floats, waves: float, size: float, count: int, rng: np.random.Generator) -> Floats:
    """(P,) sum of `count` waves in random directions at (P, 3) points, about `waves` of each over `size`."""
    total = np.zeros(len(points))
    for _ in range(count):
        way = rng.normal(size=3)
        way *= waves * 2 * np.pi / size / np.linalg.norm(way) * rng.uniform(0.5, 1.2)
        total += np.sin(points @ way + rng.uniform(0.0, 2 * np.pi))
    return total


def bent(points: Floats, angle: float, start: float, span: Vec2) -> Floats:
    """Points bent along the z axis towards +x by an angle in all, rad; what lies beyond the span goes on straight.

    Args:
        start: share of the span below which it stays straight. span: lowest and highest z of what is bent.
    """
    if abs(angle) < 1e-6:
        return points
    low, high = span
    first = low + start * (high - low)
    length = high - first
    along = (points[:, 2] - first).clip(0.0, length)
    beyond = points[:, 2] - first - along
    turn, radius = angle * along / length, length / angle
    across = radius - points[:, 0]
    x = radius - across * np.cos(turn) + np.where(beyond > 0, beyond * np.sin(turn), 0.0)
    z = first + across * np.sin(turn) + beyond * np.where(beyond > 0, np.cos(turn), 1.0)
    return np.column_stack([x, points[:, 1], z])


def wrapped(points: Floats, leaves: int, depth: float, rng: np.random.Generator) -> Floats:
    """Points raised where leaves lie round a head, as those of a cabbage do: each ends in a step.

    Args:
        depth: of a leaf, by the distance from the middle of the box.
    """
    if leaves < 1:
        return points
    middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, np.ptp(points, axis=0) / 2
    away = (points - middle) / size
    angle, height = np.arctan2(away[:, 1], away[:, 0]), away[:, 2]
    raised = np.zeros(len(points))
    for k in range(leaves):
        turn = k * GOLDEN_ANGLE + float(rng.uniform(-0.3, 0.3))
        reach, top = float(rng.uniform(0.9, 1.3)), float(rng.uniform(0.35, 0.95))
        off = (angle - turn + np.pi) % (2 * np.pi) - np.pi
        wave = 0.06 * np.sin(7.0 * off + k)
        # A leaf is a round shield that starts at the foot; its rim is a step two points wide.
        inside = 1.0 - np.sqrt((off / reach) ** 2 + ((height + 1.0) / (top + 1.0 + wave)) ** 2)
        raised = np.maximum(raised, (k + 1) / leaves * np.clip(inside / 0.08, 0.0, 1.0))
    found: Floats = middle + (points - middle) * (1.0 + depth * raised[:, None])
    return found
