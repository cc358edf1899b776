"""Bars swept along a curve: handles, spoons, blades, anything long whose section changes from end to end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import manifold3d
import numpy as np
from pydantic import Field
from scipy.interpolate import PchipInterpolator

from casa_assets.errors import DegenerateShape
from casa_assets.ext.arrays import Floats, convex_hull, signed_volume
from casa_assets.ext.families import Params
from casa_assets.ext.records import Vec2, Vec5
from casa_assets.ext.solids import Solid, hull_around, prism
from casa_assets.kitchenware.objects.closed_surface import smooth_profile

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

    along: number of rings along it. hulls: maximum number of colliders along it. span: part of the length to build, as
    shares: a sleeve or a tip of another material follows the same curves.
    """
    stations = _within(_stations(shape, size, along), span, size.length)
    width, x = stations[:, 0], stations[:, 1]
    share = x / size.length
    other = width
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
    points = np.stack(
        [x[:, None] - lift * np.sin(slope)[:, None], y, middle[:, None] + lift * np.cos(slope)[:, None]], axis=2
    )
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
    hull_solids = [hull_around(piece.reshape(-1, 3)) for piece in pieces]
    if shape.holes:
        solid = drilled(solid, ([_slot(hole, size, float(np.interp(hole[0], share, middle))) for hole in shape.holes]))
    return solid.with_colliders_of(*hull_solids)


def lofted(rings: Floats, share: Floats) -> Solid:
    """A closed skin over (M, N, 3) rings, its ends closed by fans; one picture covers it.

    share: of each ring, the height in the picture, 0..1. Its width runs once round a ring.
    """
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
    """The body with the coordinates in its picture as properties of its corners."""
    uv = solid.picture_uv if solid.picture_uv is not None else np.full((len(solid.faces), 3, 2), 0.5)
    corners = np.concatenate([solid.points[solid.faces.reshape(-1)], uv.reshape(-1, 2)], axis=1)
    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(corners, dtype=np.float64),
        tri_verts=np.arange(len(corners), dtype=np.uint64).reshape(-1, 3),
    )
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"a solid of {len(solid.faces)} faces is not closed: {body.status()}")
    return body


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
    body = prism(stadium(length * size.length, width * size.width), deep, 0.0).translated(z=-deep / 2)
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
    found: Floats = PchipInterpolator(at, value)(inside) if len(at) > 1 else np.full(len(share), value[0])
    return found


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
