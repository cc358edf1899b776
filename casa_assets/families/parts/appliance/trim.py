"""Trim on the front of an appliance: a blank badge and a touch panel."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.solids.blocks import box
from casa_assets.families.parts.appliance.look import ApplianceFront, ApplianceLook
from casa_assets.families.parts.refrigerator.door import FridgeDoor

TOUCH_PANEL_HEIGHT = 1.45  # metres above the floor


def add_badge(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook) -> None:
    """Add a badge near the upper edge of a door, and a touch panel at eye height where the look has one."""
    w, h = door.width, door.height
    if look.form is ApplianceFront.PANEL:
        return
    if look.badge:
        size = (0.11, 0.004, 0.022) if look.form is ApplianceFront.ROUND else (0.07, 0.0022, 0.012)
        plate = box(size, (w / 2, -size[1] / 2 + 0.0004, h - 0.075), 0.45 * size[1], 2)
        door.add_part(builder, plate, look.metal, "badge")
    if look.display:
        z = min(max(TOUCH_PANEL_HEIGHT - door.lower[1], 0.2), h - 0.2)
        glass = box((0.036, 0.0014, 0.2), (w / 2, -0.0006, z), 0.0005)
        door.add_part(builder, glass, "display_dark", "display", density=0.0)
        for k in range(2):
            digit = box((0.014, 0.0005, 0.018), (w / 2, -0.0016, z + 0.07 - 0.034 * k), 0.0)
            door.add_part(builder, digit, "display_white", "display", density=0.0)
        for k in range(3):
            key = box((0.01, 0.0005, 0.003), (w / 2, -0.0016, z - 0.02 - 0.026 * k), 0.0)
            door.add_part(builder, key, "plastic_grey_light", "display", density=0.0)
