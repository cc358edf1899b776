"""Jars of glass or clay with what is in them, leaves on stems, and kitchen tools that stand or hang."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import Solid, ball, box, circle, inset, lathe, loft, prism, rectangle, rod, tube
from casa_assets.kitchenware.parts.handles import on_circle, tapered_leg

LEAF_THICKNESS = 0.0012  # metres; a succulent's is thicker
GOLDEN_ANGLE = 2.399963  # rad from one leaf to the next. Ref: phyllotaxis.

SMALL_RADIUS = 0.03  # metres; a jar below this radius is drawn with fewer faces
CONTENT_GAP = 0.0006  # metres between glass and what is in it, so that neither flickers

# Closure of a jar: FLAT a disc that overlaps; KNOB a disc with a ball to lift it; SCREW a ribbed cap; CLIP a glass lid
# with a wire clip.
JarLid = StrEnum("JarLid", "FLAT KNOB CORK SCREW CLIP DOME")

CrockTool = StrEnum("CrockTool", "SPOON SPATULA FORK TURNER LADLE WHISK")

EYE_RADIUS = 0.0075  # metres, radius of the eye that the hook goes through
NECK_RADIUS = 0.0032
SHEET_THICKNESS = 0.0016

HungTool = StrEnum("HungTool", "LADLE TURNER WHISK SPOON SKIMMER MASHER FORK SCRAPER")

# Make of the handle: TURNED round, of wood or plastic, with a ferrule; FLAT a strip of steel with a hole; ROUND a steel
# tube.
ToolHandle = StrEnum("ToolHandle", "TURNED FLAT ROUND")


# Leaves ---------------------------------------------------------------------------------------------------------------


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

    length, width: metres. droop: rad that it bends over its length. fold: rise of its sides over half the width. tip:
    how pointed it is; 0.5 is round, 2 is a lance. thickness: in its middle.
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
    # The outline of a jar: straight sides, a shoulder of a height, a neck of a share of its radius.
    r, h = radius, height
    line = [(r - 0.004, 0.0), (r - 0.001, 0.0012), (r, 0.004), (r, h - shoulder - 0.012)]
    if neck < 1:
        for t in np.linspace(0.25, 1.0, 4):
            line.append((r * (1 - (1 - neck) * (0.5 - 0.5 * math.cos(math.pi * t))), h - 0.012 - shoulder * (1 - t)))
    outer = [*line, (r * min(1.0, neck), h)]
    segments = 24 if radius < SMALL_RADIUS else 32
    body = vessel_wall(outer, wall, wall * 1.4, segments)
    inside = vessel_content(outer, wall, wall * 1.4, fill, segments)
    solids, fittings, top = _lid(lid, radius * min(1.0, neck), height, wall)
    return JarSolids(body, lathe(outer, segments, 45.0), inside, tuple(solids), tuple(fittings), top)


def _lid(lid: JarLid, r: float, h: float, wall: float) -> tuple[list[Solid], list[Solid], float]:
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
        return [prism(outline, height, 0.0012).translated(z=h - height + 0.003)], [], h + 0.003
    if lid is JarLid.DOME:
        curve = [(1.02 * r * math.cos(t), z + 0.42 * r * math.sin(t)) for t in np.linspace(0, math.pi / 2, 8)]
        knob = ball(max(0.006, 0.13 * r), 10).without_colliders().translated(z=z + 0.42 * r + 0.006)
        shell = lathe([(1.02 * r, z - 0.0002), *curve[1:]], 32, 60.0)
        return [shell, knob], [], z + 0.42 * r + 0.006 + max(0.006, 0.13 * r)
    thickness = 0.008 if lid is not JarLid.CLIP else 0.011
    line = [(r, z), (1.03 * r, z + 0.0015), (1.03 * r, z + thickness - 0.002), (1.03 * r - 0.002, z + thickness)]
    disc = lathe(line, 36)
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


# Tools ----------------------------------------------------------------------------------------------------------------
# Upright or hanging kitchen tools: the end of their handle at the origin, the working end up z.


def crock_tool(kind: CrockTool, size: float) -> list[Solid]:
    """The solids of a tool of a length in metres."""
    if kind in (CrockTool.SPOON, CrockTool.SPATULA, CrockTool.FORK):
        return [tapered_leg((0, 0, 0), (0, 0, 0.74 * size), 0.0052, 0.0068, 12), *_wooden_end(kind, size)]
    grip = tapered_leg((0, 0, 0), (0, 0, 0.36 * size), 0.0085, 0.0065, 12)
    rod_ = tapered_leg((0, 0, 0.359 * size), (0, 0, 0.76 * size), 0.0032, 0.0032, 10)
    if kind is CrockTool.TURNER:
        return [grip, rod_, box((0.078, 0.0018, 0.24 * size), (0, 0.006, 0.875 * size), 0.0006)]
    if kind is CrockTool.LADLE:
        r = 0.042
        bowl = lathe([(0.002, -r), (0.6 * r, -0.8 * r), (r, 0.0), (r - 0.0014, 0.0), (0.58 * r, -0.77 * r)], 24, 60.0)
        return [grip, rod_, bowl.rotated("x", -0.5).translated(0, r * 0.8, 0.82 * size)]
    wires = []
    for k in range(5):
        t = math.pi * k / 5
        path = []
        for s in np.linspace(0, 1, 15):
            a = 2 * math.pi * (s - 0.5)
            w = 0.03 * math.sin(a)
            path.append(on_circle(w, t, (0.72 * size + 0.28 * size * (0.5 + 0.5 * math.cos(a)) ** 0.8)))
        wires.append(tube(path[1:-1], 0.0011).without_colliders())
    return [grip, rod_, *wires]


def _wooden_end(kind: CrockTool, size: float) -> list[Solid]:
    base, end = 0.73 * size, size
    if kind is CrockTool.SPOON:
        rings = []
        for s in np.linspace(0.0, 1.0, 9):
            w = 0.007 + 0.024 * math.sin(math.pi * min(1.0, 0.08 + 0.88 * s)) ** 0.7
            ring = circle(1.0, 16) * np.array([w, 0.0055])
            dip = 0.006 * math.sin(math.pi * s)
            z = base + (end - base) * s
            rings.append(np.column_stack([ring[:, 0], ring[:, 1] + dip * (1 - (ring[:, 0] / w) ** 2), np.full(16, z)]))
        return [loft(rings, 60.0)]
    flare = [(-0.008, base), (0.008, base), (0.03, end - 0.03), (0.03, end), (-0.03, end), (-0.03, end - 0.03)]
    if kind is CrockTool.SPATULA:
        return [_plate(flare, 0.005)]
    tines = [box((0.011, 0.005, 0.07), (x, 0, end - 0.035), 0.0015) for x in (-0.0205, 0.0, 0.0205)]
    return [_plate([(-0.008, base), (0.008, base), (0.026, end - 0.065), (-0.026, end - 0.065)], 0.005), *tines]


def _plate(outline: list[Vec2], thickness: float) -> Solid:
    points = np.array(outline)
    front = np.column_stack([points[:, 0], np.full(len(points), thickness / 2), points[:, 1]])
    return loft([front, (front * np.array([1.0, -1.0, 1.0]))], 40.0)


# Hung tools -----------------------------------------------------------------------------------------------------------
# Kitchen tools that hang: their eye at the origin, the working end down -z, its hollow side to the front (-y).


def hung_tool(kind: HungTool, grip: ToolHandle, size: float) -> tuple[list[Solid], list[Solid], list[Solid]]:
    """A tool of a length in metres: what the hand holds, its metal, and its head; these without colliders."""
    end = 0.42 * size
    grips, metal = _handle(grip, end)
    metal += [_eye()] if grip is not ToolHandle.FLAT else []
    neck = (0.12 if kind is HungTool.WHISK else 0.3) * size
    z = -end - neck
    metal.append(tube([(0, 0, -end + 0.012), (0, 0, z)], NECK_RADIUS))
    head = _HEADS[kind](z, size - end - neck)
    return grips, metal, [s.without_colliders() for s in head]


def _eye() -> Solid:
    turns = np.linspace(0, 2 * math.pi, 17)
    ring = [(EYE_RADIUS * math.sin(t), 0.0, -EYE_RADIUS + EYE_RADIUS * math.cos(t)) for t in turns]
    return tube(ring, circle(0.0014, 6))


def _handle(grip: ToolHandle, end: float) -> tuple[list[Solid], list[Solid]]:
    top = -2 * EYE_RADIUS - 0.001
    if grip is ToolHandle.TURNED:
        line = [(0.0045, -end), (0.0068, -end + 0.004), (0.0062, -end + 0.03), (0.0088, -0.45 * end)]
        line += [(0.0082, top - 0.012), (0.006, top - 0.002), (0.003, top)]
        ferrule = lathe([(0.0055, -end - 0.014), (0.0072, -end - 0.012), (0.0072, -end + 0.006), (0.005, -end + 0.007)])
        return [lathe(line, 16, 50.0)], [ferrule, rod(0.0022, 0.012, 0.0006).translated(z=top + 0.0025)]
    if grip is ToolHandle.ROUND:
        knob = rod(0.002, 0.01, 0.0005).translated(z=top + 0.002)
        return [rod(0.0072, end + top, 0.003).translated(z=(top - end) / 2)], [knob]
    half_width = 0.0095
    arc = [(half_width * math.cos(t), half_width * math.sin(t) - EYE_RADIUS) for t in np.linspace(0, math.pi, 11)]
    outline = np.array([*arc, (-0.0065, -end), (0.0065, -end)])
    hole = circle(0.0055, 14) + np.array([0.0, -EYE_RADIUS + 0.002])
    return [prism(outline, 0.0026, 0.0006, [hole]).rotated("x", math.pi / 2).translated(y=0.0013)], []


def _shell(width: float, length: float, depth: float) -> Solid:
    turns = np.linspace(0.0, math.pi / 2, 8)
    outer = [(math.sin(t), -math.cos(t)) for t in turns]
    solid = lathe([*outer, *([(0.96 * math.sin(t), -0.93 * math.cos(t)) for t in turns[::-1]])], 32, 60.0)
    scaled = solid.points * np.array([width / 2, length / 2, depth])
    return Solid(scaled, solid.faces, crease_deg=60.0).rotated("x", math.pi / 2)


def _ladle(z: float, length: float) -> list[Solid]:
    r = 0.041
    turns = np.linspace(0.05, math.pi / 2, 9)
    outer = [(r * math.sin(t), -r * math.cos(t)) for t in turns]
    inner = [((r - SHEET_THICKNESS) * math.sin(t), -(r - SHEET_THICKNESS) * math.cos(t)) for t in turns[::-1]]
    bowl = lathe([*outer, (r + 0.001, 0.001), *inner], 32, 60.0).rotated("x", 0.2)
    bottom = z - length + 1.02 * r
    shank = tube([(0, 0, z + 0.002), (0, 0, bottom - 0.01)], rectangle(0.011, 0.003, 0.001, 1), up=(0.0, 1.0, 0.0))
    return [bowl.translated(0, -r - 0.0015, bottom), shank]


def _turner(z: float, length: float) -> list[Solid]:
    top, bottom = z + 0.004, z - length
    points = [(-0.008, top), (-0.034, z - 0.03), (-0.04, bottom), (0.04, bottom), (0.034, z - 0.03), (0.008, top)]
    outline = np.array(points)
    slots = [
        rectangle(0.006, 0.55 * length, 0.0028, 3) + np.array([x, z - 0.56 * length])
        for x in (-0.021, -0.007, 0.007, 0.021)
    ]
    return [prism(outline, SHEET_THICKNESS, 0.0003, slots).rotated("x", math.pi / 2).rotated("x", 0.12, (0, 0, z))]


def _whisk(z: float, length: float) -> list[Solid]:
    out = [lathe([(0.003, z - 0.012), (0.0062, z - 0.008), (0.0062, z + 0.012), (0.004, z + 0.016)], 12)]
    for k in range(6):
        half_width, drop = 0.047 - 0.0018 * k, length - 0.006 - 0.0012 * k
        path: list[Vec3] = []
        for t in np.linspace(0.25, 2 * math.pi - 0.25, 25):  # a drop, its point up
            x = half_width * math.sin(t) * math.sin(t / 2) ** 1.6
            path.append((float(x), 0.0, z + 0.012 - (drop + 0.012) * 0.5 * (1 - math.cos(t))))
        out.append(tube(path, circle(0.001, 6)).rotated("z", math.pi * k / 6))
    return out


def _spoon(z: float, length: float) -> list[Solid]:
    shank = tube([(0, 0, z + 0.002), (0, 0.004, z - 0.016)], rectangle(0.012, 0.0028, 0.001, 1), up=(0.0, 1.0, 0.0))
    return [_shell(0.062, length - 0.004, 0.015).translated(0, -0.003, z - length / 2 - 0.004), shank]


def _skimmer(z: float, length: float) -> list[Solid]:
    r = min(0.052, 0.48 * length + 0.006)
    rings = [(0.0, 1)] + [(f * r, n) for f, n in ((0.25, 6), (0.5, 12), (0.75, 18))]
    holes = [
        circle(0.0032, 8) + away * np.array([math.cos(t), math.sin(t)])
        for away, n in rings
        for t in 2 * math.pi * np.arange(n) / n
    ]
    disc = prism(circle(r, 36), SHEET_THICKNESS, 0.0003, holes).rotated("x", math.pi / 2)
    rim = [(r * math.sin(t), 0.0, r * math.cos(t)) for t in np.linspace(0, 2 * math.pi, 37)]
    return [s.translated(0, 0.0, z - r + 0.002) for s in (disc, tube(rim, circle(0.0018, 6)))]


def _masher(z: float, length: float) -> list[Solid]:
    w, bottom = 0.042, z - length + 0.003
    fork = [
        (-w, 0.0, bottom), (-w, 0.0, bottom + 0.03), (-0.004, 0.0, z), (0.004, 0.0, z), (w, 0.0, bottom + 0.03),
        (w, 0.0, bottom),
    ]  # fmt: skip
    steps = enumerate(np.linspace(-w + 0.006, w - 0.006, 8))
    wave = [(float(x), 0.022 * (1 if k % 2 else -1), bottom) for k, x in steps]
    return [tube(fork, 0.0026, 0.012), tube([(-w, 0.0, bottom), *wave, (w, 0.0, bottom)], 0.0026, 0.007)]


def _fork(z: float, length: float) -> list[Solid]:
    out = [box((0.034, 0.003, 0.012), (0, 0, z - 0.004), 0.0014, 2)]
    for x in (-0.0145, 0.0145):
        out.append(tapered_leg((x, 0, z - length), (x, 0, z - 0.004), 0.0006, 0.0026, 10))
    return out


def _scraper(z: float, length: float) -> list[Solid]:
    shape = rectangle(0.056, length, 0.018, 6) + np.array([0.0, z - length / 2 + 0.002])
    thin = prism(inset(shape, 0.0), 0.008, 0.003).rotated("x", math.pi / 2).translated(y=0.004)
    return [thin, ball(0.005, 8).translated(0, 0, z)]


_HEADS = dict(zip(HungTool, (_ladle, _turner, _whisk, _spoon, _skimmer, _masher, _fork, _scraper), strict=True))
