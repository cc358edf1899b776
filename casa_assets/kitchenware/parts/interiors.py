"""Racks of a dishwasher, and interiors for imported bodies: walls round a cavity and what belongs in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, board, concatenate, rod
from casa_assets.kitchenware.parts import appliance, refrigerator
from casa_assets.kitchenware.parts.appliance import ApplianceLook, add_turntable
from casa_assets.kitchenware.parts.counter_parts import cavity_walls
from casa_assets.kitchenware.parts.handles import wire

# Dish rack ------------------------------------------------------------------------------------------------------------

WIRE_RADIUS, RIM_RADIUS = 0.0016, 0.0026  # metres; radius with its coat
TINE_HEIGHT = 0.05
TINE_PITCH = 0.095  # metres; closer rows hold no plates


def add_dish_rack(
    builder: AssetBuilder, name: str, behind: str, lower: Vec3, upper: Vec3, finish: str, tines: int, travel: float
) -> None:
    """A basket between two corners, open on top; its link is `name`, its joint `<name>_joint`.

    lower, upper: metres; lower[1] is its front. travel: how far it slides out, metres. tines: rows that hold plates;
    fewer if they would be closer together than TINE_PITCH. finish: of the wire. metal: of the bar that a hand takes.
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
    builder.add(name, grip, "stainless_brushed", "handle", name=f"{name}_handle_main")
    for x in (-half_grip + 0.012, half_grip - 0.012):
        builder.draw(
            name, rod(0.0035, 0.014, 0.0005, "y").translated(x, -0.006, height - 0.006), "stainless_brushed", "handle"
        )
    for x in (-half - 0.004, half + 0.004):
        for y in (0.2 * depth, 0.8 * depth):
            builder.draw(name, rod(0.013, 0.007, 0.0015, "x").translated(x, y, 0.004), "plastic_grey", "wheel")
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
        path = [(-half + RIM_RADIUS, y, -WIRE_RADIUS * 0.6), (half - RIM_RADIUS, y, -WIRE_RADIUS * 0.6)]
        out.append(wire(path, WIRE_RADIUS))
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
    out = []
    count = int((depth - 0.1) / 0.033)
    for row in range(rows):
        x = -half + 2 * half * (row + 0.7) / (rows + 0.7)
        for k in range(count):
            y = 0.05 + (depth - 0.1) * k / max(1, count - 1)
            out.append(wire([(x, y, 0.0), (x - 0.012, y, TINE_HEIGHT)], WIRE_RADIUS))
    return out


# Interiors ------------------------------------------------------------------------------------------------------------

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
OVEN_LOOK = appliance.OvenLook(shell="enamel_charcoal", face="stainless_brushed", metal="stainless_brushed")
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
        appliance.furnish_cavity(builder, (x0, y0, z0), interior.upper, f"{interior.name}_lamp")
    count = 1 if height < 2 * OVEN_PITCH - 0.02 else 2
    head = interior.upper[2] - (0.045 if height >= 0.22 else 0.01)
    for k in range(count):
        z = z0 + (0.04 + 0.28 * (height - 0.08) * (k + 1) if count == 2 else max(0.03, 0.3 * height))
        above = z0 + 0.04 + 0.56 * (height - 0.08) - 0.03 if k < count - 1 else head
        inner = ((x0 + interior.clear[0], y0 + 0.004, z), (x1 - interior.clear[1], y1, max(above, z + 0.03)))
        appliance.add_oven_rack(builder, f"tray_{interior.first + k}", *inner, OVEN_LOOK, interior.door)


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


def add_drawer_box(builder: AssetBuilder, link: str, interior: Interior, finish: str) -> float:
    """A box behind a front, on its link; returns how deep it is, metres.

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
