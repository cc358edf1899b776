"""Interiors for imported bodies: walls round a cavity, and the racks, shelves, turntables and boxes that belong in it.

Sizes are those of the room that there is, so everything here gives way: fewer racks, fewer shelves, none at last.
"""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.parts.appliance import dish_racks, oven
from casa_assets.families.parts.appliance.look import ApplianceLook
from casa_assets.families.parts.appliance.turntable import add_turntable
from casa_assets.families.parts.refrigerator import case
from casa_assets.model.record import Vec3

# Behind a mouth: what is built begins so far back that it lies in no front, metres.
FRONT_CLEARANCE = 0.0008
# Racks of ovens and dishwashers need so much above each other, and so much room at all, metres.
OVEN_PITCH, OVEN_MIN_HEIGHT, DISH_PITCH, DISH_MIN_HEIGHT = 0.17, 0.14, 0.24, 0.16
# Shelves of fridges and cabinets.
FRIDGE_SHELF_PITCH, SHELF_PITCH, SHELF_MIN_HEIGHT, SHELF_THICKNESS = 0.29, 0.34, 0.46, 0.016
# Boxes of drawers: room beside and above them, thickness, and the greatest height.
DRAWER_SIDE_CLEARANCE, DRAWER_TOP_CLEARANCE, DRAWER_SIDE_THICKNESS, DRAWER_BASE_THICKNESS, DRAWER_MAX_HEIGHT = (
    0.008,
    0.014,
    0.01,
    0.006,
    0.22,
)
OVEN_LOOK = oven.OvenLook(shell="enamel_charcoal", face="stainless_brushed", metal="stainless_brushed")
FRIDGE_LOOK = ApplianceLook()


@dataclass(frozen=True)
class Interior:
    """A room, metres, z up, the front faces -y.

    Attributes:
        name: of its region. low, high: inner corners; low[1] is its front. outer: corners of the walls round it.
        door: joint that stands open before anything in it moves.
        clear: what moves keeps so far from the left and the right wall, for the door that stands open there.
        first: number of the first tray.
    """

    name: str
    low: Vec3
    high: Vec3
    outer: tuple[Vec3, Vec3]
    door: str = ""
    clear: tuple[float, float] = (0.0, 0.0)
    first: int = 0

    @property
    def size(self) -> Vec3:
        """Width, depth, height inside."""
        (a, b, c), (x, y, z) = self.low, self.high
        return (x - a, y - b, z - c)


def add_walls(builder: AssetBuilder, room: Interior, finish: str) -> None:
    """Left, right, floor, roof and back; their front edges lie round the mouth."""
    (x0, _, z0), (x1, y1, z1) = room.low, room.high
    (a0, mouth, c0), (a1, b1, c1) = room.outer
    y0 = mouth + FRONT_CLEARANCE
    for low, high in (
        ((a0, y0, c0), (x0, b1, c1)),
        ((x1, y0, c0), (a1, b1, c1)),
        ((x0, y0, c0), (x1, b1, z0)),
        ((x0, y0, z1), (x1, b1, c1)),
        ((x0, y1, z0), (x1, b1, z1)),
    ):
        builder.add(ROOT, board(low, high, 0.0), finish, label="liner", density=0.0)


def furnish_oven(builder: AssetBuilder, room: Interior) -> None:
    """Racks on ledges, a grill element, a fan and a lamp."""
    (x0, y0, z0), (x1, y1, _) = room.low, room.high
    wide, deep, tall = room.size
    if min(wide, deep) < 0.2 or tall < OVEN_MIN_HEIGHT:
        return
    if tall >= 0.22:
        oven.furnish_cavity(builder, (x0, y0, z0), room.high, f"{room.name}_lamp")
    count = 1 if tall < 2 * OVEN_PITCH - 0.02 else 2
    head = room.high[2] - (0.045 if tall >= 0.22 else 0.01)
    for k in range(count):
        z = z0 + (0.04 + 0.28 * (tall - 0.08) * (k + 1) if count == 2 else max(0.03, 0.3 * tall))
        above = z0 + 0.04 + 0.56 * (tall - 0.08) - 0.03 if k < count - 1 else head
        inner = ((x0 + room.clear[0], y0 + 0.004, z), (x1 - room.clear[1], y1, max(above, z + 0.03)))
        oven.add_oven_rack(builder, f"tray_{room.first + k}", *inner, OVEN_LOOK, room.door)


