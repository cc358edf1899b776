"""Closed surfaces that a printed picture is wrapped round, and what they are parts of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import manifold3d
import numpy as np

from casa_assets.ext.arrays import Floats, Ints
from casa_assets.ext.records import Pose, Vec2
from casa_assets.ext.solids import Solid, ring_walls
from casa_assets.kitchenware.objects.closed_surface import random_waves

LYING_BACK = Pose.from_matrix(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
LYING_ALONG = Pose.from_matrix(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
# Half of the thickness of two sheets that are sealed together, metres.
SEALED = 0.0004
# Places of the points along a straight side, -1..1; they are closer together near the corners.
ALONG_SIDE = (-1.0, -0.9, -0.5, 0.0, 0.5, 0.9, 1.0)
# Share of the picture's width that a rounded corner takes on each of its two sides.
CORNER_SHARE = 0.004


@dataclass(frozen=True)
class Outline:
    """The points of one ring, for any size of it: counter-clockwise seen from above, from the middle of the back on.

    A point lies at straight * (half size - radius) + bent * radius.

    straight, bent: (N, 2). sides: (N, 2, 2) where each of the pieces between two points lies in the picture: the start
    and the end of it, round the thing (0..1) and across its own side (1 at the start of the side, 0 at its end).
    """

    straight: Floats
    bent: Floats
    sides: Floats

    def ring(self, half_x: float, half_y: float, radius: float, z: float) -> Floats:
        """The (N, 3) points of a ring, metres."""
        r = min(radius, 0.98 * half_x, 0.98 * half_y)
        flat = self.straight * (half_x - r, half_y - r) + self.bent * r
        return np.column_stack([flat, np.full(len(flat), z)])


def four_sides(front: float, side: float, corner_steps: int = 2, across: tuple[float, ...] = ALONG_SIDE) -> Outline:
    """A rectangle with rounded corners, whose front faces -y.

    front, side: shares of the picture's width. corner_steps: pieces of a corner. across: places along a side, -1..1.
    """
    back = max(0.02, 1.0 - front - 2 * side)
    turns = np.linspace(0.0, np.pi / 2, corner_steps + 1)[1:-1]
    # Of each side the direction along it, the direction out of it, and where it lies in the picture.
    table = (
        ((-1.0, 0.0), (0.0, 1.0), -back / 2, back / 2),
        ((0.0, -1.0), (-1.0, 0.0), back / 2, back / 2 + side),
        ((1.0, 0.0), (0.0, -1.0), 0.5 - front / 2, 0.5 + front / 2),
        ((0.0, 1.0), (1.0, 0.0), 0.5 + front / 2, 0.5 + front / 2 + side),
    )
    straight, bent, around, part = [], [], [], []
    for k, (way, out, first, last) in enumerate(table):
        after = table[(k + 1) % 4][1]
        for t in across:
            straight.append((t * way[0] + out[0], t * way[1] + out[1]))
            bent.append(out)
            around.append(first + (last - first) * (CORNER_SHARE + (1 - 2 * CORNER_SHARE) * (t + 1) / 2))
            part.append(k + (t + 1) / 2)
        for turn in turns:
            c, s = float(np.cos(turn)), float(np.sin(turn))
            straight.append((way[0] + out[0], way[1] + out[1]))
            bent.append((out[0] * c + after[0] * s, out[1] * c + after[1] * s))
            around.append(last)
            part.append(k + 1.0)
    # The picture's ends meet in the middle of the back.
    seam = across.index(0.0)
    points = [np.roll(np.array(v), -seam, axis=0) for v in (straight, bent, around, part)]
    run, place = points[2], points[3]
    run[len(run) - seam :] += 1.0
    place[len(place) - seam :] += 4.0
    start_side = np.floor(place + 1e-9)
    ends, next_place = np.append(run[1:], 1.0), np.append(place[1:], 4.5)
    pieces = np.stack([np.stack([run, ends], 1), 1.0 - np.stack([place - start_side, next_place - start_side], 1)], 1)
    return Outline(points[0], points[1], np.clip(pieces, 0.0, 1.0))


def round_sides(count: int) -> Outline:
    """A circle of an even count of points, its front to -y; its `ring` takes the radius as each of the half sizes."""
    turns = np.pi / 2 + np.arange(count) * 2 * np.pi / count
    bent = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    edges = np.linspace(0.0, 1.0, count + 1)
    around = np.stack([edges[:-1], edges[1:]], 1)
    # Along a picture that runs along it, a thing's left to right is down; its middle is the back, which lies above.
    across = np.where(np.arange(count)[:, None] < count // 2, 0.5, 1.5) - around
    return Outline(bent, bent, np.stack([around, across], 1))


def two_sheets(count: int) -> tuple[Floats, Floats, Floats]:
    """Places across a bag of two sheets: x -1..1, which sheet (-1 front, 1 back, 0 at the sides), and its picture.

    Returns (N,) x and (N,) sheet from the left edge on, the front first; (N, 2, 2) as in Outline.sides. count: even.
    """
    x = -np.cos(np.linspace(0.0, np.pi, count + 1)) * 0.35 + 0.65 * np.linspace(-1.0, 1.0, count + 1)
    places = np.concatenate([x, x[::-1][1:-1]])
    sheet = np.concatenate([[0.0], np.full(count - 1, -1.0), [0.0], np.full(count - 1, 1.0)])
    share = (x + 1) / 2
    # The picture's ends meet in the middle of the back, which is a point, as their number is even.
    starts = [0.75 if a < 0.5 - 1e-9 else -0.25 for a in share[:-1]]
    front = [(0.25 + 0.5 * a, 0.25 + 0.5 * b, 1 - a, 1 - b) for a, b in pairwise(share)]
    back = [(s + 0.5 * a, s + 0.5 * b, 1 - a, 1 - b) for s, (a, b) in zip(starts, pairwise(share), strict=True)]
    return places, sheet, np.array(front + back).reshape(-1, 2, 2)


def wrapped(rings: Floats, sides: Floats, heights: Floats, along: bool = False, crease_deg: float = 50.0) -> Solid:
    """A closed surface over rings of equally many points, whose ends are closed by flat faces.

    rings: (K, N, 3) from the lower end to the upper one, metres. sides: as in Outline. heights: (K,) in the picture,
    0..1. along: the picture's width runs along the thing instead of round it, and each side shows all of its height.
    """
    count, size = rings.shape[:2]
    faces = [*ring_walls(size, count)]
    around, across = sides[:, 0], sides[:, 1]
    uv: list[Floats] = []
    for k in range(count - 1):
        low, high = np.full(size, heights[k]), np.full(size, heights[k + 1])
        if along:
            corners = [(low, across[:, 0]), (low, across[:, 1]), (high, across[:, 1]), (high, across[:, 0])]
        else:
            corners = [(around[:, 0], low), (around[:, 1], low), (around[:, 1], high), (around[:, 0], high)]
        a, b, c, d = (np.column_stack(corner) for corner in corners)
        uv += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    for ring, start, level, end in ((rings[0], 0, heights[0], 0), (rings[-1], size * (count - 1), heights[-1], 1)):
        cap = np.asarray(manifold3d.triangulate([ring[:, :2]]), dtype=np.int64)
        cap = cap[:, ::-1] if end == 0 else cap
        faces.append(cap + start)
        uv.append(_end_picture(ring, sides, float(level), end, along)[cap])
    whole = np.concatenate(faces).astype(np.int64)
    return Solid(rings.reshape(-1, 3), whole, crease_deg=crease_deg, picture_uv=np.concatenate(uv))


def _end_picture(ring: Floats, sides: Floats, level: float, end: int, along: bool) -> Floats:
    """The (N, 2) places in the picture of the points of an end: as if the front were folded over it."""
    share = (ring[:, :2] - ring[:, :2].min(axis=0)) / np.maximum(np.ptp(ring[:, :2], axis=0), 1e-6)
    if along:
        return np.column_stack([np.full(len(ring), abs(level - 0.003)), 0.45 + 0.1 * share[:, 1]])
    depth = level + (2 * end - 1) * share[:, 1] * max(0.0, (level if end == 0 else 1.0 - level) - 0.004)
    return np.column_stack([0.3 + 0.4 * share[:, 0], np.clip(depth, 0.003, 0.997)])


def with_spot(solid: Solid, at: Vec2) -> Solid:
    """The solid with all of it in the colour that the picture has at a point."""
    return replace(solid, picture_uv=np.broadcast_to(np.array(at), (len(solid.faces), 3, 2)).copy())


def with_front_picture(solid: Solid, lower: Vec2, upper: Vec2, axes: tuple[int, int] = (0, 2)) -> Solid:
    """The solid with a part of the picture, lower to upper corner, over its box; axes: to the right and up in it."""
    flat = solid.points[:, list(axes)]
    share = (flat - flat.min(axis=0)) / np.maximum(np.ptp(flat, axis=0), 1e-9)
    return replace(solid, picture_uv=(np.array(lower) + share * (np.array(upper) - np.array(lower)))[solid.faces])


def plate(corners: Floats, thickness: float, up: Floats) -> Solid:
    """A thin plate below 3 or 4 corners, counter-clockwise from outside; up: (3,) out of it; it is pushed outwards."""
    lifted = corners + thickness * up / np.linalg.norm(up)
    n = len(corners)
    walls = ring_walls(n, 2)
    cap = np.array([(0, i, i + 1) for i in range(1, n - 1)], dtype=np.int64)
    faces: Ints = np.concatenate([*walls, cap[:, ::-1], cap + n]).astype(np.int64)
    return Solid(np.concatenate([corners, lifted]), faces).oriented_outwards()


def hump(values: Floats) -> Floats:
    """1 in the middle and 0 at both ends of -1..1."""
    return np.asarray(np.clip(1.0 - values**2, 0.0, 1.0))


def dented(rings: Floats, outline: Outline, amount: float, rng: np.random.Generator, waves: float = 1.6) -> Floats:
    """Rings moved by smooth random waves, as card is never flat; amount: metres; waves: over the largest side."""
    if amount <= 0:
        return rings
    points = rings.reshape(-1, 3)
    total = random_waves(points, waves, float(np.ptp(points, axis=0).max()), 6, rng)
    moved = rings.copy()
    inner = np.clip(1.15 - np.abs(outline.straight * outline.bent[:, ::-1]).sum(axis=1), 0.15, 1.0)[:, None]
    moved[..., :2] += amount / 2.5 * total.reshape(*rings.shape[:2], 1) * outline.bent * inner
    return moved


@dataclass(frozen=True)
class Part:
    """A part of a package."""

    solid: Solid  # before the package is laid down: its bottom at z = 0, its front to -y
    finish: str  # id
    label: str
    density: float = 0.0  # kg/m^3; 0: no mass
    collider: bool = False  # it has a separate collision shape
    swings: bool = False  # it is on the link of the lid
