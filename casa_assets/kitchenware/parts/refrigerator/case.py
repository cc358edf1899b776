"""The case of a refrigerator: foamed walls round its compartments, base, hinge covers, lamps and shelves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from casa_assets.ext.records import Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Placed, board, box, box_shape, rod, subtract
from casa_assets.kitchenware.parts.appliance.counter_parts import add_liner, cavity_colliders
from casa_assets.kitchenware.parts.appliance.front import ApplianceFront, ApplianceKick, ApplianceLook

# Foamed walls, metres.
SIDE_THICKNESS = 0.046
BACK_THICKNESS = DIVIDER_THICKNESS = 0.056
FLOOR_THICKNESS = 0.06
TOP_THICKNESS = 0.05
DOOR_GAP = 0.004  # metres between a door and the case; the gasket fills it
HINGE_COVER_HEIGHT = 0.014  # metres that the cover of a hinge stands above the case
LINER_THICKNESS = 0.001  # metres
LINER_FINISH = "plastic_white"


@dataclass(frozen=True)
class Compartment:
    """A cooled compartment: its name (`fridge` or `freezer`) and inner corners, metres; lower[1] = 0 is the front."""

    name: str
    lower: Vec3
    upper: Vec3


def compartment(name: str, left: float, right: float, bottom: float, top: float, depth: float) -> Compartment:
    """Make a compartment between planes of the case's inside, metres."""
    return Compartment(name, (left, 0.0, bottom), (right, depth - BACK_THICKNESS, top))


def add_case(
    builder: AssetBuilder,
    width: float,
    depth: float,
    top: float,
    base_height: float,
    compartments: Sequence[Compartment],
    look: ApplianceLook,
) -> None:
    """Add walls with liners around the compartments, from z = base_height to top, and a compressor behind the floor.

    The compartments are open to the front and lie above or next to each other; width and depth are those of the case,
    without doors, metres.
    """
    edge_radius, steps = {ApplianceFront.ROUND: (0.022, 4), ApplianceFront.SOFT: (0.006, 2)}.get(look.form, (0.0025, 1))
    body = board((0.0, 0.0, base_height), (width, depth, top), edge_radius, steps)
    holes = [board((r.lower[0], -0.05, r.lower[2]), r.upper, 0.0) for r in compartments]
    shapes = _walls(width, depth, top, base_height, compartments)
    builder.add(ROOT, subtract(body, *holes, shapes=shapes), look.body, "case", density="foamed_wall")
    for r in compartments:
        _line(builder, r)
    builder.ballast(ROOT, 9.0, (width / 2, depth - 0.12, base_height + 0.09), (0.3, 0.16, 0.16))  # compressor and pan
    for k in range(2):
        coil = board(
            (0.06, depth, base_height + 0.25 + 0.012 * k),
            (width - 0.06, depth + 0.004, base_height + 0.256 + 0.012 * k),
        )
        builder.draw(ROOT, coil, "black_matt", "case", density="condenser")


def _walls(
    width: float, depth: float, top: float, base_height: float, compartments: Sequence[Compartment]
) -> list[Placed]:
    left, right = min(r.lower[0] for r in compartments), max(r.upper[0] for r in compartments)
    floor, ceiling = min(r.lower[2] for r in compartments), max(r.upper[2] for r in compartments)
    back = compartments[0].upper[1]
    outer = ((0.0, 0.0, base_height), (width, depth, top))
    shapes = list(cavity_colliders(outer, ((left, 0.0, floor), (right, back, ceiling))))
    ordered = sorted(compartments, key=lambda r: (r.lower[2], r.lower[0]))
    for first, second in pairwise(ordered):
        if second.lower[2] >= first.upper[2]:
            shapes.append(box_shape((left, 0, first.upper[2]), (right, back, second.lower[2])))
        else:
            shapes.append(box_shape((first.upper[0], 0, first.lower[2]), (second.lower[0], back, first.upper[2])))
    return shapes


