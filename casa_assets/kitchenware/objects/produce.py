"""Fruit and vegetables that grew in one piece: profile, lobes, stem and leaves; halves, wedges and slices."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.ext.arrays import Floats, solid_moments
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Portion, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, concatenate, hull_around, tube
from casa_assets.kitchenware.objects.closed_surface import (
    Plane,
    across,
    along,
    bent,
    bumped,
    cut,
    ellipsoid,
    lobed,
    sector,
    sheet,
    shell,
    smooth_profile,
    turned,
    wrapped,
)
from casa_assets.kitchenware.parts.decor import golden_angles, leaf

# Points across a leaf and from its foot to its tip.
ACROSS, LENGTHWISE = 9, 9


def head_leaves(
    curve: Floats, count: int, curl: float, ruffle: float, reach: float, clear: float, rng: np.random.Generator
) -> list[Solid]:
    """Leaves around a body of revolution, the inner ones first; their picture runs upwards from foot to tip.

    curve: (N, 2) radius and height of the body from its lower end to its upper one, m. count: number of leaves. curl,
    ruffle: how far the rims curl away, and how far they rise and fall, relative to the largest radius. reach: share of
    the curve from the foot to the tip of the longest leaf. clear: distance of the innermost leaf from the curve,
    relative to the largest radius.
    """
    size = float(curve[:, 0].max())
    forward = np.gradient(curve, axis=0)
    forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    outward = np.column_stack([forward[:, 1], -forward[:, 0]])
    run = np.linspace(0.0, 1.0, len(curve))
    u, v = np.meshgrid(np.linspace(-1, 1, ACROSS), np.linspace(0.0, 1.0, LENGTHWISE), indexing="ij")
    out = []
    for k, turn in enumerate(golden_angles(count)):
        layer = (k + 1) / count
        place = 0.04 + ((reach * float(rng.uniform(0.82, 1.0)) * (1.0 - 0.18 * layer)) - 0.04) * v
        half = float(rng.uniform(0.95, 1.25)) * np.maximum(np.sin(np.pi * (0.12 + 0.78 * v)), 0.25) ** 0.6
        # Where the body is thin the leaf does not reach round it.
        angle = turn + u * half
        edge = (np.abs(u) ** 4 + v**4) ** 0.25
        off = clear + 0.05 * layer + curl * (0.4 + 0.6 * layer) * edge**4
        waves = float(rng.integers(4, 7))
        off = off + ruffle * edge**3 * np.sin(waves * math.pi * (u + 0.8 * v) + float(rng.uniform(0, 6)))
        base = np.stack([np.interp(place, run, curve[:, i]) for i in (0, 1)], axis=2)
        normal = np.stack([np.interp(place, run, outward[:, i]) for i in (0, 1)], axis=2)
        radius, height = np.moveaxis(base + normal * (off * size)[..., None], 2, 0)
        radius = np.maximum(radius, 0.03 * size)
        out.append(sheet(np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=2), 0.018 * size))
    return out


# How far the lining of a hollow reaches to either side of it, by the distance from its middle.
LINING = 0.015
# A round side of flat faces is rolled over if the next is lower; half degrees from one to the next.
FACET = 16

# Where the cut face of a half or a wedge looks: UP it lies on its skin; DOWN it lies on a cut face; SIDE it lies on the
# side of its skin, where it comes to rest, and a face across the axis looks to +x.
Face = StrEnum("Face", "UP DOWN SIDE")


def rest_tilt(body: Solid) -> float:
    """Angle about the y axis by which a body has to be turned from how it lies until it is at rest, rad.

    It rolls downhill: to where the middle of its mass is lowest above the ground of all tilts on the way.
    """
    _, middle, _ = solid_moments(body.points, body.faces)
    tilts = np.radians(np.arange(-90.0, 90.5, 0.5))
    # Height of the middle of mass above the lowest point, at each tilt.
    x, z = body.points[:, 0] - middle[0], body.points[:, 2] - middle[2]
    heights = np.array([-float((z * math.cos(t) - x * math.sin(t)).min()) for t in tilts])
    place = len(tilts) // 2
    while True:
        lower = min(range(max(0, place - FACET), min(len(tilts), place + FACET + 1)), key=lambda k: heights[k])
        if heights[lower] >= heights[place] - 1e-9:
            return float(tilts[place])
        place = lower


Metres = Annotated[float, Field(gt=0, le=0.5)]
Share = Annotated[float, Field(ge=0, le=1)]
# Points around and along a body; more where it has narrow furrows or leaves that wrap it.
COARSE, FINE, MANY_LOBES = (32, 25), (56, 37), 9
# Stems and leaves that stand out of the box round the body by more than this have a collision shape, metres.
MIN_OUT = 0.003
# A body that bends farther than this is covered by several hulls, rad; how many there are at most.
BENT, MAX_HULLS = 0.35, 4

# How it lies: STANDS as it is drawn; LIES its axis level, along x, and so the plane in which it bends.
Rest = StrEnum("Rest", "STANDS LIES")


class Produce(Params):
    """Parameters of food that grew in one piece; lengths in metres."""

    profile: tuple[Vec2, ...] = Field(
        min_length=4,
        max_length=16,
        description="(radius, height) by the largest, from the lower end up; it may turn back into a hollow",
    )
    length: Metres = Field(description="along the axis, m")
    width: Metres = Field(description="across the axis, m")
    flat: float = Field(1.0, ge=0.3, le=1, description="the other width by that")
    lobes: int = Field(0, ge=0, le=16, description="furrows around the axis")
    lobe_depth: float = Field(0.1, ge=0, le=0.5, description="by the radius")
    lobe_sharp: float = Field(1.5, ge=0.5, le=4, description="1: waves; more: narrow furrows")
    bumps: float = Field(0.02, ge=0, le=0.3, description="unevenness by the radius")
    waves: float = Field(1.0, ge=0.3, le=8, description="of the bumps, over the length")
    bend: float = Field(0.0, ge=-3, le=3, description="rad")
    bend_start: Share = Field(0.0, description="share of the length from which on it bends")
    stem: float = Field(0.0, ge=0, le=0.2, description="length of a stalk at the upper end, m; 0: none")
    stem_radius: float = Field(0.0015, gt=0, le=0.03, description="m")
    stem_at: Share = Field(1.0, description="share of the length where the stalk starts")
    wraps: int = Field(0, ge=0, le=24, description="leaves round it: sheets with a wrap_skin, else steps in it")
    wrap_depth: float = Field(0.1, ge=0, le=0.3, description="how far they project, by the distance from its middle")
    wrap_reach: Share = Field(0.7, description="share of the profile that they cover")
    wrap_ruffle: float = Field(0.02, ge=0, le=0.3, description="how far their rims rise and fall, by the radius")
    wrap_skin: FinishId | None = None
    leaves: int = Field(0, ge=0, le=40, description="around the upper end")
    leaf_length: Metres = Field(0.02, description="m")
    leaf_width: Metres = Field(0.008, description="m")
    leaf_rise: float = Field(0.2, ge=-1.6, le=1.6, description="steepness of leaves, rad")
    leaf_spread: float = Field(0.0, ge=0, le=1.6, description="how much steeper the last leaf is than the first, rad")
    eyes: int = Field(0, ge=0, le=5, description="dark pits around the upper end; a coconut has three")
    flesh: float = Field(1.0, ge=0.1, le=1.1, description="share of its volume that is flesh; the rest is air")
    rest: Rest = Field(Rest.STANDS, description="how it lies")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId = Field(description="picture of the whole of it")
    stem_finish: FinishId = "stem_brown"
    leaf_finish: FinishId = "leaf_mid"
    portion: Portion | None = Field(None, description="kind of portion if it was cut; None: whole")
    face: Face = Field(Face.UP, description="direction of its cut face")
    crosswise: bool = Field(False, description="a half is cut across its axis")
    cut_at: Share = Field(0.5, description="share of the length at which a half, piece or slice is cut across")
    thick: Metres = Field(0.008, description="of a slice, m")
    slant: float = Field(0.0, ge=0, le=1.2, description="deviation of a slice's cuts from square, rad")
    angle: float = Field(0.8, ge=0.2, le=2.4, description="of a wedge, rad")
    section: FinishId | None = Field(None, description="picture of the cut faces")
    heart: Share = Field(0.5, description="share of the length about which it lies on faces along the axis")
    hollow: float = Field(0.0, ge=0, le=0.95, description="size of a hollow inside by the body")
    lining: FinishId | None = Field(None, description="of the hollow; None: that of the section")
    stone: float = Field(0.0, ge=0, le=0.1, description="width of a stone or core in the middle of a half, m; 0: none")
    stone_long: float = Field(1.2, ge=0.3, le=4, description="its length by its width")
    stone_flat: float = Field(1.0, ge=0.3, le=1, description="its thickness by its width")
    stone_finish: FinishId = "fruit_stone"

    @model_validator(mode="after")
    def _cut_faces_have_a_picture(self) -> Produce:
        if self.portion is not None and self.section is None:
            raise ValueError(f"a section is expected: the picture on the cut faces of a {self.portion.value}")
        return self


def build(builder: AssetBuilder, p: Produce) -> None:
    """Build the asset: it rests on z = 0."""
    rng = p.rng()
    profile = np.array(p.profile) * (p.width / 2, p.length)
    around, along = FINE if p.lobes >= MANY_LOBES or (p.wraps and p.wrap_skin is None) else COARSE
    body = turned(smooth_profile([(float(r), float(z)) for r, z in profile], along), around)
    straight = _shaped(body.points, p, rng)
    if p.portion is not None:
        _build_portion(builder, p, replace(body, points=straight), rng)
        return
    span = float(straight[:, 2].min()), float(straight[:, 2].max())
    shaped = bent(straight, p.bend, p.bend_start, span)
    top = p.stem_at * p.length
    if p.lobes == 1 and p.rest is Rest.STANDS:
        shaped = shaped[:, [1, 0, 2]] * (1.0, -1.0, 1.0)
    laid = _laid(shaped, p)
    lowest = float(laid[:, 2].min())
    body = replace(body, points=laid - (0.0, 0.0, lowest))
    density = p.flesh * builder.supplies.finish(p.skin).substance.density
    body = body.with_colliders_of(*_hulls(body, p, around, along))
    builder.add(ROOT, body, p.skin, label="body", name="body", density=density)
    if p.wrap_skin is not None and p.wraps:
        curve = smooth_profile([(float(r), float(z)) for r, z in profile], along)
        # The leaves clear the bumps of the head.
        sheets = head_leaves(curve, p.wraps, p.wrap_depth, p.wrap_ruffle, p.wrap_reach, 0.02 + p.bumps, rng)
        leaves = concatenate(sheets)
        leaves = replace(leaves, points=_laid(leaves.points, p) - (0.0, 0.0, lowest))
        builder.add(ROOT, leaves.with_hull_collider(), p.wrap_skin, label="leaf", name="leaves", density="plant_leaf")
    if p.eyes:
        builder.add(ROOT, _eyes(p, body), "soil", label="eye", collider=False, density=0.0)
    stem = [_stem(p, rng, top)] if p.stem > 0 else []
    for parts, finish, label in ((stem, p.stem_finish, "stem"), (_leaves(p, rng, top), p.leaf_finish, "leaf")):
        if not parts:
            continue
        grown = concatenate([part.without_colliders() for part in parts])
        points = _laid(bent(grown.points, p.bend, p.bend_start, span), p) - (0.0, 0.0, lowest)
        grown = replace(grown, points=points)
        # What hardly projects needs no shape.
        far = float(np.abs(points - np.clip(points, *body.bounds)).max())
        builder.add(ROOT, grown.with_hull_collider(), finish, label=label, collider=far > MIN_OUT, density="plant_leaf")


def _build_portion(builder: AssetBuilder, p: Produce, body: Solid, rng: np.random.Generator) -> None:
    assert p.section is not None, "a validator checks"
    builder.portion = p.portion
    low, high = float(body.points[:, 2].min()), float(body.points[:, 2].max())
    heart = low + p.heart * (high - low)
    planes = _planes(p, low + p.cut_at * (high - low), heart)

    def scaled(share: float) -> Solid:
        middle = (body.points.min(axis=0) + body.points.max(axis=0)) / 2
        return replace(body, points=middle + (body.points - middle) * share, picture_uv=None)

    kept, faces = cut(body, planes, scaled(p.hollow) if p.hollow else None)
    # Only a cut along the plane of the bend stays level when the body is bent.
    bend = p.bend if p.portion is Portion.PIECE or (p.portion is Portion.HALF and not p.crosswise) else 0.0

    def rested(solid: Solid) -> Solid:
        return replace(solid, points=_portion_laid(bent(solid.points, bend, p.bend_start, (low, high)), p))

    kept, faces = rested(kept), [rested(face) for face in faces]
    if p.face is Face.SIDE:
        tilt = rest_tilt(kept)
        kept, faces = kept.rotated("y", tilt), [face.rotated("y", tilt) for face in faces]
    lowest = min(float(solid.points[:, 2].min()) for solid in (kept, *faces))
    hull = concatenate([replace(s, picture_uv=None) for s in (kept, *faces)]).translated(z=-lowest).with_hull_collider()
    density = p.flesh * builder.supplies.finish(p.skin).substance.density
    kept = kept.translated(z=-lowest).with_colliders_of(hull)
    builder.add(ROOT, kept, p.skin, label="body", name="body", density=density)
    plates = concatenate(faces).translated(z=-lowest)
    builder.add(ROOT, plates, p.section, label="section", name="section", collider=False, density=0.0)
    if p.hollow:
        lined = rested(shell(scaled(p.hollow + LINING), scaled(p.hollow - LINING), planes)).translated(z=-lowest)
        builder.add(ROOT, lined, p.lining or p.section, label="lining", collider=False, density=0.0)
    if p.stone > 0 and p.face is Face.UP:
        ball = turned(smooth_profile([(0, -1), (0.7, -0.72), (1, 0), (0.7, 0.72), (0, 1)], 13), 20)
        points = ball.points * (np.array([1.0, p.stone_flat, p.stone_long]) * 0.5 * p.stone) + (0.0, 0.0, heart)
        stone = rested(replace(ball, points=bumped(points, 0.05, 2.5, rng))).translated(z=-lowest)
        builder.add(ROOT, stone, p.stone_finish, label="stone", density=0.0)


def _planes(p: Produce, at: float, heart: float) -> list[Plane]:
    """The planes that cut a body about the z axis.

    at: height of a level cut, or of the middle of a slice, m. heart: about which pictures of upright faces lie, m.
    """
    middle = np.array([0.0, 0.0, heart])
    match p.portion:
        case Portion.SLICE:
            at *= math.cos(p.slant)
            low, high = at - p.thick / 2, at + p.thick / 2
            return [across(high, below=True, slant=p.slant), across(low, below=False, slant=p.slant)]
        case Portion.WEDGE:
            return sector(p.angle, middle)
        case Portion.HALF if not p.crosswise:
            return [along(0.0, middle)]
    return [across(at, below=True)]


def _portion_laid(points: Floats, p: Produce) -> Floats:
    x, y, z = points.T
    if p.portion is Portion.WEDGE:
        # On its skin; or turned about the axis until one of its faces lies below.
        turn = 0.0 if p.face is Face.UP else (p.angle + math.pi) / 2
        c, s = math.cos(turn), math.sin(turn)
        return np.column_stack([z, c * y + s * x, s * y - c * x])
    if p.portion is Portion.SLICE:
        c, s = math.cos(p.slant), math.sin(p.slant)
        return np.column_stack([c * x - s * z, y, s * x + c * z])
    if p.portion is Portion.HALF and not p.crosswise:
        return np.column_stack([z, x, y] if p.face is Face.UP else [z, -x, -y])
    if p.face is Face.SIDE:
        return np.column_stack([z, x, y])
    return points if p.face is Face.UP else points * (1.0, -1.0, -1.0)


def _laid(points: Floats, p: Produce) -> Floats:
    if p.rest is not Rest.LIES:
        return points
    laid = points[:, [2, 0, 1]]
    if abs(p.bend) < 1e-6:
        return laid
    # The line between the ends of what is straight up to `bend_start` and a part of a circle from there on.
    radius = (1.0 - p.bend_start) / p.bend
    ends = p.bend_start + radius * math.sin(p.bend), radius * (1.0 - math.cos(p.bend))
    along, across = np.array(ends) / math.hypot(*ends)
    return np.asarray(laid @ np.array([[along, -across, 0.0], [across, along, 0.0], [0.0, 0.0, 1.0]]))


def _shaped(points: Floats, p: Produce, rng: np.random.Generator) -> Floats:
    # A single furrow lies where the edges of the picture meet, so that a skin can show it.
    points = lobed(points, p.lobes, p.lobe_depth, p.lobe_sharp, (0.0 if p.lobes == 1 else 0.3))
    points = bumped(points, p.bumps, p.waves, rng)
    if p.wrap_skin is None or p.portion is not None:
        points = wrapped(points, p.wraps, p.wrap_depth, rng)
    return points * (1.0, p.flat, 1.0)


def _stem(p: Produce, rng: np.random.Generator, start: float) -> Solid:
    lean, turn = float(rng.uniform(0.1, 0.45)), float(rng.uniform(0.0, 2 * math.pi))
    side = p.stem * lean * np.array([math.cos(turn), math.sin(turn)])
    path = [(0.0, 0.0, start - 0.15 * p.stem), (0.0, 0.0, start + 0.4 * p.stem)]
    path.append((float(side[0]), float(side[1]), start + p.stem))
    return tube(path, p.stem_radius, 0.4 * p.stem)


def _eyes(p: Produce, body: Solid) -> Solid:
    middle = body.bounds.mean(axis=0)
    out = []
    for k in range(p.eyes):
        turn = 2 * math.pi * k / p.eyes - 0.6
        way = np.array([0.45 * math.cos(turn), 0.45 * math.sin(turn), 0.9])
        away = body.points - middle
        nearest = int(np.argmax(away @ way / (np.linalg.norm(away, axis=1) * np.linalg.norm(way))))
        disc = ellipsoid((0.11 * p.width, 0.11 * p.width, 0.02 * p.width), 12, 7)
        x, y, z = (float(v) for v in body.points[nearest])
        out.append(disc.rotated("y", 0.46).rotated("z", turn).translated(x, y, z))
    return concatenate([s.without_colliders() for s in out])


def _leaves(p: Produce, rng: np.random.Generator, start: float) -> list[Solid]:
    out = []
    for k, angle in enumerate(golden_angles(p.leaves)):
        size = float(rng.uniform(0.8, 1.1))
        blade = leaf(p.leaf_length * size, p.leaf_width * size, droop=0.5, fold=0.2, steps=5)
        rise = p.leaf_rise + p.leaf_spread * k / p.leaves + float(rng.uniform(-0.15, 0.15))
        blade = blade.rotated("x", rise).rotated("z", angle)
        out.append(blade.translated(z=start))
    return out


def _hulls(body: Solid, p: Produce, around: int, along: int) -> list[Solid]:
    count = 1 if abs(p.bend) < BENT else min(MAX_HULLS, 1 + math.ceil(abs(p.bend) / 0.5))
    if count == 1:
        return [body.with_hull_collider()]
    rings = np.array_split(np.arange(along - 2), count)
    hulls = []
    for k, part in enumerate(rings):
        rings_of = (*part, *([part[-1] + 1] if k < count - 1 else []))
        rows = [1 + i * around + j for i in rings_of for j in range(around)]
        rows += [0] if k == 0 else []
        rows += [len(body.points) - 1] if k == count - 1 else []
        hulls.append(hull_around(body.points[rows]))
    return hulls
