"""Closed surfaces that a printed picture is wrapped round; tubs and cups, rolls, and packages of film."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import manifold3d
import numpy as np

from casa_assets.ext.arrays import Floats, Ints
from casa_assets.ext.records import Pose, Vec2
from casa_assets.ext.solids import Solid, board, concatenate, lathe, ring_walls, rod
from casa_assets.kitchenware.objects.closed_surface import random_waves, smooth_profile

if TYPE_CHECKING:
    from casa_assets.kitchenware.objects.package import Package

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

    front, side: shares of the picture's width that the front and each of the two adjacent sides take. corner_steps:
    pieces of a rounded corner. across: places of points along a side, -1..1.
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
    """A circle whose front looks to -y; its radius is that of `ring`, and each half size as well.

    count: points, an even number.
    """
    turns = np.pi / 2 + np.arange(count) * 2 * np.pi / count
    bent = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    edges = np.linspace(0.0, 1.0, count + 1)
    around = np.stack([edges[:-1], edges[1:]], 1)
    # Round a thing from its left to its right is down in a picture that runs along it. The middle of that picture is at
    # the back, which is the upper side of what is laid along.
    across = np.where(np.arange(count)[:, None] < count // 2, 0.5, 1.5) - around
    return Outline(bent, bent, np.stack([around, across], 1))


def two_sheets(count: int) -> tuple[Floats, Floats, Floats]:
    """Places across a bag of two sheets: x -1..1, which sheet (-1 front, 1 back, 0 at the sides), and its picture.

    count: pieces across a sheet, an even number. Returns: (N,) x and (N,) sheet from the left edge on, the front first;
    (N, 2, 2) as in Outline.sides.
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

    rings: (K, N, 3) from the lower end to the upper one, metres. sides: as in Outline. heights: (K,) where each ring
    lies in the picture, 0..1. along: the picture's width runs along the thing instead of round it, and each side shows
    all of its height.
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
    return Solid(
        rings.reshape(-1, 3),
        np.concatenate(faces).astype(np.int64),
        crease_deg=crease_deg,
        picture_uv=np.concatenate(uv),
    )


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
    """The solid with a part of the picture laid over its box, seen along the third axis.

    lower, upper: corners of that part, 0..1. axes: of the solid, to the right and up in the picture.
    """
    flat = solid.points[:, list(axes)]
    share = (flat - flat.min(axis=0)) / np.maximum(np.ptp(flat, axis=0), 1e-9)
    return replace(solid, picture_uv=(np.array(lower) + share * (np.array(upper) - np.array(lower)))[solid.faces])


def plate(corners: Floats, thickness: float, up: Floats) -> Solid:
    """A thin plate below a flat or slightly warped quadrilateral or triangle.

    corners: (N, 3), counter-clockwise seen from outside, metres. up: (3,) out of it; it is pushed outwards.
    """
    lifted = corners + thickness * up / np.linalg.norm(up)
    n = len(corners)
    walls = ring_walls(n, 2)
    cap = np.array([(0, i, i + 1) for i in range(1, n - 1)], dtype=np.int64)
    faces: Ints = np.concatenate([*walls, cap[:, ::-1], cap + n]).astype(np.int64)
    return Solid(np.concatenate([corners, lifted]), faces).oriented_outwards()


def ramp(*shares: float) -> Floats:
    """Shares of a height as an array."""
    return np.array(shares, dtype=np.float64)


def hump(values: Floats) -> Floats:
    """1 in the middle and 0 at both ends of -1..1."""
    return np.asarray(np.clip(1.0 - values**2, 0.0, 1.0))


def dented(rings: Floats, outline: Outline, amount: float, rng: np.random.Generator, waves: float = 1.6) -> Floats:
    """Rings moved out of and into their sides by smooth random waves, as card and paper are never quite flat.

    amount: metres. waves: over the largest side.
    """
    if amount <= 0:
        return rings
    points = rings.reshape(-1, 3)
    total = random_waves(points, waves, float(np.ptp(points, axis=0).max()), 6, rng)
    moved = rings.copy()
    inner = np.clip(1.15 - np.abs(outline.straight * outline.bent[:, ::-1]).sum(axis=1), 0.15, 1.0)[:, None]
    moved[..., :2] += amount / 2.5 * total.reshape(*rings.shape[:2], 1) * outline.bent * inner
    return moved


LYING_BACK = Pose.from_matrix(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
LYING_ALONG = Pose.from_matrix(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))

# Part -----------------------------------------------------------------------------------------------------------------
# A solid, its finish, what it is called, what it weighs.


