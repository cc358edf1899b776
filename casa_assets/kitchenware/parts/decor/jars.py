"""Jars of glass or clay with what is in them, and leaves on stems."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.arrays import Floats
from casa_assets.ext.records import Vec2
from casa_assets.ext.solids import Solid, ball, circle, lathe, prism, rod, tube

# Leaves ---------------------------------------------------------------------------------------------------------------
# Thin curved solids on a stem.

LEAF_THICKNESS = 0.0012  # metres; a succulent's is thicker
GOLDEN_ANGLE = 2.399963  # rad from one leaf to the next. Ref: phyllotaxis.


def leaf(
    length: float,
    width: float,
    *,
    droop: float = 0.6,
    fold: float = 0.25,
    tip: float = 1.0,
    thickness: float = LEAF_THICKNESS,
    steps: int = 7,
) -> Solid:
    """A leaf that starts at the origin along +y and bends down towards its end; without collider.

    Args:
        length, width: metres. droop: rad that it bends over its length. fold: rise of its sides over half the width.
        tip: how pointed it is; 0.5 is round, 2 is a lance. thickness: in its middle.
    """
    s = np.linspace(0.0, 1.0, steps + 1)
    half = width / 2 * np.maximum(np.sin(np.pi * s**0.8) ** (0.5 + 0.25 * tip), 0.04)
    half[-1] = 0.02 * width
    angle = droop * s
    step = length / steps
    y = np.concatenate([[0.0], np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2))]) * step
    z = -np.concatenate([[0.0], np.cumsum(np.sin((angle[1:] + angle[:-1]) / 2))]) * step
    across = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    top = np.array(
        [[(a * h, yy, zz + fold * abs(a) * h) for a in across] for h, yy, zz in zip(half, y, z, strict=True)]
    )
    body = thickness * (1 - 0.7 * np.abs(across))[None, :] * np.sin(np.pi * np.clip(s, 0.06, 0.94))[:, None]
    underside = top.copy()
    underside[..., 2] -= body + 0.0003
    return _sheet(top, underside)


def _sheet(top: Floats, underside: Floats) -> Solid:
    """A closed solid between two (N, M, 3) grids."""
    n, m = top.shape[:2]
    points = np.concatenate([top.reshape(-1, 3), underside.reshape(-1, 3)])
    faces = []
    offset = n * m
    for i in range(n - 1):
        for j in range(m - 1):
            a, b, c, d = i * m + j, i * m + j + 1, (i + 1) * m + j + 1, (i + 1) * m + j
            faces += [(a, b, c), (a, c, d), (offset + a, offset + c, offset + b), (offset + a, offset + d, offset + c)]
    rim = [(0, j) for j in range(m)] + [(i, m - 1) for i in range(1, n)]
    rim += [(n - 1, j) for j in range(m - 2, -1, -1)] + [(i, 0) for i in range(n - 2, 0, -1)]
    for (i, j), (k, q) in zip(rim, [*rim[1:], rim[0]], strict=True):
        a, b = i * m + j, k * m + q
        faces += [(a, offset + a, offset + b), (a, offset + b, b)]
    return Solid(points, np.array(faces, dtype=np.int64), crease_deg=70.0).oriented_outwards()


def golden_angles(count: int) -> list[float]:
    """Angles at which leaves are arranged around a stem, rad."""
    return [k * GOLDEN_ANGLE % (2 * math.pi) for k in range(count)]


# Jars -----------------------------------------------------------------------------------------------------------------
# Jars of glass or clay with what is in them and a lid; bottles share their way of being filled.

SMALL_RADIUS = 0.03  # metres; a jar below this radius is drawn with fewer faces
CONTENT_GAP = 0.0006  # metres between glass and what is in it, so that neither flickers


class JarLid(StrEnum):
    """Closure of a jar."""

    FLAT = "flat"  # a disc that overlaps
    KNOB = "knob"  # a disc with a ball to lift it
    CORK = "cork"
    SCREW = "screw"  # a ribbed cap
    CLIP = "clip"  # a glass lid with a wire clip
    DOME = "dome"


@dataclass(frozen=True)
class JarSolids:
    """Solids of a jar about the z axis, from z = 0 up, by material."""

    body: Solid
    shell: Solid  # its outside alone: what is seen of glass, which has no need of a second face behind the first
    inside: Solid
    lid: tuple[Solid, ...]
    fittings: tuple[Solid, ...]  # wires, seals
    top: float  # of its lid


def vessel_wall(outer: list[Vec2], wall: float, floor: float, segments: int = 32) -> Solid:
    """A turned vessel: `outer` goes up from the foot to the mouth; its inside keeps `wall` away."""
    inner = [(max(0.001, r - wall), max(floor, z)) for r, z in outer if z >= floor]
    inner = [(outer[0][0] - wall, floor), *inner] if inner and inner[0][1] > floor + 1e-6 else inner
    return lathe([*outer, *inner[::-1]], segments, 45.0)


def vessel_content(outer: list[Vec2], wall: float, floor: float, share: float, segments: int = 32) -> Solid:
    """Content that fills such a vessel to a share of its height, with a small gap to its wall."""
    top = floor + CONTENT_GAP + share * (outer[-1][1] - floor)
    zs = sorted({floor + CONTENT_GAP, top, *(z for _, z in outer if floor + CONTENT_GAP < z < top)})
    inset = wall + CONTENT_GAP
    profile = [(float(np.interp(z, [q for _, q in outer], [r for r, _ in outer])) - inset, z) for z in zs]
    return lathe([(max(0.002, r), z) for r, z in profile], segments, 45.0)


def jar_profile(radius: float, height: float, shoulder: float, neck: float) -> list[Vec2]:
    """The outline of a jar: straight sides, a shoulder of a height, a neck of a share of its radius."""
    r, h = radius, height
    line = [(r - 0.004, 0.0), (r - 0.001, 0.0012), (r, 0.004), (r, h - shoulder - 0.012)]
    if neck < 1:
        for t in np.linspace(0.25, 1.0, 4):
            s = 0.5 - 0.5 * math.cos(math.pi * t)
            line.append((r * (1 - (1 - neck) * s), h - 0.012 - shoulder * (1 - t)))
    return [*line, (r * min(1.0, neck), h)]


def jar(
    radius: float,
    height: float,
    lid: JarLid,
    *,
    shoulder: float = 0.0,
    neck: float = 1.0,
    wall: float = 0.003,
    fill: float = 0.8,
) -> JarSolids:
    """A jar of a radius and a height without its lid, metres; `fill` is a share of its height."""
    outer = jar_profile(radius, height, shoulder, neck)
    segments = 24 if radius < SMALL_RADIUS else 32
    body = vessel_wall(outer, wall, wall * 1.4, segments)
    inside = vessel_content(outer, wall, wall * 1.4, fill, segments)
    solids, fittings, top = _lid(lid, radius * min(1.0, neck), height, wall)
    return JarSolids(body, lathe(outer, segments, 45.0), inside, tuple(solids), tuple(fittings), top)


def _lid(lid: JarLid, r: float, h: float, wall: float) -> tuple[list[Solid], list[Solid], float]:
    """Solids of a lid on a mouth of radius r at h, its fittings, and its top."""
    z = h + 0.0005
    if lid is JarLid.CORK:
        inside = r - wall - CONTENT_GAP
        cork = [(0.92 * inside, h - 0.014), (inside, h - 0.002), (r + 0.001, z), (r + 0.001, z + 0.014)]
        return [lathe(cork, 28)], [], z + 0.014
    if lid is JarLid.SCREW:
        height = max(0.012, min(0.02, 0.2 * h))
        ribs = 16 if r < SMALL_RADIUS else 24
        turns = np.linspace(0, 2 * np.pi, 4 * ribs + 1)[:-1]
        ring = r + 0.0022 + 0.0008 * np.cos(ribs * turns)
        outline = np.column_stack([ring * np.cos(turns), ring * np.sin(turns)])
        cap = prism(outline, height, 0.0012).translated(z=h - height + 0.003)
        return [cap], [], h + 0.003
    if lid is JarLid.DOME:
        curve = [(1.02 * r * math.cos(t), z + 0.42 * r * math.sin(t)) for t in np.linspace(0, math.pi / 2, 8)]
        knob = ball(max(0.006, 0.13 * r), 10).without_colliders().translated(z=z + 0.42 * r + 0.006)
        shell = lathe([(1.02 * r, z - 0.0002), *curve[1:]], 32, 60.0)
        return [shell, knob], [], z + 0.42 * r + 0.006 + max(0.006, 0.13 * r)
    thickness = 0.008 if lid is not JarLid.CLIP else 0.011
    disc = lathe(
        [(r, z), (1.03 * r, z + 0.0015), (1.03 * r, z + thickness - 0.002), (1.03 * r - 0.002, z + thickness)], 36
    )
    if lid is JarLid.FLAT:
        return [disc], [], z + thickness
    if lid is JarLid.KNOB:
        size = max(0.007, 0.2 * r)
        stem = rod(0.5 * size, size, 0.0005).without_colliders().translated(z=z + thickness + 0.4 * size)
        knob = ball(size, 12).without_colliders().translated(z=z + thickness + 1.3 * size)
        return [disc, stem, knob], [], z + thickness + 2.3 * size
    seal = lathe([(0.9 * r, h - 0.001), (1.045 * r, h - 0.0005), (1.045 * r, z + 0.0018), (0.9 * r, z + 0.002)], 36)
    return [disc], [seal, *_clip(r, h, z + thickness)], z + thickness + 0.002


def _clip(r: float, h: float, top: float) -> list[Solid]:
    """A band round the neck and a wire over the lid, with its lever at the front."""
    w = circle(0.0012, 6)
    band_z = h - 0.006
    band = [(1.02 * r * math.sin(t), 1.02 * r * math.cos(t), band_z) for t in np.linspace(0, 2 * math.pi, 33)]
    front, lid_z = -r - 0.0022, top + 0.001
    over = [(0.0, 1.06 * r, band_z), (0.0, 1.08 * r, lid_z), (0.0, front, lid_z), (0.0, front, band_z - 0.01)]
    lever_z, lever_y = band_z - 0.028, -r - 0.0026
    lever = [(-0.008, front, band_z), (-0.01, lever_y, lever_z), (0.01, lever_y, lever_z), (0.008, front, band_z)]
    return [
        tube(band, w).without_colliders(),
        tube(over, w, 0.006).without_colliders(),
        tube(lever, w, 0.006).without_colliders(),
    ]
