"""Racks of ovens, baskets of dishwashers and turntables of microwave ovens."""

from __future__ import annotations

import math

from casa_assets.ext.records import Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, board, concatenate, lathe, rod
from casa_assets.kitchenware.parts.cases import tub_walls
from casa_assets.kitchenware.parts.handles import round_bar, wire

RACK_TRAVEL = 0.26  # metres that a rack comes out

WIRE_RADIUS, RIM_RADIUS = 0.0016, 0.0026  # metres; radius with its coat
TINE_HEIGHT = 0.05
TINE_PITCH = 0.095  # metres; closer rows hold no plates


def add_oven_rack(builder: AssetBuilder, name: str, lower: Vec3, upper: Vec3, liner: str, door: str) -> None:
    """A wire rack on ledges with the finish of the liner; its region rides on it."""
    (x0, y0, z), (x1, y1, top) = lower, upper
    for x in (x0 + 0.0008, x1 - 0.0088):
        builder.draw(ROOT, board((x, y0 + 0.02, z - 0.016), (x + 0.008, y1 - 0.01, z - 0.009), 0.001), liner, "ledge")
    builder.link(name, at=((x0 + x1) / 2, y0, z))
    half, depth, front = (x1 - x0) / 2 - 0.004, y1 - y0 - 0.014, 0.022
    for x in (-half + 0.004, half - 0.004):
        builder.draw(name, round_bar((x, front, 0.0), (x, depth, 0.0), 0.0036), "chrome", "rack")
    for y in (front + 0.004, depth - 0.004):
        builder.draw(name, round_bar((-half + 0.004, y, 0.0), (half - 0.004, y, 0.0), 0.0036), "chrome", "rack")
    count = 15
    for k in range(count):
        x = -half + 0.02 + (2 * half - 0.04) * k / (count - 1)
        builder.draw(name, round_bar((x, front + 0.004, 0.0035), (x, depth - 0.004, 0.0035), 0.0015), "chrome", "rack")
    plate = board((-half, front, -0.005), (half, depth, 0.005), 0.0)
    builder.add_collider(name, plate, "chrome", "rack", f"{name}_main")
    travel = min(RACK_TRAVEL, 0.6 * depth)
    builder.slide(f"{name}_joint", name, (0.0, 1.0, 0.0), (-travel, 0.0), f"{name}_main", start_n=6.0, behind=door)
    builder.region(name, (-half + 0.01, front + 0.01, 0.005), (half - 0.01, depth - 0.01, top - z), link=name)


