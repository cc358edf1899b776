"""Bodies of prepared food (domes, long bodies, rings, coats) and of lobsters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field
from scipy.interpolate import CubicSpline, LinearNDInterpolator, NearestNDInterpolator

from casa_assets.ext.arrays import Floats, counter_clockwise, face_normals
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, circle, concatenate, hull_around, tube
from casa_assets.kitchenware.objects.closed_surface import (
    bumped,
    capped_rings,
    ellipsoid,
    run_along,
    smooth_profile,
    turned,
)

# Bodies ---------------------------------------------------------------------------------------------------------------

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

    points: in order round the outline, about the origin, in any unit. length, width: of the box along x and y, metres;
    its middle is the origin.
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
    """A body over an outline, from the middle of its underside over its rim to the middle of its upper side.

    Its picture is a disc: the middle of the picture is the middle of either side, the circle in it is the rim.

    outline: (N, 2), counter-clockwise, seen whole from the origin, metres. profile: (share of the outline, share of the
    height), the first and last share of the outline 0.
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


@dataclass(frozen=True)
class Unevenness:
    """How far a body is from its plain form."""

    bumps: float  # as of `bumped`
    waves: float  # as of `bumped`, or over `length`
    wave: float  # rise and fall of a thin thing, m
    length: float  # m


def uneven_dome(
    outline: Floats, profile: Sequence[Vec2], height: float, uneven: Unevenness, rng: np.random.Generator
) -> Solid:
    """As `dome`, but uneven: with bumps on a flat foot, or one that rises and falls."""
    body = dome(outline, profile, height)
    points = bumped(body.points, uneven.bumps, uneven.waves, rng)
    points[:, 2] += uneven.wave * smooth_noise(points[:, :2], uneven.waves / uneven.length, rng)
    return replace(body, points=points if uneven.wave else flat_foot(points))


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
    half = (diameter - hole) / 4
    middle = (diameter + hole) / 4
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

    thickness: metres. level: share of the body's height above which it is coated. wave: how far the edge rises and
    falls, as a share of the height.
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

    path: (N, 2) places that it passes, metres; it is smoothed to 12 pieces or more. width, height: of its section,
    metres. lens: it narrows to nothing at both ends.
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
        weights = rng.dirichlet(np.ones(3))
        place = weights @ solid.points[solid.faces[face]]
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


# Crustacean -----------------------------------------------------------------------------------------------------------

Metres = Annotated[float, Field(gt=0, le=0.6)]
SHELL: tuple[Vec2, ...] = (
    (0, 0), (0.62, 0.01), (0.86, 0.1), (1, 0.35), (0.94, 0.62), (0.62, 0.86), (0.2, 0.98), (0, 1),
)  # fmt: skip
RING = ((0, 0), (0.9, 0.02), (0.96, 0.2), (1, 0.55), (0.99, 0.85), (0.9, 0.98), (0, 1))
FLAT = ((0, 0), (0.7, 0.04), (0.94, 0.25), (1, 0.5), (0.94, 0.75), (0.7, 0.96), (0, 1))
# A claw from above, its wrist at -x, and the same of the finger that moves; in shares of its length and width.
PALM = (
    *((-0.5, -0.1), (-0.3, -0.42), (0.0, -0.5), (0.28, -0.34), (0.5, -0.08)),
    *((0.3, 0.0), (0.06, 0.06), (-0.1, 0.3), (-0.36, 0.26), (-0.5, 0.1)),
)
FINGER = ((-0.12, 0.3), (0.05, 0.5), (0.3, 0.42), (0.48, 0.1), (0.3, 0.16), (0.1, 0.14))
FAN = ((-0.5, 0.0), (-0.1, -0.34), (0.3, -0.5), (0.5, -0.2), (0.5, 0.2), (0.3, 0.5), (-0.1, 0.34))


class Crustacean(Params):
    """Parameters of a lobster that lies along x, its head at +x; lengths in metres."""

    length: Metres = Field(description="from the end of the fan to the tip of the head, were the tail straight, m")
    width: Metres = Field(description="of the shell, m")
    height: Metres = Field(description="of the shell, m")
    tail: float = Field(0.52, ge=0.35, le=0.7, description="share of the length that is tail")
    rings: int = Field(6, ge=4, le=7, description="of the tail")
    curl: float = Field(0.1, ge=0, le=0.6, description="how far the tail bends down at its end, rad")
    claw: Metres = Field(description="length of the larger claw, m")
    claw_width: Metres = Field(description="of the larger claw, m")
    other_claw: float = Field(0.9, ge=0.6, le=1, description="size of the other claw by that")
    spread: float = Field(0.5, ge=0, le=1.2, description="angle between an arm and the axis, rad")
    gape: float = Field(0.1, ge=0, le=0.5, description="how far a claw is open, rad")
    feeler: Metres = Field(description="length of the long feelers, which lie back along the body, m")
    band: FinishId | None = Field(None, description="of a rubber band round each claw; None: no band")
    density: float = Field(900.0, ge=300, le=1400, description="kg/m^3")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId
    limb_finish: FinishId = "dish_lobster"
    eye_finish: FinishId = "dish_eye"


