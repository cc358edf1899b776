"""The turntable of a microwave: a glass tray on a hub and a ring of rollers."""

from __future__ import annotations

import math

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import lathe, rod
from casa_assets.model.record import Vec3


def add_turntable(builder: AssetBuilder, lower: Vec3, upper: Vec3) -> None:
    """Add a glass tray on a hub and a ring of rollers; its collider and region are `tray`.

    Args:
        lower, upper: corners of the cavity, metres.
    """
    x, y = (lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2
    radius = min(upper[0] - lower[0], upper[1] - lower[1], 0.36) / 2 - 0.012
    floor = lower[2] + 0.0006
    hub = lathe([(0.02, floor), (0.02, floor + 0.004), (0.012, floor + 0.0098)]).translated(x, y)
    builder.add(ROOT, hub, "plastic_white", label="hub", collider=False)
    r = 0.62 * radius
    ring = lathe([(r - 0.004, 0.003), (r + 0.004, 0.003), (r + 0.004, 0.0085), (r - 0.004, 0.0085)], 40, closed=True)
    builder.add(ROOT, ring.translated(x, y, floor), "plastic_white", label="hub", collider=False)
    for k in range(3):
        wheel = rod(0.0045, 0.008, 0.001, "x").translated(r, 0.0, floor + 0.0046)
        builder.add(
            ROOT, wheel.rotated("z", 2 * math.pi * k / 3).translated(x, y), "plastic_white", label="hub", collider=False
        )
    z = floor + 0.0102
    rim = [(radius - 0.012, z), (radius, z + 0.003), (radius, z + 0.0066), (radius - 0.01, z + 0.0052)]
    dish = (
        lathe([*rim, (0.0, z + 0.0052)])
        .translated(x, y)
        .with_colliders_of(rod(radius, 0.0052, 0.0).translated(x, y, z + 0.0026))
    )
    builder.add(ROOT, dish, "glass_clear", label="tray", name="tray")
    builder.round_region("tray", (x, y, z + 0.0055), 2 * radius - 0.004, upper[2] - z - 0.03)
