"""Prisms, tubes, frames, lofts and mouldings: outlines swept along a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import manifold3d
import numpy as np

from casa_assets.asset.solid import Placed, Solid, concatenate, hull_around
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.planar import signed_area
from casa_assets.model.asset.parts import Box, Capsule, Shape
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3


def slab(outline: Floats, profile: Sequence[Vec2], moulded: Sequence[bool], holes: Sequence[Floats] = ()) -> Solid:
    """A slab between two planes.

    outline: (N, 2) simple polygon, metres, counter-clockwise; side i runs from point i to point i + 1. profile: (inset,
    z) from the lower plane to the upper one, metres; inset is measured from the outline inwards. moulded: for each side
    whether it follows the profile; the other sides are vertical. holes: (M, 2) outlines inside it, counter-clockwise;
    their rims are chamfered by a millimetre on top. Returns: A solid without collision shapes.
    """
    loop = np.asarray(outline, dtype=np.float64)
    flat = [(offset_sides(loop, [d if m else 0.0 for m in moulded]), z) for d, z in profile]
    rings = [np.column_stack([ring, np.full(len(ring), z)]) for ring, z in flat]
    bottom, top = profile[0][1], profile[-1][1]
    rim_radius = min(0.001, 0.2 * (top - bottom))
    stacks = [rings]
    for hole in holes:
        back = np.asarray(hole, dtype=np.float64)[::-1]
        levels = ((back, bottom), (back, top - rim_radius), (offset_sides(back, [rim_radius] * len(back)), top))
        stacks.append([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in levels])
    return stack_rings(stacks, 35.0)


def offset_sides(loop: Floats, by: Sequence[float]) -> Floats:
    """(N, 2) polygon whose side i is moved inwards (to the left of its run) by `by[i]` metres."""
    n = len(loop)
    run = np.roll(loop, -1, axis=0) - loop
    run /= np.linalg.norm(run, axis=1)[:, None]
    inwards = np.stack([-run[:, 1], run[:, 0]], axis=1)
    out = np.empty_like(loop)
    for i in range(n):
        a, b = inwards[i - 1], inwards[i]
        da, db = by[i - 1], by[i]
        det = a[0] * b[1] - a[1] * b[0]
        if abs(det) < 0.02:
            out[i] = loop[i] + (a * da + b * db) / 2
            continue
        out[i] = loop[i] + (((da * b[1] - db * a[1]) / det), ((db * a[0] - da * b[0]) / det))
    return out


def stack_rings(stacks: Sequence[Sequence[Floats]], crease_deg: float) -> Solid:
    """A solid between two level planes: an outer stack of rings, and one for each hole.

    stacks: the outer boundary, then the holes: (N, 3) rings from the lower plane to the upper one, metres,
    counter-clockwise outside and clockwise in holes. All start in one plane and end in one. crease_deg: as in Solid.
    Returns: walls between the rings of each stack, and one cap below and one above; no collision shapes.
    """
    faces: list[Ints] = []
    bottom: list[Ints] = []
    top: list[Ints] = []
    start = 0
    for rings in stacks:
        n = len(rings[0])
        faces += ring_walls(n, len(rings), start)
        bottom.append(start + np.arange(n))
        start += n * len(rings)
        top.append(start - n + np.arange(n))
    points = np.concatenate([ring for rings in stacks for ring in rings])
    for ids, step in ((bottom, -1), (top, 1)):
        triangles = np.asarray(manifold3d.triangulate([points[i, :2] for i in ids]), dtype=np.int64)
        faces.append(np.concatenate(ids)[triangles][:, ::step])
    return Solid(points, np.concatenate(faces).astype(np.int64), crease_deg=crease_deg)


def ring_walls(size: int, count: int, start: int = 0) -> list[Ints]:
    """Faces between neighbours of `count` rings of `size` points, whose points are numbered on from `start`."""
    faces: list[Ints] = []
    for k in range(count - 1):
        a, d = (start + (k + i) * size + np.arange(size) for i in (0, 1))
        b, c = np.roll(a, -1), np.roll(d, -1)
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return faces


def arc(cx: float, cz: float, radius: float, start_deg: float, end_deg: float, steps: int = 6) -> list[Vec2]:
    """(inset, z) points of an arc: 0 degrees looks inwards (+ inset), 90 up."""
    turns = np.linspace(math.radians(start_deg), math.radians(end_deg), steps + 1)
    return [(cx + radius * math.cos(t), cz + radius * math.sin(t)) for t in turns]


def loft(rings: Sequence[Floats], crease_deg: float = 40.0) -> Solid:
    """A closed skin over rings of equally many points, its ends closed by flat caps; it has no collision shapes.

    rings: (N, 3) each, metres, counter-clockwise when looking back along the direction from the first ring to the last.
    The sequence may turn back on itself: up the outside, over the rim and down the inside makes a vessel. crease_deg:
    edges with a larger angle between their faces are shaded as sharp, as in Solid.
    """
    n = len(rings[0])
    faces = [*ring_walls(n, len(rings)), _cap(rings[0])[:, ::-1], _cap(rings[-1]) + (len(rings) - 1) * n]
    return Solid(np.concatenate(list(rings)), np.concatenate(faces).astype(np.int64), crease_deg=crease_deg)


def inset_rings(outline: Floats, steps: Sequence[Vec2]) -> list[Floats]:
    """Copies of an outline, each moved inwards by an inset and raised to a height z.

    outline: (N, 2), metres, counter-clockwise. steps: (inset, z) of each ring, metres; a negative inset widens it.
    """
    loop = np.asarray(outline, dtype=np.float64)
    n = len(loop)
    return [np.column_stack([offset_sides(loop, [d] * n) if d else loop, np.full(n, z)]) for d, z in steps]


def basin(outline: Floats, depth: float, wall: float, fillet: float, lip: float = 0.0) -> Solid:
    """An open basin below z = 0: `outline` is the inside of its mouth.

    outline: (N, 2), counter-clockwise, metres. wall: thickness. fillet: radius at the floor. lip: width of its rim.
    """
    fillet_arc = [(fillet * (1 - np.cos(t)), -depth + fillet * (1 - np.sin(t))) for t in np.linspace(0.0, np.pi / 2, 5)]
    if lip > 0:
        outer = [(-wall, -depth - wall), (-wall, -wall), (-wall - lip, -wall), (-wall - lip, 0.0)]
    else:
        outer = [(-wall, -depth - wall), (-wall, 0.0)]
    return loft(inset_rings(outline, [*outer, *[(0.0, 0.0), *[(float(d), float(z)) for d, z in fillet_arc]]]), 50.0)


def _cap(ring: Floats) -> Ints:
    """(F, 3) triangles that fill a flat (N, 3) ring; they turn the same way as the ring does."""
    normal = np.cross(np.roll(ring, -1, axis=0) - ring.mean(axis=0), ring - ring.mean(axis=0)).sum(axis=0)
    flat = np.delete(ring, int(np.argmax(np.abs(normal))), axis=1)
    if signed_area(flat) < 0:
        return np.asarray((len(ring) - 1 - np.asarray(manifold3d.triangulate([flat[::-1]]), dtype=np.int64))[:, ::-1])
    return np.asarray(manifold3d.triangulate([flat]), dtype=np.int64)


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
    places = [(x, y, math.radians(a + t)) for x, y, a in corners for t in np.linspace(0.0, 90.0, steps + 1)]
    return np.array([(x + r * math.cos(turn), y + r * math.sin(turn)) for x, y, turn in places])


def inset(outline: Floats, by: float) -> Floats:
    """(N, 2) outline moved inwards by metres along its mitres; the number of points stays."""
    forward = np.roll(outline, -1, axis=0) - outline
    forward /= np.linalg.norm(forward, axis=1)[:, None]
    normal = np.stack([-forward[:, 1], forward[:, 0]], axis=1)  # inwards where counter-clockwise
    mitre = normal + np.roll(normal, 1, axis=0)
    mitre /= np.maximum(np.einsum("ij,ij->i", mitre, normal), 0.2)[:, None]
    return np.asarray(outline + by * mitre)


def prism(outline: Floats, height: float, chamfer: float = 0.001, holes: Sequence[Floats] = ()) -> Solid:
    """An outline in x, y extruded along z from 0 to `height`; unless shapes are added, its hull is its collider.

    outline: (N, 2) simple polygon, metres, counter-clockwise. chamfer: of the rims of the outer outline and of the
    holes (0: sharp). holes: (M, 2) outlines inside it, counter-clockwise.
    """
    e = min(chamfer, 0.45 * height)
    levels = [(0.0, 0.0), (height, 0.0)] if e <= 0 else [(0.0, e), (e, 0.0), (height - e, 0.0), (height, e)]
    loops = [np.asarray(outline, dtype=np.float64), *(np.asarray(h, dtype=np.float64)[::-1] for h in holes)]
    flat = [[(inset(loop, cut) if cut else loop, z) for z, cut in levels] for loop in loops]
    return stack_rings([[np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings] for rings in flat], 50.0)


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
        u, w = corner + a * reach - middle, corner + b * reach - middle
        sweep = math.acos(float(np.clip(u @ w / (r * r), -1, 1)))
        for t in np.linspace(0.0, 1.0, steps + 1):
            out.append(middle + (math.sin((1 - t) * sweep) * u + math.sin(t * sweep) * w) / math.sin(sweep))
    out.append(line[-1])
    return np.array(out)


def tube(path: Sequence[Vec3], section: float | Floats, bend: float = 0.0, up: Vec3 = (0.0, 0.0, 1.0)) -> Solid:
    """A cross-section swept along a path, its ends closed flat.

    path: corner points, metres. section: radius of a round one, or (N, 2) outline, counter-clockwise: x across, y
    towards `up`. bend: radius with which corners are rounded; 0 mitres them. up: direction that the section's y points
    to as far as it can. Each straight piece of `path` has a capsule (round) or box (outline) as collider.
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
        rings.append(line[k] + flat + (-(flat @ plane) / float(arrive @ plane))[:, None] * arrive)
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
    for t in np.asarray(manifold3d.triangulate([outline]), dtype=np.int64):
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
    """A profile swept around a rectangle in the plane x, z, mitred: a picture frame; it has no collision shapes.

    width, height: of the rectangle that the profile's origin runs along, metres; its middle is the origin. profile: (N,
    2) closed outline, counter-clockwise: x away from the rectangle's middle, y out of the front.
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


def room_moulding(loop: Floats, profile: Floats) -> Solid:
    """A moulding along all walls, mitred at every corner; its colliders are the hulls of its sides.

    loop: (N, 2) corners of the room, counter-clockwise, metres. profile: (M, 2) closed outline, counter-clockwise:
    distance from the wall, and z. The height of its picture runs along each side.
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
            along = points[[a, b, c, d], :2] @ run[k]
            flat = np.column_stack([[perimeter[i], perimeter[i + 1], perimeter[i + 1], perimeter[i]], along])
            faces += [(a, d, c), (a, c, b)]
            uv_m += [flat[[0, 3, 2]], flat[[0, 2, 1]]]
    body = Solid(points, np.array(faces, dtype=np.int64), uv_m=np.array(uv_m), crease_deg=40.0).oriented_outwards()
    corners, after = points.reshape(n, m, 3), np.roll(points, -m, axis=0).reshape(n, m, 3)
    return body.with_colliders_of(*(hull_around(np.concatenate([corners[k], after[k]])) for k in range(n)))


def straight_moulding(profile: Floats, length: float, left: float, right: float) -> Solid:
    """A moulding along x from 0 to `length`, measured at y = 0; unless shapes are added, its hull is its collider.

    profile: (M, 2) closed outline, counter-clockwise: distance from the wall (towards -y), and z. left, right: how much
    farther than at the wall an end reaches out, per metre of distance from the wall: 0 for a square cut, 1 for a mitre
    around an outer corner, -1 for one in an inner corner. Its picture's height runs along x.
    """
    m = len(profile)
    d, z = profile[:, 0], profile[:, 1]
    points = np.concatenate([np.column_stack([x, -d, z]) for x in (-left * d, length + right * d)])
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
    return Solid(points, np.array(faces, dtype=np.int64), uv_m=np.array(uv_m), crease_deg=40.0).oriented_outwards()


def _perimeter(profile: Floats) -> Floats:
    """(M + 1,) length along the outline up to each point, metres."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(profile, -1, axis=0) - profile, axis=1))])
