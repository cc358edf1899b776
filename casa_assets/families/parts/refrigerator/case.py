"""The case of a refrigerator: foamed walls round its rooms, what it stands on, hinge covers, lamps and shelves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board, box, rod
from casa_assets.families.kit.solids.boolean import subtract
from casa_assets.families.kit.solids.solid import Placed, box_shape
from casa_assets.families.parts.appliance.look import ApplianceFront, ApplianceKick, ApplianceLook
from casa_assets.model.record import Vec3

SIDE_THICKNESS, BACK_THICKNESS, FLOOR_THICKNESS, TOP_THICKNESS, DIVIDER_THICKNESS = (
    0.046,
    0.056,
    0.06,
    0.05,
    0.056,
)  # metres of foam
DOOR_GAP = 0.004  # between a door and the case; the gasket fills it
HINGE_COVER_HEIGHT = 0.014  # height of a hinge's cover above the case
LINER_THICKNESS = 0.001  # of the liner
LINER_FINISH = "plastic_white"


@dataclass(frozen=True)
class Compartment:
    """A cooled compartment: its name (`fridge` or `freezer`) and inner corners, metres; low[1] = 0 is the front."""

    name: str
    low: Vec3
    high: Vec3


def compartment(name: str, left: float, right: float, bottom: float, top: float, depth: float) -> Compartment:
    """Make a compartment between planes of the case's inside, metres."""
    return Compartment(name, (left, 0.0, bottom), (right, depth - BACK_THICKNESS, top))


def case_top(height: float, look: ApplianceLook) -> float:
    """Height of the case where covers of hinges stand on it and the whole is so high, metres."""
    return height if look.form is ApplianceFront.PANEL else height - HINGE_COVER_HEIGHT


def add_case(
    builder: AssetBuilder,
    width: float,
    depth: float,
    top: float,
    foot: float,
    rooms: Sequence[Compartment],
    look: ApplianceLook,
) -> None:
    """Walls with liners round the rooms, from z = foot to top, open to the front; a compressor behind the floor.

    The rooms lie above or beside each other; width and depth are those of the case, without doors, metres.
    """
    ease, steps = {ApplianceFront.ROUND: (0.022, 4), ApplianceFront.SOFT: (0.006, 2)}.get(look.form, (0.0025, 1))
    body = board((0.0, 0.0, foot), (width, depth, top), ease, steps)
    holes = [board((r.low[0], -0.05, r.low[2]), r.high, 0.0) for r in rooms]
    shapes = _walls(width, depth, top, foot, rooms)
    builder.add(ROOT, subtract(body, *holes, shapes=shapes), look.body, label="case", density="foamed_wall")
    for r in rooms:
        _line(builder, r)
    builder.ballast(ROOT, 9.0, (width / 2, depth - 0.12, foot + 0.09), (0.3, 0.16, 0.16))  # compressor and pan
    for k in range(2):
        coil = board((0.06, depth, foot + 0.25 + 0.012 * k), (width - 0.06, depth + 0.004, foot + 0.256 + 0.012 * k))
        builder.add(ROOT, coil, "black_matt", label="case", collider=False, density="condenser")


def _walls(width: float, depth: float, top: float, foot: float, rooms: Sequence[Compartment]) -> list[Placed]:
    left, right = min(r.low[0] for r in rooms), max(r.high[0] for r in rooms)
    low, high = min(r.low[2] for r in rooms), max(r.high[2] for r in rooms)
    back = rooms[0].high[1]
    shapes = [
        box_shape((0, 0, foot), (left, depth, top)),
        box_shape((right, 0, foot), (width, depth, top)),
        box_shape((left, 0, foot), (right, depth, low)),
        box_shape((left, 0, high), (right, depth, top)),
        box_shape((left, back, low), (right, depth, high)),
    ]
    ordered = sorted(rooms, key=lambda r: (r.low[2], r.low[0]))
    for one, other in pairwise(ordered):
        if other.low[2] >= one.high[2]:
            shapes.append(box_shape((left, 0, one.high[2]), (right, back, other.low[2])))
        else:
            shapes.append(box_shape((one.high[0], 0, one.low[2]), (other.low[0], back, one.high[2])))
    return shapes


def _line(builder: AssetBuilder, r: Compartment) -> None:
    """Sheets of a liner, an air duct at the back and a lamp under the roof."""
    (x0, y0, z0), (x1, y1, z1) = r.low, r.high
    y0, e = y0 + 0.0012, LINER_THICKNESS
    for sheet in (
        board((x0, y0, z0), (x0 + e, y1, z1), 0.0),
        board((x1 - e, y0, z0), (x1, y1, z1), 0.0),
        board((x0 + e, y0, z0), (x1 - e, y1 - e, z0 + e), 0.0),
        board((x0 + e, y0, z1 - e), (x1 - e, y1 - e, z1), 0.0),
        board((x0 + e, y1 - e, z0 + e), (x1 - e, y1, z1 - e), 0.0),
    ):
        builder.add(ROOT, sheet, LINER_FINISH, label="liner", collider=False, density="liner_sheet")
    middle, tall = (x0 + x1) / 2, z1 - z0
    wide = min(0.16, 0.4 * (x1 - x0))
    duct = board((middle - wide / 2, y1 - 0.007, z0 + 0.04), (middle + wide / 2, y1 - e - 3e-4, z1 - 0.04), 0.002)
    builder.add(ROOT, duct, "plastic_grey_light", label="liner", collider=False)
    for k in range(max(2, int(tall / 0.2))):
        z = z0 + 0.1 + k * 0.2
        if z < z1 - 0.06:
            slot = box((0.6 * wide, 0.001, 0.006), (middle, y1 - 0.0073, z), 0.0)
            builder.add(ROOT, slot, "plastic_grey_dark", label="vent", collider=False, density=0.0)
    lamp = board((middle - 0.09, 0.16, z1 - 0.009), (middle + 0.09, 0.2, z1 - e - 3e-4), 0.002)
    builder.add(ROOT, lamp, "glass_opal", label="lamp", name=f"{r.name}_light", collider=False)


