"""Jars of blenders with blades at their floor and a handle, and the covers that lie on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    Placed,
    Solid,
    board,
    box,
    circle,
    lathe,
    loft,
    rectangle,
    rod,
    tube,
)
from casa_assets.kitchenware.parts.counter_parts import round_wall_pieces

WALL_THICKNESS = 0.004  # metres
LIP_HEIGHT = 0.008
UNDER_LID = 0.0005  # how far the long pieces of the wall end below the mouth
# The glass begins so far above what the jar stands on: the collar is below it; metres.
COLLAR, RAISED = 0.026, 0.0252
# How far the plug of a lid reaches into the jar, its play there, how much wider the cover is than the jar; metres.
PLUG_DEPTH, PLUG_PLAY, OVERHANG = 0.008, 0.003, 0.001

BlenderJar = StrEnum("BlenderJar", "ROUND SQUARE CLOVER")

# Least half width of a jar like a clover, as a share of its half width.
WAIST = 0.9


@dataclass(frozen=True)
class Jar:
    """A jar; lengths in metres.

    form: its section. height: of the glass. top, foot: half width at the mouth and at the foot. grip, glass: finishes
    of collar and handle, and of the jar. reach, low: how far the handle projects, and the height of its lower end
    relative to that of the glass. edge_in_front: an edge between two collision shapes of a round wall faces the front,
    so that their bounding box is that of the wall.
    """

    form: BlenderJar
    height: float
    top: float
    foot: float
    grip: str
    glass: str
    reach: float = 0.045
    low: float = 0.2
    edge_in_front: bool = False

    @property
    def rim(self) -> float:
        """Height of the mouth above the surface that the jar rests on, metres."""
        return COLLAR + self.height


@dataclass(frozen=True)
class Cover:
    """A lid of a jar; lengths in metres.

    form, top: section of the jar, and half width of its mouth. thickness: of the cover. cap_radius, cap_height: of the
    filler cap that it is held by. grip, cap: finishes of cover and filler cap. cap_name: of the filler cap's collider.
    """

    form: BlenderJar
    top: float
    thickness: float
    cap_radius: float
    cap_height: float
    grip: str
    cap: str
    cap_name: str = "handle_main"


def jar_outline(jar: BlenderJar, half: float, z: float) -> np.ndarray:
    """(N, 3) outline of a jar of a half width at a height, metres."""
    if jar is BlenderJar.ROUND:
        flat = circle(half, 44)
    elif jar is BlenderJar.SQUARE:
        flat = rectangle(2 * half, 2 * half, 0.38 * half, 6)
    else:
        turns = np.arange(48) * 2 * np.pi / 48
        radius = half * (1.0 - 0.05 * (1 - np.cos(4 * turns)))
        flat = np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=1)
    return np.column_stack([flat, np.full(len(flat), z)])


def _jar_walls(p: Jar, width: float, foot: Vec2, rim: Vec2) -> list[Placed]:
    """Convex pieces of a jar's wall.

    width: least radius of the inside, as a share of the radius. foot, rim: radius and height, metres.
    """
    is_square = p.form is BlenderJar.SQUARE
    count = 4 if is_square else 12
    grow = math.sqrt(2.0) if is_square else 1.0
    first = 0.0 if p.edge_in_front and not is_square else math.pi / count
    lip = rim[0] - (rim[0] - foot[0]) * LIP_HEIGHT / (rim[1] - foot[1])
    profile = [foot, (lip, rim[1] - LIP_HEIGHT), rim, (rim[0], rim[1] - UNDER_LID)]
    walls, edge = (
        round_wall_pieces(
            [(width * r - WALL_THICKNESS, z) for r, z in stretch], [(grow * r, z) for r, z in stretch], count, first
        )
        for stretch in (profile[::3], profile[1:3])
    )
    # The lid lies on short pieces at the edge alone: boxes that stand for them in the light form end where they do, and
    # the long pieces, which end a little lower, have no contacts with it.
    return [*walls, *(edge[:: count // 4] if count > 4 else edge)]


def add_jar(builder: AssetBuilder, p: Jar, rest: float) -> None:
    """Add collar, jar with an open mouth, blades, and their colliders, about the z axis, from height `rest` up."""
    r0, r1, low, rim = p.foot, p.top, rest + 0.0004, rest + p.rim
    collar = lathe(
        [
            (r0 + 0.012, low), (r0 + 0.014, low + 0.002), (r0 + 0.01, low + 0.018), (r0 + 0.006, low + 0.024),
            (r0 - 0.01, low + 0.0245),
],
        44,
    )  # fmt: skip
    builder.add(ROOT, collar.with_hull_collider(), p.grip, "collar", density="blender_collar")
    floor = rest + 0.034
    base = rest + RAISED
    shares = np.linspace(0.0, 1.0, 6)
    outer = [(r0 + (r1 - r0) * float(s) ** 0.8, base + float(s) * (rim - base)) for s in shares]
    inner = [(r - WALL_THICKNESS, max(z, floor)) for r, z in outer][::-1]
    rings = [
        jar_outline(p.form, r, z)
        for r, z in [(r0 - 0.004, base), (r0, base + 0.003), *outer[1:], *inner, (inner[-1][0] - 0.008, floor - 1e-4)]
    ]
    rings.insert(len(outer) + 1, jar_outline(p.form, r1 + 0.0025, rim))
    skin = loft(rings, 50.0)
    width = WAIST if p.form is BlenderJar.CLOVER else 1.0
    walls = _jar_walls(p, width, (r0, base), (r1, rim))
    metal = not p.glass.startswith(("glass", "plastic"))
    density = {"glass": "glass", "plastic": "blender_plastic_jar"}.get(p.glass.split("_")[0], "blender_steel_jar")
    builder.add(ROOT, Solid(skin.points, skin.faces, tuple(walls), crease_deg=50.0), p.glass, "jar", density=density)
    disc = rod(r0 - 0.001, floor - base, 0.0).translated(z=(floor + base) / 2)
    builder.add_collider(ROOT, disc, p.glass, "jar", "jar_bottom")
    line = [(0.6 * r0, floor + 3e-4), (0.5 * r0, floor + 0.002), (0.2 * r0, floor + 0.003), (0.0, floor + 0.0032)]
    builder.draw(ROOT, lathe(line, 28), "stainless_polished", "blades")
    for k in range(4):
        blade = box((0.024, 0.009, 0.0014), (0.013, 0.0, 0.0), 0.0005).rotated("y", -0.35 if k % 2 else 0.1)
        turned = blade.rotated("z", k * math.pi / 2).translated(0.0, 0.0, floor + 0.0075)
        builder.draw(ROOT, turned, "stainless_polished", "blades", name="blades")
    hub = rod(0.0045, 0.008, 0.001).translated(0.0, 0.0, floor + 0.007)
    builder.draw(ROOT, hub, "stainless_polished", "blades", name="blades")
    builder.round_region("int", (0.0, 0.0, floor), 2 * (width * r0 - WALL_THICKNESS), rim - floor - 0.012)
    for k in range(0 if metal else 5):
        s = 0.25 + 0.14 * k
        r = (r0 + (r1 - r0) * s**0.8) * (0.9 if p.form is BlenderJar.CLOVER else 1.0)
        mark = box((0.02 if k % 2 else 0.012, 0.0006, 0.0012), (0.0, -r - 2e-4, base + s * (rim - base)), 0.0)
        builder.draw(ROOT, mark, "plastic_white", "scale", density=0.0)


def add_jar_handle(builder: AssetBuilder, p: Jar, rest: float) -> None:
    """Add a loop on the right side of a jar whose bottom is at height `rest`."""
    rim = rest + p.rim
    base = rest + RAISED
    low, high = base + p.low * (rim - base), rim - 0.024

    def at(z: float) -> float:
        return float(p.foot + (p.top - p.foot) * ((z - base) / (rim - base)) ** 0.8)

    far = p.top + p.reach
    path: list[Vec3] = [
        (at(high) - 0.002, 0.0, high),
        (far, 0.0, high),
        (far - 0.012, 0.0, low),
        (at(low) - 0.002, 0.0, low),
    ]
    bow = tube(path, rectangle(0.016, 0.026, 0.007, 4), 0.016, up=(0.0, 1.0, 0.0))
    builder.add(ROOT, bow, p.grip, "handle", collider="handle_main", density="hollow_moulding")


def add_cover(builder: AssetBuilder, p: Cover, link: str = ROOT) -> None:
    """Add a cover to a link, in whose frame the jar's mouth is z = 0 and its axis x = y = 0."""
    half, t = p.top + OVERHANG, p.thickness
    rings = [(half - 0.002, 0.0), (half, 0.002), (half, t - 0.004), (half - 0.004, t), (0.55 * half, t + 0.0012)]
    cover = loft([jar_outline(p.form, r, z) for r, z in rings], 50.0)
    square = p.form is BlenderJar.SQUARE
    shape = board((-half, -half, 0.0), (half, half, t), 0.0) if square else rod(half, t, 0.0).translated(z=t / 2)
    builder.add(link, cover.with_colliders_of(shape), p.grip, "lid", collider="lid_main", density="blender_lid")
    inside = (WAIST if p.form is BlenderJar.CLOVER else 1.0) * p.top - WALL_THICKNESS - PLUG_PLAY
    plug = rod(inside, PLUG_DEPTH + 0.001, 0.002).translated(z=(0.001 - PLUG_DEPTH) / 2)
    builder.add(link, plug, p.grip, "lid", collider="lid_plug", density="blender_lid")
    r, foot, top = p.cap_radius, t + 0.0005, t + p.cap_height
    cap = lathe([(r, foot), (r, top - 0.003), (r - 0.003, top)], 32)
    builder.add(link, cap.with_hull_collider(), p.cap, "handle", collider=p.cap_name, density="blender_lid")
