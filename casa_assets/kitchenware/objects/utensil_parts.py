"""Bars swept along a curve (handles, spoons, blades), and the heads of utensils and tools at their other end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import manifold3d
import numpy as np
from pydantic import Field
from scipy.interpolate import PchipInterpolator

from casa_assets.errors import DegenerateShape
from casa_assets.ext import solids
from casa_assets.ext.arrays import Floats, Ints, convex_hull, signed_volume
from casa_assets.ext.families import Params
from casa_assets.ext.records import Vec2, Vec3, Vec5
from casa_assets.ext.solids import Solid
from casa_assets.kitchenware.objects.closed_surface import manifold_of, smooth_profile, turned

# Rings along a bar, and points round one.
ALONG, AROUND = 40, 20
# How much the turns of an outline draw its rings to them, against its length.
TURNING = 0.9
# A hollow deeper than this has a floor and rims as colliders of their own, metres.
DEEP = 0.0045
# Another hull is taken where it saves at least this share of the volume of those that there are.
SAVING, MAX_HULLS = 0.09, 4

Curve = tuple[Vec2, ...]


class Bar(Params):
    """The shape of a bar that runs along x, without its size."""

    outline: Curve = Field(
        min_length=4,
        max_length=24,
        description="(half width by half the width, along by the length) from end to end, from above",
    )
    other: Curve = Field((), max_length=24, description="the same of the -y side, with the same ends; empty: alike")
    spine: Curve = Field((), description="(along, height by the rise) of its middle")
    thick: Curve = Field((), description="(along, thickness by the largest)")
    dish: Curve = Field((), description="(along, depth by the dish) of a hollow that the underside follows")
    hollow: Curve = Field((), description="(along, depth by the hollow) of one cut into the upper side")
    wedge: Curve = Field((), description="(along, share) by which it is thinner at its -y side, as a blade is")
    square: float = Field(2.0, ge=1.5, le=12, description="2: a round section; more: a flatter one with rounder edges")
    holes: tuple[Vec5, ...] = Field((), description="(along, across by half the width, length, width, angle in rad)")


class Size(Params):
    """The size of a bar, metres; the fields are those that `Bar` measures its curves by."""

    length: float
    width: float
    thickness: float
    rise: float = 0.0
    dish: float = 0.0
    hollow: float = 0.0


def bar(shape: Bar, size: Size, along: int = ALONG, hulls: int = MAX_HULLS, span: Vec2 = (0.0, 1.0)) -> Solid:
    """A bar from x = 0 on, with colliders that follow it; one picture covers it, its height along x.

    along: rings along it. hulls: most colliders along it. span: part of its length to build, shares, as of a sleeve.
    """
    stations = _within(_stations(shape, size, along), span, size.length)
    width, x = stations[:, 0], stations[:, 1]
    share, other = x / size.length, width
    if shape.other:
        curve = smooth_profile([(w, s * 1000.0) for w, s in shape.other], 400)
        other = np.interp(share, curve[:, 1] / 1000.0, curve[:, 0]) * size.width / 2
    middle = _value(shape.spine, share, 0.0) * size.rise
    thickness = _value(shape.thick, share, 1.0) * size.thickness / 2
    dish, hollow = _value(shape.dish, share, 0.0) * size.dish, _value(shape.hollow, share, 0.0) * size.hollow
    wedge = _value(shape.wedge, share, 0.0)
    slope = (_value(shape.spine, share + 1e-3, 0.0) - _value(shape.spine, share - 1e-3, 0.0)) * size.rise
    slope = np.arctan2(slope, 2e-3 * size.length)
    half = AROUND // 2
    turn = np.pi * np.arange(AROUND) / half
    # Points are spread as on a circle; a squarer section is fuller towards its edges.
    eta = np.cos(turn)
    zeta = np.sign(np.sin(turn)) * np.maximum(0.0, 1 - np.abs(eta) ** shape.square) ** (1 / shape.square)
    zeta[[0, half]] = 0.0
    upper = zeta > 0
    y = ((width - other) / 2)[:, None] + ((width + other) / 2)[:, None] * eta
    lift = thickness[:, None] * zeta * (1 - wedge[:, None] * (1 - eta) / 2)
    lift = lift - (dish[:, None] * (1 - eta**2) + np.where(upper, hollow[:, None] * (1 - eta**2) ** 0.7, 0.0))
    sine, cosine = np.sin(slope)[:, None], np.cos(slope)[:, None]
    points = np.stack([x[:, None] - lift * sine, y, middle[:, None] + lift * cosine], axis=2)
    solid = lofted(points, share)
    pieces: list[Floats] = []
    if max(size.dish, size.hollow) > DEEP:
        deep = np.flatnonzero(np.maximum(dish, hollow) > 0.4 * max(size.dish, size.hollow))
        # A few rings at an end are no piece of their own.
        first = 0 if deep[0] <= 4 else int(deep[0])
        last = len(x) - 1 if deep[-1] >= len(x) - 4 else int(deep[-1])
        pieces = _bowl_pieces(points, first, last)
        pieces += _pieces(points[: first + 1], 1) if first > 0 else []
        pieces += _pieces(points[last:], hulls) if last < len(points) - 1 else []
    else:
        pieces = _pieces(points, hulls)
    hull_solids = [solids.hull_around(piece.reshape(-1, 3)) for piece in pieces]
    if shape.holes:
        solid = drilled(solid, ([_slot(hole, size, float(np.interp(hole[0], share, middle))) for hole in shape.holes]))
    return solid.with_colliders_of(*hull_solids)


def lofted(rings: Floats, share: Floats) -> Solid:
    """A closed skin over (M, N, 3) rings, its picture once round each; share: height of each ring in it, 0..1."""
    m, n = rings.shape[:2]
    points = np.concatenate([rings.reshape(-1, 3), rings[0].mean(axis=0)[None], rings[-1].mean(axis=0)[None]])
    k, i = (g.ravel() for g in np.meshgrid(np.arange(m - 1), np.arange(n), indexing="ij"))
    j = (i + 1) % n
    a, b, c, d = k * n + i, k * n + j, (k + 1) * n + j, (k + 1) * n + i
    u0, u1, v0, v1 = i / n, (i + 1) / n, share[k], share[k + 1]
    low, high = np.arange(n), (m - 1) * n + np.arange(n)
    after = (np.arange(n) + 1) % n
    ends0, ends1 = np.full(n, m * n), np.full(n, m * n + 1)
    u, un = np.arange(n) / n, (np.arange(n) + 1) / n
    first, last = np.full(n, share[0]), np.full(n, share[-1])
    kinds = ((a, b, c), (a, c, d), (ends0, after, low), (ends1, high, high[after]))
    faces = np.concatenate([np.stack(kind, axis=1) for kind in kinds])
    walls = corners((u0, v0), (u1, v0), (u1, v1)), corners((u0, v0), (u1, v1), (u0, v1))
    middle = (u + un) / 2
    ends = corners((middle, first), (un, first), (u, first)), corners((middle, last), (u, last), (un, last))
    uv = np.concatenate([*walls, *ends])
    return Solid(points, faces.astype(np.int64), crease_deg=55.0, picture_uv=np.clip(uv, 0.0, 1.0)).oriented_outwards()


def drilled(solid: Solid, tools: Sequence[Solid]) -> Solid:
    """The solid less the tools; it keeps its picture, and the walls of the holes show one place of it."""
    cut = manifold3d.Manifold.batch_boolean([_manifold(t) for t in tools], manifold3d.OpType.Add)
    mesh = (_manifold(solid) - cut).to_mesh64()
    points, where = np.unique(np.round(mesh.vert_properties[:, :3], 8), axis=0, return_inverse=True)
    faces = where.reshape(-1)[np.asarray(mesh.tri_verts, dtype=np.int64)]
    uv = np.asarray(mesh.vert_properties)[np.asarray(mesh.tri_verts, dtype=np.int64)][:, :, 3:5]
    keep = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    picture = np.clip(uv[keep], 0.0, 1.0) if solid.picture_uv is not None else None
    return Solid(points, faces[keep], solid.shapes, crease_deg=solid.crease_deg, picture_uv=picture)


def _manifold(solid: Solid) -> manifold3d.Manifold:
    uv = solid.picture_uv if solid.picture_uv is not None else np.full((len(solid.faces), 3, 2), 0.5)
    corners = np.concatenate([solid.points[solid.faces.reshape(-1)], uv.reshape(-1, 2)], axis=1)
    return manifold_of(corners, np.arange(len(corners)))


def stadium(length: float, width: float, steps: int = 6) -> Floats:
    """(N, 2) outline about the origin of a slot along x with round ends, or of a circle; counter-clockwise."""
    radius = min(length, width) / 2
    dx, dy = length / 2 - radius, width / 2 - radius
    turns = np.linspace(0.0, np.pi / 2, steps)
    corners = [(dx, dy, 0.0), (-dx, dy, np.pi / 2), (-dx, -dy, np.pi), (dx, -dy, 1.5 * np.pi)]
    found = [(x + radius * np.cos(a + t), y + radius * np.sin(a + t)) for x, y, a in corners for t in turns]
    return np.array([p for p, q in zip(found, found[1:] + found[:1], strict=True) if math.dist(p, q) > 1e-6])


def _slot(hole: Vec5, size: Size, height: float) -> Solid:
    along, across, length, width, angle = hole
    deep = 6 * size.thickness + size.dish + size.rise
    body = solids.prism(stadium(length * size.length, width * size.width), deep, 0.0).translated(z=-deep / 2)
    return body.rotated("z", angle).translated(along * size.length, across * size.width / 2, height)


def _stations(shape: Bar, size: Size, count: int) -> Floats:
    """(count, 2) half width and x of the rings: evenly far apart along the edge, and closer where it turns."""
    curve = smooth_profile([(w * size.width / 2, s * size.length) for w, s in shape.outline], 400)
    height = _value(shape.spine, curve[:, 1] / size.length, 0.0) * size.rise
    steps = np.hypot(np.linalg.norm(np.diff(curve, axis=0), axis=1), np.diff(height))
    away = np.arctan2(*np.diff(curve, axis=0).T)
    turning = np.abs(np.diff(away, append=away[-1])) + np.abs(np.diff(away, prepend=away[0]))
    weight = steps / steps.sum() + TURNING * turning / max(float(turning.sum()), 1e-9)
    run = np.concatenate([[0.0], np.cumsum(weight)])
    even = np.linspace(0.0, run[-1], count)
    # An end that comes to a point is closed by a fan near it.
    even[0], even[-1] = 0.25 * even[1], even[-1] - 0.25 * (even[-1] - even[-2])
    found = np.stack([np.interp(even, run, curve[:, k]) for k in (0, 1)], axis=1)
    for k in (0, -1):
        if curve[k, 0] > 0.05 * size.width:
            found[k] = curve[k]
    return found


def value_at(curve: Curve, share: float, default: float) -> float:
    """The value of a curve at one place."""
    return float(_value(curve, np.array([share]), default)[0])


def _within(stations: Floats, span: Vec2, length: float) -> Floats:
    if span == (0.0, 1.0):
        return stations
    order = stations[np.argsort(stations[:, 1], kind="stable")]
    low, high = span[0] * length, span[1] * length
    ends = [(float(np.interp(x, order[:, 1], order[:, 0])), x) for x in (low, high)]
    inside = stations[(stations[:, 1] > low + 1e-5) & (stations[:, 1] < high - 1e-5)]
    return np.array([*([ends[0]] if span[0] > 0 else []), *map(tuple, inside), *([ends[1]] if span[1] < 1 else [])])


def _value(curve: Curve, share: Floats, default: float) -> Floats:
    if not curve:
        return np.full(len(share), default)
    at, value = np.array(curve, dtype=np.float64).T
    inside = np.clip(share, at[0], at[-1])
    return np.asarray(PchipInterpolator(at, value)(inside) if len(at) > 1 else np.full(len(share), value[0]))


def _pieces(points: Floats, most: int) -> list[Floats]:
    """A bar cut along its length into at most `most` pieces whose hulls follow it."""
    pieces = [points]
    while len(pieces) < most:
        total = sum(_hull_volume(piece) for piece in pieces)
        best: tuple[float, int, int] | None = None
        for index, piece in enumerate(pieces):
            if len(piece) < 7:
                continue
            whole = _hull_volume(piece)
            for cut in range(3, len(piece) - 3, max(1, len(piece) // 10)):
                saved = whole - _hull_volume(piece[: cut + 1]) - _hull_volume(piece[cut:])
                if best is None or saved > best[0]:
                    best = (saved, index, cut)
        if best is None or best[0] < SAVING * total:
            break
        _, index, cut = best
        pieces[index : index + 1] = [pieces[index][: cut + 1], pieces[index][cut:]]
    return pieces


def _bowl_pieces(points: Floats, first: int, last: int) -> list[Floats]:
    around = points.shape[1]
    rows = np.linspace(first, last, 4).round().astype(int)
    half = around // 2
    side = max(1, round(around / 6))
    bands = (
        [*range(side + 1), *range(around - side, around)],
        [*range(side, half - side + 1), *range(half + side, around - side + 1)],
        [*range(half - side, half + side + 1)],
    )
    return [points[low : high + 1][:, [i % around for i in band]] for low, high in pairwise(rows) for band in bands]


def _hull_volume(points: Floats) -> float:
    """Volume of the hull of some points, m^3; without end where they span none: nobody cuts such a piece off."""
    try:
        vertices, faces = convex_hull(points.reshape(-1, 3))
    except DegenerateShape:
        return math.inf
    return signed_volume(vertices, faces)


def corners(*places: tuple[Floats, Floats]) -> Floats:
    """(F, 3, 2) coordinates of the corners of faces."""
    return np.stack([np.stack(place, axis=1) for place in places], axis=1)


# All are built flat, the tip of the head at x = 0.


@dataclass(frozen=True)
class Part:
    """A solid of a utensil with its finish."""

    solid: Solid
    finish: str
    label: str
    collides: bool = True  # with its colliders, or its hull where it has none
    fill: float = 1.0  # share of its volume that is made of the finish's substance


def tine_cuts(count: int, start: float, width: float, gap: float, deep: float) -> list[Solid]:
    """Solids to subtract from the head of a fork: the slots between its tines, which end in points.

    start: how far slots reach from the tip. width: of the head there. gap: of a slot. deep: height about z = 0. Metres.
    """
    tine = (width - (count - 1) * gap) / count
    point = min(0.16 * start, 0.009)
    cuts = []
    for k in range(count - 1):
        y = (k - (count - 2) / 2) * (tine + gap)
        h, tip = gap / 2, gap / 2 + 0.36 * tine
        arc = [(start - h + h * math.cos(t), h * math.sin(t)) for t in np.linspace(-math.pi / 2, math.pi / 2, 7)]
        outline = [(-0.004, -tip), (0.0, -tip), (point, -h), *arc, (point, h), (0.0, tip), (-0.004, tip)]
        cuts.append(solids.prism(np.array(outline), deep, 0.0).translated(y=y, z=-deep / 2))
    return cuts


def mouth_cut(length: float, width: float, deep: float, tooth: float) -> Solid:
    """The hole of a bottle opener about the origin, with a tooth at its far side that takes hold of the cap."""
    turns = np.arange(28) * 2 * np.pi / 28
    c, s = np.cos(turns), np.sin(turns)
    oval = [half * np.sign(f) * np.abs(f) ** (2 / 2.6) for half, f in ((length / 2, c), (width / 2, s))]
    hole = solids.prism(np.column_stack(oval), deep, 0.0).translated(z=-deep / 2)
    place = (length / 2 - tooth / 2 + 0.0005, 0.0, 0.0)
    return solids.subtract(hole, solids.box((tooth, 0.42 * width, 2 * deep), place, 0.0))


def cup(radius: float, depth: float, wall: float, squat: float) -> Solid:
    """The cup of a ladle about the z axis, its mouth at z = 0; squat: 1: half an ellipsoid; more: a flatter floor."""
    turns = np.linspace(-math.pi / 2, 0.0, 10)
    outer = [(radius * math.cos(t) ** (1 / squat), depth * math.sin(t)) for t in turns]
    inner = [(r * (1 - wall / radius), z * (1 - wall / depth)) for r, z in outer]
    outer[0], inner[0] = (0.0, -depth), (0.0, -depth + wall)
    shell = solids.lathe([*outer, *inner[::-1]], 32, 60.0)
    turns = np.linspace(0, 2 * math.pi, 13)
    floor = solids.hull_around(np.array([(r * math.cos(a), r * math.sin(a), z) for r, z in outer[:4] for a in turns]))
    return shell.with_colliders_of(*wall_hulls(outer[2:], 0.003, 6), floor)


def wall_hulls(profile: Sequence[Vec2], thick: float, sectors: int, rows: int = 2) -> list[Solid]:
    """Colliders of a round wall whose outside goes through (radius, z) points from the floor to the rim.

    thick: of the slabs, metres. sectors: slabs round the wall. rows: of slabs, one above the other, 1 or 2.
    """
    line = np.array(profile)
    middle = len(line) // 2
    halves = [(line[0], line[middle]), (line[middle], line[-1])] if rows == 2 else [(line[0], line[-1])]
    widening = 1 + 0.5 * (1 / math.cos(math.pi / sectors) - 1)
    found = []
    for k in range(sectors):
        angles = [2 * math.pi * (k - 0.5) / sectors, 2 * math.pi * (k + 0.5) / sectors]
        for (r0, z0), (r1, z1) in halves:
            corners = [(r0, z0), (r1, z1), (r0 - thick, z0 + 0.4 * thick), (max(r1 - thick, 0.001), z1)]
            ring = [(r * widening * math.cos(a), r * widening * math.sin(a), z) for r, z in corners for a in angles]
            found.append(solids.hull_around(np.array(ring)))
    return found


def whisk_wires(count: int, length: float, radius: float, neck: float, wire: float, belly: float) -> Solid:
    """Loops of wire about the x axis from the tip at x = 0 to the handle.

    radius: at the belly, which is at that share of the length. neck: radius at the handle. wire: radius of one.
    """
    side = [(0.0, 0.0), (0.55 * radius, 0.05 * length), (radius, belly * length), (0.5 * radius, 0.72 * length)]
    half = smooth_profile([*side, (neck, length)], 11)
    loops = []
    for k in range(count):
        turn = math.pi * k / count
        path = np.concatenate([half[::-1], half[1:] * np.array([-1.0, 1.0])])
        x = path[:, 1] + 2.1 * wire * (k - count / 2) * np.maximum(0.0, 1 - np.abs(path[:, 0]) / (0.6 * radius))
        line = np.column_stack([x, path[:, 0] * math.cos(turn), path[:, 0] * math.sin(turn)])
        points: list[Vec3] = [(float(a), float(b), float(c)) for a, b, c in line]
        loop = solids.tube(points, solids.circle(wire, 6), up=(0.0, -math.sin(turn), math.cos(turn)))
        loops.append(loop.without_colliders())
    body = solids.concatenate(loops).with_crease(70.0)
    low, high = body.points[body.points[:, 0] < 0.62 * length], body.points[body.points[:, 0] > 0.55 * length]
    return body.with_colliders_of(solids.hull_around(low), solids.hull_around(high))


def wound_handle(rings: int, x: float, length: float, radius: float, wire: float) -> Solid:
    """A handle of wound wire: a rod with rounded ribs, along x."""
    share = np.linspace(0.0, 1.0, 4 * rings + 1)
    profile = [(radius - wire * (1 - abs(math.sin(math.pi * rings * s))), s * length) for s in share]
    body = solids.lathe([(float(r), float(z)) for r, z in profile], 14, 80.0)
    rod_ = solids.rod(radius, length, 0.0, "x").translated(x=length / 2)
    return body.rotated("y", math.pi / 2).with_colliders_of(rod_).translated(x=x)


def ring(path: Floats, section: Floats, hulls: int = 6) -> Solid:
    """A closed loop in the plane z = 0, path (N, 2) counter-clockwise, of a section (M, 2) outwards and along z."""
    forward = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    forward /= np.linalg.norm(forward, axis=1)[:, None]
    flat = path[:, None, :] + np.column_stack([forward[:, 1], -forward[:, 0]])[:, None, :] * section[None, :, :1]
    points = np.concatenate([flat, np.broadcast_to(section[None, :, 1:], (len(path), len(section), 1))], axis=2)
    n = len(path)
    body = Solid(points.reshape(-1, 3), _closed_faces(n, len(section)), crease_deg=60.0).oriented_outwards()
    cuts = np.linspace(0, n, hulls + 1).round().astype(int)
    pieces = [points[np.arange(low, high + 1) % n].reshape(-1, 3) for low, high in pairwise(cuts)]
    return body.with_colliders_of(*map(solids.hull_around, pieces))


def _closed_faces(rings: int, around: int) -> Ints:
    """(F, 3) faces between consecutive rings of `around` points each, and between the last ring and the first."""
    k, i = (g.ravel() for g in np.meshgrid(np.arange(rings), np.arange(around), indexing="ij"))
    a, b = k * around + i, k * around + (i + 1) % around
    d, c = (k + 1) % rings * around + i, (k + 1) % rings * around + (i + 1) % around
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int64)


def egg(length: float, width: float, count: int = 28, lean: float = 0.15) -> Floats:
    """(count, 2) points of an egg about the origin, its blunt end at +x; counter-clockwise."""
    turns = np.arange(count) * 2 * np.pi / count
    return np.column_stack([(length / 2 * np.cos(turns)), width / 2 * np.sin(turns) * (1 + lean * np.cos(turns))])


def round_bar_x(profile: Sequence[Vec2], points: int = 28, around: int = 28) -> Solid:
    """A turned body along x from (radius, x) points whose ends lie on the axis; one picture covers it."""
    return turned(smooth_profile(profile, points), around).rotated("y", math.pi / 2)


def tufts(places: Floats, height: float, radius: float, spread: float, seed: int) -> Solid:
    """Tufts of bristles that hang down from z = 0; (N, 2) places, metres; they lean outwards by the spread."""
    rng = np.random.Generator(np.random.PCG64(seed))
    six = np.arange(6) * np.pi / 3
    found = []
    middle = places.mean(axis=0)
    reach = float(np.abs(places - middle).max()) + 1e-9
    for x, y in places:
        lean = spread * (np.array([x, y]) - middle) / reach + rng.normal(size=2) * 0.06 * height * (spread > 0)
        rings = []
        for s in (0.0, 1.0):
            r = radius * (0.75 + 0.45 * s)
            at = np.array([x, y]) + lean * s
            rings.append(np.column_stack([at[0] + r * np.cos(six), at[1] + r * np.sin(six), np.full(6, -height * s)]))
        found.append(lofted(np.array(rings[::-1]), np.array([0.0, 1.0])))
    return solids.concatenate(found)


def grater(width: float, depth: float, height: float, taper: float, wall: float) -> Solid:
    """The four sides of a box grater, open above and below, standing on z = 0; colliders are its four sides."""
    corner = 0.09 * min(width, depth)
    levels = [(1.0, 0.0), (taper, height), (taper, height), (1.0, 0.0)]
    rings = []
    for k, (scale, z) in enumerate(levels):
        less = 2 * wall if k > 1 else 0.0
        loop = solids.rectangle(width * scale - less, depth * scale - less, max(corner - less / 2, 0.001), 3)
        rings.append(np.column_stack([loop, np.full(len(loop), z)]))
    points = np.array(rings)
    body = Solid(points.reshape(-1, 3), _closed_faces(*points.shape[:2]), crease_deg=30.0).oriented_outwards()
    sides, thick = [], 0.003
    for turn in range(4):
        across, deep = (width, depth) if turn % 2 == 0 else (depth, width)
        ends = [(s, z, sx) for s, z in ((1.0, 0.0), (taper, height)) for sx in (-1, 1)]
        corners = [(sx * across / 2 * s, -(deep / 2 * s - t), z) for s, z, sx in ends for t in (0.0, thick)]
        sides.append(solids.hull_around(np.array(corners)).rotated("z", turn * math.pi / 2))
    return body.with_colliders_of(*sides)


@dataclass(frozen=True)
class Panel:
    """A side of a grater: a slanted plane that is `turn` times a quarter turn from the front."""

    across: float  # as in `grater`, seen from this side
    deep: float
    height: float
    taper: float
    turn: int

    def placed(self, solid: Solid, across: float, up: float) -> Solid:
        """A solid that is built about the origin with its face to -y, at a place of the panel, by its half width."""
        scale = 1 + (self.taper - 1) * up
        lean = math.atan2(self.deep / 2 * (1 - self.taper), self.height)
        y = -self.deep / 2 * scale
        put = solid.rotated("x", -lean).translated(across * self.across / 2 * scale, y, up * self.height)
        return put.rotated("z", self.turn * math.pi / 2)


def punched(panel: Panel, pitch: float, size: float, hood: float) -> tuple[list[Solid], list[Solid]]:
    """Dark holes and the hoods over them, in staggered rows over most of a side."""
    holes, hoods = [], []
    # A dark disc that projects slightly from the side: a low pyramid.
    base = np.column_stack([solids.circle(size / 2, 6), np.zeros(6)])[:, [0, 2, 1]]
    faces = [(k, (k + 1) % 6, 6) for k in range(6)] + [(0, k + 1, k) for k in range(1, 5)]
    dot = Solid(np.concatenate([base, [[0.0, -0.0006, 0.0]]]), np.array(faces, dtype=np.int64), crease_deg=60.0)
    dot, lip = dot.oriented_outwards(), _hood(size, hood)
    rows = int(0.72 * panel.height / pitch)
    for row in range(rows):
        up = 0.1 + 0.8 * (row + 0.5) / rows
        scale = 1 + (panel.taper - 1) * up
        count = int(0.8 * panel.across * scale / pitch) - row % 2
        for k in range(count):
            across = (k - (count - 1) / 2) * pitch / (panel.across / 2 * scale)
            holes.append(panel.placed(dot, across, up))
            hoods.append(panel.placed(lip, across, up))
    return holes, hoods


def slits(panel: Panel, count: int, wide: float) -> tuple[list[Solid], list[Solid]]:
    """Long slits with raised lips for slices."""
    holes, lips = [], []
    for k in range(count):
        up = 0.22 + 0.6 * k / max(count - 1, 1)
        across = wide * panel.across * (1 + (panel.taper - 1) * up)
        slit = solids.prism(stadium(across, 0.006, 4), 0.0005, 0.0).without_colliders().rotated("x", math.pi / 2)
        holes.append(panel.placed(slit, 0.0, up))
        lips.append(panel.placed(solids.box((across, 0.003, 0.004), (0.0, -0.0015, 0.0045), 0.001), 0.0, up))
    return holes, lips


def _hood(size: float, out: float) -> Solid:
    r = 0.62 * size
    base = [(-r, 0.0003, 0.05 * size), (r, 0.0003, 0.05 * size), (0.7 * r, 0.0003, 0.7 * size)]
    base += [(-0.7 * r, 0.0003, 0.7 * size), (-0.45 * r, -out, 0.12 * size), (0.45 * r, -out, 0.12 * size)]
    points = np.array(base)
    quads = [(0, 1, 5, 4), (1, 2, 5), (2, 3, 4, 5), (3, 0, 4), (3, 2, 1, 0)]
    faces = [(q[0], q[k], q[k + 1]) for q in quads for k in range(1, len(q) - 1)]
    return Solid(points, np.array(faces, dtype=np.int64), crease_deg=20.0).oriented_outwards()


def straw(length: float, radius: float, wall: float, twist: float, folds: int) -> Solid:
    """A straw along x, open at both ends; its picture winds round it `twist` times. folds: of its bend; 0: none."""
    around = 14
    low, high = 0.74, 0.74 + 0.0022 * folds / length
    share = [s for s in np.linspace(0.0, 1.0, math.ceil(around * twist) + 3) if not (folds and low < s < high)]
    ridges = list(np.linspace(low, high, 2 * folds + 1)) if folds else []
    places = sorted([*share, *ridges])
    rings, heights = [], []
    for inside, order in ((0.0, places), (1.0, places[::-1])):
        for s in order:
            ridge = 0.25 * radius * (1 if any(abs(s - q) < 1e-9 for q in ridges[1::2]) else 0)
            r = radius * 0.78 + ridge - inside * wall if folds else radius - inside * wall
            turn = np.arange(around) * 2 * np.pi / around + 2 * np.pi * twist * s
            rings.append(np.column_stack([np.full(around, s * length), r * np.cos(turn), r * np.sin(turn)]))
            heights.append(s)
    points = np.array(rings)
    m, n = points.shape[:2]
    k, i = (g.ravel() for g in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))
    v = np.array(heights)
    v0, v1, u0, u1 = v[k], v[(k + 1) % m], i / n, (i + 1) / n
    uv = np.concatenate([corners((u0, v0), (u1, v0), (u1, v1)), corners((u0, v0), (u1, v1), (u0, v1))])
    body = Solid(points.reshape(-1, 3), _closed_faces(m, n), crease_deg=50.0, picture_uv=uv)
    return body.oriented_outwards().with_colliders_of(solids.rod(radius, length, 0.0, "x").translated(x=length / 2))


def reamer_dish(radius: float, depth: float, wall: float) -> Solid:
    """A round dish whose bottom is at z = 0, with its floor and wall as colliders."""
    foot = 0.72 * radius
    outer = [(foot, 0.0), (0.86 * radius, 0.3 * depth), (0.96 * radius, 0.7 * depth), (radius, depth)]
    inner = [(radius - wall, depth), (0.95 * radius - wall, 0.7 * depth), (0.82 * radius - wall, 0.32 * depth)]
    inner += [(foot - 1.2 * wall, wall)]
    body = solids.lathe([*outer, *inner, (0.0, wall)], 40, 45.0)
    floor = solids.rod(foot, wall, 0.0).translated(z=wall / 2)
    return body.with_colliders_of(floor, *wall_hulls([outer[0], outer[3]], 0.004, 12, 1))


def ribbed_cone(radius: float, height: float, ribs: int, sharp: float) -> Solid:
    """The cone of a citrus reamer about the z axis, with furrows; its collider is its hull."""
    side = [(0.0, 0.0), (radius, 0.0005), (0.93 * radius, 0.25 * height), (0.66 * radius, 0.65 * height)]
    body = turned(smooth_profile([*side, (0.2 * radius, 0.95 * height), (0.0, height)], 16), 4 * ribs, 35.0)
    wave = 0.5 + 0.5 * np.cos(ribs * np.arctan2(body.points[:, 1], body.points[:, 0]))
    points = np.column_stack([body.points[:, :2] * (1 - sharp * (1 - wave))[:, None], body.points[:, 2]])
    return replace(body, points=points).with_hull_collider()


def digits(text: str, height: float, stroke: float) -> Solid:
    """Digits of seven bars each, in the plane x, y about the origin, a little above z = 0."""
    lit = {"0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc", "5": "afgcd", "6": "afgedc", "7": "abc"}
    lit |= {"8": "abcdefg", "9": "abcdfg"}
    half, wide = height / 2, 0.5 * height
    at = {"a": (0, half, 1), "g": (0, 0, 1), "d": (0, -half, 1), "b": (wide / 2, half / 2, 0)}
    at |= {"c": (wide / 2, -half / 2, 0), "e": (-wide / 2, -half / 2, 0), "f": (-wide / 2, half / 2, 0)}
    found = []
    for k, sign in enumerate(text):
        start = (k - (len(text) - 1) / 2) * 1.6 * wide
        for name in lit[sign]:
            x, y, level = at[name]
            size = (wide - stroke, stroke, 0.0004) if level else (stroke, half - stroke, 0.0004)
            found.append(solids.box(size, (start + x, y, 0.0002), 0.0).without_colliders())
    return solids.concatenate(found)
