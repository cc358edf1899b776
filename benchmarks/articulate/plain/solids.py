"""Extruded outlines, boxes, tubes and turned shapes, in metres, with faces outward."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from casa_assets.core.numeric import Floats, Ints

Surface = tuple[Floats, Ints]


@dataclass(frozen=True)
class Place:
    """A plane to draw on: (u, v) in the plane and w out of it, w = u x v.

    Attributes:
        origin: (3,). axes: (3, 3) rows: u, v, w.
    """

    origin: Floats
    axes: Floats

    def points(self, flat: Floats, w: float | Floats) -> Floats:
        """(N, 3) points of (N, 2) spots at a height w over the plane."""
        return self.origin + np.column_stack([flat, np.broadcast_to(w, len(flat))]) @ self.axes

    def point(self, u: float, v: float, w: float = 0.0) -> Floats:
        """(3,) one point."""
        return self.points(np.array([[u, v]]), w)[0]


def front_of(y: float = 0.0) -> Place:
    """The plane that faces -y: u to the right (x), v up (z)."""
    return Place(np.array([0.0, y, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))


def top_of(z: float = 0.0) -> Place:
    """The plane that faces up: u to the right (x), v to the back (y)."""
    return Place(np.array([0.0, 0.0, z]), np.eye(3))


def side_of(x: float, right: bool) -> Place:
    """The plane that faces +x or -x: v up (z)."""
    sign = 1.0 if right else -1.0
    return Place(np.array([x, 0.0, 0.0]), np.array([[0, sign, 0], [0, 0, 1.0], [sign, 0, 0]]))


def rectangle(u0: float, v0: float, u1: float, v1: float) -> Floats:
    """(4, 2) corners, counterclockwise."""
    return np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]], dtype=np.float64)


def ellipse(u: float, v: float, a: float, b: float, sides: int) -> Floats:
    """(sides, 2) points on an ellipse, counterclockwise."""
    angle = (np.arange(sides) + 0.5) / sides * 2 * np.pi
    return np.column_stack([u + a * np.cos(angle), v + b * np.sin(angle)])


def rounded(u0: float, v0: float, u1: float, v1: float, radius: float, steps: int = 3) -> Floats:
    """A rectangle with round corners, counterclockwise."""
    radius = min(radius, 0.49 * (u1 - u0), 0.49 * (v1 - v0))
    centers = ((u1 - radius, v1 - radius), (u0 + radius, v1 - radius), (u0 + radius, v0 + radius))
    centers += ((u1 - radius, v0 + radius),)
    out = []
    for k, (u, v) in enumerate(centers):
        angle = (k + np.arange(steps + 1) / steps) * np.pi / 2
        out.append(np.column_stack([u + radius * np.cos(angle), v + radius * np.sin(angle)]))
    return np.concatenate(out)


def plate(place: Place, outer: Floats, holes: Sequence[Floats] = (), w: float = 0.0) -> Surface:
    """A flat sheet with holes; its corners are exactly those of the outlines."""
    loops = [outer, *(h[::-1] for h in holes)]
    faces = np.asarray(manifold3d.triangulate(loops), dtype=np.int64).reshape(-1, 3)
    return place.points(np.concatenate(loops), w), faces


def extrude(
    place: Place,
    outer: Floats,
    low: float,
    high: float,
    holes: Sequence[Floats] = (),
    *,
    back: bool = True,
    face: bool = True,
    taper: float = 1.0,
) -> Surface:
    """An outline drawn out of its plane from `low` to `high`.

    Args:
        back, face: whether it has the sheet at `low` and at `high`. taper: size at `high` as a share of that at `low`.
    """
    middle = (outer.min(axis=0) + outer.max(axis=0)) / 2
    loops = [outer, *(h[::-1] for h in holes)]
    pieces: list[Surface] = []
    for loop in loops:
        n = len(loop)
        ring = np.concatenate([place.points(loop, low), place.points(middle + (loop - middle) * taper, high)])
        a, b = np.arange(n), (np.arange(n) + 1) % n
        pieces.append((ring, np.concatenate([np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)])))
    caps = np.asarray(manifold3d.triangulate(loops), dtype=np.int64).reshape(-1, 3)
    flat = np.concatenate(loops)
    if face:
        pieces.append((place.points(middle + (flat - middle) * taper, high), caps))
    if back:
        pieces.append((place.points(flat, low), caps[:, ::-1]))
    return joined(pieces)


def box(low: Sequence[float] | Floats, high: Sequence[float] | Floats, without: str = "") -> Surface:
    """A box without some sides, named by one letter each: l(eft) r(ight) f(ront) b(ack) d(own) u(p)."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    points = np.array([[x, y, z] for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)], dtype=np.float64)
    sides = {"d": (0, 2, 3, 1), "u": (4, 5, 7, 6), "f": (0, 1, 5, 4), "b": (2, 6, 7, 3), "l": (0, 4, 6, 2)}
    sides["r"] = (1, 3, 7, 5)
    kept = [q for name, q in sides.items() if name not in without]
    return points, np.array([t for a, b, c, d in kept for t in ((a, b, c), (a, c, d))], dtype=np.int64)


