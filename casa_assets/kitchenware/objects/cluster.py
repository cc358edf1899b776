"""Fruit and vegetables of many small bodies: grapes, berries, florets, bracts, roots with knobs, bundles, stalks."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, circle, concatenate, tube
from casa_assets.kitchenware.objects.closed_surface import bumped, capped_rings, smooth_profile, turned
from casa_assets.kitchenware.parts.decor import GOLDEN_ANGLE, golden_angles, leaf

Metres = Annotated[float, Field(gt=0, le=0.5)]
BERRY_FOOT = 0.14  # of the length of a berry, that its collision shape is flat in
# Points around and along a small body, a middling one and a long one.
SMALL, MIDDLING, LONG = (9, 6), (12, 9), (14, 12)
BALL: tuple[Vec2, ...] = ((0.0, 0.0), (0.5, 0.07), (0.87, 0.25), (1.0, 0.5), (0.87, 0.75), (0.5, 0.93), (0.0, 1.0))

# How the small bodies lie together: GRAPES round a stalk that lies, widest near its upper end; BERRY over a cone that
# stands on its wide end; FLORETS a dome on branches that leave a stem; BRACTS pointed leaves over a bud, in spirals;
# KNOBS a root that lies, with knobs that leave it; BUNDLE long bodies side by side; STALKS ribbed channels that leave a
# common foot, along x, with leaves at their ends.
Build = StrEnum("Build", "GRAPES BERRY FLORETS BRACTS KNOBS BUNDLE STALKS")


class Cluster(Params):
    """Parameters of what consists of many small bodies; lengths in metres."""

    build: Build = Field(description="how they lie")
    length: Metres = Field(description="of the whole, without stem and leaves, m")
    width: Metres = Field(description="of the whole, without leaves, m")
    count: int = Field(ge=1, le=80, description="of the small bodies")
    piece: Metres = Field(description="diameter of one, m")
    piece_length: Metres = Field(description="of one, m")
    profile: tuple[Vec2, ...] = Field(BALL, description="of one in a bundle, (radius, height) by the largest")
    bumps: float = Field(0.03, ge=0, le=0.4, description="unevenness of one, by its radius")
    stem: float = Field(0.0, ge=0, le=0.3, description="length of the stalk that carries them, m")
    stem_radius: float = Field(0.002, gt=0, le=0.04, description="m")
    leaves: int = Field(0, ge=0, le=24, description="round the lower end; of stalks, at the end of each")
    leaf_length: Metres = Field(0.1, description="m")
    leaf_width: Metres = Field(0.05, description="m")
    density: Annotated[float, Field(gt=0, le=2000)] | None = Field(None, description="kg/m^3; None: that of the finish")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId = Field(description="picture of each small body")
    stem_finish: FinishId = "leaf_light"
    leaf_finish: FinishId = "leaf_mid"


def build(builder: AssetBuilder, p: Cluster) -> None:
    """Build the asset: it rests on z = 0."""
    rng = p.rng()
    pieces, stems = _BUILDS[p.build](p, rng)
    blades = _leaves(p, rng)
    lowest = min(float(s.points[:, 2].min()) for s in (*pieces, *stems, *blades))
    groups = ((pieces, p.skin, "body"), (stems, p.stem_finish, "stem"), (blades, p.leaf_finish, "leaf"))
    for solids, finish, label in groups:
        if not solids:
            continue
        whole = concatenate([s.without_colliders() for s in solids]).translated(z=-lowest)
        hulls = [s.translated(z=-lowest).with_hull_collider() for s in _covers(solids, label, p)]
        density = p.density if label == "body" else "plant_stalk"
        builder.add(ROOT, whole.with_colliders_of(*hulls), finish, label=label, name=label, density=density)


def _covers(solids: list[Solid], label: str, p: Cluster) -> list[Solid]:
    """Solids whose hulls are the collision shapes: each body of a bundle or a root, otherwise one solid of all."""
    if label == "body" and p.build in (Build.BUNDLE, Build.KNOBS):
        return solids
    whole = concatenate(solids)
    if label == "body" and p.build is Build.BERRY:  # its foot is made flat, so that it rests firmly
        points = whole.points.copy()
        points[(points[:, 2] < points[:, 2].min() + BERRY_FOOT * p.length), 2] = points[:, 2].min()
        whole = replace(whole, points=points)
    return [whole]


def _body(p: Cluster, size: tuple[int, int], rng: np.random.Generator, scale: float = 1.0) -> Solid:
    points = np.array(p.profile) * (p.piece / 2 * scale, p.piece_length * scale)
    made = turned(smooth_profile([(float(r), float(z)) for r, z in points], size[1]), size[0])
    shaped = bumped(made.points - (0.0, 0.0, p.piece_length * scale / 2), p.bumps, 1.6, rng)
    return replace(made, points=shaped)


def _pointing(body: Solid, way: Floats, at: Floats) -> Solid:
    way = way / np.linalg.norm(way)
    side = np.cross(way, [0.0, 0.0, 1.0] if abs(way[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    return replace(body, points=body.points @ np.stack([side, np.cross(way, side), way]) + at)


def _grapes(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    out = []
    for k in range(p.count):
        t = (k + 0.5) / p.count
        reach = (p.width - p.piece) / 2 * (1.0 - t) ** 0.6 * min(1.0, 0.35 + 2.6 * t)
        angle, out_by = k * GOLDEN_ANGLE, math.sqrt(float(rng.uniform(0.15, 1.0)))
        at = np.array([t * p.length, reach * out_by * math.cos(angle), 0.75 * reach * out_by * math.sin(angle)])
        at[2] = max(at[2], -0.5 * p.width + 0.5 * p.piece)
        body = _body(p, SMALL, rng, float(rng.uniform(0.9, 1.05)))
        out.append(_pointing(body, rng.normal(size=3) + np.array([1.5, 0.0, 0.0]), at))
    path = [(-p.stem, 0.0, 0.1 * p.width), (0.0, 0.0, 0.05 * p.width), (0.7 * p.length, 0.0, 0.0)]
    return out, [tube(path, p.stem_radius, 0.3 * p.stem)] if p.stem > 0 else []


def _berry(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    out = []
    for k in range(p.count):
        height = 1.0 - ((k + 0.5) / p.count) ** 1.15
        reach = (p.width - p.piece) / 2 * math.sqrt(max(0.02, 1.0 - height**2.2))
        angle = k * GOLDEN_ANGLE
        at = np.array([reach * math.cos(angle), reach * math.sin(angle), height * (p.length - p.piece)])
        out.append(_pointing(_body(p, SMALL, rng, float(rng.uniform(0.92, 1.06))), at + np.array([0.0, 0.0, 1e-3]), at))
    core = p.replace(piece=0.78 * p.width, piece_length=0.8 * p.length, profile=BALL)
    return [*out, _body(core, MIDDLING, rng).translated(z=0.38 * p.length)], []


def _florets(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    heads, branches = [], []
    top = p.stem
    for k in range(p.count):
        tilt, angle = 1.45 * math.sqrt((k + 0.5) / p.count), k * GOLDEN_ANGLE + float(rng.uniform(-0.2, 0.2))
        way = np.array([math.sin(tilt) * math.cos(angle), math.sin(tilt) * math.sin(angle), math.cos(tilt)])
        size = np.array([p.width - p.piece, p.width - p.piece, 2 * (p.length - p.stem) - p.piece]) / 2
        at = np.array([0.0, 0.0, top]) + way * size
        heads.append(_pointing(_body(p, MIDDLING, rng, float(rng.uniform(0.85, 1.1))), way, at))
        if p.stem > 0:
            start = (0.0, 0.0, 0.75 * top)
            x, y, z = (float(v) for v in np.array([0.0, 0.0, top]) + 0.35 * way * size)
            end = (float(at[0]), float(at[1]), float(at[2]))
            branches.append(tube([start, (x, y, z), end], min(0.32 * p.stem_radius, 0.0078)))
    if p.stem > 0:
        branches.append(tube([(0.0, 0.0, 0.0), (0.0, 0.0, top)], p.stem_radius))
    return heads, branches


def _bracts(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    core = p.replace(piece=0.92 * p.width, piece_length=0.94 * p.length, profile=BALL)
    out = [_body(core, MIDDLING, rng).translated(z=0.47 * p.length)]
    for k in range(p.count):
        t = (k + 0.5) / p.count
        height = 0.12 + 0.72 * t
        reach = 0.5 * p.width * math.sqrt(max(0.03, 1.0 - (2.0 * height - 0.92) ** 2)) * (0.82 + 0.1 * t)
        long = p.piece_length * (1.05 - 0.3 * t)
        blade = leaf(long, p.piece, droop=-0.75, fold=-0.35, tip=0.6, thickness=0.003, steps=5)
        blade = blade.rotated("x", 0.62 + t + float(rng.uniform(-0.08, 0.08)))
        blade = blade.translated(y=reach, z=height * p.length - 0.25 * p.piece_length)
        # A picture is laid over the leaf; its height runs along the leaf.
        lower, upper = blade.bounds
        flat = (blade.points[:, :2] - lower[:2]) / np.maximum(upper[:2] - lower[:2], 1e-9)
        out.append(replace(blade.rotated("z", k * GOLDEN_ANGLE), picture_uv=flat[blade.faces]))
    return out, ([tube([(0.0, 0.0, -p.stem), (0.0, 0.0, 0.1 * p.length)], p.stem_radius)] if p.stem > 0 else [])


def _knobs(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    main = max(2, p.count // 2)
    out = []
    for k in range(p.count):
        if k < main:
            x = (k + 0.5) / main * p.length
            way, at, scale = np.array([1.0, rng.uniform(-0.3, 0.3), 0.0]), np.array([x, 0.0, 0.0]), 1.0
        else:
            x = float(rng.uniform(0.15, 0.85)) * p.length
            side = 1.0 if k % 2 else -1.0
            way = np.array([rng.uniform(-0.5, 0.8), side, rng.uniform(-0.1, 0.25)])
            at, scale = np.array([x, side * 0.5 * (p.width - 0.6 * p.piece_length), 0.0]), 0.75
        out.append(_pointing(_body(p, MIDDLING, rng, scale * float(rng.uniform(0.85, 1.1))), way, at))
    return out, []


def _bundle(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    out = []
    row = max(1, int(p.width / p.piece))
    for k in range(p.count):
        layer, place = divmod(k, row)
        y = (place + (0.5 * (layer % 2)) - (min(row, p.count) - 1) / 2) * 0.97 * p.piece
        at = np.array([(float(rng.uniform(-0.03, 0.03)) * p.piece_length), y, (0.5 + 0.8 * layer) * p.piece])
        out.append(_pointing(_body(p, LONG, rng, float(rng.uniform(0.95, 1.0))), np.array([1.0, 0.0, 0.0]), at))
    return out, []


def _leaves(p: Cluster, rng: np.random.Generator) -> list[Solid]:
    out = []
    if p.build is Build.STALKS:
        for k in range(p.leaves):
            size, turn = float(rng.uniform(0.7, 1.15)), float(rng.uniform(0.0, 2 * math.pi))
            long, wide = p.leaf_length * size, p.leaf_width * size
            blade = leaf(long, wide, droop=0.5, fold=0.25, tip=0.7, thickness=0.0015, steps=4)
            blade = blade.rotated("z", -math.pi / 2 + float(rng.uniform(-0.6, 0.6)))
            away = 0.35 * (p.width if p.count > 1 else p.piece) * float(rng.uniform(0.2, 1.0))
            x = p.length * (0.9 + 0.16 * k / p.leaves) + float(rng.uniform(-0.01, 0.01))
            out.append(blade.rotated("x", turn).translated(x, away * math.cos(turn), away * math.sin(turn)))
        return out
    for angle in golden_angles(p.leaves):
        size = float(rng.uniform(0.85, 1.1))
        blade = leaf(p.leaf_length * size, p.leaf_width * size, droop=-0.5, fold=0.5, tip=0.5, thickness=0.003)
        blade = blade.rotated("x", 0.75 + float(rng.uniform(-0.12, 0.12)))
        out.append(blade.translated(y=0.3 * p.width, z=0.4 * p.stem).rotated("z", angle))
    return out


def _stalks(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """Channels in rings round the x axis, the hollow side inwards; each has twigs that carry its leaves."""
    out, twigs = [], []
    for k in range(p.count):
        inner = k >= 6
        turn = 2 * math.pi * k / min(p.count, 6) + (0.5 if inner else 0.0) + float(rng.uniform(-0.15, 0.15))
        size, long = float(rng.uniform(0.85, 1.1)) * (0.75 if inner else 1.0), float(rng.uniform(0.85, 1.0)) * p.length
        reach = 0.0 if p.count == 1 else (0.25 if inner else 0.5) * (p.width - p.piece)
        # A single stalk lies on its back.
        turn = -math.pi / 2 if p.count == 1 else turn
        out.append(_stalk(p, long, size, reach).rotated("x", turn - math.pi / 2))
        end = np.array([long, 0.0, reach + 0.1 * p.piece])
        for _ in range(2 if p.leaves else 0):
            way = np.array([1.0, float(rng.uniform(-0.35, 0.35)), float(rng.uniform(-0.05, 0.3))]) * 0.6 * p.leaf_length
            path = [(float(x), float(y), float(z)) for x, y, z in (end - 0.2 * way, end + 0.5 * way, end + way)]
            twigs.append(tube(path, circle(0.13 * p.piece * size, 6)).rotated("x", turn - math.pi / 2))
    return out, twigs


def _stalk(p: Cluster, long: float, size: float, reach: float) -> Solid:
    """One channel along x, its hollow side down, at a distance above the x axis."""
    across = np.linspace(-1.0, 1.0, 9)
    outer = np.column_stack([0.5 * across, 0.34 * (1 - across**2) + (0.04 * (np.arange(9) % 2))])
    inner = np.column_stack([0.36 * across[::-1], 0.2 * (1 - across[::-1] ** 2) - 0.12])
    section = np.concatenate([outer, inner]) * p.piece * size
    rings = []
    for t in np.linspace(0.0, 1.0, 11):
        # Broad and flat at the foot, narrow and high at the leaves.
        wide, high = 1.0 - 0.62 * t**0.8, 1.0 - 0.35 * t
        bow = reach * (0.72 + 0.5 * t + 0.3 * math.sin(math.pi * t))
        points = section * (wide, high)
        rings.append(np.column_stack([np.full(len(points), t * long), points[:, 0], points[:, 1] + bow]))
    n = len(section)
    ends = [rings[0].mean(axis=0, keepdims=True), rings[-1].mean(axis=0, keepdims=True)]
    points = np.concatenate([ends[0], *rings, ends[1]])
    place = np.concatenate([[0.0], np.repeat(np.linspace(0.0, 1.0, len(rings)), n), [1.0]])
    around = np.concatenate([[0.5], np.tile(np.linspace(0.0, 1.0, n), len(rings)), [0.5]])
    faces = capped_rings(n, len(rings))
    return Solid(points, faces, crease_deg=50.0, picture_uv=np.column_stack([around, place])[faces]).oriented_outwards()


_BUILDS = {
    Build(maker.__name__.removeprefix("_")): maker
    for maker in (_grapes, _berry, _florets, _bracts, _knobs, _bundle, _stalks)
}
