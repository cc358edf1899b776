"""Closed surfaces of organic things: turned profiles, sheets, balls; lobes, bumps and bends; cuts by planes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import manifold3d
import numpy as np
from scipy.interpolate import PchipInterpolator

from casa_assets.ext.arrays import Floats, Ints, counter_clockwise, signed_area
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import Solid
from casa_assets.kitchenware.parts.decor import GOLDEN_ANGLE


def run_along(line: Floats) -> Floats:
    """(N,) length of an open line from its first point to each of its (N, D) points."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def smooth_profile(points: Sequence[Vec2], count: int) -> Floats:
    """(count, 2) points, evenly apart, of a smooth curve through (radius, height) points from the lower end upwards."""
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
    """A surface of revolution about z of (radius, height) points from axis to axis; one picture covers it."""
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

    middle: grid along u, then along v of the picture, seen from the side it faces. thickness: metres, one or (N, M).
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
    """Points drawn in to the z axis in furrows, as of a pumpkin; depth: by the radius; sharp: 1 for waves, or more."""
    if count < 1 or depth <= 0:
        return points
    furrow = np.abs(np.sin(0.5 * count * np.arctan2(points[:, 1], points[:, 0]) + phase))
    return np.column_stack([points[:, :2] * (1.0 - depth * (1.0 - furrow ** (1.0 / sharp)))[:, None], points[:, 2]])


def bumped(points: Floats, amount: float, waves: float, rng: np.random.Generator) -> Floats:
    """Points moved by smooth random waves; amount: by the distance from the middle; waves: over the largest side."""
    if amount <= 0:
        return points
    middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, float(np.ptp(points, axis=0).max())
    away = points - middle
    return np.asarray(middle + away * (1.0 + amount * random_waves(away, waves, size, 7, rng)[:, None] / 3.0))


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
    """Points raised as leaves lie round a cabbage, each with a step at its end; depth: by distance from the middle."""
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
    return np.asarray(middle + (points - middle) * (1.0 + depth * raised[:, None]))


# A cut face is a plate of this thickness; a part of it stands out of the body, so that nothing of the body shows, m.
PLATE, PROUD = 0.0006, 0.00025
# Size of a plate by that of the face: the rest is the edge of the skin.
WITHIN = 0.985
# Points nearer than this to a plane lie on it, m.
ON_PLANE = 1e-7
# Points of an outline nearer than this to the one before are left out, m: what is written is rounded to a tenth of it.
SAME = 1e-7
# Radius of the rim of a face in the picture of a section, by its width; as in kitchenware/textures/food.py.
PICTURE_RIM = 0.49


@dataclass(frozen=True)
class Plane:
    """A cutting plane: everything beyond it is removed."""

    normal: Floats  # (3,) unit vector, away from what is kept
    offset: float  # along it from the origin, m
    middle: Floats | None  # (3,) middle of the picture of the cut face, m; None: that of the face
    up: Floats  # (3,) unit vector in the plane: the upward direction of the picture


def along(turn: float, middle: Floats) -> Plane:
    """A plane through the z axis that leaves the half turn before an angle, rad from x."""
    return Plane(np.array([-math.sin(turn), math.cos(turn), 0.0]), 0.0, middle, np.array([0.0, 0.0, 1.0]))


def sector(angle: float, middle: Floats) -> list[Plane]:
    """Two planes through the z axis that leave a sector of an angle (rad) about the x axis."""
    first, last = along(angle / 2, middle), along(-angle / 2, middle)
    return [first, replace(last, normal=-last.normal)]


def across(height: float, *, below: bool, slant: float = 0.0) -> Plane:
    """A plane that leaves what is below or above it, level or slanted towards x by an angle, rad, at a height, m."""
    sign = 1.0 if below else -1.0
    normal = sign * np.array([math.sin(slant), 0.0, math.cos(slant)])
    return Plane(normal, sign * height, None, np.array([0.0, 1.0, 0.0]))


def cut(solid: Solid, planes: list[Plane], hollow: Solid | None = None) -> tuple[Solid, list[Solid]]:
    """Cut a body by planes, and make the plates that lie on its cut faces.

    solid: closed; its picture is kept on its skin. hollow: an empty body within it, or None; its faces have no picture.
    Returns: the rest of the body, closed, without collision shapes; and for each plane a plate, whose picture is that
    of a section. Raises ValueError: the planes leave nothing of the body, or a plane does not meet it.
    """
    body = _manifold(solid)
    if hollow is not None:
        body -= _manifold(hollow)
    body = _trimmed(body, planes)
    if body.is_empty():
        raise ValueError("the cuts leave nothing of the body")
    kept = _solid(body, solid.crease_deg)
    return kept, [_plate(kept, plane) for plane in planes]


def shell(outer: Solid, inner: Solid, planes: list[Plane]) -> Solid:
    """The cut material between two closed bodies, slightly behind the cut faces; its picture is seen from the side."""
    kept = _solid(_trimmed(_manifold(outer) - _manifold(inner), planes, behind=PLATE), outer.crease_deg)
    low, high = kept.bounds
    # The middle of the picture has the flesh without the skin.
    return replace(kept, picture_uv=(0.5 + 0.5 * ((kept.points - low) / (high - low) - 0.5)[:, [0, 2]])[kept.faces])


def _trimmed(body: manifold3d.Manifold, planes: list[Plane], behind: float = 0.0) -> manifold3d.Manifold:
    """The rest of a body after cuts by planes that are moved by `behind` into it, m."""
    for plane in planes:
        x, y, z = (-float(v) for v in plane.normal)
        body = body.trim_by_plane((x, y, z), behind - plane.offset)
    return body


