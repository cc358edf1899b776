"""Meat and fish: slabs, thin strips and long bodies, with rind, fins, bones and string."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import counter_clockwise, outline_of
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Portion, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, board, hull_around, prism, tube
from casa_assets.kitchenware.objects import food
from casa_assets.kitchenware.objects.closed_surface import bumped, ellipsoid, sheet
from casa_assets.kitchenware.objects.food import Surface

Metres = Annotated[float, Field(gt=0, le=0.8)]
Thin = Annotated[float, Field(ge=0, le=0.05)]
Share = Annotated[float, Field(ge=0, le=1)]
Profile = Annotated[tuple[Vec2, ...], Field(min_length=4, max_length=24)]
Line = Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=32)]
Lines = Annotated[tuple[Line, ...], Field(max_length=16)]
# A body that bends farther than this is a ring: its hulls follow one another round the middle of the bend, rad.
RING = 2.5
# Points round a long body.
AROUND = 24
# A box below a thin wavy body reaches so far towards its outline, and so high, by the height of the body.
PLINTH, PLINTH_HIGH = 0.8, 0.3
FIN_OUT = 0.002  # metres that a fin or a bone may project from the body's box without a separate shape

# SLAB a slab over an outline; STRIP a thin strip that rises and falls; LONG a long body along x.
Cut = StrEnum("Cut", "SLAB STRIP LONG")


class SlabFood(Params):
    """Parameters of meat and fish; lengths in metres, places in shares of length and width from the middle."""

    cut: Cut = Field(Cut.SLAB, description="basic shape")
    length: Metres = Field(description="along x, m")
    width: Metres = Field(description="along y, m")
    height: Metres = Field(description="along z, m; of a strip its thickness")
    outline: tuple[Vec2, ...] = Field((), description="of a slab from above; empty: a superellipse")
    profile: Profile = Field(
        ((0, 0), (0.86, 0), (0.97, 0.12), (1, 0.45), (0.96, 0.85), (0.85, 0.98), (0.4, 1), (0, 1)),
        description="slab: (share of outline, of height) from bottom to top; long body: (radius, place)",
    )
    square: float = Field(2.0, ge=1, le=12, description="power of the superellipse of a section")
    foot: float = Field(1.0, ge=0.1, le=1, description="where a long body is flat below, by half the height")
    bend: float = Field(0.0, ge=-5, le=5, description="of a long body, rad")
    cut_at: float = Field(1.0, ge=0.3, le=1, description="place at which it is cut off square; 1: nowhere")
    segments: int = Field(0, ge=0, le=12, description="rings along a long body")
    segment_depth: float = Field(0.1, ge=0, le=0.6, description="by the radius")
    bumps: float = Field(0.02, ge=0, le=0.3, description="unevenness by the size")
    waves: float = Field(1.5, ge=0.3, le=8, description="of the unevenness, over the size")
    wave: Thin = Field(0.0, description="amplitude of rise and fall, m")
    above: bool = Field(False, description="its picture is laid on from above, not around it or over its rim")
    rind: Thin = Field(0.0, description="thickness of fat along a slab's edge, m")
    rind_from: float = Field(0.0, ge=-360, le=360, description="where the rind begins, degrees")
    rind_to: float = Field(180.0, ge=-360, le=360, description="where it ends, degrees")
    lines: Lines = Field((), description="raised lines on top: grill marks, gills, folds, flat bones")
    line_width: Thin = Field(0.004, description="m")
    line_height: Thin = Field(0.001, description="m")
    line_lens: bool = Field(False, description="lines narrow to their ends")
    fins: Lines = Field((), description="outlines of flat parts that project at half the height")
    fin_thickness: Thin = Field(0.002, description="m")
    eyes: tuple[Vec2, ...] = Field((), max_length=4, description="places of eyes on the upper and the lower side")
    eye_size: Thin = Field(0.008, description="m")
    bones: Lines = Field((), description="paths of round bones at half the height")
    bone_radius: Thin = Field(0.006, description="m")
    bone_knob: Thin = Field(0.0, description="radius of the knob at their end, m; 0: none")
    feelers: Lines = Field((), description="paths of thin round parts")
    feeler_radius: Thin = Field(0.0008, description="m")
    ties: int = Field(0, ge=0, le=10, description="loops of string")
    density: float = Field(1040.0, ge=50, le=2000, description="of its body, kg/m^3")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId
    rind_finish: FinishId = "dish_fat"
    face_finish: FinishId = "dish_meat_pink"
    line_finish: FinishId = "dish_char"
    fin_finish: FinishId = "dish_fin"
    eye_finish: FinishId = "dish_eye"
    bone_finish: FinishId = "dish_bone"
    feeler_finish: FinishId = "dish_shell_orange"


def build(builder: AssetBuilder, p: SlabFood) -> None:
    """Build the asset: it rests on z = 0."""
    builder.portion = Portion.PIECE if p.cut_at < 1 else None
    body, face = _body(p, p.rng())
    low = float(body.points[:, 2].min())
    body = body.translated(z=-low)
    rind = _rind(p, body) if p.rind > 0 else None
    hulls = _hulls(body, p) if rind is None else [food.hull_of(body, rind)]
    builder.add(ROOT, body.with_colliders_of(*hulls), p.skin, label="body", name="body", density=p.density)
    if face is not None:
        builder.add(ROOT, face.translated(z=-low), p.face_finish, label="face", collider=False, density=0.0)
    if rind is not None:
        builder.add(ROOT, rind, p.rind_finish, label="rind", collider=False, density=0.0)
    middle = (float(body.points[:, 2].min()) + float(body.points[:, 2].max())) / 2
    if p.lines:
        drawn = food.ridges(body, body.bounds, p.lines, p.line_width, p.line_height, lens=p.line_lens)
        builder.add(ROOT, drawn, p.line_finish, label="line", collider=False, density=0.0)
    paths = [[(x * p.length, y * p.width, 0.0) for x, y in line] for line in p.feelers]
    feelers = [tube(path, p.feeler_radius, 0.02).without_colliders() for path in paths]
    for parts, finish, label in (
        (_fins(p), p.fin_finish, "fin"),
        (_bones(p), p.bone_finish, "bone"),
        (feelers, p.feeler_finish, "feeler"),
        (_ties(p, body), "rope", "string"),
    ):
        if not parts:
            continue
        whole = food.joined(parts)
        if label != "string":
            whole = replace(whole, points=food.bent_level(whole.points, p.bend, p.length)).translated(z=middle)
        builder.add(ROOT, whole, finish, label=label, collider=False, density="fish_fin")
        if label != "string":
            for part in parts:
                moved = replace(part, points=food.bent_level(part.points, p.bend, p.length)).translated(z=middle)
                if float(np.abs(moved.points - np.clip(moved.points, *body.bounds)).max()) > FIN_OUT:
                    builder.add_collider(ROOT, food.hull_of(moved), finish, label)
    if p.eyes:
        builder.add(ROOT, food.joined(_eyes(p, body)), p.eye_finish, label="eye", collider=False, density=0.0)


def _body(p: SlabFood, rng: np.random.Generator) -> tuple[Solid, Solid | None]:
    if p.cut is Cut.STRIP:
        return _strip(p, rng), None
    if p.cut is Cut.SLAB:
        outline = food.outline_of_food(p.outline, p.length, p.width, p.square, 44)
        body = food.uneven(food.dome(outline, p.profile, p.height), p.bumps, p.waves, p.wave, p.length, rng)
        return food.seen_from_above(body) if p.above else body, None
    section = {"square": p.square, "square_top": p.square, "foot": p.foot, "cut": p.cut_at}
    size, along = (p.length, p.width, p.height), 51 if p.segments else 31
    body = food.long_body(p.profile, *size, **section, around=AROUND, along=along)
    points = body.points
    if p.segments:
        phase = np.mod(p.segments * (points[:, 0] / p.length + 0.5), 1.0)
        points = points * np.column_stack([np.ones(len(points)), *2 * [1.0 - p.segment_depth * phase]])
    face = food.cut_face(points) if p.cut_at < 1 else None
    points = points if face is not None else bumped(points, p.bumps, p.waves, rng)
    if p.above:
        body = food.seen_from_above(replace(body, points=points))
    return replace(body, points=food.flat_foot(food.bent_level(points, p.bend, p.length))), face


def _strip(p: SlabFood, rng: np.random.Generator) -> Solid:
    n, m = 41, 9
    s, t = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(-0.5, 0.5, m), indexing="ij")
    phase = rng.uniform(0, 2 * math.pi)
    place = np.stack([s.ravel() * p.length, t.ravel() * p.width], axis=1)
    z = p.wave * np.sin(2 * np.pi * p.waves * s + phase + 0.8 * t).ravel()
    z += 0.35 * p.wave * food.smooth_noise(place, 2.5 * p.waves / p.length, rng)
    x = s * p.length
    side = p.bumps * p.width * food.smooth_noise(np.stack([x[:, 0], 0 * x[:, 0]], axis=1), 3.0 / p.length, rng)
    end = 1.0 - 0.25 * np.abs(2 * s) ** 10
    y = t * p.width * end * (1 + 0.6 * p.bumps * np.sin(9 * s + 2 * phase)) + side[:, None]
    return sheet(np.stack([x, y, z.reshape(n, m)], axis=2), p.height)


def _rind(p: SlabFood, body: Solid) -> Solid:
    outline = food.outline_of_food(p.outline, p.length, p.width, p.square, 44)
    angle = np.degrees(np.arctan2(outline[:, 1], outline[:, 0]))
    middle, half = (p.rind_from + p.rind_to) / 2, abs(p.rind_to - p.rind_from) / 2
    share = np.clip((half - np.abs(np.mod(angle - middle + 180.0, 360.0) - 180.0)) / 25.0, 0.0, 1.0)
    share = share * share * (3 - 2 * share)
    out = 0.93 * (1 - share) + share * (1.0 + p.rind / np.hypot(outline[:, 0], outline[:, 1]))
    height = float(np.ptp(body.points[:, 2]))
    rind = food.dome(outline * out[:, None], p.profile, 0.95 * height)
    return replace(rind, points=food.flat_foot(rind.points)).translated(z=0.005 * height)


def _fins(p: SlabFood) -> list[Solid]:
    """Flat parts of an outline, about z = 0."""
    out = []
    for line in p.fins:
        outline = counter_clockwise(np.array(line) * (p.length, p.width))
        out.append(replace(prism(outline, p.fin_thickness, 0.0003).translated(z=-p.fin_thickness / 2), shapes=()))
    return out


def _bones(p: SlabFood) -> list[Solid]:
    """Round bones about z = 0, with a double knob at their end where it has one."""
    out = []
    for line in p.bones:
        path = [(x * p.length, y * p.width, 0.0) for x, y in line]
        parts = [tube(path, p.bone_radius, 0.04).without_colliders()]
        if p.bone_knob > 0:
            x, y, _ = path[-1]
            r = p.bone_knob
            for side in (-0.55, 0.55):
                parts.append(ellipsoid((2 * r, 1.7 * r, 1.8 * r), 12, 8).translated(x, y + side * r))
        out.append(food.joined([food.plain(part) for part in parts]))
    return out


def _ties(p: SlabFood, body: Solid) -> list[Solid]:
    out = []
    rings = (len(body.points) - 2) // AROUND
    for k in range(p.ties):
        first = 1 + AROUND * round(rings * (k + 1) / (p.ties + 1))
        ring = body.points[first : first + AROUND]
        center = (ring.min(axis=0) + ring.max(axis=0)) / 2
        ring = ring[np.argsort(np.arctan2(ring[:, 2] - center[2], ring[:, 1] - center[1]))]
        loop = center + (np.vstack([ring, ring[:2]]) - center) * (1.0, 1.005, 1.005)
        loop[:, 2] = np.maximum(loop[:, 2], 0.001)
        kept = [loop[0]]
        for point in loop[1:]:
            if np.linalg.norm(point - kept[-1]) > 0.003:
                kept.append(point)
        out.append(tube([(float(a), float(b), float(c)) for a, b, c in kept], 0.0014).without_colliders())
    return out


def _eyes(p: SlabFood, body: Solid) -> list[Solid]:
    out = []
    size = p.eye_size
    top = float(body.points[:, 2].max())
    for x, y in p.eyes:
        place = np.array([[x * p.length, y * p.width]])
        height = float(Surface(body).height(place)[0])
        for z in (height - 0.05 * size, top - height + 0.05 * size):
            out.append(ellipsoid((size, size, 0.4 * size), 12, 7).translated(float(place[0, 0]), float(place[0, 1]), z))
    return out


def _hulls(body: Solid, p: SlabFood) -> list[Solid]:
    if p.cut is Cut.LONG and abs(p.bend) > RING:
        around = np.arctan2(body.points[:, 0], ((p.length / p.bend) - body.points[:, 1]) * np.sign(p.bend))
        return food.hulls_by(body.points, around, 6)
    if p.wave > 0:
        # A box, and from half its height on one hull: a simulation finds now and then one corner of a thin wavy hull.
        low, high = body.bounds
        middle, half = (low + high) / 2, (high - low) / 2
        outline = outline_of(body.points[:, :2])
        edges = np.roll(outline, -1, axis=0) - outline
        normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
        # The largest box of the body's proportions within its outline: each corner is on the inner side of every edge.
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half[:2]
        room = ((outline - middle[:2]) * normals).sum(axis=1)
        reach = PLINTH * float((room / np.maximum(corners @ normals.T, 1e-12)).min())
        tall = PLINTH_HIGH * float(high[2] - low[2])
        (x0, y0), (x1, y1), z = middle[:2] - reach * half[:2], middle[:2] + reach * half[:2], float(low[2])
        plinth = board((float(x0), float(y0), z), (float(x1), float(y1), z + tall), 0.0)
        raised = body.points.copy()
        raised[:, 2] = raised[:, 2].clip(z + tall / 2)
        return [hull_around(raised), plinth]
    return food.hulls_of_bent(body, p.bend if p.cut is Cut.LONG else 0.0)
