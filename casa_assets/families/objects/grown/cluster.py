"""Fruit and vegetables of many small bodies: grapes, berries, heads of florets, bracts, roots with knobs, bundles."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.core.typing import Floats
from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.solid import Solid, concatenate
from casa_assets.families.kit.solids.sweep import tube
from casa_assets.families.objects.closed_surface import bumped, smooth_profile, turned
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.families.parts.decor.leaves import golden_angles, leaf
from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Vec2

Metres = Annotated[float, Field(gt=0, le=0.5)]
# Points around and along a small body, a middling one and a long one.
SMALL, MIDDLING, LONG = (10, 7), (14, 10), (14, 12)
BALL: tuple[Vec2, ...] = ((0.0, 0.0), (0.5, 0.07), (0.87, 0.25), (1.0, 0.5), (0.87, 0.75), (0.5, 0.93), (0.0, 1.0))


class Build(StrEnum):
    """How the small bodies lie together."""

    GRAPES = "grapes"  # round a stalk that lies, widest near its upper end
    BERRY = "berry"  # over a cone that stands on its wide end
    FLORETS = "florets"  # a dome on branches that leave a stem
    BRACTS = "bracts"  # pointed leaves over a bud, in spirals
    KNOBS = "knobs"  # a root that lies, with knobs that leave it
    BUNDLE = "bundle"  # long bodies side by side


class Cluster(Params):
    """Parameters of what consists of many small bodies; lengths in metres.

    Attributes:
        build: how they lie. length, width: of the whole, without stem and leaves. count: of the small bodies.
        piece, piece_length: diameter and length of one. profile: of one in a bundle, (radius, height) by the largest.
        bumps: unevenness of one, by its radius. stem, stem_radius: length and radius of the stalk that carries them.
        leaves, leaf_length, leaf_width: round the lower end.
        density: kg/m^3 of the small bodies, None for that of their finish. seed: of what is random.
        skin, stem_finish, leaf_finish: finishes; skin is a picture for each small body.
    """

    build: Build
    length: Metres
    width: Metres
    count: Annotated[int, Field(ge=1, le=80)]
    piece: Metres
    piece_length: Metres
    profile: tuple[Vec2, ...] = BALL
    bumps: Annotated[float, Field(ge=0, le=0.4)] = 0.03
    stem: Annotated[float, Field(ge=0, le=0.3)] = 0.0
    stem_radius: Annotated[float, Field(gt=0, le=0.04)] = 0.002
    leaves: Annotated[int, Field(ge=0, le=24)] = 0
    leaf_length: Metres = 0.1
    leaf_width: Metres = 0.05
    density: Annotated[float, Field(gt=0, le=2000)] | None = None
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId
    stem_finish: FinishId = "leaf_light"
    leaf_finish: FinishId = "leaf_mid"


def build(builder: AssetBuilder, p: Cluster) -> None:
    """Build the asset: it rests on z = 0."""
    rng = np.random.Generator(np.random.PCG64(p.seed))
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
    """What the collision shapes are hulls of: each body of a bundle or a root, else all of them together."""
    if label == "body" and p.build in (Build.BUNDLE, Build.KNOBS):
        return solids
    return [concatenate(solids)]


def _body(p: Cluster, size: tuple[int, int], rng: np.random.Generator, scale: float = 1.0) -> Solid:
    """A small body about the z axis, its middle at the origin."""
    points = np.array(p.profile) * (p.piece / 2 * scale, p.piece_length * scale)
    made = turned(smooth_profile([(float(r), float(z)) for r, z in points], size[1]), size[0])
    shaped = bumped(made.points - (0.0, 0.0, p.piece_length * scale / 2), p.bumps, 1.6, rng)
    return replace(made, points=shaped)


def _pointing(body: Solid, way: Floats, at: Floats) -> Solid:
    """A body with its upper end turned to a direction and its middle moved to a point."""
    way = way / np.linalg.norm(way)
    side = np.cross(way, [0.0, 0.0, 1.0] if abs(way[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    axes = np.stack([side, np.cross(way, side), way])
    return replace(body, points=body.points @ axes + at)


def _grapes(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """Berries on rings round a stalk along x, in several shells; none lies below the table."""
    out = []
    for k in range(p.count):
        t = (k + 0.5) / p.count
        # Widest at a quarter of the length, a point at the far end.
        reach = (p.width - p.piece) / 2 * (1.0 - t) ** 0.6 * min(1.0, 0.35 + 2.6 * t)
        angle, out_by = k * 2.399963, math.sqrt(float(rng.uniform(0.15, 1.0)))
        at = np.array([t * p.length, reach * out_by * math.cos(angle), 0.75 * reach * out_by * math.sin(angle)])
        at[2] = max(at[2], -0.5 * p.width + 0.5 * p.piece)
        body = _body(p, SMALL, rng, float(rng.uniform(0.9, 1.05)))
        out.append(_pointing(body, rng.normal(size=3) + np.array([1.5, 0.0, 0.0]), at))
    path = [(-p.stem, 0.0, 0.1 * p.width), (0.0, 0.0, 0.05 * p.width), (0.7 * p.length, 0.0, 0.0)]
    return out, [tube(path, p.stem_radius, 0.3 * p.stem)] if p.stem > 0 else []


def _berry(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """Drupelets in spirals over a blunt cone, and the cone."""
    out = []
    for k in range(p.count):
        t = (k + 0.5) / p.count
        height = 1.0 - t**1.15
        reach = (p.width - p.piece) / 2 * math.sqrt(max(0.02, 1.0 - height**2.2))
        angle = k * 2.399963
        at = np.array([reach * math.cos(angle), reach * math.sin(angle), height * (p.length - p.piece)])
        out.append(_pointing(_body(p, SMALL, rng, float(rng.uniform(0.92, 1.06))), at + np.array([0.0, 0.0, 1e-3]), at))
    core = p.replace(piece=0.7 * p.width, piece_length=0.7 * p.length, profile=BALL)
    return [*out, _body(core, MIDDLING, rng).translated(z=0.36 * p.length)], []


def _florets(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """Bumpy heads over a dome, each on a branch from the top of the stem."""
    heads, branches = [], []
    top = p.stem
    for k in range(p.count):
        t = (k + 0.5) / p.count
        tilt, angle = 1.45 * math.sqrt(t), k * 2.399963 + float(rng.uniform(-0.2, 0.2))
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
    """A bud, and pointed leaves that lie over it from the foot to the tip; a stalk below."""
    core = p.replace(piece=0.86 * p.width, piece_length=0.94 * p.length, profile=BALL)
    out = [_body(core, MIDDLING, rng).translated(z=0.47 * p.length)]
    for k in range(p.count):
        t = (k + 0.5) / p.count
        height = 0.12 + 0.72 * t
        reach = 0.5 * p.width * math.sqrt(max(0.03, 1.0 - (2.0 * height - 0.92) ** 2)) * 0.97
        blade = leaf(p.piece_length * (1.05 - 0.3 * t), p.piece, droop=-0.75, fold=-0.35, tip=0.6, thickness=0.003)
        blade = blade.rotated("x", 0.55 + 0.75 * t + float(rng.uniform(-0.08, 0.08)))
        blade = blade.translated(y=reach, z=height * p.length - 0.25 * p.piece_length)
        out.append(replace(blade.rotated("z", k * 2.399963), picture_uv=_flat_uv(blade)))
    stalk = [tube([(0.0, 0.0, -p.stem), (0.0, 0.0, 0.1 * p.length)], p.stem_radius)] if p.stem > 0 else []
    return out, stalk


def _flat_uv(blade: Solid) -> Floats:
    """Coordinates of a picture laid over a leaf: its height runs along the leaf."""
    lower, upper = blade.bounds
    flat = (blade.points[:, :2] - lower[:2]) / np.maximum(upper[:2] - lower[:2], 1e-9)
    found: Floats = flat[blade.faces]
    return found


def _knobs(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """A chain of fat bodies along x and short ones that leave it to both sides."""
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
        body = _body(p, MIDDLING, rng, scale * float(rng.uniform(0.85, 1.1)))
        out.append(_pointing(body, way, at))
    return out, []


def _bundle(p: Cluster, rng: np.random.Generator) -> tuple[list[Solid], list[Solid]]:
    """Long bodies side by side along x, those that find no room on top of the others."""
    out = []
    row = max(1, int(p.width / p.piece))
    for k in range(p.count):
        layer, place = divmod(k, row)
        shift = 0.5 * (layer % 2)
        y = (place + shift - (min(row, p.count) - 1) / 2) * 0.97 * p.piece
        slide = float(rng.uniform(-0.03, 0.03)) * p.piece_length
        at = np.array([slide, y, (0.5 + 0.8 * layer) * p.piece])
        out.append(_pointing(_body(p, LONG, rng, float(rng.uniform(0.95, 1.0))), np.array([1.0, 0.0, 0.0]), at))
    return out, []


def _leaves(p: Cluster, rng: np.random.Generator) -> list[Solid]:
    """Leaves that stand up round the lower end."""
    out = []
    for angle in golden_angles(p.leaves):
        size = float(rng.uniform(0.85, 1.1))
        blade = leaf(p.leaf_length * size, p.leaf_width * size, droop=-0.5, fold=0.5, tip=0.5, thickness=0.003)
        blade = blade.rotated("x", 0.75 + float(rng.uniform(-0.12, 0.12)))
        out.append(blade.translated(y=0.3 * p.width, z=0.4 * p.stem).rotated("z", angle))
    return out


_BUILDS = {
    Build.GRAPES: _grapes,
    Build.BERRY: _berry,
    Build.FLORETS: _florets,
    Build.BRACTS: _bracts,
    Build.KNOBS: _knobs,
    Build.BUNDLE: _bundle,
}
FORM = ParametricModel("cluster", Cluster, build, base=Base.FREE)
