"""Racks of a dishwasher: baskets of coated wire with tines, on slides."""

from __future__ import annotations

from casa_assets.ext.records import Vec3
from casa_assets.ext.solids import AssetBuilder, Solid, board, concatenate, rod
from casa_assets.kitchenware.parts.hardware.handles import wire

WIRE_RADIUS, RIM_RADIUS = 0.0016, 0.0026  # metres; radius with its coat
TINE_HEIGHT = 0.05
TINE_PITCH = 0.095  # metres; closer rows hold no plates


def add_dish_rack(
    builder: AssetBuilder,
    name: str,
    behind: str,
    lower: Vec3,
    upper: Vec3,
    finish: str,
    metal: str,
    *,
    tines: int,
    travel: float,
) -> None:
    """A basket between two corners, open on top; its link is `name`, its joint `<name>_joint`.

    Args:
        lower, upper: metres; lower[1] is its front. travel: how far it slides out, metres.
        tines: rows that hold plates; fewer if they would be closer together than TINE_PITCH.
        finish: of the wire. metal: of the bar that a hand takes.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    half, depth, height = (x1 - x0) / 2, y1 - y0, z1 - z0
    builder.link(name, at=((x0 + x1) / 2, y0, z0))
    rows = min(tines, int(2 * half / TINE_PITCH))
    wires = [*_floor(half, depth), *_sides(half, depth, height), *_tines(half, depth, rows)]
    builder.draw(name, concatenate(wires), finish, "rack", density="coated_wire")
    t = 0.007
    for solid, part in (
        (board((-half, 0.0, -RIM_RADIUS), (half, depth, 2 * RIM_RADIUS), 0.0), "main"),
        (board((-half, 0.0, 2 * RIM_RADIUS), (half, t, height), 0.0), "front"),
        (board((-half, depth - t, 2 * RIM_RADIUS), (half, depth, height), 0.0), "back"),
        (board((-half, t, 2 * RIM_RADIUS), (-half + t, depth - t, height), 0.0), "left"),
        (board((half - t, t, 2 * RIM_RADIUS), (half, depth - t, height), 0.0), "right"),
    ):
        builder.add_collider(name, solid, finish, "rack", f"{name}_{part}")
    half_grip = 0.6 * half
    grip = rod(0.0055, 2 * half_grip, 0.002, "x").translated(0.0, -0.013, height - 0.006)
    builder.add(name, grip, metal, "handle", name=f"{name}_handle_main")
    for x in (-half_grip + 0.012, half_grip - 0.012):
        link = rod(0.0035, 0.014, 0.0005, "y").translated(x, -0.006, height - 0.006)
        builder.draw(name, link, metal, "handle")
    for x in (-half - 0.004, half + 0.004):
        for y in (0.2 * depth, 0.8 * depth):
            wheel = rod(0.013, 0.007, 0.0015, "x").translated(x, y, 0.004)
            builder.draw(name, wheel, "plastic_grey", "wheel")
    joint = f"{name}_joint"
    builder.slide(joint, name, (0.0, 1.0, 0.0), (-travel, 0.0), f"{name}_handle_main", start_n=6.0, behind=behind)
    builder.region(name, (-half + t, t, 2 * RIM_RADIUS), (half - t, depth - t, height), link=name)


def _floor(half: float, depth: float) -> list[Solid]:
    out = []
    for k in range(11):
        x = -half + RIM_RADIUS + (2 * half - 2 * RIM_RADIUS) * k / 10
        out.append(wire([(x, RIM_RADIUS, WIRE_RADIUS), (x, depth - RIM_RADIUS, WIRE_RADIUS)], WIRE_RADIUS))
    for k in range(8):
        y = RIM_RADIUS + (depth - 2 * RIM_RADIUS) * k / 7
        out.append(
            wire([(-half + RIM_RADIUS, y, -WIRE_RADIUS * 0.6), (half - RIM_RADIUS, y, -WIRE_RADIUS * 0.6)], WIRE_RADIUS)
        )
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
    """Upright wires in rows from front to back."""
    out = []
    count = int((depth - 0.1) / 0.033)
    for row in range(rows):
        x = -half + 2 * half * (row + 0.7) / (rows + 0.7)
        for k in range(count):
            y = 0.05 + (depth - 0.1) * k / max(1, count - 1)
            out.append(wire([(x, y, 0.0), (x - 0.012, y, TINE_HEIGHT)], WIRE_RADIUS))
    return out