def _manifold(solid: Solid) -> manifold3d.Manifold:
    uv = np.zeros((*solid.faces.shape, 2)) if solid.picture_uv is None else solid.picture_uv
    corners = np.column_stack([solid.points[solid.faces.ravel()], uv.reshape(-1, 2)])
    rows, index = np.unique(np.round(corners, 12), axis=0, return_inverse=True)
    return manifold_of(rows, index)


def manifold_of(corners: Floats, index: Ints) -> manifold3d.Manifold:
    """A body of (P, 5) corners, places and (u, v), three to a face in `index`. Raises ValueError: it is not closed."""
    triangles = index.reshape(-1, 3).astype(np.uint64)
    mesh = manifold3d.Mesh64(vert_properties=np.ascontiguousarray(corners), tri_verts=triangles)
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"a body of {len(triangles)} faces is not closed: {body.status()}")
    return body


def _solid(body: manifold3d.Manifold, crease_deg: float) -> Solid:
    mesh = body.to_mesh64()
    corners, faces = np.array(mesh.vert_properties, dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)
    points, index = np.unique(np.round(corners[:, :3], 9), axis=0, return_inverse=True)
    return Solid(points, index[faces], crease_deg=crease_deg, picture_uv=corners[:, 3:5][faces])


def _plate(body: Solid, plane: Plane) -> Solid:
    """The plate over the face that a plane cut, holes left out: a fan, so that the picture follows the outline."""
    side = np.cross(plane.up, plane.normal)
    loops = [body.points[loop] for loop in _loops(body, plane)]
    if not loops:
        raise ValueError("a plane does not meet the body")
    outlines = [np.column_stack([loop @ side, loop @ plane.up]) for loop in loops]
    outlines.sort(key=lambda loop: -abs(signed_area(loop)))
    outer = counter_clockwise(outlines[0])
    middle = _centroid(outer) if plane.middle is None else np.array([plane.middle @ side, plane.middle @ plane.up])
    rim = outer - middle
    angle = np.arctan2(rim[:, 1], rim[:, 0])
    hole = 0.0 * angle
    if len(outlines) > 1:
        # The plate stands a trifle over the hollow, or its edge would lie in the wall.
        hole = np.minimum(WITHIN * _radius(outlines[1] - middle, angle) / np.hypot(rim[:, 0], rim[:, 1]), 0.96)
    inner = rim * hole[:, None]
    n = len(rim)
    # Its edges slant inwards below the face: upright ones might lie in a wall of the body.
    slant = 0.04 * (rim - inner)
    below = inner + np.where(hole > 0, 1.0, 0.0)[:, None] * slant
    levels = ((PROUD, inner, WITHIN * rim), (PROUD - PLATE, below, WITHIN * rim - slant))
    flats = [(np.concatenate([low, high]) + middle, plane.offset + level) for level, low, high in levels]
    placed = [flat[:, :1] * side + flat[:, 1:] * plane.up + level * plane.normal for flat, level in flats]
    points = np.concatenate(placed)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    top = np.concatenate([np.stack([n + i, n + j, i], 1), np.stack([n + j, j, i], 1)])
    wall = np.concatenate([np.stack([n + i, 3 * n + i, n + j], 1), np.stack([n + j, 3 * n + i, 3 * n + j], 1)])
    core = np.concatenate([np.stack([i, j, 2 * n + i], 1), np.stack([j, 2 * n + j, 2 * n + i], 1)])
    faces = np.concatenate([top, top[:, ::-1] + 2 * n, wall, core])
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    uv = 0.5 + PICTURE_RIM * np.concatenate([circle * hole[:, None], circle] * 2)
    return _welded(Solid(points, faces.astype(np.int64), crease_deg=40.0, picture_uv=uv[faces])).oriented_outwards()


def _welded(solid: Solid) -> Solid:
    """The solid with points that are the same made one, and without the faces that vanish."""
    points, index = np.unique(np.round(solid.points, 9), axis=0, return_inverse=True)
    faces = index[solid.faces]
    a, b, c = faces.T
    kept = (a != b) & (b != c) & (c != a)
    assert solid.picture_uv is not None
    return replace(solid, points=points, faces=faces[kept], picture_uv=solid.picture_uv[kept])


def _loops(body: Solid, plane: Plane) -> list[Ints]:
    faces = body.faces[(np.abs(body.points @ plane.normal - plane.offset) < ON_PLANE)[body.faces].all(axis=1)]
    edges = {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}
    after = {a: b for a, b in sorted(edges) if (b, a) not in edges}
    loops = []
    while after:
        first, following = next(iter(after.items()))
        loop = [first]
        while following in after and following != first:
            loop.append(following)
            following = after.pop(following)
        after.pop(first, None)
        loops.append(np.array(loop))
    steps = [np.linalg.norm(body.points[loop] - body.points[np.roll(loop, 1)], axis=1) for loop in loops]
    loops = [loop[step > SAME] for loop, step in zip(loops, steps, strict=True)]
    return [loop for loop in loops if len(loop) > 2]


def _centroid(loop: Floats) -> Floats:
    """(2,) middle of the area within a loop."""
    after = np.roll(loop, -1, axis=0)
    share = loop[:, 0] * after[:, 1] - after[:, 0] * loop[:, 1]
    return np.asarray(((loop + after) * share[:, None]).sum(axis=0) / (3 * share.sum()))


def _radius(loop: Floats, angle: Floats) -> Floats:
    """(N,) distance of a loop from the origin in directions, rad."""
    own = np.arctan2(loop[:, 1], loop[:, 0])
    order = np.argsort(own)
    return np.asarray(np.interp(angle, own[order], np.hypot(loop[:, 0], loop[:, 1])[order], period=2 * np.pi))
