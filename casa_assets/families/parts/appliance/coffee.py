"""Parts of coffee machines: drip trays, brewing groups with a portafilter, steam wands, hoppers, gauges, cup rails."""

from __future__ import annotations

import math

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board, box, lathe, rod
from casa_assets.families.kit.solids.boolean import subtract
from casa_assets.families.kit.solids.sweep import tube
from casa_assets.families.parts.appliance.case import rounded_body
from casa_assets.model.record import Vec3


def add_drip_tray(builder: AssetBuilder, lower: Vec3, upper: Vec3, metal: str) -> None:
    """Add a dark tray with a grid on top to the root link, between two corners, metres; cups are placed at upper[2]."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    pan = subtract(
        board(lower, (x1, y1, z1 - 0.0006), 0.003, 2),
        board((x0 + 0.006, y0 + 0.006, z0 + 0.006), (x1 - 0.006, y1 - 0.006, 1.0), 0.0),
    )
    builder.add(ROOT, pan, "plastic_black", label="tray", collider=False)
    collider_box = board(lower, upper, 0.0)
    builder.add_collider(ROOT, collider_box, metal, "tray", "drip_tray")
    for y in (y0 + 0.008, y1 - 0.008):
        rail = board((x0 + 0.0064, y - 0.0016, z1 - 0.003), (x1 - 0.0064, y + 0.0016, z1), 0.0005)
        builder.add(ROOT, rail, metal, label="tray", collider=False)
    count = max(5, int((x1 - x0 - 0.02) / 0.0085))
    for k in range(count):
        x = x0 + 0.011 + (x1 - x0 - 0.022) * k / (count - 1)
        slat = board((x - 0.0017, y0 + 0.0065, z1 - 0.0024), (x + 0.0017, y1 - 0.0065, z1 - 0.0003), 0.0)
        builder.add(ROOT, slat, metal, label="tray", collider=False)


def add_brew_group(builder: AssetBuilder, at: Vec3, ceiling: float, metal: str, grip: str) -> None:
    """A brewing group under a ceiling with a portafilter whose two spouts end at `at`, its handle to the front."""
    x, y, z = at
    head = rod(0.036, ceiling - z - 0.034, 0.003).translated(x, y, (ceiling + z + 0.034) / 2)
    builder.add(ROOT, head, metal, label="group", collider="group_head", density="brewing_casting")
    ring = rod(0.041, 0.01, 0.002).translated(x, y, z + 0.0392)
    builder.add(ROOT, ring, metal, label="portafilter", collider=False, density="brewing_casting")
    basket = lathe([(0.02, z + 0.016), (0.034, z + 0.0215), (0.0352, z + 0.034)], 28).translated(x, y)
    builder.add(
        ROOT,
        basket.with_box_collider(),
        metal,
        label="portafilter",
        collider="portafilter_basket",
        density="brewing_casting",
    )
    for s in (-1, 1):
        spout = tube([(x, y, z + 0.014), (x + s * 0.012, y, z + 0.011), (x + s * 0.012, y, z)], 0.0048, 0.006)
        builder.add(ROOT, spout, metal, label="portafilter", collider=False)
    neck = tube([(x, y - 0.03, z + 0.028), (x, y - 0.066, z + 0.026)], 0.006)
    builder.add(ROOT, neck, metal, label="portafilter", collider=False)
    line = [(0.0075, 0.0), (0.0125, 0.012), (0.0118, 0.05), (0.0142, 0.085), (0.011, 0.097), (0.004, 0.1)]
    handle = lathe(line, 20, 60.0).rotated("x", math.pi / 2 + 0.06).translated(x, y - 0.064, z + 0.0262)
    builder.add(ROOT, handle.with_hull_collider(), grip, label="portafilter", collider="portafilter_grip")


def add_spout(builder: AssetBuilder, at: Vec3, ceiling: float, finish: str, twin: bool) -> None:
    """A block under a ceiling from which one or two spouts look down; `at` is their lower end."""
    x, y, z = at
    width = 0.06 if twin else 0.034
    block = board((x - width / 2, y - 0.022, z + 0.008), (x + width / 2, y + 0.022, ceiling), 0.005, 3)
    builder.add(ROOT, block, finish, label="spout", collider="spout", density="hollow_moulding")
    for dx in (-0.014, 0.014) if twin else (0.0,):
        tip = lathe([(0.0042, z), (0.0062, z + 0.0085)], 16).translated(x + dx, y)
        builder.add(ROOT, tip, "plastic_black", label="spout", collider=False)


def add_steam_wand(builder: AssetBuilder, at: Vec3, tip_z: float, metal: str) -> None:
    """A steam wand that hangs from `at` down to z = low, leaning out to its side (the sign of x)."""
    x, y, z = at
    side = math.copysign(1.0, x)
    ball_ = rod(0.011, 0.018, 0.004).translated(x, y, z - 0.004)
    builder.add(ROOT, ball_, metal, label="wand", collider=False)
    pipe = tube([(x, y, z), (x, y, z - 0.03), (x + side * 0.02, y - 0.015, tip_z)], 0.0042, 0.012)
    builder.add(ROOT, pipe, metal, label="wand", density="steam_wand")
    sleeve = tube(
        [
            (x + side * 0.0095, y - 0.007, tip_z + (z - tip_z) * 0.5),
            (x + side * 0.0155, y - 0.0117, tip_z + (z - tip_z) * 0.22),
        ],
        0.0066,
    )
    builder.add(ROOT, sleeve, "rubber_black", label="wand", collider=False)


def add_bean_hopper(builder: AssetBuilder, x: float, y: float, z: float, size: float, height: float) -> None:
    """Add a transparent funnel for beans with a lid; z is the height of the surface below it."""
    steps = [(0.022, z), (0.0, z + 0.5 * height), (0.0, z + height - 0.012)]
    body = rounded_body(size, size, steps, 0.03).translated(x, y)
    builder.add(ROOT, body.with_hull_collider(), "plastic_smoked", label="hopper", density="bean_hopper")
    beans = rounded_body(
        size - 0.008, size - 0.008, [(0.022, z + 0.003), (0.002, z + 0.45 * height)], 0.028
    ).translated(x, y)
    builder.add(ROOT, beans, "coffee_dark", label="hopper", collider=False, density="coffee_beans")
    lid = rounded_body(
        size + 0.004, size + 0.004, [(0.0, z + height - 0.0118), (0.0, z + height - 0.003), (0.003, z + height)], 0.031
    ).translated(x, y)
    builder.add(ROOT, lid.with_hull_collider(), "plastic_black", label="hopper", density="hopper_lid")
    knob = rod(0.011, 0.012, 0.003).translated(x, y, z + height + 0.006)
    builder.add(ROOT, knob, "plastic_black", label="hopper")


def add_pressure_gauge(builder: AssetBuilder, at: Vec3, radius: float, metal: str) -> None:
    """A round pressure gauge in a front that looks to -y."""
    x, y, z = at
    bezel = lathe(
        [(radius, 0.0), (radius, 0.005), (radius - 0.003, 0.007), (radius - 0.004, 0.0062), (0.0, 0.0062)], 32
    )
    builder.add(ROOT, bezel.rotated("x", math.pi / 2).translated(x, y, z), metal, label="gauge", collider=False)
    dial = rod(radius - 0.0042, 0.0006, 0.0, "y").translated(x, y - 0.0067, z)
    builder.add(ROOT, dial, "enamel_white", label="gauge", collider=False, density=0.0)
    for k in range(9):
        angle = math.radians(-130 + 260 * k / 8)
        tick = (
            box((0.0008, 0.0004, 0.003), (0.0, -0.0072, radius - 0.0066), 0.0).rotated("y", angle).translated(x, y, z)
        )
        builder.add(ROOT, tick, "plastic_black", label="gauge", collider=False, density=0.0)
    hand = (
        box((0.0012, 0.0004, radius - 0.008), (0.0, -0.0075, 0.3 * radius), 0.0).rotated("y", -0.9).translated(x, y, z)
    )
    builder.add(ROOT, hand, "plastic_red", label="gauge", collider=False, density=0.0)


def add_cup_rail(builder: AssetBuilder, lower: Vec3, upper: Vec3, metal: str) -> None:
    """Add a low fence of rod round the warming plate at lower[2], up to upper[2]. Metres."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    loop = [(x1, y1, z1), (x1, y0, z1), (x0, y0, z1), (x0, y1, z1), (x1, y1, z1)]
    builder.add(ROOT, tube(loop, 0.0028), metal, label="rail")
    for x, y in ((x0, y0), (x1, y0), (x0, y1), (x1, y1)):
        builder.add(
            ROOT, rod(0.0026, z1 - z0, 0.0005).translated(x, y, (z0 + z1) / 2), metal, label="rail", collider=False
        )