def furnish_microwave(builder: AssetBuilder, room: Interior) -> None:
    """A turntable, where there is room for one."""
    wide, deep, tall = room.size
    if min(wide, deep) >= 0.16 and tall >= 0.09:
        add_turntable(builder, room.low, room.high)


def furnish_cold(builder: AssetBuilder, room: Interior) -> None:
    """Panes on ledges."""
    wide, deep, tall = room.size
    count = max(0, int(tall / FRIDGE_SHELF_PITCH) - 1) if min(wide, deep) >= 0.18 else 0
    front = room.low[1] + max(0.022, 0.14 * deep)
    inside = case.Compartment(room.name, room.low, room.high)
    for k in range(1, count + 1):
        z = room.low[2] + tall * k / (count + 1)
        case.add_shelf(builder, f"{room.name}_shelf{k}", inside, z, front, FRIDGE_LOOK)


def furnish_dishwasher(builder: AssetBuilder, room: Interior) -> None:
    """One basket of wire, or two."""
    (x0, y0, z0), (x1, y1, _) = room.low, room.high
    wide, deep, tall = room.size
    if min(wide, deep) < 0.25 or tall < DISH_MIN_HEIGHT:
        return
    floors = [z0 + 0.04] if tall < 2 * DISH_PITCH - 0.06 else [z0 + 0.045, z0 + 0.52 * tall]
    front, back = y0 + 0.03, y1 - 0.02
    for k, z in enumerate(floors):
        top = min(z + 0.19, (floors[1] - 0.02 if k == 0 and len(floors) > 1 else room.high[2]) - 0.02)
        low, high = (x0 + 0.02 + room.clear[0], front, z), (x1 - 0.02 - room.clear[1], back, top)
        coat, metal = "plastic_grey_light", "stainless_brushed"
        way = round(0.85 * (back - front), 3)
        dish_racks.add_dish_rack(
            builder, f"tray_{room.first + k}", room.door, low, high, coat, metal, tines=3 if k == 0 else 2, way=way
        )


def furnish_cabinet(builder: AssetBuilder, room: Interior) -> None:
    """Boards between the walls."""
    (x0, y0, z0), (x1, y1, _) = room.low, room.high
    _, deep, tall = room.size
    count = 0 if tall < SHELF_MIN_HEIGHT or deep < 0.12 else max(1, round(tall / SHELF_PITCH) - 1)
    front = y0 + min(0.03, 0.1 * deep)
    for k in range(1, count + 1):
        z = z0 + tall * k / (count + 1)
        shelf = board((x0 + 0.0005, front, z - SHELF_THICKNESS), (x1 - 0.0005, y1 - 0.0005, z), 0.0008)
        builder.add(ROOT, shelf, "melamine_white", label="shelf", density=0.0)


def add_drawer_box(builder: AssetBuilder, link: str, room: Interior, finish: str) -> float:
    """A box behind a front, on its link; returns how deep it is, metres.

    Args:
        link: of the drawer, its frame that of the room.
    """
    (x0, y0, z0), (x1, y1, z1) = room.low, room.high
    beside, above = min(DRAWER_SIDE_CLEARANCE, 0.04 * (x1 - x0)), min(DRAWER_TOP_CLEARANCE, 0.1 * (z1 - z0))
    side, base = min(DRAWER_SIDE_THICKNESS, 0.05 * (x1 - x0)), min(DRAWER_BASE_THICKNESS, 0.08 * (z1 - z0))
    x0, x1, y0, y1 = x0 + beside, x1 - beside, y0 + 0.0002, y1 - 0.5 * beside
    z0 += 0.5 * above
    z1 = min(z1 - above, z0 + DRAWER_MAX_HEIGHT)
    along, across = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)
    for low, high, grain in (
        ((x0, y0, z0), (x0 + side, y1, z1), along),
        ((x1 - side, y0, z0), (x1, y1, z1), along),
        ((x0 + side, y0, z0), (x1 - side, y0 + side, z1 - 0.001), across),
        ((x0 + side, y1 - side, z0), (x1 - side, y1, z1 - 0.001), across),
        ((x0 + side, y0 + side, z0 + 0.0005), (x1 - side, y1 - side, z0 + base), across),
    ):
        builder.add(link, board(low, high, 0.0005), finish, label="drawer", grain=grain, density=0.0)
    builder.region(f"{room.name}_int", (x0 + side, y0 + side, z0 + base), (x1 - side, y1 - side, z1), link=link)
    return y1 - y0
