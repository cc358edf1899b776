"""Interiors for imported bodies: walls round a cavity, and the racks, shelves, turntables and boxes that belong in it.

Sizes are those of the room that there is, so everything here gives way: fewer racks, fewer shelves, none at last.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, board
from casa_assets.kitchenware.parts.appliance import dish_racks, oven
from casa_assets.kitchenware.parts.appliance.counter_parts import cavity_walls
from casa_assets.kitchenware.parts.appliance.front import ApplianceLook
from casa_assets.kitchenware.parts.appliance.oven import add_turntable
from casa_assets.kitchenware.parts.refrigerator import case

# All lengths in metres; choices that suit usual appliances and cabinets.
FRONT_CLEARANCE = 0.0008  # from the mouth of a cavity to the front edges of the walls, which then overlap no front
OVEN_PITCH, DISH_PITCH = 0.17, 0.24  # least distance from rack to rack
OVEN_MIN_HEIGHT, DISH_MIN_HEIGHT = 0.14, 0.16  # of a cavity that gets a rack at all
FRIDGE_SHELF_PITCH, SHELF_PITCH = 0.29, 0.34
SHELF_MIN_HEIGHT = 0.46  # of a cabinet that gets a shelf
SHELF_THICKNESS = 0.016
DRAWER_SIDE_CLEARANCE, DRAWER_TOP_CLEARANCE = 0.008, 0.014
DRAWER_SIDE_THICKNESS, DRAWER_BASE_THICKNESS = 0.01, 0.006
DRAWER_MAX_HEIGHT = 0.22
OVEN_LOOK = oven.OvenLook(shell="enamel_charcoal", face="stainless_brushed", metal="stainless_brushed")
FRIDGE_LOOK = ApplianceLook()


@dataclass(frozen=True)
class Interior:
    """A cavity behind a door or a drawer's front; metres, z up, the front faces -y.

    Attributes:
        name: of its region. lower, upper: inner corners; lower[1] is its front. outer: corners of the walls around it.
        door: joint that has to be open before anything in the cavity moves.
        clear: distance that moving parts keep from the left and the right wall, because of the open door there.
        first: number of the first tray.
    """

    name: str
    lower: Vec3
    upper: Vec3
    outer: tuple[Vec3, Vec3]
    door: str = ""
    clear: Vec2 = (0.0, 0.0)
    first: int = 0

    @property
    def size(self) -> Vec3:
        """Width, depth, height inside."""
        (a, b, c), (x, y, z) = self.lower, self.upper
        return (x - a, y - b, z - c)


def add_walls(builder: AssetBuilder, interior: Interior, finish: str) -> None:
    """Left, right, floor, roof and back; their front edges lie round the mouth."""
    (x, mouth, z), upper = interior.outer
    for corners in cavity_walls(((x, mouth + FRONT_CLEARANCE, z), upper), (interior.lower, interior.upper)):
        builder.add(ROOT, board(*corners, 0.0), finish, "liner", density=0.0)


def furnish_oven(builder: AssetBuilder, interior: Interior) -> None:
    """Racks on ledges, a grill element, a fan and a lamp."""
    (x0, y0, z0), (x1, y1, _) = interior.lower, interior.upper
    width, depth, height = interior.size
    if min(width, depth) < 0.2 or height < OVEN_MIN_HEIGHT:
        return
    if height >= 0.22:
        oven.furnish_cavity(builder, (x0, y0, z0), interior.upper, f"{interior.name}_lamp")
    count = 1 if height < 2 * OVEN_PITCH - 0.02 else 2
    head = interior.upper[2] - (0.045 if height >= 0.22 else 0.01)
    for k in range(count):
        z = z0 + (0.04 + 0.28 * (height - 0.08) * (k + 1) if count == 2 else max(0.03, 0.3 * height))
        above = z0 + 0.04 + 0.56 * (height - 0.08) - 0.03 if k < count - 1 else head
        inner = ((x0 + interior.clear[0], y0 + 0.004, z), (x1 - interior.clear[1], y1, max(above, z + 0.03)))
        oven.add_oven_rack(builder, f"tray_{interior.first + k}", *inner, OVEN_LOOK, interior.door)


def furnish_microwave(builder: AssetBuilder, interior: Interior) -> None:
    """A turntable, where there is room for one."""
    width, depth, height = interior.size
    if min(width, depth) >= 0.16 and height >= 0.09:
        add_turntable(builder, interior.lower, interior.upper)


def furnish_refrigerator(builder: AssetBuilder, interior: Interior) -> None:
    """Panes on ledges."""
    width, depth, height = interior.size
    count = max(0, int(height / FRIDGE_SHELF_PITCH) - 1) if min(width, depth) >= 0.18 else 0
    front = interior.lower[1] + max(0.022, 0.14 * depth)
    inside = case.Compartment(interior.name, interior.lower, interior.upper)
    for k in range(1, count + 1):
        z = interior.lower[2] + height * k / (count + 1)
        case.add_shelf(builder, f"{interior.name}_shelf{k}", inside, z, front, FRIDGE_LOOK)


def furnish_dishwasher(builder: AssetBuilder, interior: Interior) -> None:
    """One basket of wire, or two."""
    (x0, y0, z0), (x1, y1, _) = interior.lower, interior.upper
    width, depth, height = interior.size
    if min(width, depth) < 0.25 or height < DISH_MIN_HEIGHT:
        return
    floors = [z0 + 0.04] if height < 2 * DISH_PITCH - 0.06 else [z0 + 0.045, z0 + 0.52 * height]
    front, back = y0 + 0.03, y1 - 0.02
    for k, z in enumerate(floors):
        top = min(z + 0.19, (floors[1] - 0.02 if k == 0 and len(floors) > 1 else interior.upper[2]) - 0.02)
        lower, upper = (x0 + 0.02 + interior.clear[0], front, z), (x1 - 0.02 - interior.clear[1], back, top)
        coat, metal = "plastic_grey_light", "stainless_brushed"
        travel = round(0.85 * (back - front), 3)
        dish_racks.add_dish_rack(
            builder,
            f"tray_{interior.first + k}",
            interior.door,
            lower,
            upper,
            coat,
            metal,
            tines=3 if k == 0 else 2,
            travel=travel,
        )


def furnish_cabinet(builder: AssetBuilder, interior: Interior) -> None:
    """Boards between the walls."""
    (x0, y0, z0), (x1, y1, _) = interior.lower, interior.upper
    _, depth, height = interior.size
    count = 0 if height < SHELF_MIN_HEIGHT or depth < 0.12 else max(1, round(height / SHELF_PITCH) - 1)
    front = y0 + min(0.03, 0.1 * depth)
    for k in range(1, count + 1):
        z = z0 + height * k / (count + 1)
        shelf = board((x0 + 0.0005, front, z - SHELF_THICKNESS), (x1 - 0.0005, y1 - 0.0005, z), 0.0008)
        builder.add(ROOT, shelf, "melamine_white", "shelf", density=0.0)


def add_drawer_box(builder: AssetBuilder, link: str, interior: Interior, finish: str) -> float:
    """A box behind a front, on its link; returns how deep it is, metres.

    Args:
        link: of the drawer, its frame that of the room.
    """
    (x0, y0, z0), (x1, y1, z1) = interior.lower, interior.upper
    beside, above = min(DRAWER_SIDE_CLEARANCE, 0.04 * (x1 - x0)), min(DRAWER_TOP_CLEARANCE, 0.1 * (z1 - z0))
    side, base = min(DRAWER_SIDE_THICKNESS, 0.05 * (x1 - x0)), min(DRAWER_BASE_THICKNESS, 0.08 * (z1 - z0))
    x0, x1, y0, y1 = x0 + beside, x1 - beside, y0 + 0.0002, y1 - 0.5 * beside
    z0 += 0.5 * above
    z1 = min(z1 - above, z0 + DRAWER_MAX_HEIGHT)
    along, across = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)
    for lower, upper, grain in (
        ((x0, y0, z0), (x0 + side, y1, z1), along),
        ((x1 - side, y0, z0), (x1, y1, z1), along),
        ((x0 + side, y0, z0), (x1 - side, y0 + side, z1 - 0.001), across),
        ((x0 + side, y1 - side, z0), (x1 - side, y1, z1 - 0.001), across),
        ((x0 + side, y0 + side, z0 + 0.0005), (x1 - side, y1 - side, z0 + base), across),
    ):
        builder.add(link, board(lower, upper, 0.0005), finish, "drawer", grain=grain, density=0.0)
    builder.region(f"{interior.name}_int", (x0 + side, y0 + side, z0 + base), (x1 - side, y1 - side, z1), link=link)
    return y1 - y0


# Functions that add the shelves, racks or turntable of an interior, by the kind of interior.
FURNISHERS: Mapping[str, Callable[[AssetBuilder, Interior], None]] = {
    "oven": furnish_oven,
    "microwave": furnish_microwave,
    "refrigerator": furnish_refrigerator,
    "dishwasher": furnish_dishwasher,
    "cabinet": furnish_cabinet,
}
