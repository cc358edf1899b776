"""Bodies of prepared food: domes, long bodies, rings, coats, ridges, and what is strewn on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline, LinearNDInterpolator, NearestNDInterpolator

from casa_assets.ext.arrays import Floats, counter_clockwise, face_normals
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import Solid, concatenate, hull_around
from casa_assets.kitchenware.objects.closed_surface import (
    bumped,
    capped_rings,
    ellipsoid,
    run_along,
    smooth_profile,
    turned,
)

CREASE = 60.0  # degrees; food is soft
# Bend in a long body from which on it has several hulls, rad.
BENT = 0.35

Piece = StrEnum("Piece", "SEED ROD CHIP BALL DISC SHRED")

# Half lengths of a piece along x, y, z by its size.
_PIECES = {
    Piece.SEED: (0.5, 0.32, 0.16), Piece.ROD: (0.5, 0.12, 0.12), Piece.CHIP: (0.5, 0.42, 0.3),
    Piece.BALL: (0.5, 0.5, 0.5), Piece.DISC: (0.5, 0.5, 0.07), Piece.SHRED: (0.5, 0.08, 0.05),
}  # fmt: skip


def outline_curve(points: Sequence[Vec2], length: float, width: float, count: int) -> Floats:
    """(count, 2) even points of a smooth closed curve through some points, counter-clockwise, scaled to a box.

    points: in order round the outline, about the origin, in any unit. length, width: of the box about it, metres.
    """
    corners = np.array(points, dtype=np.float64)
    loop = np.vstack([corners, corners[:1]])
    run = run_along(loop)
    fine = CubicSpline(run, loop, bc_type="periodic")(np.linspace(0.0, run[-1], 40 * count))
    fine = fine - (fine.min(axis=0) + fine.max(axis=0)) / 2
    fine *= np.array([length, width]) / np.ptp(fine, axis=0)
    along = run_along(fine)
    even = np.arange(count) / count * along[-1]
    return counter_clockwise(np.stack([np.interp(even, along, fine[:, k]) for k in (0, 1)], axis=1))


def superellipse(length: float, width: float, power: float = 2.0, count: int = 40) -> Floats:
    """(count, 2) points of a rounded outline about the origin: power 2 is an ellipse, more is squarer."""
    angle = np.arange(count) * 2 * np.pi / count
    c, s = np.cos(angle), np.sin(angle)
    radius = (np.abs(c) ** power + np.abs(s) ** power) ** (-1.0 / power)
    return np.stack([0.5 * length * radius * c, 0.5 * width * radius * s], axis=1)


def outline_of_food(points: Sequence[Vec2], length: float, width: float, power: float, count: int = 40) -> Floats:
    """(count, 2) points of `outline_curve`, or without points of `superellipse`."""
    return outline_curve(points, length, width, count) if points else superellipse(length, width, power, count)


def dome(outline: Floats, profile: Sequence[Vec2], height: float, rings: int = 15) -> Solid:
    """A body over an outline, from the middle of its underside over its rim to that of its upper side.

    Its picture is a disc: its middle is that of either side, its circle the rim. outline: (N, 2), counter-clockwise,
    seen whole from the origin, metres. profile: (share of the outline, share of the height), at both ends (0, ...).
    """
    curve = smooth_profile(list(profile), rings)
    n = len(outline)
    inner = curve[1:-1]
    below, above = ([[0.0, 0.0, height * z]] for z in curve[[0, -1], 1])
    loops = [np.column_stack([outline * share, np.full(n, height * z)]) for share, z in inner]
    points = np.concatenate([below, *loops, above])
    run = run_along(np.column_stack([curve[:, 0] * (float(np.ptp(outline, axis=0).mean()) / 2), curve[:, 1] * height]))
    rim = int(np.argmax(curve[:, 0]))
    share = np.where(np.arange(len(run)) <= rim, run / run[rim], (run[-1] - run) / (run[-1] - run[rim]))
    angle = np.arctan2(outline[:, 1], outline[:, 0])
    ring_uv = 0.5 + 0.49 * share[1:-1, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    uv = np.concatenate([[[0.5, 0.5]], ring_uv.reshape(-1, 2), [[0.5, 0.5]]])
    faces = capped_rings(n, len(inner))
    return Solid(points, faces, crease_deg=CREASE, picture_uv=uv[faces])


def uneven(body: Solid, bumps: float, waves: float, rise: float, length: float, rng: np.random.Generator) -> Solid:
    """A dome with bumps on a flat foot; or a thin one that rises and falls by `rise`, with `waves` to a length, m."""
    points = bumped(body.points, bumps, waves, rng)
    points[:, 2] += rise * smooth_noise(points[:, :2], waves / length, rng)
    return replace(body, points=points if rise else flat_foot(points))


def long_body(
    profile: Sequence[Vec2],
    length: float,
    width: float,
    height: float,
    *,
    square: float = 2.0,
    square_top: float = 2.0,
    foot: float = 1.0,
    cut: float = 1.0,
    around: int = 28,
    along: int = 27,
) -> Solid:
    """A body about the x axis, from -x to +x; its picture runs round it and from end to end.

    profile: (radius, place) from one end to the other, both 0..1; the first and last radius are 0. square, square_top:
    powers of the superellipse of its section below and above; 2 is an ellipse. foot: share of the half height below the
    axis at which it is flat. cut: place at which it is cut off square; what is left has the whole length.
    """
    curve = smooth_profile(list(profile), along)
    if cut < 1:
        kept = curve[curve[:, 1] < cut - 0.005]
        curve = np.vstack([kept, [(float(np.interp(cut, curve[:, 1], curve[:, 0])), cut), (0.0, cut)]]) / (1.0, cut)
    body = turned(curve, around, CREASE)
    c, s, place = body.points[:, 0], body.points[:, 1], body.points[:, 2]
    radius = np.hypot(c, s)
    angle = np.arctan2(s, c)
    power = np.where(s < 0, square, square_top)
    out = radius * (np.abs(np.cos(angle)) ** power + np.abs(np.sin(angle)) ** power) ** (-1.0 / power)
    y, z = 0.5 * width * out * np.cos(angle), 0.5 * height * out * np.sin(angle)
    z = np.maximum(z, -0.5 * height * foot)
    return replace(body, points=np.column_stack([length * (place - 0.5), y, z])).oriented_outwards()


def cut_face(points: Floats) -> Solid:
    """The inside on the face at +x where a long body is cut: a thin plate a millimetre proud of it."""
    end = points[np.isclose(points[:, 0], points[:, 0].max())]
    rim = end[np.hypot(end[:, 1], end[:, 2]) > 1e-4]
    rim = rim[np.argsort(np.arctan2(rim[:, 2], rim[:, 1]))]
    outline = np.column_stack([-rim[:, 2], rim[:, 1]]) * 0.94
    face = dome(outline, [(0, 0), (0.97, 0), (1, 0.5), (0.97, 1), (0, 1)], 0.003, 9)
    return face.rotated("y", math.pi / 2).translated(x=float(rim[0, 0]) - 0.002)


def bent_level(points: Floats, angle: float, length: float) -> Floats:
    """Points about the x axis bent level by an angle over a length, rad, metres; both ends move towards +y."""
    if abs(angle) < 1e-6:
        return points
    radius = length / angle
    turn = points[:, 0] / radius
    out = radius - points[:, 1]
    return np.column_stack([out * np.sin(turn), radius - out * np.cos(turn), points[:, 2]])


def ring_body(
    diameter: float, height: float, hole: float, power: float = 2.2, around: int = 40, section: int = 18
) -> Solid:
    """A ring about z; its picture runs round it, and from below over the outside and the top back through the hole."""
    half, middle = (diameter - hole) / 4, (diameter + hole) / 4
    angle = -np.pi / 2 + np.arange(section) * 2 * np.pi / section
    c, s = np.cos(angle), np.sin(angle)
    radius = (np.abs(c) ** power + np.abs(s) ** power) ** (-1.0 / power)
    r, z = middle + half * radius * c, 0.5 * height * radius * s
    turn = np.arange(around) * 2 * np.pi / around
    x, y = r[None] * np.cos(turn)[:, None], r[None] * np.sin(turn)[:, None]
    points = np.stack([x, y, np.broadcast_to(z, (around, section))], axis=2)
    faces, uv = [], []
    for i in range(around):
        for j in range(section):
            i1, j1 = (i + 1) % around, (j + 1) % section
            a, b, c4, d = i * section + j, i1 * section + j, i1 * section + j1, i * section + j1
            u0, u1, v0, v1 = i / around, (i + 1) / around, j / section, (j + 1) / section
            faces += [(a, b, c4), (a, c4, d)]
            uv += [((u0, v0), (u1, v0), (u1, v1)), ((u0, v0), (u1, v1), (u0, v1))]
    body = Solid(points.reshape(-1, 3), np.array(faces, dtype=np.int64), crease_deg=CREASE, picture_uv=np.array(uv))
    return body.oriented_outwards()


def seen_from_above(solid: Solid) -> Solid:
    """The solid under a picture that is laid over it from above: its width along x, its height along y."""
    low, high = solid.bounds
    return replace(solid, picture_uv=((solid.points[:, :2] - low[:2]) / (high - low)[:2]).clip(0.0, 1.0)[solid.faces])


def vertex_normals(solid: Solid) -> Floats:
    """(P, 3) unit normals of the points."""
    normals, areas = face_normals(solid.points, solid.faces)
    total = np.zeros_like(solid.points)
    for k in range(3):
        np.add.at(total, solid.faces[:, k], normals * areas[:, None])
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12))


def coated(solid: Solid, thickness: float, level: float, wave: float, rng: np.random.Generator) -> Solid:
    """A coat over the upper part of a body: it lies outside the body there, and under its surface below.

    level: share of the body's height above which it is coated. wave: how far its edge rises and falls, by the height.
    """
    points = solid.points
    low, high = points[:, 2].min(), points[:, 2].max()
    edge = np.full(len(points), level)
    if wave > 0:
        edge = edge + wave * smooth_noise(points[:, :2], 4.0 / float(np.ptp(points[:, 0])), rng)
    side = np.clip((((points[:, 2] - low) / (high - low)) - edge) / 0.09, -1.0, 1.0)
    out = thickness * np.where(side > 0, np.sqrt(np.abs(side)), side)
    return replace(solid, points=points + vertex_normals(solid) * out[:, None], shapes=())


def smooth_noise(points: Floats, waves: float, rng: np.random.Generator) -> Floats:
    """(P,) smooth random values of about -1..1 at points of any dimension; `waves` to a metre."""
    total = np.zeros(len(points))
    for _ in range(6):
        way = np.asarray(rng.normal(size=points.shape[1]))
        way = way / np.linalg.norm(way) * (waves * 2 * np.pi * rng.uniform(0.5, 1.3))
        total += np.sin(points @ way + rng.uniform(0.0, 2 * np.pi))
    return total / 2.6


class Surface:
    """The upper side of a body, by place: its height above a point of the ground."""

    def __init__(self, solid: Solid) -> None:
        upper = solid.points[vertex_normals(solid)[:, 2] > 0.05]
        # Of points above one another only the highest counts.
        upper = upper[np.argsort(-upper[:, 2])]
        _, first = np.unique(np.round(upper[:, :2], 5), axis=0, return_index=True)
        upper = upper[first]
        self._inside = LinearNDInterpolator(upper[:, :2], upper[:, 2])
        self._nearest = NearestNDInterpolator(upper[:, :2], upper[:, 2])

    def height(self, places: Floats) -> Floats:
        """(N,) z over (N, 2) places, metres; beyond the rim that of the nearest point."""
        found = np.asarray(self._inside(places))
        return np.asarray(np.where(np.isnan(found), self._nearest(places), found))


def ridge(surface: Surface, path: Floats, width: float, height: float, lens: bool) -> Solid:
    """A raised line that lies on a surface: a burst score of a loaf, icing out of a bag, a mark of a grill.

    path: (N, 2) places, smoothed to 12 pieces or more. width, height: of its section. lens: it narrows at both ends.
    """
    line = np.asarray(path, dtype=np.float64)
    run = run_along(line)
    count = max(12, 4 * (len(line) - 1))
    at = np.linspace(0.0, run[-1], count)
    straight = np.stack([np.interp(at, run, line[:, k]) for k in (0, 1)], 1)
    dense = CubicSpline(run, line)(at) if len(line) > 2 else straight
    z = surface.height(dense)
    forward = np.gradient(dense, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    side = np.stack([-forward[:, 1], forward[:, 0]], axis=1)
    t = np.linspace(0.0, 1.0, count)
    swell = np.sin(np.pi * t) ** 0.7 if lens else np.minimum(1.0, np.minimum(t, 1 - t) * count / 1.5) ** 0.5
    swell = np.maximum(swell, 0.04)
    angle = np.linspace(0.0, 2 * np.pi, 8, endpoint=False)
    rings = []
    for p, n, level, s in zip(dense, side, z, swell, strict=True):
        places = p + (0.5 * width * s * np.cos(angle))[:, None] * n
        base = surface.height(places) if lens else np.full(8, level)
        rings.append(np.column_stack([places, base + height * (s * 0.5 * np.sin(angle) + 0.5 - 0.35)]))
    points = np.concatenate([rings[0].mean(axis=0)[None], *rings, rings[-1].mean(axis=0)[None]])
    return Solid(points, capped_rings(8, count), crease_deg=75.0).oriented_outwards()


def ridges(
    top: Solid, box: Floats, lines: Sequence[Sequence[Vec2]], width: float, height: float, *, lens: bool
) -> Solid:
    """Raised lines on a surface, as one body.

    top: what they lie on. box: (2, 3) lower and upper corner that they are drawn in, metres. lines: paths in shares of
    its length and width, about its middle. width, height, lens: as of `ridge`.
    """
    surface, size, middle = Surface(top), np.ptp(box, axis=0)[:2], (box[0] + box[1])[:2] / 2
    return joined([ridge(surface, np.array(line) * size + middle, width, height, lens) for line in lines])


def strewn(
    solid: Solid,
    kind: Piece,
    count: int,
    size: float,
    rng: np.random.Generator,
    *,
    steep: float = 0.35,
    above: float = 0.0,
    sunk: float = 0.25,
    apart: float = 1.0,
    within: float = 1.5,
) -> list[Solid]:
    """Small things on the upper side of a body, each turned at random and a little different in size.

    size: length of one, metres. steep: least z of the normal where one may lie. above: share of the height below which
    none lies. sunk: share of a piece's height that is in the body. apart: least distance between two by the size.
    within: how far from the middle one may lie, by the half sides of the body's box.
    """
    normals, areas = face_normals(solid.points, solid.faces)
    centers = solid.points[solid.faces].mean(axis=1)
    low, high = solid.bounds[:, 2]
    middle, half_sides = solid.bounds[:, :2].mean(axis=0), np.ptp(solid.bounds[:, :2], axis=0) / 2
    share = np.where((normals[:, 2] > steep) & (centers[:, 2] > low + above * (high - low)), areas, 0.0)
    if count < 1 or share.sum() <= 0:
        return []
    half = np.array(_PIECES[kind]) * size
    if kind is Piece.DISC:
        rim = [(0, 0), (0.8, 0), (1, 0.3), (1, 0.7), (0.8, 1), (0, 1)]
        small = dome(superellipse(size, size, count=14), rim, 0.14 * size, 7).translated(z=-half[2])
    else:
        fine = (10, 6) if kind in (Piece.BALL, Piece.CHIP) else (6, 5)
        small = ellipsoid((2 * half[0], 2 * half[1], 2 * half[2]), *fine)
    taken: list[Floats] = []
    out: list[Solid] = []
    for face in rng.choice(len(share), size=6 * count, p=share / share.sum()):
        if len(out) == count:
            break
        place = rng.dirichlet(np.ones(3)) @ solid.points[solid.faces[face]]
        if float(np.linalg.norm((place[:2] - middle) / half_sides)) > within:
            continue
        if any(float(np.linalg.norm(place - other)) < apart * size for other in taken):
            continue
        taken.append(place)
        out.append(_placed(small, place, normals[face], rng, sunk * half[2]))
    return out


def _placed(small: Solid, place: Floats, normal: Floats, rng: np.random.Generator, sunk: float) -> Solid:
    turn = rng.uniform(0.0, 2 * np.pi)
    x = np.array([math.cos(turn), math.sin(turn), 0.0])
    x -= normal * float(x @ normal)
    if np.linalg.norm(x) < 1e-6:
        x = np.array([0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(normal, x), normal])
    height = float(small.points[:, 2].max())
    points = (small.points * rng.uniform(0.85, 1.15)) @ frame + place + normal * (height - 2 * sunk)
    return replace(small, points=points)


def hulls_by(points: Floats, key: Floats, count: int) -> list[Solid]:
    """Hulls that cover points piece by piece along a key, such as x or the angle about z; neighbours share an edge."""
    edges = np.linspace(float(key.min()), float(key.max()), count + 1)
    margin = 1e-6 + 0.02 * float(edges[1] - edges[0])
    return [hull_around(points[(key >= low - margin) & (key <= high + margin)]) for low, high in pairwise(edges)]


def hulls_of_bent(body: Solid, bend: float) -> list[Solid]:
    """Hulls of a long body that was bent level by an angle, rad: one, or several along it."""
    if abs(bend) <= BENT:
        return [body.with_hull_collider()]
    return hulls_by(body.points, body.points[:, 0], 2 + 2 * math.ceil(abs(bend) / 1.2))


def hull_of(*solids: Solid) -> Solid:
    """One hull over several bodies, without a surface."""
    return hull_around(np.concatenate([s.points for s in solids]))


def flat_foot(points: Floats, share: float = 0.03) -> Floats:
    """Points whose lowest share of the height is flat, so that the body rests on a face."""
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    return np.column_stack([points[:, :2], np.maximum(points[:, 2], low + share * (high - low))])


def plain(solid: Solid) -> Solid:
    """The solid without coordinates of a picture and shapes to touch, so that it may be joined with any other."""
    return replace(solid, picture_uv=None, uv_m=None, shapes=())


def joined(solids: Sequence[Solid]) -> Solid:
    """Bodies as one, without shapes to touch."""
    return concatenate([s.without_colliders() for s in solids])