def add_turntable(builder: AssetBuilder, lower: Vec3, upper: Vec3) -> None:
    """Add a glass tray on a hub and rollers to a cavity between two corners; its collider and region are `tray`."""
    x, y = (lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2
    radius = min(upper[0] - lower[0], upper[1] - lower[1], 0.36) / 2 - 0.012
    floor = lower[2] + 0.0006
    hub = lathe([(0.02, floor), (0.02, floor + 0.004), (0.012, floor + 0.0098)]).translated(x, y)
    builder.draw(ROOT, hub, "plastic_white", "hub")
    r = 0.62 * radius
    ring = lathe([(r - 0.004, 0.003), (r + 0.004, 0.003), (r + 0.004, 0.0085), (r - 0.004, 0.0085)], 40, closed=True)
    builder.draw(ROOT, ring.translated(x, y, floor), "plastic_white", "hub")
    for k in range(3):
        wheel = rod(0.0045, 0.008, 0.001, "x").translated(r, 0.0, floor + 0.0046)
        builder.draw(ROOT, wheel.rotated("z", 2 * math.pi * k / 3).translated(x, y), "plastic_white", "hub")
    z = floor + 0.0102
    rim = [(radius - 0.012, z), (radius, z + 0.003), (radius, z + 0.0066), (radius - 0.01, z + 0.0052)]
    dish = lathe([*rim, (0.0, z + 0.0052)]).translated(x, y)
    dish = dish.with_colliders_of(rod(radius, 0.0052, 0.0).translated(x, y, z + 0.0026))
    builder.add(ROOT, dish, "glass_clear", "tray", name="tray")
    builder.round_region("tray", (x, y, z + 0.0055), 2 * radius - 0.004, upper[2] - z - 0.03)


def add_dish_rack(
    builder: AssetBuilder, name: str, behind: str, lower: Vec3, upper: Vec3, finish: str, tines: int, travel: float
) -> None:
    """A basket between two corners, open on top; its link is `name`, its joint `<name>_joint`.

    lower, upper: metres; lower[1] is its front. travel: how far it slides out, metres. tines: rows that hold plates;
    fewer if they would be closer together than TINE_PITCH. finish: of the wire.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    half, depth, height = (x1 - x0) / 2, y1 - y0, z1 - z0
    builder.link(name, at=((x0 + x1) / 2, y0, z0))
    rows = min(tines, int(2 * half / TINE_PITCH))
    wires = [*_floor(half, depth), *_sides(half, depth, height), *_tines(half, depth, rows)]
    builder.draw(name, concatenate(wires), finish, "rack", density="coated_wire")
    t = 0.007
    inner = ((-half + t, t, 2 * RIM_RADIUS), (half - t, depth - t, height))
    walls = tub_walls(((-half, 0.0, -RIM_RADIUS), (half, depth, height)), inner)
    for corners, part in zip(walls, ("main", "front", "back", "left", "right"), strict=True):
        builder.add_collider(name, board(*corners, 0.0), finish, "rack", f"{name}_{part}")
    half_grip = 0.6 * half
    grip = rod(0.0055, 2 * half_grip, 0.002, "x").translated(0.0, -0.013, height - 0.006)
    builder.add(name, grip, "stainless_brushed", "handle", name=f"{name}_handle_main")
    for x in (-half_grip + 0.012, half_grip - 0.012):
        post = rod(0.0035, 0.014, 0.0005, "y").translated(x, -0.006, height - 0.006)
        builder.draw(name, post, "stainless_brushed", "handle")
    for x in (-half - 0.004, half + 0.004):
        for y in (0.2 * depth, 0.8 * depth):
            builder.draw(name, rod(0.013, 0.007, 0.0015, "x").translated(x, y, 0.004), "plastic_grey", "wheel")
    joint = f"{name}_joint"
    builder.slide(joint, name, (0.0, 1.0, 0.0), (-travel, 0.0), f"{name}_handle_main", start_n=6.0, behind=behind)
    builder.region(name, *inner, link=name)


def _floor(half: float, depth: float) -> list[Solid]:
    out = []
    for k in range(11):
        x = -half + RIM_RADIUS + (2 * half - 2 * RIM_RADIUS) * k / 10
        out.append(wire([(x, RIM_RADIUS, WIRE_RADIUS), (x, depth - RIM_RADIUS, WIRE_RADIUS)], WIRE_RADIUS))
    for k in range(8):
        y = RIM_RADIUS + (depth - 2 * RIM_RADIUS) * k / 7
        path = [(-half + RIM_RADIUS, y, -WIRE_RADIUS * 0.6), (half - RIM_RADIUS, y, -WIRE_RADIUS * 0.6)]
        out.append(wire(path, WIRE_RADIUS))
    return out


def _sides(half: float, depth: float, height: float) -> list[Solid]:
    a, b, c = half - RIM_RADIUS, RIM_RADIUS, depth - RIM_RADIUS
    out = []
    for z, radius in ((height - RIM_RADIUS, RIM_RADIUS), (0.5 * height, WIRE_RADIUS)):
        corners = [(-a, b, z), (a, b, z), (a, c, z), (-a, c, z)]
        out += [wire([p, q], radius) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    for k in range(11):
        x = -a + 2 * a * k / 10
        out += [wire([(x, y, 0.0), (x, y, height - RIM_RADIUS)], WIRE_RADIUS) for y in (b, c)]
    for k in range(1, 8):
        y = b + (c - b) * k / 8
        out += [wire([(x, y, 0.0), (x, y, height - RIM_RADIUS)], WIRE_RADIUS) for x in (-a, a)]
    return out


def _tines(half: float, depth: float, rows: int) -> list[Solid]:
    out = []
    count = int((depth - 0.1) / 0.033)
    for row in range(rows):
        x = -half + 2 * half * (row + 0.7) / (rows + 0.7)
        for k in range(count):
            y = 0.05 + (depth - 0.1) * k / max(1, count - 1)
            out.append(wire([(x, y, 0.0), (x - 0.012, y, TINE_HEIGHT)], WIRE_RADIUS))
    return out