@dataclass(frozen=True)
class Part:
    """A part of a package."""

    solid: Solid  # before the package is laid down: its bottom at z = 0, its front to -y
    finish: str  # id
    label: str
    density: float = 0.0  # kg/m^3; 0: no mass
    collider: bool = False  # it has a separate collision shape
    swings: bool = False  # it is on the link of the lid


FLANGE, FILM = 0.0012, 0.0006


def tub(p: Package) -> list[Part]:
    """A tub or a cup with a flange, closed by foil with a tongue to pull, or by a lid of plastic that snaps on."""
    outline = round_sides(40) if p.corner >= 1 else four_sides(p.front, p.side, 4)
    snaps = p.lid_rise > 0.003
    top = p.height - (p.lid_rise + FILM)
    profile = smooth_profile(p.profile, 13) if p.curved else np.array(p.profile)
    rings = np.stack([_ring(p, outline, share, 0.0, level * top) for share, level in profile])
    levels = profile[:, 1]
    rings[1:-1] = _fluted(p, outline, rings[1:-1])
    body = wrapped(rings, outline.sides, p.lower + (1 - p.lower - p.upper) * levels, crease_deg=35.0)
    parts = [Part(body, p.skin, "package", p.heft)]
    if p.content:
        rows = [*profile[levels < p.fill], (np.interp(p.fill, levels, profile[:, 0]), p.fill)]
        inner = [_ring(p, outline, s, -0.0012, max(0.0012, level * top)) for s, level in rows]
        # The flutes go farther in than the content lies off the wall.
        rings = _fluted(p, outline, np.stack(inner))
        held = wrapped(rings, outline.sides, np.linspace(0, 1, len(rows)), crease_deg=35.0)
        parts.append(Part(held, p.content, "content"))
    flange = np.stack([_ring(p, outline, 1.0, p.flange, z) for z in (top - FLANGE, top - 0.0004)])
    parts.append(Part(wrapped(flange, outline.sides, ramp(0.0, 1.0), crease_deg=40.0), p.rim_finish, "rim"))
    parts += _snap_lid(p, outline, top) if snaps else _foil_lid(p, outline, top)
    return parts


def _ring(p: Package, outline: Outline, share: float, beyond: float, z: float) -> Floats:
    """A ring of the tub: share of the width, and metres beyond that."""
    half_x, half_y = share * p.width / 2 - p.flange + beyond, share * p.depth / 2 - p.flange + beyond
    return outline.ring(half_x, half_y, p.corner * min(half_x, half_y), z)


def _fluted(p: Package, outline: Outline, rings: Floats) -> Floats:
    if p.flutes < 1:
        return rings
    turn = np.arctan2(outline.bent[:, 1], outline.bent[:, 0])
    moved = rings.copy()
    moved[..., :2] -= (0.03 * p.width * np.abs(np.sin(p.flutes * turn / 2))[:, None] ** 2) * outline.bent
    return moved


def _foil_lid(p: Package, outline: Outline, top: float) -> list[Part]:
    rise, edge, small = p.lid_rise, p.flange + 0.0004, min(p.width, p.depth)
    steps = ((0.0, 0.0), (0.0, FILM), (0.06, FILM + 0.05 * rise), (0.35, FILM + 0.75 * rise), (0.75, FILM + rise))
    rings = [_ring(p, outline, 1.0, edge - shrink * small / 2, top + z) for shrink, z in steps]
    lid = wrapped(np.stack(rings), outline.sides, np.linspace(0, 1, 5), crease_deg=60.0)
    lid = with_front_picture(lid, (0.02, 0.02), (0.98, 0.98), (0, 1))
    tongue = p.tongue
    if tongue <= 0:
        return [Part(lid, p.lid, "lid")]
    turns = np.linspace(-np.pi / 2, np.pi / 2, 9)
    half = 0.75 * tongue
    inside = p.width / 2 - 0.35 * half
    end = [(p.width / 2 + (tongue - half) + half * np.cos(t), half * np.sin(t)) for t in turns]
    flat = np.array([(inside, -1.5 * half), *end, (inside, 1.5 * half)])
    # The tongue hangs down a little, seen from the flange on.
    droop = -0.45 * np.maximum(0.0, flat[:, 0] - p.width / 2)
    loops = [np.column_stack([flat, top + FILM * 0.2 + droop]), np.column_stack([flat, top + FILM * 1.05 + droop])]
    flap = wrapped(np.stack(loops), np.zeros((len(flat), 2, 2)), ramp(0.0, 1.0), crease_deg=50.0)
    flap = with_front_picture(flap.oriented_outwards(), (0.9, 0.45), (0.97, 0.55), (0, 1)).rotated("z", p.tongue_turn)
    return [Part(lid, p.lid, "lid"), Part(flap, p.lid, "lid")]