def inside_out(surface: Surface) -> Surface:
    """The same faces wound the other way: the walls of a room."""
    return surface[0], surface[1][:, ::-1]


def tube(path: Floats, radius: float | Floats, sides: int, caps: bool = True) -> Surface:
    """A round tube along (N, 3) points; the ring at a bend stands across the mean of both directions."""
    way = np.diff(path, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    ahead = np.concatenate([way[:1], way[:-1] + way[1:], way[-1:]])
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    across = np.cross(ahead[0], np.eye(3)[int(np.abs(ahead[0]).argmin())])
    rings = []
    angle = np.arange(sides) / sides * 2 * np.pi
    for spot, on, r in zip(path, ahead, np.broadcast_to(radius, len(path)), strict=True):
        across = across - on * (across @ on)
        across /= np.linalg.norm(across)
        beside = np.cross(on, across)
        rings.append(spot + r * (np.outer(np.cos(angle), across) + np.outer(np.sin(angle), beside)))
    points = np.concatenate(rings)
    a, b = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = [np.stack([a, b, b + sides], 1) + k * sides for k in range(len(path) - 1)]
    faces += [np.stack([a, b + sides, a + sides], 1) + k * sides for k in range(len(path) - 1)]
    if caps:
        last = (len(path) - 1) * sides
        fan = np.stack([np.zeros(sides - 2, dtype=np.int64), np.arange(1, sides - 1), np.arange(2, sides)], 1)
        faces += [fan[:, ::-1], fan + last]
    return points, np.concatenate(faces)


def turned(place: Place, u: float, v: float, profile: Floats, sides: int) -> Surface:
    """A shape of revolution around the normal of a plane: (N, 2) radius and height, from below to above."""
    angle = (np.arange(sides) + 0.5) / sides * 2 * np.pi
    rings = [place.points(np.column_stack([u + r * np.cos(angle), v + r * np.sin(angle)]), w) for r, w in profile]
    a, b = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = [np.stack([a, b, b + sides], 1) + k * sides for k in range(len(profile) - 1)]
    faces += [np.stack([a, b + sides, a + sides], 1) + k * sides for k in range(len(profile) - 1)]
    points, every = np.concatenate(rings), np.concatenate(faces)
    corners = points[every]
    alive = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-15
    return points, every[alive]


def joined(pieces: Sequence[Surface]) -> Surface:
    """Several surfaces as one."""
    starts = np.cumsum([0, *(len(p) for p, _ in pieces[:-1])]).tolist()
    return np.concatenate([p for p, _ in pieces]), np.concatenate(
        [f + s for (_, f), s in zip(pieces, starts, strict=True)]
    )
