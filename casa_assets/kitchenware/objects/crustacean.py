"""Lobsters: a shell, a tail of rings, claws, legs and feelers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, circle, tube
from casa_assets.kitchenware.objects.closed_surface import bumped, ellipsoid
from casa_assets.kitchenware.objects.food import dome, hull_of, joined, long_body, outline_curve, plain

Metres = Annotated[float, Field(gt=0, le=0.6)]
SHELL: tuple[Vec2, ...] = (
    (0, 0), (0.62, 0.01), (0.86, 0.1), (1, 0.35), (0.94, 0.62), (0.62, 0.86), (0.2, 0.98), (0, 1),
)  # fmt: skip
RING = ((0, 0), (0.9, 0.02), (0.96, 0.2), (1, 0.55), (0.99, 0.85), (0.9, 0.98), (0, 1))
FLAT = ((0, 0), (0.7, 0.04), (0.94, 0.25), (1, 0.5), (0.94, 0.75), (0.7, 0.96), (0, 1))
# A claw from above, its wrist at -x, and the same of the finger that moves; in shares of its length and width.
PALM = (
    *((-0.5, -0.1), (-0.3, -0.42), (0.0, -0.5), (0.28, -0.34), (0.5, -0.08)),
    *((0.3, 0.0), (0.06, 0.06), (-0.1, 0.3), (-0.36, 0.26), (-0.5, 0.1)),
)
FINGER = ((-0.12, 0.3), (0.05, 0.5), (0.3, 0.42), (0.48, 0.1), (0.3, 0.16), (0.1, 0.14))
FAN = ((-0.5, 0.0), (-0.1, -0.34), (0.3, -0.5), (0.5, -0.2), (0.5, 0.2), (0.3, 0.5), (-0.1, 0.34))


class Crustacean(Params):
    """Parameters of a lobster that lies along x, its head at +x; lengths in metres."""

    length: Metres = Field(description="from the end of the fan to the tip of the head, were the tail straight, m")
    width: Metres = Field(description="of the shell, m")
    height: Metres = Field(description="of the shell, m")
    tail: float = Field(0.52, ge=0.35, le=0.7, description="share of the length that is tail")
    rings: int = Field(6, ge=4, le=7, description="of the tail")
    curl: float = Field(0.1, ge=0, le=0.6, description="how far the tail bends down at its end, rad")
    claw: Metres = Field(description="length of the larger claw, m")
    claw_width: Metres = Field(description="of the larger claw, m")
    other_claw: float = Field(0.9, ge=0.6, le=1, description="size of the other claw by that")
    spread: float = Field(0.5, ge=0, le=1.2, description="angle between an arm and the axis, rad")
    gape: float = Field(0.1, ge=0, le=0.5, description="how far a claw is open, rad")
    feeler: Metres = Field(description="length of the long feelers, which lie back along the body, m")
    band: FinishId | None = Field(None, description="of a rubber band round each claw; None: no band")
    density: float = Field(900.0, ge=300, le=1400, description="kg/m^3")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    skin: FinishId
    limb_finish: FinishId = "dish_lobster"
    eye_finish: FinishId = "dish_eye"


def build(builder: AssetBuilder, p: Crustacean) -> None:
    """Build the asset: it rests on z = 0."""
    rng = p.rng()
    shell, tail, fan = _shell(p, rng), _tail(p), _fan(p)
    claws, limbs, bands = [], [*_legs(p), *_feelers(p, rng)], []
    larger = 1 if rng.random() < 0.5 else -1
    for side in (-1, 1):
        claw, arm, band = _claw(p, side, 1.0 if side == larger else p.other_claw)
        claws.append(claw)
        limbs.append(arm)
        bands.append(band)
    low = min(float(s.points[:, 2].min()) for s in (shell, *tail, *fan, *claws))
    # Legs and feelers reach the ground and not below it.
    limbs = [replace(s, points=np.column_stack([s.points[:, :2], np.maximum(s.points[:, 2], low)])) for s in limbs]
    hulls = [hull_of(shell), hull_of(*tail[: p.rings // 2 + 1]), hull_of(*tail[p.rings // 2 :], *fan)]
    body = joined([shell, *tail]).translated(z=-low).with_colliders_of(*(h.translated(z=-low) for h in hulls))
    builder.add(ROOT, body, p.skin, label="body", name="body", density=p.density)
    for parts, finish, label in ((fan, p.limb_finish, "fan"), (limbs, p.limb_finish, "limb")):
        builder.add(ROOT, joined([plain(s) for s in parts]).translated(z=-low), finish, label=label, collider=False)
    for touched in (limbs[:4], limbs[4:8], limbs[-2:-1], limbs[-1:]):
        builder.add_collider(ROOT, hull_of(*touched).translated(z=-low), p.limb_finish, "limb")
    for claw in claws:
        solid = plain(claw).translated(z=-low)
        builder.add(ROOT, solid.with_hull_collider(), p.limb_finish, label="claw", density=p.density)
    if p.band is not None:
        builder.add(ROOT, joined(bands).translated(z=-low), p.band, label="band", collider=False)
    head = p.length * (1 - p.tail)
    eye = ellipsoid((0.07 * p.width,) * 3, 10, 7)
    eyes = [eye.translated(0.86 * head, side * 0.22 * p.width, 0.68 * p.height - low) for side in (-1, 1)]
    builder.add(ROOT, joined(eyes), p.eye_finish, label="eye", collider=False, density=0.0)


def _shell(p: Crustacean, rng: np.random.Generator) -> Solid:
    """The shell of head and breast, from x = 0 to the tip of the head, its axis at half its height."""
    long = p.length * (1 - p.tail)
    body = long_body(SHELL, long, p.width, p.height, square=2.4, foot=0.75, around=22, along=17)
    return replace(body, points=bumped(body.points, 0.015, 3.0, rng)).translated(long / 2, 0.0, p.height / 2)


def _on_tail(p: Crustacean, points: Floats) -> Floats:
    """Points about x = 0 .. -length of the tail bent down along it."""
    long = p.length * p.tail
    drop = 0.5 * p.curl * long * np.clip(-points[:, 0] / long, 0.0, 1.2) ** 2 * 0.6
    return np.column_stack([points[:, :2], points[:, 2] - np.minimum(drop, 0.2 * p.height)])


def _tail(p: Crustacean) -> list[Solid]:
    long = 0.8 * p.length * p.tail
    out = []
    for k in range(p.rings):
        t = k / p.rings
        size = 0.94 - 0.4 * t
        wide, high = size * p.width, size * 0.9 * p.height
        ring = long_body(RING, 1.35 * long / p.rings, wide, high, square=2.3, foot=0.7, along=9, around=16)
        ring = ring.translated(-(k + 0.5) / p.rings * long, 0.0, (0.42 - 0.06 * t) * p.height)
        out.append(replace(ring, points=_on_tail(p, ring.points)))
    return out


def _fan(p: Crustacean) -> list[Solid]:
    long = p.length * p.tail
    out = []
    for k, turn in enumerate((-0.75, 0.75, -0.38, 0.38, 0.0)):
        lobe = dome(outline_curve(FAN, 0.3 * long, 0.42 * p.width, 16), FLAT, 0.006, 6).translated(x=0.13 * long)
        lobe = lobe.rotated("z", math.pi + turn).translated(-0.74 * long, 0.0, 0.2 * p.height + 0.002 * k)
        out.append(replace(lobe, points=_on_tail(p, lobe.points)))
    return out


def _claw(p: Crustacean, side: int, size: float) -> tuple[Solid, Solid, Solid]:
    long, wide = p.claw * size, p.claw_width * size
    thick = 0.5 * wide
    palm = dome(outline_curve(PALM, long, 0.8 * wide, 30), FLAT, thick, 9).translated(y=-0.1 * wide)
    finger = dome(outline_curve(FINGER, 0.6 * long, 0.36 * wide, 18), FLAT, 0.7 * thick, 7)
    finger = finger.translated(0.18 * long, 0.3 * wide, 0.15 * thick)
    finger = finger.rotated("z", p.gape, (-0.1 * long, 0.3 * wide, 0.0))
    claw = joined([plain(palm), plain(finger)])
    if side < 0:
        claw = claw.mirrored_x().rotated("z", math.pi)
    head = p.length * (1 - p.tail)
    elbow = np.array([0.95 * head, side * (0.5 * p.width + 0.2 * long * (0.4 + p.spread)), 0.3 * p.height])
    wrist = np.array([head + 0.15 * long, side * (0.5 * p.width + 0.35 * long * (0.3 + p.spread)), 0.28 * p.height])
    turn = side * p.spread * 0.35
    way = np.array([math.cos(turn), math.sin(turn), 0.0])
    middle = wrist + 0.48 * long * way
    claw = claw.rotated("z", turn).translated(float(middle[0]), float(middle[1]), 0.28 * p.height - 0.5 * thick)
    shoulder = (0.62 * head, side * 0.3 * p.width, 0.35 * p.height)
    path = [shoulder, *((float(x), float(y), float(z)) for x, y, z in (elbow, wrist))]
    arm = tube(path, circle(0.15 * wide, 8), 0.2 * wide).without_colliders()
    x, y, _ = (float(v) for v in middle + 0.06 * long * way)
    turns = np.linspace(0.0, 2 * np.pi, 22, endpoint=False)
    loop = np.column_stack([0 * turns, 0.45 * wide * np.cos(turns), 0.54 * thick * np.sin(turns)])
    c, s = math.cos(turn), math.sin(turn)
    loop = np.column_stack([x - s * loop[:, 1], y + c * loop[:, 1], 0.28 * p.height + loop[:, 2]])
    loop = np.vstack([loop, loop[:2]])
    return claw, arm, tube([(float(a), float(b), float(d)) for a, b, d in loop], circle(0.0035, 6)).without_colliders()


def _legs(p: Crustacean) -> list[Solid]:
    head = p.length * (1 - p.tail)
    out = []
    for side in (-1, 1):
        for k in range(4):
            x, sweep = head * (0.6 - 0.13 * k), 0.25 - 0.22 * k
            knee = (x + 0.5 * sweep * p.width, side * 0.85 * p.width, 0.42 * p.height)
            foot = (x + 1.1 * sweep * p.width, side * 1.3 * p.width, 0.05 * p.height)
            hip = (x, side * 0.35 * p.width, 0.3 * p.height)
            out.append(tube([hip, knee, foot], circle(0.045 * p.width, 6), 0.06 * p.width).without_colliders())
    return out


def _feelers(p: Crustacean, rng: np.random.Generator) -> list[Solid]:
    head = p.length * (1 - p.tail)
    out = []
    for side in (-1, 1):
        out_by = side * (0.75 + float(rng.uniform(0.0, 0.4))) * p.width
        start = (0.9 * head, side * 0.14 * p.width, 0.55 * p.height)
        path = [start, (1.12 * head, 0.4 * out_by, 0.75 * p.height), (head, out_by, 0.8 * p.height)]
        path.append((head - p.feeler, 1.15 * out_by, 0.35 * p.height))
        out.append(tube(path, circle(0.02 * p.width, 5), 0.2 * p.width))
        out.append(tube([start, (1.15 * head, side * 0.3 * p.width, 0.7 * p.height)], circle(0.015 * p.width, 5)))
    return [feeler.without_colliders() for feeler in out]
