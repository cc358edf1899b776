"""Composed food: towers of layers, filled buns and shells, things on a skewer, cakes, cups, cones and sushi."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Portion, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, prism, tube
from casa_assets.kitchenware.objects import food
from casa_assets.kitchenware.objects.closed_surface import bumped, ellipsoid, lobed, sheet, smooth_profile, turned
from casa_assets.kitchenware.objects.food import Piece

Metres = Annotated[float, Field(gt=0, le=0.6)]
Thin = Annotated[float, Field(ge=0, le=0.08)]
Share = Annotated[float, Field(ge=0, le=1)]
# A solid and its finish, to be drawn.
Part = tuple[Solid, str]

# How it is put together: TOWER layers on each other; BUN a sausage in a split bun; SHELL fillings in a folded shell;
# SKEWER pieces on a stick; CAKE sponge and cream under icing, whole or with a piece cut out; CUP a paper cup with a
# swirl on it; CONE balls of ice in a cone, lying; BAR ice on a stick, lying; NIGIRI a slice on a roll of rice; MAKI a
# piece of a roll, on its end.
Build = StrEnum("Build", "TOWER BUN SHELL SKEWER CAKE CUP CONE BAR NIGIRI MAKI")

Filling = StrEnum(
    "Filling",
    "BASE CROWN SLICE PATTY CHEESE CHEESE_PALE LETTUCE TOMATO ONION ONION_RED PICKLE HAM EGG KETCHUP MUSTARD "
    "CUCUMBER PEPPER_GREEN PEPPER_RED PEPPER_YELLOW MUSHROOM MEAT",
)

# Thickness in metres, reach by the outline, and finish of layers that are plain.
_LAYERS = {
    Filling.CHEESE: (0.003, 1.04, "dish_cheese_yellow"), Filling.CHEESE_PALE: (0.003, 1.04, "dish_cheese_pale"),
    Filling.LETTUCE: (0.005, 1.1, "dish_lettuce"), Filling.TOMATO: (0.006, 0.97, "dish_tomato"),
    Filling.ONION: (0.003, 0.98, "dish_onion"), Filling.ONION_RED: (0.003, 0.98, "dish_onion_red"),
    Filling.PICKLE: (0.003, 0.98, "dish_pickle"), Filling.CUCUMBER: (0.004, 0.99, "dish_cucumber"),
    Filling.HAM: (0.004, 1.03, "dish_meat_pink"), Filling.EGG: (0.004, 1.04, "dish_white_fish"),
    Filling.KETCHUP: (0.002, 0.98, "dish_ketchup"), Filling.MUSTARD: (0.002, 0.98, "dish_mustard"),
}  # fmt: skip
FOLD = 0.001  # metres that the filling of a shell stays within the middle of it where it is folded
CHIP_M = 0.014  # of what is cut into cubes in a taco
FLAT_STEP = 0.0005  # metres between the undersides of neighbours on a skewer
# Length along the stick and size across it by the width of a skewer, and finish, of what is on one.
_PIECES = {
    Filling.MEAT: (0.9, 0.9, ""), Filling.ONION: (0.3, 0.95, "dish_onion"),
    Filling.ONION_RED: (0.3, 0.95, "dish_onion_red"), Filling.TOMATO: (0.8, 0.8, "dish_tomato"),
    Filling.PEPPER_GREEN: (0.28, 0.95, "dish_pepper_green"), Filling.PEPPER_RED: (0.28, 0.95, "dish_pepper_red"),
    Filling.PEPPER_YELLOW: (0.28, 0.95, "dish_pepper_yellow"), Filling.MUSHROOM: (0.7, 0.85, "dish_mushroom"),
    Filling.CUCUMBER: (0.4, 0.9, "dish_cucumber"), Filling.PATTY: (2.6, 0.85, ""),
}  # fmt: skip
_FLAT = ((0, 0), (0.8, 0), (0.97, 0.1), (1, 0.5), (0.97, 0.9), (0.8, 1), (0, 1))
_BASE = ((0, 0), (0.75, 0), (0.93, 0.14), (1, 0.55), (0.99, 0.85), (0.95, 1), (0.5, 1), (0, 1))
_CROWN = ((0, 0), (0.9, 0), (0.98, 0.05), (1, 0.2), (0.94, 0.5), (0.76, 0.79), (0.45, 0.96), (0, 1))


class Stacked(Params):
    """Parameters of composed food; lengths in metres."""

    build: Build = Field(description="way of composing it")
    length: Metres = Field(description="of the whole along x, about, m")
    width: Metres = Field(description="of the whole along y, about, m")
    height: Metres = Field(description="of the whole along z, about, of a tower that of its upper bread, m")
    outline: tuple[Vec2, ...] = Field((), description="of a tower from above; empty: a superellipse of power `square`")
    square: Annotated[float, Field(ge=1, le=12)] = 2.0
    layers: tuple[Filling, ...] = Field((), description="of a tower from bottom to top; of a skewer from end to end")
    base_height: Thin = Field(0.018, description="of the lower bread, or of a layer of sponge, m")
    patty_height: Thin = Field(0.014, description="m")
    count: int = Field(2, ge=1, le=12, description="layers of sponge, balls of ice, or turns of the line of sauce")
    opening: float = Field(360.0, ge=20, le=360, description="angle of the cake that is left, degrees; 360: whole")
    ripple: float = Field(0.12, ge=0, le=0.4, description="depth of a swirl by its radius")
    turns: float = Field(3.0, ge=0, le=6, description="of a swirl")
    topping: Piece = Field(Piece.SEED, description="kind of what is strewn on top; its finishes take turns")
    topping_count: Annotated[int, Field(ge=0, le=90)] = 0
    topping_size: Thin = Field(0.004, description="m")
    cherry: Thin = Field(0.0, description="diameter of a ball on top, m; 0: none")
    stick: Thin = Field(0.04, description="how far a stick projects, m")
    band: bool = Field(False, description="a band of seaweed around nigiri")
    density: float = Field(600.0, ge=50, le=2000, description="of the whole, kg/m^3")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId = Field(description="bread, shell, cup, cone or seaweed")
    meat: FinishId = Field("dish_meat_minced", description="patty, sausage, meat or fish")
    second: FinishId = Field("dish_cream", description="cream, frosting, ice or rice")
    third: FinishId = Field("dish_icing_white", description="icing, sauce, or the core of a roll")
    topping_finish: FinishId = "dish_sesame"
    topping_finish_2: FinishId | None = None
    topping_finish_3: FinishId | None = None
    cherry_finish: FinishId = "dish_candy_red"
    stick_finish: FinishId = "oak_light"


@dataclass(frozen=True)
class Composed:
    """Solids of a composed food."""

    parts: list[Part]  # solids with their finishes; the first is the largest
    hulls: list[list[Solid]]  # groups of solids, each with one hull over it
    light: list[Part]  # solids without mass, with their finishes


def build(builder: AssetBuilder, p: Stacked) -> None:
    """Build the asset: it rests on z = 0."""
    if p.opening < 360:
        builder.portion = Portion.PIECE if p.opening > 180 else Portion.WEDGE
    made = _BUILDERS[p.build](p, p.rng())
    low = min(float(s.points[:, 2].min()) for group in made.hulls for s in group)
    for parts, density in ((made.parts, p.density), (made.light, 0.0)):
        for finish in dict.fromkeys(finish for _, finish in parts):
            whole = food.joined([s for s, f in parts if f == finish]).translated(z=-low)
            label = finish.removeprefix("skin_").removeprefix("dish_")
            builder.add(ROOT, whole, finish, label=label, collider=False, density=density)
    for k, group in enumerate(made.hulls):
        name = "body" if k == 0 else None
        builder.add_collider(ROOT, food.hull_of(*group).translated(z=-low), made.parts[0][1], "body", name)


def _toppings(p: Stacked, on: Solid, rng: np.random.Generator, steep: float = 0.4) -> list[Part]:
    finishes = [f for f in (p.topping_finish, p.topping_finish_2, p.topping_finish_3) if f is not None]
    pieces = food.strewn(on, p.topping, p.topping_count, p.topping_size, rng, steep=steep)
    return [(food.plain(piece), finishes[k % len(finishes)]) for k, piece in enumerate(pieces)]


def _tower(p: Stacked, rng: np.random.Generator) -> Composed:
    outline = food.outline_of_food(p.outline, p.length, p.width, p.square)
    parts: list[Part] = []
    light: list[Part] = []
    z = 0.0
    for filling in p.layers:
        if filling in (Filling.BASE, Filling.CROWN, Filling.SLICE):
            height = p.height if filling is Filling.CROWN else p.base_height
            profile = {Filling.BASE: _BASE, Filling.CROWN: _CROWN, Filling.SLICE: _FLAT}[filling]
            bread = food.dome(outline, profile, height)
            bread = replace(bread, points=food.flat_foot(bumped(bread.points, 0.012, 1.0, rng), 0.01)).translated(z=z)
            parts.append((bread, p.skin))
            z += height - 0.0006
            if filling is Filling.CROWN:
                light += _toppings(p, bread, rng)
            continue
        if filling is Filling.PATTY:
            patty = food.dome(outline * 1.01, _FLAT, p.patty_height)
            patty = replace(patty, points=bumped(patty.points, 0.05, 3.0, rng)).translated(z=z)
            parts.append((patty, p.meat))
            z += p.patty_height - 0.001
            continue
        thickness, reach, finish = _LAYERS[filling]
        parts += [(food.plain(s).translated(z=z), finish) for s in _layer(p, filling, outline * reach, thickness, rng)]
        z += thickness - 0.0006
    return Composed(parts, [[s for s, _ in parts]], light)


def _layer(p: Stacked, filling: Filling, outline: Floats, thickness: float, rng: np.random.Generator) -> list[Solid]:
    """One filling of a tower, from z = 0."""
    reach = float(np.abs(outline).max())
    match filling:
        case Filling.CHEESE | Filling.CHEESE_PALE if not p.outline:
            grid = np.linspace(-0.93 * reach, 0.93 * reach, 13)
            x, y = np.meshgrid(grid, grid, indexing="ij")
            hang = np.maximum(np.hypot(x, y) - 0.94 * reach, 0.0)
            x, y = x - 0.4 * x * hang / reach, y - 0.4 * y * hang / reach
            points = np.stack([x, y, thickness / 2 - 1.1 * hang], axis=2)
            return [sheet(points, thickness).rotated("z", float(rng.uniform(0, 1.57)))]
        case Filling.LETTUCE | Filling.HAM | Filling.EGG:
            disc = food.dome(outline, _FLAT, thickness, 11)
            angle = np.arctan2(disc.points[:, 1], disc.points[:, 0])
            share = np.hypot(disc.points[:, 0], disc.points[:, 1]) / reach
            waves = int(rng.integers(8, 11)) if filling is Filling.LETTUCE else int(rng.integers(3, 6))
            rise = 0.0045 if filling is Filling.LETTUCE else 0.002
            ruffle = np.sin(waves * angle + rng.uniform(0, 6)) + 0.6 * np.sin((waves + 4) * angle + rng.uniform(0, 6))
            points = disc.points.copy()
            points[:, 2] += rise * ruffle * share**4 - 0.8 * rise * share**4
            points[:, :2] *= (1.0 + 0.05 * share**3 * np.sin((waves - 3) * angle + rng.uniform(0, 6)))[:, None]
            return [replace(disc, points=points)]
        case Filling.TOMATO | Filling.PICKLE | Filling.CUCUMBER | Filling.ONION | Filling.ONION_RED:
            count = 2 if filling is Filling.TOMATO else 4
            size = (1.3 if count == 2 else 0.9) * float(np.ptp(outline, axis=0).min()) / 2
            start = float(rng.uniform(0, 6.28))
            out = []
            for k in range(count):
                turn = start + 2 * math.pi * k / count
                way = np.array([math.cos(turn), math.sin(turn)])
                edge = float((outline @ way).max()) - size / 2
                if filling in (Filling.ONION, Filling.ONION_RED):
                    part = food.ring_body(size, thickness, 0.72 * size, 3.0, 20, 6).translated(z=thickness / 2)
                else:
                    part = food.dome(food.superellipse(size, size, count=24), _FLAT, thickness, 7)
                x, y = edge * way
                out.append(part.translated(float(x), float(y), 0.0003 * k))
            return out
        case _:
            disc = food.dome(outline, _FLAT, thickness, 9)
            wander = 1.0 + 0.04 * food.smooth_noise(disc.points[:, :2], 40.0, rng)
            return [replace(disc, points=disc.points * np.column_stack([wander, wander, np.ones(len(wander))]))]


def _bun(p: Stacked, rng: np.random.Generator) -> Composed:
    loaf = ((0, 0), (0.5, 0.01), (0.85, 0.06), (1, 0.18), (1, 0.5), (1, 0.82), (0.85, 0.94), (0.5, 0.99), (0, 1))
    link = ((0, 0), (0.5, 0.012), (0.85, 0.045), (1, 0.12), (1, 0.5), (1, 0.88), (0.85, 0.955), (0.5, 0.988), (0, 1))
    bun_length, thick = 0.9 * p.length, 0.42 * p.width
    halves = []
    for side in (-1, 1):
        half = food.long_body(loaf, bun_length, thick, 0.72 * p.height, square_top=2.4, square=2.4, along=19, around=20)
        half = half.rotated("x", -0.28 * side).translated(0.0, side * 0.29 * p.width, 0.4 * p.height)
        halves.append(half)
    base = food.long_body(loaf, 0.97 * bun_length, 0.8 * p.width, 0.4 * p.height, square=3.0, along=15, around=16)
    loaves = (*halves, base.translated(z=0.21 * p.height))
    bread = [replace(s, points=bumped(s.points, 0.012, 1.5, rng)) for s in loaves]
    size = 0.46 * p.width
    sausage = food.long_body(link, p.length, size, size, along=23, around=20)
    bow = 0.06 * size * np.cos(np.pi * sausage.points[:, 0] / p.length)
    points = sausage.points + np.column_stack([0 * bow, 0 * bow, bow])
    sausage = replace(sausage, points=points).translated(z=p.height - size / 2 - 0.003)
    parts: list[Part] = [(s, p.skin) for s in bread] + [(sausage, p.meat)]
    light: list[Part] = []
    surface = food.Surface(sausage)
    t = np.linspace(-0.42, 0.42, 6 * p.count + 1)
    swing = 0.16 * size * np.sin(2 * np.pi * p.count * (t + 0.42) / 0.84) if p.count > 1 else 0.0 * t
    if p.third:
        sauce = food.ridge(surface, np.column_stack([t * p.length, swing]), 0.0055, 0.005, False)
        light.append((food.plain(sauce), p.third))
    light += _toppings(p, sausage, rng, 0.75)
    return Composed(parts, [[*bread, sausage, *(s for s, _ in light)]], light)


def _shell(p: Stacked, rng: np.random.Generator) -> Composed:
    radius, n, m = p.length / 2, 23, 19
    gap = 0.32 * p.width
    s = np.linspace(-0.995, 0.995, n)[:, None] * radius
    half = (0.5 * math.pi * gap / 2 + p.height - gap / 2) * np.sqrt(np.maximum(1.0 - (s / radius) ** 2, 0.006)) ** 0.85
    along = np.linspace(-1.0, 1.0, m)[None, :] * half
    bow = np.minimum(np.abs(along) / gap, math.pi / 2 * 0.82)
    rest = np.maximum(np.abs(along) - gap * math.pi / 2 * 0.82, 0.0)
    lean = math.pi / 2 * 0.82
    y = np.sign(along) * (gap * np.sin(bow) + rest * math.cos(lean))
    z = gap * (1 - np.cos(bow)) + rest * math.sin(lean)
    grid = np.stack([np.broadcast_to(s, y.shape), y, z], axis=2)
    grid[..., 2] += 0.0015 * food.smooth_noise(grid.reshape(-1, 3), 30.0, rng).reshape(n, m)
    grid[..., 2] = np.maximum(grid[..., 2], 0.002)
    shell = sheet(grid, 0.0028)
    fill_profile = ((0, 0), (0.3, 0.02), (0.75, 0.14), (1, 0.35), (1, 0.65), (0.75, 0.86), (0.3, 0.98), (0, 1))
    heart = food.long_body(fill_profile, 0.94 * p.length, 1.7 * gap, 1.5 * p.height * 0.86, along=25, around=20)
    points = bumped(heart.points, 0.05, 3.0, rng)
    points[:, 2] = np.maximum(points[:, 2], -0.25 * p.height)
    heart = food.plain(replace(heart, points=points)).translated(z=0.93 * p.height - float(points[:, 2].max()))
    low = 0.0045
    x, y, z = heart.points.T
    z = np.maximum(z, low)
    # It narrows below as the fold of the shell does, or it would come out of it.
    y = y * np.minimum(1.0, np.sqrt((gap - FOLD) ** 2 - np.maximum(gap - z, 0.0) ** 2) / (1.05 * 0.85 * gap))
    heart = replace(heart, points=np.column_stack([x, y, z]))
    parts: list[Part] = [(shell, p.skin), (heart, p.meat)]
    light: list[Part] = []
    chips = food.strewn(heart, Piece.CHIP, 12, CHIP_M, rng, steep=0.35, above=0.55, sunk=0.3, apart=0.6)
    light += [(food.plain(s), p.second) for s in chips]
    for finish, kind, size, count in (
        (p.third, Piece.SHRED, 0.03, 34),
        (p.topping_finish, p.topping, p.topping_size, p.topping_count),
    ):
        more = food.strewn(heart, kind, count, size, rng, steep=0.35, above=0.55, sunk=0.3, apart=0.6)
        # What is flat lies beside the chips: the upper sides of two that meet would lie in one plane.
        clear = 0.0 if kind is Piece.SHRED else 0.5 * (CHIP_M + size)
        light += [(food.plain(s), finish) for s in more if _distance(s, chips) >= clear]
    return Composed(parts, [[shell, heart, *(s for s, _ in light)]], light)


def _distance(solid: Solid, others: Sequence[Solid]) -> float:
    """How far the middle of a solid is from that of the nearest other, metres."""
    middle = solid.points.mean(axis=0)
    return min((float(np.linalg.norm(other.points.mean(axis=0) - middle)) for other in others), default=math.inf)


def _skewer(p: Stacked, rng: np.random.Generator) -> Composed:
    spans = [_PIECES[f] for f in p.layers]
    total = sum(length for length, _, _ in spans)
    scale = min(1.25, (p.length - 1.3 * p.stick) / (total * p.width))
    x = -scale * total * p.width / 2
    parts: list[Part] = []
    for number, (filling, (length, across, finish)) in enumerate(zip(p.layers, spans, strict=True)):
        size = scale * length * p.width
        piece = _on_stick(filling, size, across * p.width, rng).translated(x=x + size / 2)
        points = piece.points.copy()
        # Flat where they lie; neighbours reach into each other, and two flats in one plane would flicker.
        points[:, 2] = np.maximum(points[:, 2], -0.42 * p.width + FLAT_STEP * (number % 2))
        piece = replace(piece, points=points)
        parts.append((food.plain(piece) if finish else piece, finish or p.meat))
        x += size
    reach = scale * total * p.width / 2
    stick = tube([(-reach - 0.3 * p.stick, 0.0, 0.0), (reach + p.stick, 0.0, 0.0)], 0.0017)
    return Composed([*parts, (food.plain(stick), p.stick_finish)], [([s for s, _ in parts]), [stick]], [])


def _on_stick(filling: Filling, size: float, wide: float, rng: np.random.Generator) -> Solid:
    """A piece about the origin whose length along x is `size`, metres."""
    spin = float(rng.uniform(0, 6.28))
    if filling is Filling.PATTY:
        profile = ((0, 0), (0.5, 0.01), (0.85, 0.05), (1, 0.15), (0.96, 0.4), (1, 0.6), (1, 0.85), (0.85, 0.95), (0, 1))
        body = food.long_body(profile, 1.04 * size, wide, 0.86 * wide, around=20, along=27)
        return replace(body, points=bumped(body.points, 0.05, 3.0, rng))
    if filling is Filling.MEAT:
        block = food.dome(food.superellipse(wide, wide, 4.0, 28), _FLAT, size * 1.06, 11).translated(z=-0.53 * size)
        block = block.rotated("y", math.pi / 2).rotated("x", spin)
        return replace(block, points=bumped(block.points, 0.09, 1.2, rng))
    if filling is Filling.TOMATO:
        return ellipsoid((1.1 * size, wide, wide), 20, 13)
    if filling is Filling.MUSHROOM:
        line = [(0, 0), (0.35, 0), (0.35, 0.4), (0.9, 0.42), (1, 0.55), (0.8, 0.85), (0.4, 1), (0, 1)]
        cap = turned(smooth_profile([(float(r), z) for r, z in line], 15), 20, food.CREASE)
        cap = replace(cap, points=cap.points * (wide / 2, wide / 2, size))
        return cap.translated(z=-size / 2).rotated("y", math.pi / 2)
    power = 2.0 if filling is Filling.CUCUMBER else 3.0
    flat = food.dome(food.superellipse(wide, wide * (1.0 if power == 2.0 else 0.85), power, 24), _FLAT, 0.8 * size, 9)
    points = flat.points.copy()
    if filling is not Filling.CUCUMBER:  # layers of an onion and walls of a pepper are curved
        points[:, 2] += 0.35 * size * (1 - 8 * (points[:, 0] / wide) ** 2 / 2)
    flat = replace(flat, points=points - (0.0, 0.0, float(points[:, 2].mean())))
    return flat.rotated("y", math.pi / 2).rotated("x", spin)


def _sector(radius: float, opening: float, inner: float = 0.0) -> Floats:
    """Outline of a disc, or of the part of it about +y that is left, degrees; `inner` is cut out round the middle."""
    if opening >= 360:
        return food.superellipse(2 * radius, 2 * radius, count=64)
    half = math.radians(opening / 2)
    turns = math.pi / 2 + np.linspace(-half, half, max(9, round(opening / 5.5)))
    arc = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    if inner <= 0:
        return np.vstack([arc, [[0.0, 0.0]]])
    return np.vstack([arc, (inner * np.stack([np.cos(turns[::-1]), np.sin(turns[::-1])], axis=1))])


def _cake(p: Stacked, rng: np.random.Generator) -> Composed:
    """Layers of sponge and cream, icing over all, rosettes or things strewn on top; a piece of it may be missing."""
    radius, coat = p.length / 2, 0.004
    inside = _sector(radius - coat, p.opening)
    cream = 0.006
    parts: list[Part] = []
    z = 0.0
    for k in range(p.count):
        parts.append((food.plain(prism(inside, p.base_height, 0.0).translated(z=z)), p.skin))
        z += p.base_height
        if k < p.count - 1:
            # A cut leaves the cream a trifle behind the sponge.
            parts.append((food.plain(prism(inside * 0.9985, cream, 0.0).translated(z=z)), p.second))
            z += cream
    top = prism(_sector(radius, p.opening) * 0.999, coat, 0.0012).translated(z=z)
    if p.opening >= 360:
        wall = prism(_sector(radius, 360), z + 0.5 * coat, 0.001, holes=[_sector(radius - coat, 360)])
    else:
        wall = prism(_sector(radius, p.opening, radius - coat), z + 0.5 * coat, 0.0)
    parts += [(food.plain(top), p.third), (food.plain(wall), p.third)]
    z += coat
    solids = [s for s, _ in parts]
    light = _toppings(p, top, rng, 0.9)
    whole = 2 * math.pi * p.opening / 360
    start = math.pi / 2 - whole / 2
    roses = max(1, round(8 * p.opening / 360)) if p.turns > 0 else 0
    for k in range(roses):
        turn, size = start + whole * (k + 0.5) / roses, 0.15 * radius + 0.004
        x, y = 0.76 * radius * math.cos(turn), 0.76 * radius * math.sin(turn)
        rose = _swirl(size, 0.9 * size, 0.18, 2.0, fine=False).translated(x, y, z - 0.001)
        parts.append((food.plain(rose), p.second))
        solids.append(rose)
        # Nothing is strewn below a rosette: flat sides of both might lie in one plane.
        at = np.array([math.cos(turn), math.sin(turn)]) * 0.76 * radius
        light = [(s, f) for s, f in light if np.linalg.norm(s.points[:, :2] - at, axis=1).min() > size]
        if p.cherry > 0:
            ball = ellipsoid((p.cherry,) * 3, 14, 9).translated(x, y, z + 0.8 * size)
            light.append((food.plain(ball), p.cherry_finish))
            solids.append(ball)
    # A cake with a piece missing has one hull to each half, so that the gap stays open.
    if 180 < p.opening < 360:
        groups = [[Solid(s.points[sign * s.points[:, 0] >= -1e-9], s.faces) for s in solids] for sign in (-1, 1)]
        return Composed(parts, [[s for s in g if len(s.points)] for g in groups], light)
    return Composed(parts, [solids], light)


def _swirl(radius: float, height: float, ripple: float, turns: float, fine: bool = True) -> Solid:
    profile = [(0, 0), (0.85, 0), (1, 0.1), (0.92, 0.32), (0.7, 0.58), (0.42, 0.82), (0.14, 0.97), (0, 1)]
    along, around = (23, 28) if fine else (14, 18)
    body = turned(smooth_profile([(float(r), float(z)) for r, z in profile], along), around, 70.0)
    angle = np.arctan2(body.points[:, 1], body.points[:, 0])
    wave = np.abs(np.sin(np.pi * np.mod(turns * body.points[:, 2] - angle / (2 * np.pi), 1.0))) ** 0.7
    share = 1.0 - ripple + 1.4 * ripple * wave + (0.25 * ripple * np.cos(9 * angle + 5.0 * body.points[:, 2]))
    share = np.where(body.points[:, 2] > 0.01, share, 1.0 - ripple / 2)
    size = np.column_stack([share * radius, share * radius, np.full(len(share), height)])
    return replace(body, points=body.points * size)


def _cup(p: Stacked, rng: np.random.Generator) -> Composed:
    radius, height = p.length / 2, p.base_height
    line = [(0.0, 0.0), (0.7, 0.0), (0.72, 0.02), (0.86, 0.5), (0.985, 0.98), (0.96, 1.0), (0.5, 1.0), (0.0, 1.0)]
    cup = turned(np.array(line), 80, 40.0)
    cup = replace(cup, points=lobed(cup.points * (0.93 * radius, 0.93 * radius, height), 20, 0.06, 1.0, 0.0))
    profile = [(0, 0), (0.8, 0), (0.97, 0.2), (1, 0.42), (0.85, 0.75), (0.5, 0.95), (0, 1)]
    cake = food.dome(food.superellipse(2 * radius, 2 * radius, count=36), profile, 0.45 * radius, 11)
    cake = replace(cake, points=bumped(cake.points, 0.03, 2.0, rng)).translated(z=height - 0.1 * radius)
    parts: list[Part] = [(food.plain(cup), p.third), (food.plain(cake), p.skin)]
    top = cake
    if p.ripple > 0:
        top = _swirl(0.95 * radius, p.height - height - 0.15 * radius, p.ripple, p.turns)
        top = top.translated(z=height + 0.12 * radius)
        parts.append((food.plain(top), p.second))
    light = _toppings(p, top, rng, 0.1)
    solids = [s for s, _ in parts]
    if p.cherry > 0:
        ball = ellipsoid((p.cherry,) * 3, 16, 11).translated(z=float(top.points[:, 2].max()) + 0.2 * p.cherry)
        parts.append((food.plain(ball), p.cherry_finish))
        solids.append(ball)
    return Composed(parts, [[cup], solids[1:]], light)


# A ball of ice with a skirt below: (radius, height) from the lower end to the upper one.
SCOOP = [(0, 0), (0.75, 0.02), (1.04, 0.1), (1.06, 0.18), (0.98, 0.24), (1, 0.45), (0.86, 0.75), (0.5, 0.94), (0, 1)]


def _cone(p: Stacked, rng: np.random.Generator) -> Composed:
    mouth, long = p.width / 2 * 0.9, p.base_height * 2
    line = [(0.0, 0.0), (0.0035, 0.0), (0.5 * mouth, 0.5 * long), (mouth, 0.985 * long), (0.97 * mouth, long)]
    line.append((0.0, long))
    cone = turned(np.array(line), 36, 50.0)
    assert cone.picture_uv is not None
    uv = cone.picture_uv.copy()
    uv[..., 0] += 0.35 * uv[..., 1]
    cone = replace(cone, picture_uv=uv)
    parts: list[Part] = [(cone, p.skin)]
    light: list[Part] = []
    ices = [p.second, p.third, p.meat]
    radius, z = p.width / 2, long + 0.3 * p.width / 2
    middle = z
    for k in range(min(p.count, 3)):
        ball = turned(smooth_profile(SCOOP, 21), 30, 70.0)
        size = radius * 0.94**k
        points = bumped(ball.points * (size, size, 1.8 * size), 0.035, 3.0, rng)
        ball = food.plain(replace(ball, points=points)).translated(z=z - 0.6 * size)
        parts.append((ball, ices[k]))
        z += 1.2 * size
        if k == p.count - 1 or k == 2:
            light += _toppings(p, ball, rng, 0.2)
            if p.cherry > 0:
                peak = float(ball.points[:, 2].max())
                cherry = ellipsoid((p.cherry,) * 3, 14, 9).translated(z=peak + 0.25 * p.cherry)
                light.append((food.plain(cherry), p.cherry_finish))
    turn = -(math.pi / 2 - math.asin(min(0.9, 1.02 * radius / middle)))
    parts = [(s.rotated("y", turn), f) for s, f in parts]
    light = [(s.rotated("y", turn), f) for s, f in light]
    balls = [s for s, _ in parts[1:]] + [s for s, f in light if f == p.cherry_finish]
    return Composed(parts, [[parts[0][0]], balls], light)


def _bar(p: Stacked, rng: np.random.Generator) -> Composed:
    w, h = p.width / 2, p.length / 2
    turns = np.linspace(0, math.pi, 19)
    arch = min(w, 0.9 * h)
    outline = np.vstack(
        [
            np.column_stack([w * np.cos(turns), h - arch + arch * np.sin(turns)]),
            [(-w, y) for y in np.linspace(h - arch, -0.9 * h, 6)[1:]],
            [(-0.9 * w, -h), (0.0, -h), (0.9 * w, -h)],
            [(w, y) for y in np.linspace(-0.9 * h, h - arch, 6)[:-1]],
        ]
    )
    profile = ((0, 0), (0.78, 0), (0.94, 0.12), (1, 0.5), (0.94, 0.88), (0.78, 1), (0, 1))
    body = food.dome(outline, profile, p.height, 13)
    body = food.seen_from_above(replace(body, points=food.flat_foot(bumped(body.points, 0.008, 2.0, rng), 0.02)))
    corners = [(-0.005, -h - p.stick), (0.005, -h - p.stick), (0.005, -0.6 * h), (-0.005, -0.6 * h)]
    stick = prism(np.array(corners), 0.0022, 0.0004).translated(z=p.height / 2)
    parts: list[Part] = [(body, p.skin), (food.plain(stick), p.stick_finish)]
    parts = [(s.rotated("z", math.pi / 2), f) for s, f in parts]
    return Composed(parts, [[parts[0][0]], [parts[1][0]]], [])


def _nigiri(p: Stacked, rng: np.random.Generator) -> Composed:
    """A roll of rice under a slice that bends over its ends, with or without a band of seaweed."""
    profile = ((0, 0), (0.55, 0.01), (0.88, 0.07), (1, 0.22), (1, 0.5), (1, 0.78), (0.88, 0.93), (0.55, 0.99), (0, 1))
    size = (0.88 * p.length, 0.86 * p.width, (0.7 * p.height))
    rice = food.long_body(profile, *size, square=3.0, square_top=2.4, along=23, around=24)
    rice = replace(rice, points=food.flat_foot(bumped(rice.points, 0.03, 4.0, rng), 0.05))
    top = float(rice.points[:, 2].max())
    s, t = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 11), indexing="ij")
    x, y = 0.5 * p.length * s + 0.03 * p.width * t, 0.5 * p.width * t * (1.0 - 0.12 * np.abs(s) ** 4 - 0.06 * s)
    z = top + 0.14 * p.height - 0.3 * p.height * np.abs(s) ** 3 - 0.3 * p.height * np.abs(t) ** 2.6
    z += 0.01 * p.height * food.smooth_noise(np.stack([x.ravel(), y.ravel()], axis=1), 60.0, rng).reshape(z.shape)
    slice_ = sheet(np.stack([x, y, z], axis=2), 0.3 * p.height * (1 - 0.3 * np.abs(t)))
    parts: list[Part] = [(rice, p.second), (slice_, p.meat)]
    if p.band:
        strip = ((0, 0), (0.98, 0.001), (1, 0.1), (1, 0.9), (0.98, 0.999), (0, 1))
        size = (0.011, 1.02 * p.width, 1.04 * p.height)
        band = food.long_body(strip, *size, square=3.5, square_top=2.6, along=9, around=32)
        # The band runs below the rice, or their undersides would lie in one plane.
        floor, roof = float(rice.points[:, 2].min()) - 0.0004, float(slice_.points[:, 2].max()) + 0.0006
        span = np.ptp(band.points[:, 2])
        points = band.points.copy()
        points[:, 2] = floor + (points[:, 2] - points[:, 2].min()) / span * (roof - floor)
        parts.append((food.plain(replace(band, points=points)), p.skin))
    return Composed(parts, [[s for s, _ in parts]], [])


def _maki(p: Stacked, rng: np.random.Generator) -> Composed:
    rim = ((0, 0), (0.93, 0), (0.99, 0.04), (1, 0.3), (1, 0.7), (0.99, 0.96), (0.93, 1), (0, 1))
    outline = food.superellipse(p.length, p.width, p.square, 40)
    outer = food.dome(outline, rim, p.height)
    rice = food.dome(outline * 0.92, rim, p.height + 0.0016).translated(z=-0.0008)
    parts: list[Part] = [(replace(outer, points=bumped(outer.points, 0.01, 2.0, rng)), p.skin)]
    parts.append((rice, p.second))
    hearts = [f for f in (p.meat, p.third, p.topping_finish) if f][: p.count]
    light: list[Part] = []
    for k, finish in enumerate(hearts):
        turn = 2 * math.pi * k / len(hearts) + 0.5
        off = 0.0 if len(hearts) == 1 else 0.17 * p.length
        size = (0.42 if len(hearts) == 1 else 0.28) * p.length
        heart = food.dome(food.superellipse(size, 0.85 * size, 3.0, 20), rim, p.height + 0.003, 9).rotated("z", turn)
        light.append((food.plain(heart).translated(off * math.cos(turn), off * math.sin(turn), -0.0015), finish))
    solids = [s for s, _ in parts] + [s for s, _ in light]
    if p.topping_count:
        roe = food.strewn(rice, p.topping, p.topping_count, p.topping_size, rng, steep=0.9, sunk=0.2, apart=0.7)
        light += [(food.plain(s), p.third) for s in roe]
        solids += roe
    return Composed(parts, [solids], light)


_BUILDERS: dict[Build, Callable[[Stacked, np.random.Generator], Composed]] = {
    Build(maker.__name__.removeprefix("_")): maker
    for maker in (_tower, _bun, _shell, _skewer, _cake, _cup, _cone, _bar, _nigiri, _maki)
}