def _snap_lid(p: Package, outline: Outline, top: float) -> list[Part]:
    edge, rise = p.flange + 0.0009, p.lid_rise
    skirt = min(0.3 * p.height, 1.6 * rise)
    small = min(p.width, p.depth) / 2
    steps = ((0.0, FLANGE * -1.3 - 0.6 * skirt), (0.0, 0.6 * rise), (0.02, rise), (0.1, rise), (0.125, 0.45 * rise))
    rings = [_ring(p, outline, 1.0, edge - shrink * small, top + z) for shrink, z in steps]
    lid = wrapped(np.stack(rings), outline.sides, np.linspace(0, 1, 5), crease_deg=35.0)
    field = [_ring(p, outline, 1.0, edge - 0.14 * small, top + z) for z in (0.45 * rise - 0.0005, 0.45 * rise + 0.0004)]
    print_ = wrapped(np.stack(field), outline.sides, ramp(0.0, 1.0), crease_deg=40.0)
    print_ = with_front_picture(print_, (0.02, 0.02), (0.98, 0.98), (0, 1))
    return [Part(lid, p.fitting, "lid"), Part(print_, p.lid, "lid")]


def roll(p: Package) -> list[Part]:
    """A roll of foil, film or paper on a tube of cardboard; it lies, its end a little loose."""
    r, core = p.depth / 2, 0.28 * p.depth
    rim, high = r - 0.0006, p.height
    line = [(core, 0.0), (rim, 0.0), (r, 0.0006), (r, high - 0.0006), (rim, high), (core, high)]
    outer = lathe(line, 40, 40.0, closed=True)
    low, high, inner, wide = -0.004, p.height + 0.004, core - 0.0016, core - 0.0001
    tube = lathe([(inner, low), (wide, low), (wide, high), (inner, high)], 28, 40.0, closed=True)
    # The loose end of the sheet, which stands off more and more.
    turns = np.linspace(0.0, 0.5, 7)
    beyond = r + 0.0012 * turns + 0.0002
    loop = np.column_stack([beyond * np.sin(turns), beyond * np.cos(turns)])
    flat = np.concatenate([loop * (1 + 0.0005 / r), loop[::-1]])
    rows = [np.column_stack([flat, np.full(len(flat), z)]) for z in (0.002, p.height - 0.002)]
    flap = wrapped(np.stack(rows), np.zeros((len(flat), 2, 2)), ramp(0, 1), crease_deg=40.0).oriented_outwards()
    sheet = concatenate([outer, flap])
    return [
        Part(Solid(sheet.points, sheet.faces, crease_deg=40.0), p.skin, "roll", p.heft),
        Part(tube, "paper_kraft", "core"),
    ]


# Pieces across a sheet.
ACROSS = 28


def pillow(p: Package) -> list[Part]:
    """A bag of two sheets, full of food and air, with a crimped strip at both ends and folds next to the strips."""
    x, sheet, sides = two_sheets(ACROSS)
    rng = p.rng()
    inner = p.height - 2 * p.crimp
    steps = 0.45 * (np.sin(np.linspace(-np.pi / 2, np.pi / 2, 15)) * 0.5 + 0.5) + 0.55 * np.linspace(0, 1, 15)
    half, deep = p.width / 2, p.depth / 2
    slack = _creases(p, x, sheet, rng)
    rings, heights = [], []
    for share in steps:
        full = max(0.0, 1.0 - abs(2 * share - 1) ** p.full) ** 0.62
        back = deep * full * (1.0 + p.sag)
        front = deep * full * (1.0 - p.sag)
        # The skin does not stretch: where the bag is full, it is narrower.
        width = float(np.sqrt(max(half**2 - 1.3 * (deep * full) ** 2, (0.55 * half) ** 2)))
        thick = np.where(sheet < 0, front, back)
        bulge = thick * np.clip(1 - np.abs(x) ** p.round_by, 0, 1) ** 0.5 * (1.0 + slack(share))
        y = np.where(sheet == 0, 0.0, sheet * (SEALED + np.maximum(0.0, bulge)))
        # The folds reach into the strip, which is never quite flat.
        rings.append(np.column_stack([x * width, y, np.full(len(x), p.crimp + inner * share)]))
        heights.append((p.crimp + inner * share) / p.height)
    low, high = _strip(p, x, sheet, half, rng, 0), _strip(p, x, sheet, half, rng, 1)
    grid = np.stack([*low, *rings, *high])
    strip = [p.crimp * s / p.height for s in CRIMPS]
    levels = np.array([0.0, *strip, *heights, *(1 - s for s in strip[::-1]), 1.0])
    # Ends of the strip may be cut in teeth.
    if p.teeth:
        tooth = np.where(np.arange(len(x)) % 2 == 0, 0.0, 0.0022)
        grid[0, :, 2] += np.where(sheet == 0, 0.0, tooth)
        grid[-1, :, 2] -= np.where(sheet == 0, 0.0, tooth)
    parts = [Part(wrapped(grid, sides, levels, along=p.along, crease_deg=62.0), p.skin, "package", p.heft)]
    if p.seam:
        parts.append(Part(_back_seam(p, rings), p.skin, "package"))
    return parts


