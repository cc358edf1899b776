"""Racks of a dishwasher: baskets of coated wire with tines, on slides."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import Bench
from casa_assets.families.kit.solids.blocks import board, rod
from casa_assets.families.kit.solids.solid import Solid, joined
from casa_assets.families.kit.solids.sweep import circle, tube
from casa_assets.model.record import Vec3

WIRE, RIM = 0.0016, 0.0026  # metres; radius with its coat
TINE = 0.05
TINES_APART = 0.095  # metres; closer rows hold no plates


def wire(a: Vec3, b: Vec3, radius: float = WIRE) -> Solid:
    """A thin straight wire that nothing touches; six sides."""
    return tube([a, b], circle(radius, 6)).untouched()


def rack(
    bench: Bench, name: str, behind: str, low: Vec3, high: Vec3, finish: str, metal: str, *, tines: int, way: float
) -> None:
    """A basket between two corners, open on top; its link is `name`, its joint `<name>_joint`.

    Args:
        low, high: metres; low[1] is its front. way: how far it slides out, metres.
        tines: rows that hold plates; fewer where they would stand closer than TINES_APART.
        finish: of the wire. metal: of the bar that a hand takes.
    """
    (x0, y0, z0), (x1, y1, z1) = low, high
    half, deep, tall = (x1 - x0) / 2, y1 - y0, z1 - z0
    bench.link(name, at=((x0 + x1) / 2, y0, z0))
    rows = min(tines, int(2 * half / TINES_APART))
    wires = [*_floor(half, deep), *_sides(half, deep, tall), *_tines(half, deep, rows)]
    bench.add(name, joined(wires), finish, label="rack", touch=False, density="coated_wire")
    t = 0.007
    for solid, part in (
        (board((-half, 0.0, -RIM), (half, deep, 2 * RIM), 0.0), "main"),
        (board((-half, 0.0, 2 * RIM), (half, t, tall), 0.0), "front"),
        (board((-half, deep - t, 2 * RIM), (half, deep, tall), 0.0), "back"),
        (board((-half, t, 2 * RIM), (-half + t, deep - t, tall), 0.0), "left"),
        (board((half - t, t, 2 * RIM), (half, deep - t, tall), 0.0), "right"),
    ):
        bench.add(name, solid, finish, label="rack", touch=f"{name}_{part}", density=0.0, seen=False)
    wide = 0.6 * half
    grip = rod(0.0055, 2 * wide, 0.002, "x").at(0.0, -0.013, tall - 0.006)
    bench.add(name, grip, metal, label="handle", name=f"{name}_handle_main")
    for x in (-wide + 0.012, wide - 0.012):
        link = rod(0.0035, 0.014, 0.0005, "y").at(x, -0.006, tall - 0.006)
        bench.add(name, link, metal, label="handle", touch=False)
    for x in (-half - 0.004, half + 0.004):
        for y in (0.2 * deep, 0.8 * deep):
            wheel = rod(0.013, 0.007, 0.0015, "x").at(x, y, 0.004)
            bench.add(name, wheel, "plastic_grey", label="wheel", touch=False)
    joint = f"{name}_joint"
    bench.slide(joint, name, (0.0, 1.0, 0.0), (-way, 0.0), f"{name}_handle_main", start_n=6.0, behind=behind)
    bench.region(name, (-half + t, t, 2 * RIM), (half - t, deep - t, tall), link=name)


def _floor(half: float, deep: float) -> list[Solid]:
    out = []
    for k in range(11):
        x = -half + RIM + (2 * half - 2 * RIM) * k / 10
        out.append(wire((x, RIM, WIRE), (x, deep - RIM, WIRE)))
    for k in range(8):
        y = RIM + (deep - 2 * RIM) * k / 7
        out.append(wire((-half + RIM, y, -WIRE * 0.6), (half - RIM, y, -WIRE * 0.6)))
    return out


def _sides(half: float, deep: float, tall: float) -> list[Solid]:
    a, b, c = half - RIM, RIM, deep - RIM
    out = []
    for z, radius in ((tall - RIM, RIM), (0.5 * tall, WIRE)):
        corners = [(-a, b, z), (a, b, z), (a, c, z), (-a, c, z)]
        out += [wire(p, q, radius) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)]
    for k in range(11):
        x = -a + 2 * a * k / 10
        out += [wire((x, y, 0.0), (x, y, tall - RIM)) for y in (b, c)]
    for k in range(1, 8):
        y = b + (c - b) * k / 8
        out += [wire((x, y, 0.0), (x, y, tall - RIM)) for x in (-a, a)]
    return out


def _tines(half: float, deep: float, rows: int) -> list[Solid]:
    """Upright wires in rows from front to back."""
    out = []
    count = int((deep - 0.1) / 0.033)
    for row in range(rows):
        x = -half + 2 * half * (row + 0.7) / (rows + 0.7)
        for k in range(count):
            y = 0.05 + (deep - 0.1) * k / max(1, count - 1)
            out.append(wire((x, y, 0.0), (x - 0.012, y, TINE)))
    return out