def build(builder: AssetBuilder, p: Crustacean) -> None:
    """Build the asset: it rests on z = 0."""
    rng = np.random.Generator(np.random.PCG64(p.seed))
    shell, tail, fan = _shell(p, rng), _tail(p), _fan(p)
    claws, limbs, bands = [], [*_legs(p), *_feelers(p, rng)], []
    larger = 1 if rng.random() < 0.5 else -1
    for side in (-1, 1):
        claw, arm, band = _claw(p, side, 1.0 if side == larger else p.other_claw)
        claws.append(claw)
        limbs.append(arm)
        bands.append(band)
    low = min(float(s.points[:, 2].min()) for s in (shell, *tail, *fan, *claws))
    # Legs and feelers reach the ground and not below it.
    limbs = [replace(s, points=np.column_stack([s.points[:, :2], np.maximum(s.points[:, 2], low)])) for s in limbs]
    hulls = [hull_of(shell), hull_of(*tail[: p.rings // 2 + 1]), hull_of(*tail[p.rings // 2 :], *fan)]
    body = joined([shell, *tail]).translated(z=-low).with_colliders_of(*(h.translated(z=-low) for h in hulls))
    builder.add(ROOT, body, p.skin, label="body", name="body", density=p.density)
    for parts, finish, label in ((fan, p.limb_finish, "fan"), (limbs, p.limb_finish, "limb")):
        builder.add(ROOT, joined([plain(s) for s in parts]).translated(z=-low), finish, label=label, collider=False)
    for touched in (limbs[:4], limbs[4:8], limbs[-2:-1], limbs[-1:]):
        builder.add_collider(ROOT, hull_of(*touched).translated(z=-low), p.limb_finish, "limb")
    for claw in claws:
        solid = plain(claw).translated(z=-low)
        builder.add(ROOT, solid.with_hull_collider(), p.limb_finish, label="claw", density=p.density)
    if p.band is not None:
        builder.add(ROOT, joined(bands).translated(z=-low), p.band, label="band", collider=False)
    head = p.length * (1 - p.tail)
    eyes = [
        ellipsoid((0.07 * p.width,) * 3, 10, 7).translated(0.86 * head, side * 0.22 * p.width, 0.68 * p.height - low)
        for side in (-1, 1)
    ]
    builder.add(ROOT, joined(eyes), p.eye_finish, label="eye", collider=False, density=0.0)


def _shell(p: Crustacean, rng: np.random.Generator) -> Solid:
    """The shell of head and breast, from x = 0 to the tip of the head, its axis at half its height."""
    long = p.length * (1 - p.tail)
    body = long_body(SHELL, long, p.width, p.height, square=2.4, foot=0.75, around=22, along=17)
    points = bumped(body.points, 0.015, 3.0, rng)
    return replace(body, points=points).translated(long / 2, 0.0, p.height / 2)


def _on_tail(p: Crustacean, points: Floats) -> Floats:
    """Points about x = 0 .. -length of the tail bent down along it."""
    long = p.length * p.tail
    drop = 0.5 * p.curl * long * np.clip(-points[:, 0] / long, 0.0, 1.2) ** 2 * 0.6
    return np.column_stack([points[:, :2], points[:, 2] - np.minimum(drop, 0.2 * p.height)])


def _tail(p: Crustacean) -> list[Solid]:
    long = 0.8 * p.length * p.tail
    out = []
    for k in range(p.rings):
        t = k / p.rings
        size = 0.94 - 0.4 * t
        wide, high = size * p.width, size * 0.9 * p.height
        ring = long_body(RING, 1.35 * long / p.rings, wide, high, square=2.3, foot=0.7, along=9, around=16)
        ring = ring.translated(-(k + 0.5) / p.rings * long, 0.0, (0.42 - 0.06 * t) * p.height)
        out.append(replace(ring, points=_on_tail(p, ring.points)))
    return out


def _fan(p: Crustacean) -> list[Solid]:
    long = p.length * p.tail
    out = []
    for k, turn in enumerate((-0.75, 0.75, -0.38, 0.38, 0.0)):
        lobe = dome(outline_curve(FAN, 0.3 * long, 0.42 * p.width, 16), FLAT, 0.006, 6).translated(x=0.13 * long)
        lobe = lobe.rotated("z", math.pi + turn).translated(-0.74 * long, 0.0, 0.2 * p.height + 0.002 * k)
        out.append(replace(lobe, points=_on_tail(p, lobe.points)))
    return out


def _claw(p: Crustacean, side: int, size: float) -> tuple[Solid, Solid, Solid]:
    long, wide = p.claw * size, p.claw_width * size
    thick = 0.5 * wide
    palm = dome(outline_curve(PALM, long, 0.8 * wide, 30), FLAT, thick, 9).translated(y=-0.1 * wide)
    finger = dome(outline_curve(FINGER, 0.6 * long, 0.36 * wide, 18), FLAT, 0.7 * thick, 7)
    finger = finger.translated(0.18 * long, 0.3 * wide, 0.15 * thick).rotated(
        "z", p.gape, (-0.1 * long, 0.3 * wide, 0.0)
    )
    claw = joined([plain(palm), plain(finger)])
    if side < 0:
        claw = claw.mirrored_x().rotated("z", math.pi)
    head = p.length * (1 - p.tail)
    elbow = np.array([0.95 * head, side * (0.5 * p.width + 0.2 * long * (0.4 + p.spread)), 0.3 * p.height])
    wrist = np.array([head + 0.15 * long, side * (0.5 * p.width + 0.35 * long * (0.3 + p.spread)), 0.28 * p.height])
    turn = side * p.spread * 0.35
    way = np.array([math.cos(turn), math.sin(turn), 0.0])
    middle = wrist + 0.48 * long * way
    claw = claw.rotated("z", turn).translated(float(middle[0]), float(middle[1]), 0.28 * p.height - 0.5 * thick)
    shoulder = (0.62 * head, side * 0.3 * p.width, 0.35 * p.height)
    path = [shoulder, *((float(x), float(y), float(z)) for x, y, z in (elbow, wrist))]
    arm = tube(path, circle(0.15 * wide, 8), 0.2 * wide).without_colliders()
    x, y, _ = (float(v) for v in middle + 0.06 * long * way)
    turns = np.linspace(0.0, 2 * np.pi, 22, endpoint=False)
    loop = np.column_stack([0 * turns, 0.45 * wide * np.cos(turns), 0.54 * thick * np.sin(turns)])
    c, s = math.cos(turn), math.sin(turn)
    loop = np.column_stack([x - s * loop[:, 1], y + c * loop[:, 1], 0.28 * p.height + loop[:, 2]])
    loop = np.vstack([loop, loop[:2]])
    return claw, arm, tube([(float(a), float(b), float(d)) for a, b, d in loop], circle(0.0035, 6)).without_colliders()


def _legs(p: Crustacean) -> list[Solid]:
    head = p.length * (1 - p.tail)
    out = []
    for side in (-1, 1):
        for k in range(4):
            x = head * (0.6 - 0.13 * k)
            sweep = 0.25 - 0.22 * k
            knee = (x + 0.5 * sweep * p.width, side * 0.85 * p.width, 0.42 * p.height)
            foot = (x + 1.1 * sweep * p.width, side * 1.3 * p.width, 0.05 * p.height)
            hip = (x, side * 0.35 * p.width, 0.3 * p.height)
            out.append(tube([hip, knee, foot], circle(0.045 * p.width, 6), 0.06 * p.width).without_colliders())
    return out


def _feelers(p: Crustacean, rng: np.random.Generator) -> list[Solid]:
    head = p.length * (1 - p.tail)
    out = []
    for side in (-1, 1):
        out_by = side * (0.75 + float(rng.uniform(0.0, 0.4))) * p.width
        start = (0.9 * head, side * 0.14 * p.width, 0.55 * p.height)
        path = [start, (1.12 * head, 0.4 * out_by, 0.75 * p.height), (head, out_by, 0.8 * p.height)]
        path.append((head - p.feeler, 1.15 * out_by, 0.35 * p.height))
        out.append(tube(path, circle(0.02 * p.width, 5), 0.2 * p.width))
        out.append(tube([start, (1.15 * head, side * 0.3 * p.width, 0.7 * p.height)], circle(0.015 * p.width, 5)))
    return [feeler.without_colliders() for feeler in out]
