"""Kitchen tools that stand or hang."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import Solid, ball, box, circle, inset, lathe, loft, prism, rectangle, rod, tube
from casa_assets.kitchenware.fixtures.counters.wall_plates import upright_on_wall
from casa_assets.kitchenware.parts.hardware.handles import tapered_leg

# Tools ----------------------------------------------------------------------------------------------------------------
# Upright or hanging kitchen tools: the end of their handle at the origin, the working end up z.

# Kind of tool.
CrockTool = StrEnum("CrockTool", "SPOON SPATULA FORK TURNER LADLE WHISK")


def crock_tool(kind: CrockTool, size: float) -> list[Solid]:
    """The solids of a tool of a length in metres."""
    if kind in (CrockTool.SPOON, CrockTool.SPATULA, CrockTool.FORK):
        stem = tapered_leg((0, 0, 0), (0, 0, 0.74 * size), 0.0052, 0.0068, 12)
        return [stem, *_wooden_end(kind, size)]
    grip = tapered_leg((0, 0, 0), (0, 0, 0.36 * size), 0.0085, 0.0065, 12)
    rod_ = tapered_leg((0, 0, 0.359 * size), (0, 0, 0.76 * size), 0.0032, 0.0032, 10)
    if kind is CrockTool.TURNER:
        blade = box((0.078, 0.0018, 0.24 * size), (0, 0.006, 0.875 * size), 0.0006)
        return [grip, rod_, blade]
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
            z = 0.72 * size + 0.28 * size * (0.5 + 0.5 * math.cos(a)) ** 0.8
            path.append((w * math.cos(t), w * math.sin(t), z))
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
    neck = [(-0.008, base), (0.008, base), (0.026, end - 0.065), (-0.026, end - 0.065)]
    return [_plate(neck, 0.005), *tines]


def _plate(outline: list[Vec2], thickness: float) -> Solid:
    """An outline in x, z pulled through y."""
    points = np.array(outline)
    front = np.column_stack([points[:, 0], np.full(len(points), thickness / 2), points[:, 1]])
    back = front * np.array([1.0, -1.0, 1.0])
    return loft([front, back], 40.0)


# Hung tools -----------------------------------------------------------------------------------------------------------
# Kitchen tools that hang: their eye at the origin, the working end down -z, its hollow side to the front (-y).

EYE_RADIUS = 0.0075  # metres, radius of the eye that the hook goes through
NECK_RADIUS = 0.0032
SHEET_THICKNESS = 0.0016

# Kind of tool.
HungTool = StrEnum("HungTool", "LADLE TURNER WHISK SPOON SKIMMER MASHER FORK SCRAPER")


class ToolHandle(StrEnum):
    """Make of the handle."""

    TURNED = "turned"  # round, of wood or plastic, with a ferrule
    FLAT = "flat"  # a strip of steel with a hole
    ROUND = "round"  # a steel tube


@dataclass(frozen=True)
class ToolSolids:
    """A tool: what the hand holds, and the rest of it."""

    grip: tuple[Solid, ...]
    metal: tuple[Solid, ...]
    head: tuple[Solid, ...]


def hung_tool(kind: HungTool, grip: ToolHandle, size: float) -> ToolSolids:
    """A tool of a length in metres, without collider."""
    end = 0.42 * size
    grips, metal = _handle(grip, end)
    metal += [_eye()] if grip is not ToolHandle.FLAT else []
    neck = (0.12 if kind is HungTool.WHISK else 0.3) * size
    z = -end - neck
    metal.append(tube([(0, 0, -end + 0.012), (0, 0, z)], NECK_RADIUS))
    head = _HEADS[kind](z, size - end - neck)
    return ToolSolids(tuple(grips), tuple(metal), tuple(replace(s, shapes=()) for s in head))


def _eye() -> Solid:
    ring = [
        (EYE_RADIUS * math.sin(t), 0.0, -EYE_RADIUS + EYE_RADIUS * math.cos(t)) for t in np.linspace(0, 2 * math.pi, 17)
    ]
    return tube(ring, circle(0.0014, 6))


def _handle(grip: ToolHandle, end: float) -> tuple[list[Solid], list[Solid]]:
    """Solids of the handle's own finish, and those of metal; it starts below the eye."""
    top = -2 * EYE_RADIUS - 0.001
    if grip is ToolHandle.TURNED:
        line = [(0.0045, -end), (0.0068, -end + 0.004), (0.0062, -end + 0.03), (0.0088, -0.45 * end)]
        line += [(0.0082, top - 0.012), (0.006, top - 0.002), (0.003, top)]
        ferrule = lathe([(0.0055, -end - 0.014), (0.0072, -end - 0.012), (0.0072, -end + 0.006), (0.005, -end + 0.007)])
        return [lathe(line, 16, 50.0)], [ferrule, rod(0.0022, 0.012, 0.0006).translated(z=top + 0.0025)]
    if grip is ToolHandle.ROUND:
        return [rod(0.0072, end + top, 0.003).translated(z=(top - end) / 2)], [
            rod(0.002, 0.01, 0.0005).translated(z=top + 0.002)
        ]
    half_width = 0.0095
    arc = [(half_width * math.cos(t), half_width * math.sin(t) - EYE_RADIUS) for t in np.linspace(0, math.pi, 11)]
    outline = np.array([*arc, (-0.0065, -end), (0.0065, -end)])
    hole = circle(0.0055, 14) + np.array([0.0, -EYE_RADIUS + 0.002])
    return [upright_on_wall(prism(outline, 0.0026, 0.0006, [hole])).translated(y=0.0013)], []


