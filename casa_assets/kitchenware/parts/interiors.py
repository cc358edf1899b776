"""Interiors for imported bodies: walls round a cavity, and the racks, shelves or turntable that belong in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, board
from casa_assets.kitchenware.parts import refrigerator
from casa_assets.kitchenware.parts.appliance import ApplianceLook
from casa_assets.kitchenware.parts.cases import cavity_walls
from casa_assets.kitchenware.parts.oven import furnish_cavity
from casa_assets.kitchenware.parts.racks import add_dish_rack, add_oven_rack, add_turntable

# All lengths in metres; choices that suit usual appliances and cabinets.
FRONT_CLEARANCE = 0.0008  # from the mouth of a cavity to the front edges of the walls, which then overlap no front
OVEN_PITCH, DISH_PITCH = 0.17, 0.24  # least distance from rack to rack
OVEN_MIN_HEIGHT, DISH_MIN_HEIGHT = 0.14, 0.16  # of a cavity that gets a rack at all
FRIDGE_SHELF_PITCH, SHELF_PITCH = 0.29, 0.34
SHELF_MIN_HEIGHT = 0.46  # of a cabinet that gets a shelf
SHELF_THICKNESS = 0.016
OVEN_LINER = "enamel_charcoal"  # finish of the ledges of racks
FRIDGE_LOOK = ApplianceLook()


@dataclass(frozen=True)
class Interior:
    """A cavity behind a door or a drawer's front; metres, z up, the front faces -y.

    name: of its region. lower, upper: inner corners; lower[1] is its front. outer: corners of the walls around it.
    door: joint that has to be open before anything in the cavity moves. clear: distance that moving parts keep from the
    left and the right wall, because of the open door there. first: number of the first tray.
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
        furnish_cavity(builder, (x0, y0, z0), interior.upper, f"{interior.name}_lamp")
    count = 1 if height < 2 * OVEN_PITCH - 0.02 else 2
    head = interior.upper[2] - (0.045 if height >= 0.22 else 0.01)
    for k in range(count):
        z = z0 + (0.04 + 0.28 * (height - 0.08) * (k + 1) if count == 2 else max(0.03, 0.3 * height))
        above = z0 + 0.04 + 0.56 * (height - 0.08) - 0.03 if k < count - 1 else head
        inner = ((x0 + interior.clear[0], y0 + 0.004, z), (x1 - interior.clear[1], y1, max(above, z + 0.03)))
        add_oven_rack(builder, f"tray_{interior.first + k}", *inner, OVEN_LINER, interior.door)


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
    inside = refrigerator.Compartment(interior.name, interior.lower, interior.upper)
    for k in range(1, count + 1):
        z = interior.lower[2] + height * k / (count + 1)
        refrigerator.add_shelf(builder, f"{interior.name}_shelf{k}", inside, z, front, FRIDGE_LOOK)


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
        travel = round(0.85 * (back - front), 3)
        name, tines = f"tray_{interior.first + k}", 3 if k == 0 else 2
        add_dish_rack(builder, name, interior.door, lower, upper, "plastic_grey_light", tines, travel)


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


# Functions that add the shelves, racks or turntable of an interior, by the kind of interior.
FURNISHERS: Mapping[str, Callable[[AssetBuilder, Interior], None]] = {
    "oven": furnish_oven,
    "microwave": furnish_microwave,
    "refrigerator": furnish_refrigerator,
    "dishwasher": furnish_dishwasher,
    "cabinet": furnish_cabinet,
}