CRIMPS = (0.25, 0.5, 0.75)


def _creases(p: Package, x: Floats, sheet: Floats, rng: np.random.Generator) -> Callable[[float], Floats]:
    """Function of the height's share: how far each point is in or out of the even surface, by the thickness there."""
    waves = [(rng.uniform(4, 9), rng.uniform(0, 6.3), rng.uniform(0.5, 1), s) for s in (-1, 1) for _ in range(3)]
    broad = [(rng.normal(size=2) * 3.2, rng.uniform(0, 6.3), s) for s in (-1, 1) for _ in range(3)]

    def at(share: float) -> Floats:
        total = np.zeros(len(x))
        for count, phase, size, s in waves:
            for end, away in ((0, share), (1, 1 - share)):
                pull = np.exp(-away / 0.16)
                total += (sheet == s) * size * pull * np.sin(count * x * (1 + 0.25 * away) + phase + 2.0 * end)
        for way, phase, s in broad:
            total += (sheet == s) * 0.35 * np.sin(way[0] * x + 1.4 * way[1] * share + phase)
        return np.asarray(p.pleats * total)

    return at


def _strip(p: Package, x: Floats, sheet: Floats, half: float, rng: np.random.Generator, end: int) -> list[Floats]:
    phase, bow = rng.uniform(0, 6.3), rng.uniform(0.6, 1.2)
    out = []
    for k, share in enumerate((0.0, *CRIMPS)):
        z = p.crimp * share if end == 0 else p.height - p.crimp * share
        wave = bow * 0.035 * half * (1.0 - share) * np.sin(3.2 * x + phase)
        out.append(np.column_stack([x * half, sheet * SEALED + wave + (0.0004 * (-1) ** k), np.full(len(x), z)]))
    return out if end == 0 else out[::-1]


def _back_seam(p: Package, rings: list[Floats]) -> Solid:
    wide, middle = 0.05 * p.width + 0.004, 3 * ACROSS // 2
    loops = []
    for ring in rings:
        y, z = float(ring[middle, 1]), float(ring[middle, 2])
        loops.append([(-wide, y + 0.0001, z), (0.001, y - 0.0004, z), (0.001, y + 0.0006, z), (-wide, y + 0.0011, z)])
    seam = wrapped(np.array(loops), np.zeros((4, 2, 2)), np.linspace(0, 1, len(loops)), crease_deg=40.0)
    return with_spot(seam.oriented_outwards(), (0.02, 0.5))


