"""Packages of food: cartons, bricks, bags, pouches, tubs, wrapped bars and blocks, with print on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Pose, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, axis_turn, board, box_shape, lathe, tube
from casa_assets.kitchenware.objects import wrapping
from casa_assets.kitchenware.objects.block import SHAPES as BLOCKS
from casa_assets.kitchenware.objects.block import Block
from casa_assets.kitchenware.objects.block import Shape as BlockShape
from casa_assets.kitchenware.objects.closures import LID, LID_GRIP, swing_up
from casa_assets.kitchenware.objects.wrapping import LYING_ALONG, LYING_BACK, SEALED, Outline, Part, roll

# Heights of the rings of a body, as shares of it.
LEVELS = wrapping.ramp(0.0, 0.04, 0.14, 0.32, 0.5, 0.68, 0.86, 0.96, 1.0)
CARD = 0.0009  # of folded card and what hides below it, metres
BOARD_FINISH = "paper_kraft"
# Takes a block that lies along x to one that stands, its upper side to the back.
UPRIGHT = Pose.from_matrix(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))


def carton(p: Package) -> list[Part]:
    """A folded carton with flaps at its ends, and where it has one a window or a spout."""
    outline = wrapping.four_sides(p.front, p.side)
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
            parts.append(
                Part(wrapping.with_front_picture(lid, (0.32, level[0]), (0.68, level[1]), (0, 1)), p.skin, "package")
            )
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
    rings = wrapping.dented(_bulged(rings, outline, p.bulge, 2 * LEVELS - 1), outline, p.dents, p.rng())
    rings[[0, -1], :, 2] = np.array([[0.0], [height]])
    return wrapping.wrapped(rings, outline.sides, low + (high - low) * LEVELS, along=p.along)


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
    body = wrapping.wrapped(rings, outline.sides, np.array([*heights, 1.0 - p.upper, 1.0 - p.upper]), along=p.along)
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
    picture = wrapping.with_front_picture(lid, (0.32, 1.0 - p.upper), (0.68, 0.997), (0, 1))
    return [*parts, Part(picture.with_box_collider(), p.skin, "lid", swings=True)]


def lid_seam(p: Package) -> float:
    """Height of the upper edge of an open carton, below its lid, metres."""
    return p.height - 2 * CARD - 0.0004


def _bulged(rings: Floats, outline: Outline, amount: float, levels: Floats) -> Floats:
    moved = rings.copy()
    wide = np.abs(outline.bent[:, 1:]) * np.ptp(rings[0, :, 0]) + np.abs(outline.bent[:, :1]) * np.ptp(rings[0, :, 1])
    share = wrapping.hump(np.abs(outline.straight * outline.bent[:, ::-1]).sum(axis=1))[:, None] * wide / wide.max()
    moved[..., :2] += amount * wrapping.hump(levels)[:, None, None] * (share * outline.bent)
    return moved


def _window(p: Package) -> Solid:
    half, low, high = 0.5 * p.width * p.window_wide, p.height * 0.08, p.height * (0.08 + p.window)
    columns, rows = np.linspace(-half, half, 7), np.linspace(low, high, 9)
    front = []
    for z in rows:
        lift = p.bulge * wrapping.hump(np.array(2 * z / p.height - 1)) * wrapping.hump(2 * columns / p.width) + 0.0004
        cut = 0.86 if z in (rows[0], rows[-1]) else 1.0
        front.append(np.column_stack([columns * cut, -p.depth / 2 - lift - 0.5 * p.dents, np.full(7, z)]))
    sheet = np.array(front)
    back = np.add(sheet, (0.0, 0.0012, 0.0))
    loop = [np.concatenate([sheet[k], back[k][::-1]]) for k in range(9)]
    solid = wrapping.wrapped(np.array(loop), np.zeros((14, 2, 2)), np.linspace(0, 1, 9), crease_deg=30.0)
    return wrapping.with_front_picture(solid.oriented_outwards(), (0.02, 0.02), (0.98, 0.98))


def gable(p: Package) -> list[Part]:
    """A carton with a gable: its upper end is folded to a ridge, and a cap sits on the slope."""
    outline = wrapping.four_sides(p.front, p.side, 1)
    half_x, half_y = p.width / 2, p.depth / 2
    wall = p.height * (1.0 - p.roof) - p.fin
    shares = wrapping.ramp(0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
    rings = [outline.ring(half_x, half_y, p.edge, wall * share) for share in shares]
    body = _bulged(np.stack(rings), outline, p.bulge, 2 * shares - 1)
    roof = [gathered(outline, half_x, half_y, p.edge, wall, p.height - p.fin, s) for s in (0.06, 0.3, 0.6, 0.9, 1.0)]
    everything = np.concatenate([body, np.stack([*roof, (roof[-1] + (0.0, 0.0, p.fin))])])
    slope = [1.0 - p.upper * (1.0 - 0.8 * s) for s in (0.06, 0.3, 0.6, 0.9, 1.0)]
    heights = np.array([*(p.lower + (1.0 - p.lower - p.upper) * shares), *slope, 1.0])
    parts = [Part(wrapping.wrapped(everything, outline.sides, heights, crease_deg=28.0), p.skin, "package", p.heft)]
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
    """A ring of a top that is folded to a ridge along x, its two narrow sides tucked in.

    low, high: of the slope, metres. share: how far up.
    """
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
    body = _sides(p, wrapping.four_sides(p.front, p.side, 1), p.height, p.lower, 1.0 - p.upper)
    half_x, half_y = p.width / 2, p.depth / 2
    parts = [Part(body, p.skin, "package", p.heft)]
    spot = (0.5, 1.0 - 0.5 * max(p.upper, 0.02))
    strip = board((-half_x + 0.001, -0.002, p.height), (half_x - 0.001, 0.006, p.height + 0.0011), 0.0003)
    parts.append(Part(wrapping.with_spot(strip, spot), p.skin, "package"))
    for sign in (-1, 1):
        x = sign * (half_x + 0.0002)
        tip = (x + sign * p.bulge * 0.3, 0.0, p.height - 0.85 * half_y)
        corners = [(x, -half_y * 0.96, p.height), (x, half_y * 0.96, p.height), tip]
        ear = wrapping.plate(np.array(corners), 0.0009, np.array([float(sign), 0.0, 0.0]))
        level = 1.0 - p.upper
        edge = 0.5 + sign * (p.front + p.side) / 2
        ear = wrapping.with_front_picture(
            ear, (edge - 0.3 * p.side, level - 0.12), (edge + 0.3 * p.side, level), (1, 2)
        )
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


def wrapped_block(p: Package) -> list[Part]:
    """A block in paper or foil whose ends are folded like those of a parcel; part of it may be bare."""
    if p.bare >= 1:
        return [Part(_bare_block(p, 0.0), p.content or p.skin, "food", p.heft)]
    outline = wrapping.four_sides(p.front, p.side, 2)
    fold = 0.0007
    top = p.height * (1.0 - p.bare)
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
            foil = wrapping.wrapped(np.stack(rings), outline.sides, wrapping.ramp(0.0, 1.0), crease_deg=50.0)
            parts.append(Part(foil, p.fitting, "foil"))
    if p.seam:
        y = p.depth / 2 + p.bulge * 0.4
        strip = board((-0.18 * p.width, -y - 0.0004, fold), (-0.1 * p.width, -y + 0.001, top - fold), 0.0)
        parts.append(Part(wrapping.with_spot(strip, (0.5, 0.5)), p.skin, "package"))
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
        folded = wrapping.plate(corners if sign * up < 0 else corners[::-1], 0.0003, np.array([0.0, 0.0, up]))
        parts.append(Part(wrapping.with_spot(folded, spot), p.skin, "package"))
    return parts


def _bare_block(p: Package, less: float) -> Solid:
    """The unwrapped food, smaller by `less` on each side, metres: a plain block, or a tablet of chocolate."""
    shape = BlockShape.TABLET if p.rows > 0 else BlockShape.SLAB
    block = Block(
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
    return BLOCKS[shape](block)[0].solid.transformed(UPRIGHT).translated(y=-p.depth / 2 + less, z=p.height / 2 + less)


def paper_bag(p: Package) -> list[Part]:
    """A bag of flour or sugar: a soft block whose upper end is folded over and lies flat, or is rolled up."""
    outline = wrapping.four_sides(p.front, p.side, 2)
    half_x, half_y = p.width / 2, p.depth / 2
    wall = p.height * (1.0 - p.roof) - p.fin
    shares = wrapping.ramp(0.0, 0.03, 0.12, 0.3, 0.5, 0.7, 0.88, 1.0)
    rings = np.stack([outline.ring(half_x - 0.0015 * (s == 0), half_y, p.edge, wall * s) for s in shares])
    body = _bulged(rings, outline, p.bulge, np.minimum(2 * shares - 1, 0.55))
    steps = (0.1, 0.3, 0.55, 0.8, 1.0)
    top = [gathered(outline, half_x, half_y, p.edge, wall, p.height - p.fin, s) for s in steps]
    rng = p.rng()
    everything = wrapping.dented(np.concatenate([body, np.stack(top)]), outline, p.dents, rng, 2.6)
    everything[-1] = top[-1]
    if p.fin > 0:
        everything = np.concatenate([everything, (top[-1] + (0.0, 0.0, p.fin))[None]])
    everything[0, :, 2] = 0.0
    heights = [*(p.lower + (1 - p.lower - p.upper) * shares), *(1.0 - p.upper * (1.0 - 0.8 * s) for s in steps)]
    solid = wrapping.wrapped(
        everything, outline.sides, np.array([*heights, 1.0] if p.fin > 0 else heights), crease_deg=55.0
    )
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
    bar = wrapping.wrapped(rings, np.zeros((len(oval), 2, 2)), wrapping.ramp(0, 1)).transformed(LYING_ALONG)
    return wrapping.with_spot(bar, (0.5, 0.985)).translated(y=-0.5 * p.roll, z=p.height - 0.55 * p.roll)


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
    return wrapping.with_spot(wrapping.plate(corners, 0.0022, out), (0.5, 0.985))


Metres = Annotated[float, Field(gt=0, le=0.5)]
Small = Annotated[float, Field(ge=0, le=0.1)]
Share = Annotated[float, Field(ge=0, le=1)]

# Kind of package: GABLE a carton folded to a ridge above; BRICK a brick of drink with a straw; BLOCK a block wrapped in
# paper or foil, its ends folded; PILLOW a bag or wrapper of film with a crimped strip at both ends; POUCH a bag that
# stands; TWIST a sweet in twisted paper; ROLL of foil or film.
Shape = StrEnum("Shape", "CARTON GABLE BRICK BLOCK PAPER_BAG PILLOW POUCH TWIST TUB ROLL")

# How a package lies; all its dimensions are those of the upright package: BACK on its back, its upper end away from the
# viewer; ALONG its height along x, its back up.
Rest = StrEnum("Rest", "STANDS BACK ALONG")


class Package(Params):
    """Parameters of a package; lengths in metres, of the upright package, its front to -y."""

    shape: Shape = Field(description="kind of package")
    rest: Rest = Field(Rest.STANDS, description="how it lies")
    width: Metres = Field(description="of bags that of the empty bag, m")
    depth: Metres = Field(description="of bags that of the full bag, m")
    height: Metres = Field(description="m")
    front: float = Field(0.36, ge=0.1, le=0.9, description="share of the picture's width, as in the label's recipe")
    side: float = Field(0.14, ge=0, le=0.4, description="the same on each adjacent side")
    lower: float = Field(0.04, ge=0, le=0.4, description="share of the picture's height on the lower end")
    upper: float = Field(0.04, ge=0, le=0.4, description="the same on the upper end")
    along: bool = Field(False, description="the picture's width runs along the height; each side shows all of it")
    edge: Small = Field(0.0012, description="radius of upright edges, m")
    bulge: Small = Field(0.0015, description="of the sides, m")
    dents: Small = Field(0.0004, description="depth of the sides' unevenness, m")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    flap: float = Field(0.1, ge=-1, le=1, description="where flaps meet, by half the depth; near 1: a single flap")
    window: float = Field(0.0, ge=0, le=0.8, description="height of a pane in a carton's front, by the height")
    window_wide: Share = Field(0.7, description="width of the pane, by the width")
    window_finish: FinishId = Field("pasta_dry", description="what is seen through the pane")
    opens: bool = Field(False, description="a carton's upper end is a lid that swings up over a hollow down to `fill`")
    spout: Small = Field(0.0, description="above 0, a carton has a sheet metal spout at its side")
    roof: float = Field(0.15, ge=0, le=0.5, description="of a gable or a paper bag's folds, by the height")
    fin: Small = Field(0.012, description="height of the ridge's seam; width of the ends of twisted paper, m")
    cap_radius: Small = Field(0.0, description="of a screw cap on a gable or a pouch, m; 0: none")
    straw: Small = Field(0.0, description="how far a straw projects from a brick, m; 0: in a wrapper on the back")
    seam: bool = Field(False, description="a flap of the seam at the back")
    roll: Small = Field(0.0, description="half the thickness of a paper bag's rolled end, m; 0: a folded end")
    tie: bool = Field(False, description="the roll has a strip of tin")
    bare: Share = Field(0.0, description="share of a wrapped block at its upper end that is unwrapped")
    rows: int = Field(0, ge=0, le=8, description="segments of the block if it is a tablet, else 0")
    columns: int = Field(0, ge=0, le=12, description="segments of a tablet")
    liner: Small = Field(0.0, description="how far foil projects from the paper of a bare block, m")
    crimp: Small = Field(0.012, description="height of a sealed strip, or of twisted paper at each end, m")
    teeth: bool = Field(True, description="the strip has a serrated edge")
    pleats: float = Field(0.1, ge=0, le=0.5, description="depth of the folds")
    full: float = Field(3.0, ge=1, le=12, description="bluntness of the ends of the filled part")
    round_by: float = Field(2.2, ge=1.2, le=12, description="bluntness of its sides")
    sag: float = Field(0.0, ge=-0.9, le=0.9, description="how much deeper the back is than half the depth, by that")
    zip_line: bool = Field(False, description="a pouch has a zip")
    profile: tuple[Vec2, ...] = Field(
        ((0.8, 0.0), (1.0, 1.0)),
        min_length=2,
        max_length=14,
        description="(width, height) of a tub from foot to flange, shares",
    )
    curved: bool = Field(False, description="the profile of a tub is a smooth curve")
    corner: float = Field(1.0, ge=0.1, le=1, description="radius of a tub's corners by half the width; 1: round")
    flange: float = Field(0.003, ge=0, le=0.012, description="how far it projects, m")
    flutes: int = Field(0, ge=0, le=24, description="upright ones of a tub")
    lid_rise: Small = Field(0.0006, description="height of a tub's lid, m; from 3 mm on it is of plastic")
    tongue: Small = Field(0.008, description="length of a tongue to pull the lid off, m")
    tongue_turn: float = Field(-0.8, ge=-3.2, le=3.2, description="direction of the tongue, rad")
    fill: Share = Field(0.85, description="share of the height that is filled, if the content can be seen")
    heft: float = Field(400.0, gt=5, le=3000, description="mass of the whole per volume of its body, kg/m^3")
    skin: FinishId
    fitting: FinishId = Field("plastic_white", description="of cap, straw or tie")
    lid: FinishId = Field("foil_silver", description="of a tub")
    rim_finish: FinishId = Field("plastic_white", description="of a tub's flange")
    content: FinishId | None = Field(None, description="of a clear package, or of a bare block")

    @model_validator(mode="after")
    def _can_open(self) -> Package:
        if self.opens and (self.shape is not Shape.CARTON or self.rest is not Rest.STANDS or self.spout > 0):
            raise ValueError(f"a carton without a spout that stands is expected to open, got a {self.shape}")
        return self

    def rng(self) -> np.random.Generator:
        """The generator of what is random in its form."""
        return np.random.Generator(np.random.PCG64(self.seed))


SHAPES: Mapping[Shape, Callable[[Package], list[Part]]] = {
    Shape.CARTON: carton, Shape.GABLE: gable, Shape.BRICK: brick, Shape.BLOCK: wrapped_block,
    Shape.PAPER_BAG: paper_bag, Shape.PILLOW: wrapping.pillow, Shape.POUCH: wrapping.pouch,
    Shape.TWIST: wrapping.twist, Shape.TUB: wrapping.tub, Shape.ROLL: roll,
}  # fmt: skip
# Collision shapes of an open carton's walls are so thick, metres; its lid turns so far, rad.
WALL, LID_SWING = 0.002, 1.9
POSES = {Rest.STANDS: Pose(), Rest.BACK: LYING_BACK, Rest.ALONG: LYING_ALONG}


def build_package(builder: AssetBuilder, p: Package) -> None:
    """Build the asset: it rests on z = 0."""
    parts = SHAPES[p.shape](p)
    everything = np.concatenate([part.solid.points for part in parts])
    pose = POSES[p.rest]
    at = Pose(position=(0.0, 0.0, -float(pose.apply(everything)[:, 2].min()))) @ pose
    colliders = [solid.transformed(at) for solid in _colliders(p, parts[0].solid, everything)]
    for k, part in enumerate(parts):
        solid = part.solid.transformed(at)
        if part.swings:
            low, high = solid.bounds
            hinge = (0.0, float(high[1]), float(low[2]))
            builder.link(LID, hinge)
            placed = solid.translated(*(-v for v in hinge))
            builder.add(
                LID, placed, part.finish, label=part.label, name="lid", collider=LID_GRIP, density="cardboard_flap"
            )
            swing_up(builder, (-1.0, 0.0, 0.0), LID_SWING)
            continue
        if k == 0:
            solid = solid.with_colliders_of(*colliders)
        elif part.collider and not solid.shapes:
            solid = solid.with_hull_collider()
        touched = k == 0 or part.collider
        builder.add(ROOT, solid, part.finish, label=part.label, collider=touched, density=part.density)


def _colliders(p: Package, body: Solid, everything: Floats) -> list[Solid]:
    low, high = body.bounds
    match p.shape:
        case Shape.CARTON if p.opens:
            level, top, t = p.fill * p.height, lid_seam(p), WALL
            (x0, y0, _), (x1, y1, _) = low, high
            below = box_shape((x0, y0, 0.0), (x1, y1, level))
            # The lid swings past the back, which bulges less up here.
            y1 = p.depth / 2
            walls = [
                ((x0, y0, level), (x0 + t, y1, top)), ((x1 - t, y0, level), (x1, y1, top)),
                ((x0 + t, y0, level), (x1 - t, y0 + t, top)), ((x0 + t, y1 - t, level), (x1 - t, y1, top)),
            ]  # fmt: skip
            return [body.with_shapes(below, *(box_shape(a, b) for a, b in walls))]
        case Shape.CARTON | Shape.BRICK | Shape.BLOCK:
            top = high[2] if p.bare > 0 else p.height
            return [body.with_shapes(box_shape((low[0], low[1], 0.0), (high[0], high[1], top)))]
        case Shape.GABLE | Shape.PAPER_BAG:
            wall = p.height * (1.0 - p.roof) - p.fin
            upper = Solid(body.points[body.points[:, 2] > wall - 0.001], body.faces[:0]).with_hull_collider()
            return [body.with_shapes(box_shape((low[0], low[1], 0.0), (high[0], high[1], wall))), upper]
        case Shape.TWIST:
            # Boxes do not roll; all of them reach down to what it lies on, its front.
            edges = (low[2], p.crimp, p.height - p.crimp, high[2])
            within = [body.points[(body.points[:, 2] >= a) & (body.points[:, 2] <= b)] for a, b in pairwise(edges)]
            boxes = [
                box_shape((q[:, 0].min(), low[1], a), (q[:, 0].max(), q[:, 1].max(), b))
                for q, (a, b) in zip(within, pairwise(edges), strict=True)
            ]
            return [body.with_shapes(*boxes)]
        case Shape.TUB:
            return [Solid(everything, body.faces[:0]).with_hull_collider()]
    return [body.with_hull_collider()]
