"""Bread, pastry and the like: domes, rolls, rings, waffles, with what is on them."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Portion, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, box, tube
from casa_assets.kitchenware.objects import food
from casa_assets.kitchenware.objects.closed_surface import bumped
from casa_assets.kitchenware.objects.food import Piece, Surface

Metres = Annotated[float, Field(gt=0, le=0.8)]
Thin = Annotated[float, Field(ge=0, le=0.05)]
Share = Annotated[float, Field(ge=0, le=1)]
Profile = Annotated[tuple[Vec2, ...], Field(min_length=4, max_length=20)]
Line = Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=24)]
# Most small things that are strewn on one.
MAX_STREWN = 90
# Toppings that stand out of the box round the body by more than this have a shape of their own, metres.
MIN_OUT = 0.003

# ROUND a dome over an outline; LONG a roll along x; RING with a hole; GRID a plate of pits between bars.
Body = StrEnum("Body", "ROUND LONG RING GRID")


class Dough(Params):
    """Parameters of what is baked or made of dough; lengths in metres."""

    body: Body = Field(Body.ROUND, description="basic shape")
    length: Metres = Field(description="along x, m")
    width: Metres = Field(description="along y, m")
    height: Metres = Field(description="along z, m")
    outline: tuple[Vec2, ...] = Field((), description="of a round or grid body from above; empty: a superellipse")
    profile: Profile = Field(
        ((0, 0), (0.8, 0), (1, 0.3), (0.9, 0.7), (0.5, 0.95), (0, 1)),
        description="round body: (share of outline, of height) from bottom to top; long: (radius, place)",
    )
    square: float = Field(2.0, ge=1, le=12, description="power of the superellipse of a section, below")
    square_top: float = Field(2.0, ge=1, le=12, description="the same above")
    foot: float = Field(1.0, ge=0.1, le=1, description="share of the lower half height that is left before it is flat")
    hole: Thin = Field(0.03, description="diameter, m")
    bend: float = Field(0.0, ge=-3, le=3, description="of a long body, rad")
    cut: float = Field(1.0, ge=0.3, le=1, description="place where a long body is cut off square; 1: nowhere")
    segments: int = Field(0, ge=0, le=8, description="ridges of rolled layers from the middle to either end")
    segment_depth: float = Field(0.2, ge=0, le=0.6, description="by the radius")
    bumps: float = Field(0.02, ge=0, le=0.3, description="unevenness by the size")
    waves: float = Field(1.5, ge=0.3, le=8, description="of the unevenness, over the size")
    wave: Thin = Field(0.0, description="rise and fall of a thin thing, m")
    grid: int = Field(5, ge=2, le=12, description="pits across the shorter side")
    count: int = Field(1, ge=1, le=6, description="bodies on one another")
    shift: Thin = Field(0.004, description="how far off each other they lie, m")
    coat: Thin = Field(0.0, description="thickness of icing, m")
    coat_level: Share = Field(0.5, description="share of the height above which it is coated")
    coat_wave: Share = Field(0.1, description="how far the edge of the coat wanders, by the height")
    lines: tuple[Line, ...] = Field((), max_length=12, description="paths over the top, by length and width")
    line_width: Thin = Field(0.01, description="m")
    line_height: Thin = Field(0.004, description="m")
    line_lens: bool = Field(True, description="lines narrow to their ends")
    topping: Piece = Field(Piece.SEED, description="kind of what is strewn; its finishes take turns")
    topping_count: Annotated[int, Field(ge=0, le=MAX_STREWN)] = 0
    topping_size: Thin = Field(0.004, description="m")
    topping_above: Share = Field(0.3, description="share of the height below which none lies")
    topping_within: float = Field(1.5, gt=0, le=1.5, description="how far out it lies, by half the sides")
    topping_steep: Share = Field(0.4, description="least z of the normal where it lies")
    topping_sunk: Share = Field(0.25, description="share of a piece's height that is in the body")
    pat: Thin = Field(0.0, description="side of a pat of butter on top, m; 0: none")
    stick: float = Field(0.0, ge=0, le=0.2, description="length of a stick out of its +x end, m; 0: none")
    stick_radius: Thin = Field(0.002, description="m")
    portion: Portion | None = Field(None, description="what is left of a thing that was cut; None: whole")
    density: float = Field(270.0, ge=50, le=2000, description="of its body, kg/m^3")
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
    rng = p.rng()
    level = 0.0
    for k in range(p.count):
        body, crumb = _body(p, rng)
        if p.count > 1:
            turn, off = float(rng.uniform(0, 2 * math.pi)), rng.uniform(-p.shift, p.shift, 2) * (k > 0)
            if p.outline == () and p.length == p.width:
                body = body.rotated("z", turn)
            body = body.translated(float(off[0]), float(off[1]))
        body = body.translated(z=level - float(body.points[:, 2].min()))
        if p.body is Body.RING and p.hole > 0.012:
            hulls = food.hulls_by(body.points, np.arctan2(body.points[:, 1], body.points[:, 0]), 6)
        else:
            hulls = food.hulls_of_bent(body, p.bend if p.body is Body.LONG else 0.0)
        name = "body" if k == 0 else f"body_{k + 1}"
        builder.add(ROOT, body.with_colliders_of(*hulls), p.skin, label="body", name=name, density=p.density)
        for part in crumb:
            builder.add(ROOT, part.translated(z=level), p.crumb_finish, label="crumb", collider=False, density=0.0)
        level += 0.96 * float(np.ptp(body.points[:, 2]))
    _add_top(builder, p, body, rng)


def _add_top(builder: AssetBuilder, p: Dough, body: Solid, rng: np.random.Generator) -> None:
    top = body
    if p.coat > 0:
        top = replace(food.coated(body, p.coat, p.coat_level, p.coat_wave, rng), picture_uv=None)
        builder.add(ROOT, top, p.coat_finish, label="coat", collider=False, density=0.0)
    size = np.ptp(body.points, axis=0)
    middle = (body.bounds[0] + body.bounds[1])[:2] / 2
    if p.lines:
        drawn = food.ridges(top, body.bounds, p.lines, p.line_width, p.line_height, lens=p.line_lens)
        builder.add(ROOT, drawn, p.line_finish, label="line", collider=False, density=0.0)
    finishes = [f for f in (p.topping_finish, p.topping_finish_2, p.topping_finish_3) if f is not None]
    where = {"steep": p.topping_steep, "above": p.topping_above, "sunk": p.topping_sunk, "within": p.topping_within}
    pieces = food.strewn(top, p.topping, p.topping_count, p.topping_size, rng, **where)
    if pieces and float((food.joined(pieces).points - body.bounds[1]).max()) > MIN_OUT:
        builder.add_collider(ROOT, food.hull_of(*pieces), p.topping_finish, "topping")
    for k, finish in enumerate(finishes):
        if own := pieces[k :: len(finishes)]:
            builder.add(ROOT, food.joined(own), finish, label="topping", collider=False, density=0.0)
    if p.pat > 0:
        place = middle + rng.uniform(-0.06, 0.06, 2) * size[:2]
        at = float(Surface(top).height(place[None])[0])
        pat = box((p.pat, 0.8 * p.pat, 0.35 * p.pat), (0.0, 0.0, 0.0), 0.003, 3).rotated("z", float(rng.uniform(0, 3)))
        pat = pat.translated(float(place[0]), float(place[1]), at + 0.12 * p.pat)
        builder.add(ROOT, pat.with_hull_collider(), p.pat_finish, label="butter", density=0.0)
    if p.stick > 0:
        low, high = body.bounds
        end, height = float(high[0]), float((low[2] + high[2]) / 2)
        stick = tube([(end - 0.3 * float(size[0]), 0.0, height), (end + p.stick, 0.0, height)], p.stick_radius)
        builder.add(ROOT, stick, p.stick_finish, label="stick", name="stick")


def _body(p: Dough, rng: np.random.Generator) -> tuple[Solid, list[Solid]]:
    if p.body is Body.GRID:
        return _grid(p), []
    if p.body is Body.RING:
        body = food.ring_body(p.length, p.height, p.hole, p.square)
        body = replace(body, points=body.points * (1.0, p.width / p.length, 1.0))
        return replace(body, points=food.flat_foot(bumped(body.points, p.bumps, p.waves, rng), 0.06)), []
    if p.body is Body.ROUND:
        outline = food.outline_of_food(p.outline, p.length, p.width, p.square)
        return food.uneven(food.dome(outline, p.profile, p.height), p.bumps, p.waves, p.wave, p.length, rng), []
    section = {"square": p.square, "square_top": p.square_top, "foot": p.foot, "cut": p.cut}
    around, along = (26, 51) if p.segments else (30, 27)
    body = food.long_body(p.profile, p.length, p.width, p.height, **section, around=around, along=along)
    points = body.points
    if p.segments:
        place = np.abs(points[:, 0]) / (0.5 * p.length)
        phase = np.mod(p.segments * place + 0.5 + 0.2 * np.cos(np.arctan2(points[:, 2], points[:, 1])), 1.0)
        points = points * np.column_stack([np.ones(len(points)), *2 * [1.0 + p.segment_depth * (0.5 - phase)]])
    cut = p.cut < 1
    crumb = [food.cut_face(points)] if cut else []
    points = points if cut else bumped(points, p.bumps, p.waves, rng)
    points = food.flat_foot(food.bent_level(points, p.bend, p.length))
    low = float(points[:, 2].min())
    return replace(body, points=points), [part.translated(z=-low) for part in crumb]


def _grid(p: Dough) -> Solid:
    outline = food.outline_of_food(p.outline, p.length, p.width, p.square)
    flat = [(0, 0), (0.9, 0), (1, 0.25), (1, 0.75), (0.9, 1), (0, 1)]
    parts = [food.dome(outline, flat, 0.45 * p.height, 7).translated(z=0.275 * p.height)]
    path = [(float(x), float(y), p.height / 2) for x, y in 0.965 * np.vstack([outline, outline[:2]])]
    pitch = min(p.length, p.width) / p.grid
    bar, h = 0.3 * pitch, 0.49 * p.height
    section = np.array([(0.3, -h), (0.5, 0.0), (0.3, h), (-0.3, h), (-0.5, 0.0), (-0.3, -h)])
    section[:, 0] *= bar
    parts.append(tube(path, section * (1.1, 1.02)).without_colliders())
    for axis in (0, 1):
        reach = float(np.abs(outline[:, axis]).max())
        steps = round(2 * reach / pitch)
        for k in range(1, steps):
            at = -reach + 2 * reach * k / steps
            # Half the length of the outline across an axis at a place on it, metres.
            near = np.argsort(np.abs(outline[:, axis] - at))
            upper = [i for i in near if outline[i, 1 - axis] > 0][:2]
            pairs = sorted((float(outline[i, axis]), float(outline[i, 1 - axis])) for i in upper)
            half = float(np.interp(at, [x for x, _ in pairs], [y for _, y in pairs])) - 0.4 * bar
            if half < 0.5 * bar:
                continue
            ends = [(at, -half), (at, half)] if axis == 0 else [(-half, at), (half, at)]
            parts.append(tube([(x, y, p.height / 2) for x, y in ends], section).without_colliders())
    return food.seen_from_above(replace(food.joined([food.plain(part) for part in parts]), crease_deg=40.0))