def pouch(p: Package) -> list[Part]:
    """A pouch that rests on its oval bottom; its upper end is sealed flat, with a strip for tearing."""
    x, sheet, sides = two_sheets(ACROSS)
    rng = p.rng()
    half, deep = p.width / 2, p.depth / 2
    shape = np.clip(1 - np.abs(x / (1.0 - (0.045 * p.width) / half)) ** p.round_by, 0, 1) ** 0.8
    phase = rng.uniform(0, 6.3, 4)
    rings, heights = [], []
    for share in (0.0, 0.015, 0.06, 0.14, 0.25, 0.38, 0.52, 0.66, 0.78, 0.87, 0.93):
        full = min(1.0, 0.9 + 2.5 * share) * max(0.0, 1 - (max(0.0, share - 0.12) / 0.83) ** p.full)
        crease = p.pleats * share * (np.sin(5 * x + phase[0] + 4 * share) + 0.6 * np.sin(9 * x + phase[1] - 5 * share))
        crease += 0.5 * p.pleats * np.sin(7 * share + phase[2 + (sheet > 0).astype(int)])
        y = sheet * (SEALED + deep * full * shape * np.maximum(0.2, 1 + crease))
        # The corners of the bottom are cut round.
        width = half * (0.93 + 0.07 * min(1.0, share / 0.06))
        rings.append(np.column_stack([x * width, y, np.full(len(x), share * p.height)]))
        heights.append(share)
    for share in (0.935, 0.94, 0.985, 1.0):
        width, thick = half * (1.0 if share < 0.99 else 0.97), SEALED * (1.6 if share == 0.94 else 1.0)
        rings.append(np.column_stack([x * width, sheet * thick, np.full(len(x), share * p.height)]))
        heights.append(share)
    grid = np.stack(rings)
    grid[:, :, 1] += 0.02 * p.height * (grid[:, :, 2] / p.height) ** 2 * np.sin(phase[0])
    parts = [Part(wrapped(grid, sides, np.array(heights), crease_deg=55.0), p.skin, "package", p.heft)]
    if p.zip_line:
        # In the sealed strip, where both sheets lie together.
        z, y = 0.962 * p.height, float(grid[-2, :, 1].mean())
        for k in (-1, 1):
            low, high = z + 0.003 * k - 0.0008, z + 0.003 * k + 0.0008
            line = board((-0.9 * half, y - 0.0013, low), (0.9 * half, y + 0.0013, high), 0.0004)
            parts.append(Part(with_spot(line, (0.5, 0.99)), p.skin, "package"))
    if p.cap_radius > 0:
        r = p.cap_radius
        neck = rod(0.7 * r, 0.6 * r, 0.0005).translated(z=p.height + 0.2 * r)
        cap = rod(r, 1.3 * r, 0.0012).translated(z=p.height + 1.1 * r)
        parts += [Part(neck, p.fitting, "cap"), Part(cap, p.fitting, "cap", 400.0, collider=True)]
    return parts


def twist(p: Package) -> list[Part]:
    """A sweet in paper or film that is twisted at both ends and fans out there."""
    count = 24
    outline = round_sides(count)
    rng = p.rng()
    turn = np.arctan2(outline.bent[:, 1], outline.bent[:, 0])
    body = p.height - 2 * p.crimp
    neck = 0.22 * min(p.width, p.depth)
    rings, heights = [], []
    phase = rng.uniform(0, 6.3, 2)
    for share in (0.0, 0.3, 0.62, 0.85, 1.0):
        rings.append(_fan(p, outline.bent, turn, neck, share, phase[0]))
        heights.append(share * p.crimp / p.height)
    for share in (0.06, 0.2, 0.4, 0.6, 0.8, 0.94):
        full = (1.0 - abs(2 * share - 1) ** p.full) ** 0.5
        fold = 1.0 + 0.10 * p.pleats * np.sin(7 * turn + phase[1] + 3 * share) * abs(2 * share - 1)
        half_x, half_y = (max(neck, full * side / 2) for side in (p.width, p.depth))
        ring = outline.bent * (half_x, half_y) * fold[:, None]
        rings.append(np.column_stack([ring, np.full(count, p.crimp + share * body)]))
        heights.append((p.crimp + share * body) / p.height)
    for share in (1.0, 0.85, 0.62, 0.3, 0.0):
        ring = _fan(p, outline.bent, turn, neck, share, phase[1])
        ring[:, 2] = p.height - ring[:, 2]
        rings.append(ring)
        heights.append(1 - share * p.crimp / p.height)
    solid = wrapped(np.stack(rings), outline.sides, np.array(heights), along=p.along, crease_deg=48.0)
    return [Part(solid, p.skin, "package", p.heft)]


def _fan(p: Package, bent: Floats, turn: Floats, neck: float, share: float, phase: float) -> Floats:
    """A ring of a twisted end; at share 1 it is the neck, at 0 the free edge, wide, flat and in pleats."""
    open_by = (1 - share) ** 0.8
    wide = neck + (0.5 * p.fin - neck) * open_by
    thin = neck * (1 - open_by) + 2 * SEALED * open_by
    pleat = 0.09 * p.fin * open_by * np.sin(4.5 * bent[:, 0] * np.pi + phase)
    twisted = 0.9 * (1 - share)
    x, y = bent[:, 0] * wide, bent[:, 1] * thin + pleat
    flat = np.column_stack([x * np.cos(twisted) - y * np.sin(twisted), x * np.sin(twisted) + y * np.cos(twisted)])
    ragged = 0.06 * p.crimp * np.sin(3 * turn + phase) * open_by
    return np.column_stack([flat, p.crimp * share + np.maximum(0.0, ragged + 0.06 * p.crimp * open_by)])
