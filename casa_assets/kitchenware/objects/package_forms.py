"""Forms of packages: folded cartons, gables and bricks, wrapped blocks, bags, pouches, twisted sweets, tubs, rolls."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.records import Pose
from casa_assets.ext.solids import Solid, axis_turn, board, concatenate, lathe, rod, tube
from casa_assets.kitchenware.objects.block import SHAPES as BLOCKS
from casa_assets.kitchenware.objects.block import Block
from casa_assets.kitchenware.objects.block import Shape as BlockShape
from casa_assets.kitchenware.objects.closed_surface import smooth_profile
from casa_assets.kitchenware.objects.wrapping import (
    LYING_ALONG,
    SEALED,
    Outline,
    Part,
    dented,
    four_sides,
    hump,
    plate,
    round_sides,
    two_sheets,
    with_front_picture,
    with_spot,
    wrapped,
)

if TYPE_CHECKING:
    from casa_assets.kitchenware.objects.package import Package

# Heights of the rings of a body, as shares of it.
LEVELS = np.array([0.0, 0.04, 0.14, 0.32, 0.5, 0.68, 0.86, 0.96, 1.0])
CARD = 0.0009  # of folded card and what hides below it, metres
BOARD_FINISH = "paper_kraft"
# Takes a block that lies along x to one that stands, its upper side to the back.
UPRIGHT = Pose.from_matrix(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))


# Pieces across a sheet.
ACROSS = 28
CRIMPS = (0.25, 0.5, 0.75)
FLANGE, FILM = 0.0012, 0.0006


def carton(p: Package) -> list[Part]:
    """A folded carton with flaps at its ends, and where it has one a window or a spout."""
    outline = four_sides(p.front, p.side)
    flaps = CARD * 2
    half_x, half_y = p.width / 2, p.depth / 2
    if p.opens:
        parts = _open_carton(p, outline, flaps)
    else:
        body = _sides(p, outline, p.height - 2 * flaps, p.lower, 1.0 - p.upper).translated(z=flaps)
        parts = [Part(body, p.skin, "package", p.heft)]
    for end in (0,) if p.opens else (0, 1):
        z = p.height - flaps if end else 0.0
        layer, low = (z, z + CARD) if end else (z + CARD, z)
        x, y = half_x - 0.5 * CARD, half_y - 0.5 * CARD
        parts.append(Part(board((-x, -y, layer), (x, y, layer + CARD), 0.0), BOARD_FINISH, "flap"))
        middle = half_y * p.flap
        level = (1.0 - p.upper, 0.997) if end else (0.003, p.lower)
        pieces = ((-half_y, middle - 0.0007), (middle + 0.0007, half_y)) if p.flap < 0.95 else ((-half_y, half_y),)
        for front, back in pieces:
            lid = board((-half_x, front, low), (half_x, back, low + CARD), 0.0)
            parts.append(Part(with_front_picture(lid, (0.32, level[0]), (0.68, level[1]), (0, 1)), p.skin, "package"))
    if p.window > 0:
        parts.append(Part(_window(p), p.window_finish, "window"))
    if p.spout > 0:
        x, size = half_x + p.bulge * 0.3, 0.3 * p.depth
        low, high = p.height - 0.8 * size - 0.008, p.height - 0.008
        parts.append(Part(board((x - 0.002, -size / 2, low), (x + 0.0012, size / 2, high), 0.0006), p.fitting, "spout"))
    return parts


def _sides(p: Package, outline: Outline, height: float, low: float, high: float) -> Solid:
    half_x, half_y = p.width / 2, p.depth / 2
    rings = np.stack([outline.ring(half_x, half_y, p.edge, height * share) for share in LEVELS])
    rings = dented(_bulged(rings, outline, p.bulge, 2 * LEVELS - 1), outline, p.dents, p.rng())
    rings[[0, -1], :, 2] = np.array([[0.0], [height]])
    return wrapped(rings, outline.sides, low + (high - low) * LEVELS, along=p.along)


def _open_carton(p: Package, outline: Outline, flaps: float) -> list[Part]:
    """The body of a carton that is open above what fills it, its lining, what is seen inside, and its lid."""
    half_x, half_y, top, level = p.width / 2, p.depth / 2, lid_seam(p), p.fill * p.height
    # The lining is flat, so the sides are dented little.
    smooth = p.replace(dents=min(p.dents, 0.0003))
    full = _sides(smooth, outline, top - flaps, p.lower, 1.0 - p.upper).translated(z=flaps)
    outside = full.points.reshape(len(LEVELS), -1, 3)
    inside = [outline.ring(half_x - CARD, half_y - CARD, p.edge, z) for z in (top, level)]
    heights = p.lower + (1.0 - p.upper - p.lower) * LEVELS
    rings = np.concatenate([outside, np.stack(inside)])
    body = wrapped(rings, outline.sides, np.array([*heights, 1.0 - p.upper, 1.0 - p.upper]), along=p.along)
    parts = [Part(body, p.skin, "package", p.heft * full.volume / body.volume)]
    x, y, z = half_x - CARD, half_y - CARD, top - 0.0005
    for sign in (-1, 1):
        ends, sides = sorted((sign * x, sign * (x - 0.0003))), sorted((sign * y, sign * (y - 0.0003)))
        end = board((ends[0], -y, level), (ends[1], y, z), 0.0)
        side = board((-x + 0.0003, sides[0], level), (x - 0.0003, sides[1], z), 0.0)
        parts += [Part(sheet, BOARD_FINISH, "lining") for sheet in (end, side)]
    held = board((-x + 0.0004, -y + 0.0004, level - 0.001), (x - 0.0004, y - 0.0004, level + 0.0006), 0.0)
    parts.append(Part(held, p.content or "paper_white", "content"))
    lid = board((-half_x, -half_y, top + 0.0004), (half_x, half_y, p.height), 0.0)
    picture = with_front_picture(lid, (0.32, 1.0 - p.upper), (0.68, 0.997), (0, 1))
    return [*parts, Part(picture.with_box_collider(), p.skin, "lid", swings=True)]


def lid_seam(p: Package) -> float:
    """Height of the upper edge of an open carton, below its lid, metres."""
    return p.height - 2 * CARD - 0.0004


def _bulged(rings: Floats, outline: Outline, amount: float, levels: Floats) -> Floats:
    moved = rings.copy()
    wide = np.abs(outline.bent[:, 1:]) * np.ptp(rings[0, :, 0]) + np.abs(outline.bent[:, :1]) * np.ptp(rings[0, :, 1])
    share = hump(np.abs(outline.straight * outline.bent[:, ::-1]).sum(axis=1))[:, None] * wide / wide.max()
    moved[..., :2] += amount * hump(levels)[:, None, None] * (share * outline.bent)
    return moved


def _window(p: Package) -> Solid:
    half, low, high = 0.5 * p.width * p.window_wide, p.height * 0.08, p.height * (0.08 + p.window)
    columns, rows = np.linspace(-half, half, 7), np.linspace(low, high, 9)
    front = []
    for z in rows:
        lift = p.bulge * hump(np.array(2 * z / p.height - 1)) * hump(2 * columns / p.width) + 0.0004
        cut = 0.86 if z in (rows[0], rows[-1]) else 1.0
        front.append(np.column_stack([columns * cut, -p.depth / 2 - lift - 0.5 * p.dents, np.full(7, z)]))
    sheet = np.array(front)
    back = np.add(sheet, (0.0, 0.0012, 0.0))
    loop = [np.concatenate([sheet[k], back[k][::-1]]) for k in range(9)]
    solid = wrapped(np.array(loop), np.zeros((14, 2, 2)), np.linspace(0, 1, 9), crease_deg=30.0)
    return with_front_picture(solid.oriented_outwards(), (0.02, 0.02), (0.98, 0.98))


def gable(p: Package) -> list[Part]:
    """A carton with a gable: its upper end is folded to a ridge, and a cap sits on the slope."""
    outline = four_sides(p.front, p.side, 1)
    half_x, half_y = p.width / 2, p.depth / 2
    wall = p.height * (1.0 - p.roof) - p.fin
    shares = np.array([0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0])
    rings = [outline.ring(half_x, half_y, p.edge, wall * share) for share in shares]
    body = _bulged(np.stack(rings), outline, p.bulge, 2 * shares - 1)
    roof = [gathered(outline, half_x, half_y, p.edge, wall, p.height - p.fin, s) for s in (0.06, 0.3, 0.6, 0.9, 1.0)]
    everything = np.concatenate([body, np.stack([*roof, (roof[-1] + (0.0, 0.0, p.fin))])])
    slope = [1.0 - p.upper * (1.0 - 0.8 * s) for s in (0.06, 0.3, 0.6, 0.9, 1.0)]
    heights = np.array([*(p.lower + (1.0 - p.lower - p.upper) * shares), *slope, 1.0])
    parts = [Part(wrapped(everything, outline.sides, heights, crease_deg=28.0), p.skin, "package", p.heft)]
    if p.cap_radius > 0:
        rise, run, r, high = p.height * p.roof, half_y, p.cap_radius, 0.85 * p.cap_radius
        profile = [(1.25 * r, -0.002), (1.25 * r, 0.001), (r, 0.0018), (r, 0.85 * high), (0.9 * r, high)]
        at = Pose(position=(0.0, -0.52 * run, wall + 0.48 * rise)) @ axis_turn("x", math.atan2(rise, run))
        cap = ribbed(lathe(profile, 36, 45.0), r).with_hull_collider().transformed(at)
        parts.append(Part(cap, p.fitting, "cap", 500.0, collider=True))
    return parts


def gathered(
    outline: Outline, half_x: float, half_y: float, edge: float, low: float, high: float, share: float
) -> Floats:
    """A ring of a top folded to a ridge along x from z = low to high, its narrow sides tucked in; share: how far up."""
    ring = outline.ring(half_x, half_y, edge * (1 - share) + 1e-5, low + share * (high - low))
    ridge = 2.2 * SEALED
    place = ring[:, 1] / half_y
    ring[:, 1] = place * (half_y * (1 - share) + ridge * share)
    tuck = np.where(np.abs(outline.bent[:, 0]) > 0.99, half_y * share * (1.0 - np.abs(place)), 0.0)
    ring[:, 0] -= np.sign(ring[:, 0]) * np.minimum(tuck, 0.92 * half_x)
    return ring


def ribbed(cap: Solid, radius: float) -> Solid:
    """A cap of 36 points round whose grip has ribs."""
    points = cap.points.copy()
    angle = np.arctan2(points[:, 1], points[:, 0])
    outer = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius) < 1e-6
    points[:, :2] *= np.where(outer, 1.0 - 0.05 * (np.round(angle / (2 * np.pi / 36)) % 2), 1.0)[:, None]
    return Solid(points, cap.faces, cap.shapes, crease_deg=30.0)


def brick(p: Package) -> list[Part]:
    """A brick of drink with folded ears and a straw, in its hole or glued to the back."""
    body = _sides(p, four_sides(p.front, p.side, 1), p.height, p.lower, 1.0 - p.upper)
    half_x, half_y = p.width / 2, p.depth / 2
    parts = [Part(body, p.skin, "package", p.heft)]
    spot = (0.5, 1.0 - 0.5 * max(p.upper, 0.02))
    strip = board((-half_x + 0.001, -0.002, p.height), (half_x - 0.001, 0.006, p.height + 0.0011), 0.0003)
    parts.append(Part(with_spot(strip, spot), p.skin, "package"))
    for sign in (-1, 1):
        x = sign * (half_x + 0.0002)
        tip = (x + sign * p.bulge * 0.3, 0.0, p.height - 0.85 * half_y)
        corners = [(x, -half_y * 0.96, p.height), (x, half_y * 0.96, p.height), tip]
        ear = plate(np.array(corners), 0.0009, np.array([float(sign), 0.0, 0.0]))
        level, edge = 1.0 - p.upper, 0.5 + sign * (p.front + p.side) / 2
        ear = with_front_picture(ear, (edge - 0.3 * p.side, level - 0.12), (edge + 0.3 * p.side, level), (1, 2))
        parts.append(Part(ear, p.skin, "package"))
    radius = 0.0021
    x, y = 0.45 * half_x, -0.45 * half_y
    hole = lathe([(0.0052, p.height + 0.0002), (0.0052, p.height + 0.0012)], 20).translated(x, y)
    if p.straw > 0:
        parts.append(Part(hole, "foil_silver", "seal"))
        bend = p.height + 0.62 * p.straw
        path = [(x, y, p.height - 0.01), (x, y, bend), (x - 0.35 * p.straw, y, bend + 0.3 * p.straw)]
        parts.append(Part(tube(path, radius, 0.006), p.fitting, "straw", 200.0, collider=True))
    else:
        y = half_y + p.bulge + p.dents + radius
        reach = 0.36 * min(p.height, 4 * p.width)
        lean = min(0.7, math.atan2(0.62 * p.width, 2 * reach))
        dx, dz = reach * math.sin(lean), reach * math.cos(lean)
        path = [(-dx, y, p.height / 2 - dz), (dx, y, p.height / 2 + dz)]
        parts += [Part(tube(path, radius), p.fitting, "straw", 200.0, collider=True), Part(hole, "foil_silver", "seal")]
    return parts


def block(p: Package) -> list[Part]:
    """A block in paper or foil whose ends are folded like those of a parcel; part of it may be bare."""
    if p.bare >= 1:
        return [Part(_bare_block(p, 0.0), p.content or p.skin, "food", p.heft)]
    outline = four_sides(p.front, p.side, 2)
    fold, top = 0.0007, p.height * (1.0 - p.bare)
    # A wrapper that is open lies smoothly, so that it stays clear of what is in it.
    smooth = p if p.bare == 0 else p.replace(dents=0.0)
    body = _sides(smooth, outline, top - 2 * fold, p.lower, 1.0 - p.upper).translated(z=fold)
    parts = [Part(body, p.skin, "package", p.heft if p.bare == 0 else 0.0)]
    for end in (0, 1):
        if end == 0 or p.bare == 0:
            parts += _parcel_end(p, top, fold, end)
    if p.bare > 0:
        parts.append(Part(_bare_block(p, 0.0007), p.content or p.skin, "food", p.heft, collider=True))
        if p.liner > 0:
            # Foil under the paper stands out a little, where it was torn.
            half_x, half_y = p.width / 2 - 0.0004, p.depth / 2 - 0.0004
            rings = [outline.ring(half_x, half_y, p.edge, z) for z in (top - 0.004, top + p.liner)]
            rings[1][:, 2] += 0.35 * p.liner * np.sin(np.arange(len(rings[1])) * 2.1)
            foil = wrapped(np.stack(rings), outline.sides, np.array([0.0, 1.0]), crease_deg=50.0)
            parts.append(Part(foil, p.fitting, "foil"))
    if p.seam:
        y = p.depth / 2 + p.bulge * 0.4
        strip = board((-0.18 * p.width, -y - 0.0004, fold), (-0.1 * p.width, -y + 0.001, top - fold), 0.0)
        parts.append(Part(with_spot(strip, (0.5, 0.5)), p.skin, "package"))
    return parts


def _parcel_end(p: Package, top: float, fold: float, end: int) -> list[Part]:
    less = 0.0004 + 0.3 * p.edge
    half_x, half_y = p.width / 2 - less, p.depth / 2 - less
    z, up = (top - fold, 1.0) if end else (fold, -1.0)
    spot = (0.5, 0.996 if end else 0.004)
    cut, lean = 0.85 * min(half_x, half_y), 0.25 * half_y
    parts = []
    for k, sign in enumerate((-1, 1)):
        flap = [(-half_x, sign * half_y), (half_x, sign * half_y)]
        flap += [(half_x - cut, -sign * lean), (-half_x + cut, -sign * lean)]
        corners = np.array([(x, y, z + 0.00035 * k * up) for x, y in flap])
        folded = plate(corners if sign * up < 0 else corners[::-1], 0.0003, np.array([0.0, 0.0, up]))
        parts.append(Part(with_spot(folded, spot), p.skin, "package"))
    return parts


def _bare_block(p: Package, less: float) -> Solid:
    """The unwrapped food, smaller by `less` on each side, metres: a plain block, or a tablet of chocolate."""
    shape = BlockShape.TABLET if p.rows > 0 else BlockShape.SLAB
    bare = Block(
        shape=shape,
        width=p.height - 2 * less,
        depth=p.width - 2 * less,
        height=p.depth - 2 * less,
        corner=0.1,
        edge=0.0015,
        rows=max(1, p.rows),
        columns=max(1, p.columns),
        gap=0.0016,
        bumps=0.004 if p.rows == 0 else 0.0,
        seed=p.seed,
        skin=p.skin,
    )
    return BLOCKS[shape](bare)[0].solid.transformed(UPRIGHT).translated(y=-p.depth / 2 + less, z=p.height / 2 + less)


def paper_bag(p: Package) -> list[Part]:
    """A bag of flour or sugar: a soft block whose upper end is folded over and lies flat, or is rolled up."""
    outline = four_sides(p.front, p.side, 2)
    half_x, half_y = p.width / 2, p.depth / 2
    wall = p.height * (1.0 - p.roof) - p.fin
    shares = np.array([0.0, 0.03, 0.12, 0.3, 0.5, 0.7, 0.88, 1.0])
    rings = np.stack([outline.ring(half_x - 0.0015 * (s == 0), half_y, p.edge, wall * s) for s in shares])
    body = _bulged(rings, outline, p.bulge, np.minimum(2 * shares - 1, 0.55))
    steps = (0.1, 0.3, 0.55, 0.8, 1.0)
    top = [gathered(outline, half_x, half_y, p.edge, wall, p.height - p.fin, s) for s in steps]
    everything = dented(np.concatenate([body, np.stack(top)]), outline, p.dents, p.rng(), 2.6)
    everything[-1] = top[-1]
    if p.fin > 0:
        everything = np.concatenate([everything, (top[-1] + (0.0, 0.0, p.fin))[None]])
    everything[0, :, 2] = 0.0
    heights = [*(p.lower + (1 - p.lower - p.upper) * shares), *(1.0 - p.upper * (1.0 - 0.8 * s) for s in steps)]
    solid = wrapped(everything, outline.sides, np.array([*heights, 1.0] if p.fin > 0 else heights), crease_deg=55.0)
    parts = [Part(solid, p.skin, "package", p.heft)]
    if p.roll <= 0:
        return [*parts, Part(_folded_end(p), p.skin, "package")]
    parts.append(Part(_rolled_end(p), p.skin, "package"))
    if p.tie:
        y, z, reach = -1.34 * p.roll, p.height - 0.54 * p.roll, half_x + 0.009
        tie = board((-reach, y - 0.08 * p.roll, z - 0.12 * p.roll), (reach, y, z + 0.12 * p.roll), 0.0004)
        parts.append(Part(tie, p.fitting, "tie", collider=True))
    return parts


def _rolled_end(p: Package) -> Solid:
    half_x, turns = 0.98 * p.width / 2, np.linspace(0, 2 * np.pi, 14)[:-1]
    oval = np.column_stack([0.9 * p.roll * np.cos(turns), 0.55 * p.roll * np.sin(turns)])
    rings = np.stack([np.column_stack([oval, np.full(len(oval), x)]) for x in (-half_x, half_x)])
    bar = wrapped(rings, np.zeros((len(oval), 2, 2)), np.array([0.0, 1.0])).transformed(LYING_ALONG)
    return with_spot(bar, (0.5, 0.985)).translated(y=-0.5 * p.roll, z=p.height - 0.55 * p.roll)


def _folded_end(p: Package) -> Solid:
    half_x, half_y, ridge = p.width / 2, p.depth / 2, p.height - p.fin
    slope = np.array([0.0, -half_y, -p.height * p.roof])
    slope /= np.linalg.norm(slope)
    out = np.array([0.0, slope[2], -slope[1]])
    reach = min(0.9 * half_y, 0.03)
    start, end = np.array([0.0, -0.0006, ridge]) + 0.0006 * out, np.array([0.0, 0.0, ridge]) + reach * slope
    end += 0.0012 * out
    side = np.array([half_x * 0.99, 0.0, 0.0])
    corners = np.array([start - side, end - 0.97 * side, end + 0.97 * side, start + side])
    return with_spot(plate(corners, 0.0022, out), (0.5, 0.985))


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
    parts.append(Part(wrapped(flange, outline.sides, np.array([0.0, 1.0]), crease_deg=40.0), p.rim_finish, "rim"))
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
    flap = wrapped(np.stack(loops), np.zeros((len(flat), 2, 2)), np.array([0.0, 1.0]), crease_deg=50.0)
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
    print_ = wrapped(np.stack(field), outline.sides, np.array([0.0, 1.0]), crease_deg=40.0)
    print_ = with_front_picture(print_, (0.02, 0.02), (0.98, 0.98), (0, 1))
    return [Part(lid, p.fitting, "lid"), Part(print_, p.lid, "lid")]


def roll(p: Package) -> list[Part]:
    """A roll of foil, film or paper on a tube of cardboard; it lies, its end a little loose."""
    r, core = p.depth / 2, 0.28 * p.depth
    rim, high = r - 0.0006, p.height
    line = [(core, 0.0), (rim, 0.0), (r, 0.0006), (r, high - 0.0006), (rim, high), (core, high)]
    outer = lathe(line, 40, 40.0, closed=True)
    low, high, inner, wide = -0.004, p.height + 0.004, core - 0.0016, core - 0.0001
    cardboard = lathe([(inner, low), (wide, low), (wide, high), (inner, high)], 28, 40.0, closed=True)
    # The loose end of the sheet, which stands off more and more.
    turns = np.linspace(0.0, 0.5, 7)
    beyond = r + 0.0012 * turns + 0.0002
    loop = np.column_stack([beyond * np.sin(turns), beyond * np.cos(turns)])
    flat = np.concatenate([loop * (1 + 0.0005 / r), loop[::-1]])
    rows = [np.column_stack([flat, np.full(len(flat), z)]) for z in (0.002, p.height - 0.002)]
    flap = wrapped(np.stack(rows), np.zeros((len(flat), 2, 2)), np.array([0.0, 1.0]), crease_deg=40.0)
    sheet = concatenate([outer, flap.oriented_outwards()])
    whole = Solid(sheet.points, sheet.faces, crease_deg=40.0)
    return [Part(whole, p.skin, "roll", p.heft), Part(cardboard, BOARD_FINISH, "core")]


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
        back, front = deep * full * (1.0 + p.sag), deep * full * (1.0 - p.sag)
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


FORMS: Mapping[str, Callable[[Package], list[Part]]] = {
    form.__name__: form for form in (carton, gable, brick, block, paper_bag, pillow, pouch, twist, tub, roll)
}