def add_base(builder: AssetBuilder, width: float, depth: float, foot: float, look: ApplianceLook) -> None:
    """Add the base of the case: a grille or a plinth before feet, or four turned feet; z from 0 to foot."""
    if look.kick is ApplianceKick.FEET:
        for x in (0.075, width - 0.075):
            for y in (0.07, depth - 0.07):
                builder.add(
                    ROOT, rod(0.02, foot - 1e-3, 0.002).translated(x, y, foot / 2 + 3e-4), look.metal, label="foot"
                )
                pad = rod(0.026, 0.01, 0.002).translated(x, y, 0.0053)
                builder.add(ROOT, pad, "rubber_black", label="foot", collider=False)
        return
    set_back = 0.004 if look.kick is ApplianceKick.GRILLE else 0.045
    board_ = board((0.012, set_back, 0.003), (width - 0.012, depth - 0.05, foot - 3e-4), 0.002)
    finish = "plastic_grey_dark" if look.kick is ApplianceKick.GRILLE else "black_matt"
    # Rollers, pan and air behind it.
    builder.add(ROOT, board_, finish, label="plinth", density="appliance_plinth")
    for x in (0.08, width - 0.08):
        for y in (0.1, depth - 0.12):
            builder.add(ROOT, rod(0.018, 0.003).translated(x, y, 0.0015), "rubber_black", label="foot", collider=False)
    if look.kick is ApplianceKick.GRILLE:
        count = int((width - 0.16) / 0.022)
        for k in range(count):
            x = width / 2 + (k - (count - 1) / 2) * 0.022
            slot = box((0.013, 0.001, foot - 0.03), (x, set_back - 3e-4, foot / 2), 0.0)
            builder.add(ROOT, slot, "rubber_black", label="vent", collider=False, density=0.0)


def add_hinge_cover(builder: AssetBuilder, x: float, top: float, thick: float, look: ApplianceLook) -> None:
    """The cover of a hinge on top of the case, reaching over the door; x is its middle."""
    if look.form is ApplianceFront.PANEL:
        return
    length = 0.1 + thick
    lid = box(
        (0.055, length, HINGE_COVER_HEIGHT - 0.002),
        (x, 0.1 - length / 2 - 0.01, top + HINGE_COVER_HEIGHT / 2 + 3e-4),
        0.004,
        2,
    )
    finish = look.metal if look.form is ApplianceFront.ROUND else "plastic_grey_dark"
    builder.add(ROOT, lid, finish, label="hinge", density="hinge_cover")


def add_shelf(builder: AssetBuilder, name: str, r: Compartment, z: float, front: float, look: ApplianceLook) -> None:
    """A pane with a moulded edge on ledges; its upper side is z, its front edge y = front. Metres."""
    x0, x1, y1 = r.low[0] + LINER_THICKNESS + 0.002, r.high[0] - LINER_THICKNESS - 0.002, r.high[1] - 0.012
    pane = board((x0 + 0.006, front + 0.01, z - 0.005), (x1 - 0.006, y1 - 0.008, z - 0.001), 0.0005)
    builder.add(ROOT, pane, "glass_clear", label="shelf", collider=False)
    edge = board((x0, front, z - 0.016), (x1, front + 0.014, z), 0.003, 2)
    rear = board((x0, y1 - 0.012, z - 0.012), (x1, y1, z), 0.002)
    for bar in (edge, rear):
        builder.add(ROOT, bar, look.trim, label="shelf", collider=False)
    for a, b in ((x0, x0 + 0.01), (x1 - 0.01, x1)):
        rail = board((a, front + 0.0145, z - 0.014), (b, y1 - 0.0125, z - 0.0004), 0.001)
        builder.add(ROOT, rail, look.trim, label="shelf", collider=False)
    touch = board((x0, front, z - 0.012), (x1, y1, z), 0.0)
    builder.add_collider(ROOT, touch, "glass_clear", "shelf", f"{name}_pane")


def region_above_shelf(
    builder: AssetBuilder, name: str, r: Compartment, z: float, front: float, ceiling: float
) -> None:
    """The region above a shelf: from z to the ceiling, from its front edge to the back, metres."""
    low = (r.low[0] + 0.006, front + 0.004, z)
    builder.region(name, low, (r.high[0] - 0.006, r.high[1] - 0.016, ceiling))