def _shell(width: float, length: float, depth: float) -> Solid:
    """A shallow bowl, open to the front (-y), its longer way along z, about its mouth's middle."""
    turns = np.linspace(0.0, math.pi / 2, 8)
    outer = [(math.sin(t), -math.cos(t)) for t in turns]
    inner = [(0.96 * math.sin(t), -0.93 * math.cos(t)) for t in turns[::-1]]
    solid = lathe([*outer, *inner], 32, 60.0)
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
    outline = np.array(
        [(-0.008, top), (-0.034, z - 0.03), (-0.04, bottom), (0.04, bottom), (0.034, z - 0.03), (0.008, top)]
    )
    slots = [
        rectangle(0.006, 0.55 * length, 0.0028, 3) + np.array([x, z - 0.56 * length])
        for x in (-0.021, -0.007, 0.007, 0.021)
    ]
    return [upright_on_wall(prism(outline, SHEET_THICKNESS, 0.0003, slots)).rotated("x", 0.12, (0, 0, z))]


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
    disc = upright_on_wall(prism(circle(r, 36), SHEET_THICKNESS, 0.0003, holes))
    rim = [(r * math.sin(t), 0.0, r * math.cos(t)) for t in np.linspace(0, 2 * math.pi, 37)]
    return [s.translated(0, 0.0, z - r + 0.002) for s in (disc, tube(rim, circle(0.0018, 6)))]


def _masher(z: float, length: float) -> list[Solid]:
    w, bottom = 0.042, z - length + 0.003
    fork = [
        (-w, 0.0, bottom),
        (-w, 0.0, bottom + 0.03),
        (-0.004, 0.0, z),
        (0.004, 0.0, z),
        (w, 0.0, bottom + 0.03),
        (w, 0.0, bottom),
    ]
    wave = [
        (float(x), 0.022 * (1 if k % 2 else -1), bottom) for k, x in enumerate(np.linspace(-w + 0.006, w - 0.006, 8))
    ]
    return [tube(fork, 0.0026, 0.012), tube([(-w, 0.0, bottom), *wave, (w, 0.0, bottom)], 0.0026, 0.007)]


def _fork(z: float, length: float) -> list[Solid]:
    out = [box((0.034, 0.003, 0.012), (0, 0, z - 0.004), 0.0014, 2)]
    for x in (-0.0145, 0.0145):
        out.append(tapered_leg((x, 0, z - length), (x, 0, z - 0.004), 0.0006, 0.0026, 10))
    return out


def _scraper(z: float, length: float) -> list[Solid]:
    shape = rectangle(0.056, length, 0.018, 6) + np.array([0.0, z - length / 2 + 0.002])
    thin = upright_on_wall(prism(inset(shape, 0.0), 0.008, 0.003)).translated(y=0.004)
    return [thin, ball(0.005, 8).translated(0, 0, z)]


_HEADS = {
    HungTool.LADLE: _ladle,
    HungTool.TURNER: _turner,
    HungTool.WHISK: _whisk,
    HungTool.SPOON: _spoon,
    HungTool.SKIMMER: _skimmer,
    HungTool.MASHER: _masher,
    HungTool.FORK: _fork,
    HungTool.SCRAPER: _scraper,
}
