"""Bread, pastry and the like: a dome, a roll, a ring or a grid, with cuts, a coat, lines and things strewn on it."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.core.numeric import Floats
from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.assemble import Family
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import box
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.kit.solids.sweep import tube
from casa_assets.families.objects.closed_surface import bumped
from casa_assets.families.objects.food.bodies import (
    Piece,
    Surface,
    Unevenness,
    bent_level,
    coated,
    cut_face,
    dome,
    flat_foot,
    hull_of,
    hulls_by,
    hulls_of_bent,
    joined,
    long_body,
    outline_curve,
    plain,
    ridges,
    ring_body,
    seen_from_above,
    strewn,
    superellipse,
    uneven_dome,
)
from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Vec2
from casa_assets.model.registry.category import Portion

Metres = Annotated[float, Field(gt=0, le=0.8)]
Thin = Annotated[float, Field(ge=0, le=0.05)]
Share = Annotated[float, Field(ge=0, le=1)]
Profile = Annotated[tuple[Vec2, ...], Field(min_length=4, max_length=20)]
Line = Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=24)]
# Most small things that are strewn on one.
MAX_STREWN = 90
# Toppings that stand out of the box round the body by more than this have a shape of their own, metres.
MIN_OUT = 0.003


class Body(StrEnum):
    """Basic shape of the food."""

    ROUND = "round"  # a dome over an outline
    LONG = "long"  # a roll along x
    RING = "ring"  # with a hole
    GRID = "grid"  # a plate of pits between bars


class Dough(Params):
    """Parameters of what is baked or made of dough; lengths in metres.

    Attributes:
        body: shape at heart. length, width, height: along x, y, z.
        outline: of a round or grid body, seen from above, points in order; none is an ellipse of power `square`.
        profile: of a round body (share of the outline, share of the height) from the middle of the underside to that of
            the upper side; of a long one (radius, place) from end to end.
        square, square_top: powers of the superellipse of a section, below and above. foot: share of the lower half
            height that is left before it is flat. hole: diameter.
        bend: of a long body, rad. cut: place where a long body is cut off square, 1 for nowhere.
        segments, segment_depth: ridges of rolled layers from the middle to either end.
        bumps, waves: unevenness by the size, and how often over it. wave: a thin thing's rise and fall, metres.
        grid: pits across the shorter side. count, shift: how many lie on one another, and how far off each other.
        coat, coat_level, coat_wave: thickness of icing, from which share of the height on, and how its edge wanders.
        lines: paths over the top by length and width, about the middle. line_width, line_height, line_lens: their
            section and whether they narrow to their ends.
        topping, topping_count, topping_size, topping_above, topping_within, topping_steep, topping_sunk: what is
            strewn, how much, how large, how far up, how far out, on how steep a side, and how deep it is in. Its
            finishes take turns.
        pat: side of a pat of butter on top. stick, stick_radius: length of a stick out of its +x end.
        portion: what is left of a thing that was cut, None for a whole one; what is cut off square is a piece.
        density: of its body, kg/m^3. seed: of what is random.
        skin, crumb_finish, coat_finish, line_finish, pat_finish, stick_finish, topping_finish and on: finishes.
    """

    body: Body = Body.ROUND
    length: Metres
    width: Metres
    height: Metres
    outline: tuple[Vec2, ...] = ()
    profile: Profile = ((0, 0), (0.8, 0), (1, 0.3), (0.9, 0.7), (0.5, 0.95), (0, 1))
    square: Annotated[float, Field(ge=1, le=12)] = 2.0
    square_top: Annotated[float, Field(ge=1, le=12)] = 2.0
    foot: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    hole: Thin = 0.03
    bend: Annotated[float, Field(ge=-3, le=3)] = 0.0
    cut: Annotated[float, Field(ge=0.3, le=1)] = 1.0
    segments: Annotated[int, Field(ge=0, le=8)] = 0
    segment_depth: Annotated[float, Field(ge=0, le=0.6)] = 0.2
    bumps: Annotated[float, Field(ge=0, le=0.3)] = 0.02
    waves: Annotated[float, Field(ge=0.3, le=8)] = 1.5
    wave: Thin = 0.0
    grid: Annotated[int, Field(ge=2, le=12)] = 5
    count: Annotated[int, Field(ge=1, le=6)] = 1
    shift: Thin = 0.004
    coat: Thin = 0.0
    coat_level: Share = 0.5
    coat_wave: Share = 0.1
    lines: Annotated[tuple[Line, ...], Field(max_length=12)] = ()
    line_width: Thin = 0.01
    line_height: Thin = 0.004
    line_lens: bool = True
    topping: Piece = Piece.SEED
    topping_count: Annotated[int, Field(ge=0, le=MAX_STREWN)] = 0
    topping_size: Thin = 0.004
    topping_above: Share = 0.3
    topping_within: Annotated[float, Field(gt=0, le=1.5)] = 1.5
    topping_steep: Share = 0.4
    topping_sunk: Share = 0.25
    pat: Thin = 0.0
    stick: Annotated[float, Field(ge=0, le=0.2)] = 0.0
    stick_radius: Thin = 0.002
    portion: Portion | None = None
    density: Annotated[float, Field(ge=50, le=2000)] = 270.0
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId
    crumb_finish: FinishId = "dish_crumb"
    coat_finish: FinishId = "dish_icing_white"
    line_finish: FinishId = "dish_crumb"
    pat_finish: FinishId = "butter_deep"
    stick_finish: FinishId = "oak_light"
    topping_finish: FinishId = "dish_sesame"
    topping_finish_2: FinishId | None = None
    topping_finish_3: FinishId | None = None


def build(builder: AssetBuilder, p: Dough) -> None:
    """Build the asset: it rests on z = 0."""
    builder.portion = Portion.PIECE if p.cut < 1 else p.portion
    rng = np.random.Generator(np.random.PCG64(p.seed))
    level = 0.0
    for k in range(p.count):
        body, crumb = _body(p, rng)
        if p.count > 1:
            turn, off = float(rng.uniform(0, 2 * math.pi)), rng.uniform(-p.shift, p.shift, 2) * (k > 0)
            if p.outline == () and p.length == p.width:
                body = body.rotated("z", turn)
            body = body.translated(float(off[0]), float(off[1]))
        body = body.translated(z=level - float(body.points[:, 2].min()))
        hulls = _hulls(body, p)
        name = "body" if k == 0 else f"body_{k + 1}"
        builder.add(ROOT, body.with_colliders_of(*hulls), p.skin, label="body", name=name, density=p.density)
        for part in crumb:
            builder.add(ROOT, part.translated(z=level), p.crumb_finish, label="crumb", collider=False, density=0.0)
        level += 0.96 * float(np.ptp(body.points[:, 2]))
    _add_top(builder, p, body, rng)


def _add_top(builder: AssetBuilder, p: Dough, body: Solid, rng: np.random.Generator) -> None:
    """Add coat, lines, toppings, a pat of butter and a stick to the body, as far as it has them."""
    top = body
    if p.coat > 0:
        top = replace(coated(body, p.coat, p.coat_level, p.coat_wave, rng), picture_uv=None)
        builder.add(ROOT, top, p.coat_finish, label="coat", collider=False, density=0.0)
    size = np.ptp(body.points, axis=0)
    middle = (body.bounds[0] + body.bounds[1])[:2] / 2
    if p.lines:
        drawn = ridges(top, body.bounds, p.lines, p.line_width, p.line_height, lens=p.line_lens)
        builder.add(ROOT, drawn, p.line_finish, label="line", collider=False, density=0.0)
    finishes = [f for f in (p.topping_finish, p.topping_finish_2, p.topping_finish_3) if f is not None]
    pieces = strewn(
        top,
        p.topping,
        p.topping_count,
        p.topping_size,
        rng,
        steep=p.topping_steep,
        above=p.topping_above,
        sunk=p.topping_sunk,
        within=p.topping_within,
    )
    if pieces and float((joined(pieces).points - body.bounds[1]).max()) > MIN_OUT:
        builder.add_collider(ROOT, hull_of(*pieces), p.topping_finish, "topping")
    for k, finish in enumerate(finishes):
        if pieces[k :: len(finishes)]:
            part = joined(pieces[k :: len(finishes)])
            builder.add(ROOT, part, finish, label="topping", collider=False, density=0.0)
    if p.pat > 0:
        place = middle + rng.uniform(-0.06, 0.06, 2) * size[:2]
        at = float(Surface(top).height(place[None])[0])
        pat = box((p.pat, 0.8 * p.pat, 0.35 * p.pat), (0.0, 0.0, 0.0), 0.003, 3).rotated("z", float(rng.uniform(0, 3)))
        pat = pat.translated(float(place[0]), float(place[1]), at + 0.12 * p.pat)
        builder.add(ROOT, pat.with_hull_collider(), p.pat_finish, label="butter", density=0.0)
    if p.stick > 0:
        low, high = body.bounds
        height = float((low[2] + high[2]) / 2)
        stick = tube(
            [(float(high[0]) - 0.3 * float(size[0]), 0.0, height), (float(high[0]) + p.stick, 0.0, height)],
            p.stick_radius,
        )
        builder.add(ROOT, stick, p.stick_finish, label="stick", name="stick")


def _body(p: Dough, rng: np.random.Generator) -> tuple[Solid, list[Solid]]:
    """The body, and the crumb on its cut face."""
    if p.body is Body.GRID:
        return _grid(p), []
    if p.body is Body.RING:
        body = ring_body(p.length, p.height, p.hole, p.square)
        body = replace(body, points=body.points * (1.0, p.width / p.length, 1.0))
        return replace(body, points=flat_foot(bumped(body.points, p.bumps, p.waves, rng), 0.06)), []
    if p.body is Body.ROUND:
        unevenness = Unevenness(p.bumps, p.waves, p.wave, p.length)
        return uneven_dome(_outline(p), p.profile, p.height, unevenness, rng), []
    body = long_body(
        p.profile,
        p.length,
        p.width,
        p.height,
        square=p.square,
        square_top=p.square_top,
        foot=p.foot,
        cut=p.cut,
        around=30 if p.segments == 0 else 26,
        along=27 if p.segments == 0 else 51,
    )
    points = body.points
    if p.segments:
        place = np.abs(points[:, 0]) / (0.5 * p.length)
        angle = np.arctan2(points[:, 2], points[:, 1])
        phase = np.mod(p.segments * place + 0.5 + 0.2 * np.cos(angle), 1.0)
        points = points * np.column_stack([np.ones(len(points)), *2 * [1.0 + p.segment_depth * (0.5 - phase)]])
    cut = p.cut < 1
    crumb = [cut_face(points)] if cut else []
    points = points if cut else bumped(points, p.bumps, p.waves, rng)
    points = flat_foot(bent_level(points, p.bend, p.length))
    low = float(points[:, 2].min())
    return replace(body, points=points), [part.translated(z=-low) for part in crumb]


def _outline(p: Dough) -> Floats:
    if p.outline:
        return outline_curve(p.outline, p.length, p.width)
    return superellipse(p.length, p.width, p.square)


def _grid(p: Dough) -> Solid:
    """A waffle: a thin plate, bars both ways across it, and a rim."""
    outline = _outline(p)
    flat = [(0, 0), (0.9, 0), (1, 0.25), (1, 0.75), (0.9, 1), (0, 1)]
    parts = [dome(outline, flat, 0.45 * p.height, 7).translated(z=0.275 * p.height)]
    path = [(float(x), float(y), p.height / 2) for x, y in 0.965 * np.vstack([outline, outline[:2]])]
    pitch = min(p.length, p.width) / p.grid
    bar = 0.3 * pitch
    h = 0.49 * p.height
    section = np.array([(0.3, -h), (0.5, 0.0), (0.3, h), (-0.3, h), (-0.5, 0.0), (-0.3, -h)])
    section[:, 0] *= bar
    rim = section * (1.1, 1.02)
    parts.append(tube(path, rim).without_colliders())
    for axis in (0, 1):
        reach = float(np.abs(outline[:, axis]).max())
        steps = round(2 * reach / pitch)
        for k in range(1, steps):
            at = -reach + 2 * reach * k / steps
            half = _chord(outline, axis, at) - 0.4 * bar
            if half < 0.5 * bar:
                continue
            ends = [(at, -half), (at, half)] if axis == 0 else [(-half, at), (half, at)]
            parts.append(tube([(x, y, p.height / 2) for x, y in ends], section).without_colliders())
    whole = joined([plain(part) for part in parts])
    return seen_from_above(replace(whole, crease_deg=40.0))


def _chord(outline: Floats, axis: int, at: float) -> float:
    """Half the length of the outline across an axis at a place on it, metres."""
    near = np.argsort(np.abs(outline[:, axis] - at))
    upper = [i for i in near if outline[i, 1 - axis] > 0][:2]
    pairs = sorted((float(outline[i, axis]), float(outline[i, 1 - axis])) for i in upper)
    return float(np.interp(at, [x for x, _ in pairs], [y for _, y in pairs]))


def _hulls(body: Solid, p: Dough) -> list[Solid]:
    """The body as one hull, or as several round a ring or along a bend."""
    points = body.points
    if p.body is Body.RING and p.hole > 0.012:
        return hulls_by(points, np.arctan2(points[:, 1], points[:, 0]), 6)
    return hulls_of_bent(body, p.bend if p.body is Body.LONG else 0.0)


FORM = Family("dough", Dough, build, base=Base.FREE)