def _line(builder: AssetBuilder, r: Compartment) -> None:
    """Sheets of a liner, an air duct at the back and a lamp under the roof."""
    (x0, y0, z0), (x1, y1, z1) = r.lower, r.upper
    y0, e = y0 + 0.0012, LINER_THICKNESS
    add_liner(builder, (x0, y0, z0), r.upper, LINER_FINISH, "liner_sheet", e)
    middle, height = (x0 + x1) / 2, z1 - z0
    duct_width = min(0.16, 0.4 * (x1 - x0))
    duct = board(
        (middle - duct_width / 2, y1 - 0.007, z0 + 0.04), (middle + duct_width / 2, y1 - e - 3e-4, z1 - 0.04), 0.002
    )
    builder.draw(ROOT, duct, "plastic_grey_light", "liner")
    for k in range(max(2, int(height / 0.2))):
        z = z0 + 0.1 + k * 0.2
        if z < z1 - 0.06:
            slot = box((0.6 * duct_width, 0.001, 0.006), (middle, y1 - 0.0073, z), 0.0)
            builder.draw(ROOT, slot, "plastic_grey_dark", "vent", density=0.0)
    lamp = board((middle - 0.09, 0.16, z1 - 0.009), (middle + 0.09, 0.2, z1 - e - 3e-4), 0.002)
    builder.draw(ROOT, lamp, "glass_opal", "lamp", name=f"{r.name}_light")


def add_base(builder: AssetBuilder, width: float, depth: float, base_height: float, look: ApplianceLook) -> None:
    """Add the base of the case: a grille or a plinth before feet, or four turned feet; z from 0 to foot."""
    if look.kick is ApplianceKick.FEET:
        for x in (0.075, width - 0.075):
            for y in (0.07, depth - 0.07):
                foot = rod(0.02, base_height - 1e-3, 0.002).translated(x, y, base_height / 2 + 3e-4)
                builder.add(ROOT, foot, look.metal, "foot")
                builder.draw(ROOT, rod(0.026, 0.01, 0.002).translated(x, y, 0.0053), "rubber_black", "foot")
        return
    set_back = 0.004 if look.kick is ApplianceKick.GRILLE else 0.045
    board_ = board((0.012, set_back, 0.003), (width - 0.012, depth - 0.05, base_height - 3e-4), 0.002)
    finish = "plastic_grey_dark" if look.kick is ApplianceKick.GRILLE else "black_matt"
    # Rollers, pan and air behind it.
    builder.add(ROOT, board_, finish, "plinth", density="appliance_plinth")
    for x in (0.08, width - 0.08):
        for y in (0.1, depth - 0.12):
            builder.draw(ROOT, rod(0.018, 0.003).translated(x, y, 0.0015), "rubber_black", "foot")
    if look.kick is ApplianceKick.GRILLE:
        count = int((width - 0.16) / 0.022)
        for k in range(count):
            x = width / 2 + (k - (count - 1) / 2) * 0.022
            slot = box((0.013, 0.001, base_height - 0.03), (x, set_back - 3e-4, base_height / 2), 0.0)
            builder.draw(ROOT, slot, "rubber_black", "vent", density=0.0)


def add_hinge_cover(builder: AssetBuilder, x: float, top: float, thickness: float, look: ApplianceLook) -> None:
    """The cover of a hinge on top of the case, reaching over the door; x is its middle."""
    if look.form is ApplianceFront.PANEL:
        return
    length = 0.1 + thickness
    lid = box(
        (0.055, length, HINGE_COVER_HEIGHT - 0.002),
        (x, 0.1 - length / 2 - 0.01, top + HINGE_COVER_HEIGHT / 2 + 3e-4),
        0.004,
        2,
    )
    finish = look.metal if look.form is ApplianceFront.ROUND else "plastic_grey_dark"
    builder.add(ROOT, lid, finish, "hinge", density="hinge_cover")


def add_shelf(builder: AssetBuilder, name: str, r: Compartment, z: float, front: float, look: ApplianceLook) -> None:
    """A pane with a moulded edge on ledges; its upper side is z, its front edge y = front. Metres."""
    x0, x1, y1 = r.lower[0] + LINER_THICKNESS + 0.002, r.upper[0] - LINER_THICKNESS - 0.002, r.upper[1] - 0.012
    pane = board((x0 + 0.006, front + 0.01, z - 0.005), (x1 - 0.006, y1 - 0.008, z - 0.001), 0.0005)
    builder.draw(ROOT, pane, "glass_clear", "shelf")
    edge = board((x0, front, z - 0.016), (x1, front + 0.014, z), 0.003, 2)
    rear = board((x0, y1 - 0.012, z - 0.012), (x1, y1, z), 0.002)
    for bar in (edge, rear):
        builder.draw(ROOT, bar, look.trim, "shelf")
    for a, b in ((x0, x0 + 0.01), (x1 - 0.01, x1)):
        rail = board((a, front + 0.0145, z - 0.014), (b, y1 - 0.0125, z - 0.0004), 0.001)
        builder.draw(ROOT, rail, look.trim, "shelf")
    collider_box = board((x0, front, z - 0.012), (x1, y1, z), 0.0)
    builder.add_collider(ROOT, collider_box, "glass_clear", "shelf", f"{name}_pane")
