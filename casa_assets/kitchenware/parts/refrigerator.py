"""Cases and doors of refrigerators."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import (
    ROOT,
    AssetBuilder,
    Placed,
    Solid,
    board,
    box,
    box_shape,
    prism,
    rectangle,
    rod,
    subtract,
)
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.appliance import (
    LATCH_LENGTH,
    ApplianceFront,
    ApplianceKick,
    ApplianceLook,
    AppliancePull,
    appliance_pull,
)
from casa_assets.kitchenware.parts.cases import add_liner, cavity_colliders, cavity_walls
from casa_assets.kitchenware.parts.fronts import FrontKind

SIDE_THICKNESS = 0.046
BACK_THICKNESS = DIVIDER_THICKNESS = 0.056
FLOOR_THICKNESS = 0.06
TOP_THICKNESS = 0.05
DOOR_GAP = 0.004  # metres between a door and the case; the gasket fills it
HINGE_COVER_HEIGHT = 0.014  # metres that the cover of a hinge stands above the case
LINER_THICKNESS = 0.001  # metres
LINER_FINISH = "plastic_white"

DOOR_TRAVEL = math.pi / 2
BIN_DEPTH = 0.1  # metres that bins reach into the case
HAND_HEIGHT = 1.08  # height of the middle of a hand that stands before it, metres
BIN_REGION = "bin"  # begins the names of their regions
MIN_BIN_PITCH = 0.16  # metres between two bins
# Fronts whose stiles are wide enough for the foot of a pull.
FRAMED_FRONTS = (FrontKind.SHAKER, FrontKind.RAISED)
NICHE_DEPTH = 0.042
TOUCH_PANEL_HEIGHT = 1.45  # metres above the floor


# Case -----------------------------------------------------------------------------------------------------------------


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
    for first, second in pairwise(sorted(compartments, key=lambda r: (r.lower[2], r.lower[0]))):
        if second.lower[2] >= first.upper[2]:
            shapes.append(box_shape((left, 0, first.upper[2]), (right, back, second.lower[2])))
        else:
            shapes.append(box_shape((first.upper[0], 0, first.lower[2]), (second.lower[0], back, first.upper[2])))
    return shapes


def _line(builder: AssetBuilder, r: Compartment) -> None:
    (x0, y0, z0), (x1, y1, z1) = r.lower, r.upper
    y0, e = y0 + 0.0012, LINER_THICKNESS
    add_liner(builder, (x0, y0, z0), r.upper, LINER_FINISH, "liner_sheet", e)
    middle, height = (x0 + x1) / 2, z1 - z0
    duct_width = min(0.16, 0.4 * (x1 - x0))
    half, back = duct_width / 2, y1 - e - 3e-4
    duct = board((middle - half, y1 - 0.007, z0 + 0.04), (middle + half, back, z1 - 0.04), 0.002)
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
    builder.add(ROOT, board_, finish, "plinth", density="appliance_plinth")
    feet = [rod(0.018, 0.003).translated(x, y, 0.0015) for x in (0.08, width - 0.08) for y in (0.1, depth - 0.12)]
    builder.draw(ROOT, feet, "rubber_black", "foot")
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
    builder.draw(ROOT, (edge, board((x0, y1 - 0.012, z - 0.012), (x1, y1, z), 0.002)), look.trim, "shelf")
    for a, b in ((x0, x0 + 0.01), (x1 - 0.01, x1)):
        rail = board((a, front + 0.0145, z - 0.014), (b, y1 - 0.0125, z - 0.0004), 0.001)
        builder.draw(ROOT, rail, look.trim, "shelf")
    builder.add_collider(ROOT, board((x0, front, z - 0.012), (x1, y1, z), 0.0), "glass_clear", "shelf", f"{name}_pane")


def gasket_frame(lower: Vec2, upper: Vec2, y0: float, y1: float, strip_width: float = 0.014) -> Solid:
    """A frame of rubber between planes y0 and y1, without collider; lower, upper: outer corners in x and z, metres."""
    w, h = upper[0] - lower[0], upper[1] - lower[1]
    outer, inner = rectangle(w, h, 0.01, 2), rectangle(w - 2 * strip_width, h - 2 * strip_width, 0.004, 2)
    ring = prism(outer, y1 - y0, min(0.0008, 0.2 * (y1 - y0)), (inner,))
    # Pulled along z, then laid so that z becomes -y: the plane y1 is its foot.
    upright = ring.rotated("x", 1.5707963267948966)
    return upright.translated((lower[0] + upper[0]) / 2, y1, (lower[1] + upper[1]) / 2).without_colliders()


# Door -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FridgeDoor:
    """A door of a refrigerator.

    name: `fridge`, `fridge_left`, `freezer`: prefix of its link, joint and colliders; may be empty. lower, upper:
    corners in x and z, asset frame, metres. right: whether it is hinged on the right. compartment: what it shuts.
    clearance_x: x of the wall on its free side that its bins must swing clear of. face: finish of its front. across:
    whether its pull lies across, `pull_drop` metres below its upper edge.
    """

    name: str
    lower: Vec2
    upper: Vec2
    right: bool
    compartment: Compartment
    clearance_x: float
    face: str
    across: bool = False
    pull_drop: float = 0.07

    @property
    def link(self) -> str:
        """Name of its link, and prefix of its colliders."""
        return f"{self.name}_door" if self.name else "door"

    @property
    def joint(self) -> str:
        """Name of its joint."""
        return f"{self.link}_joint"

    @property
    def width(self) -> float:
        """Metres."""
        return self.upper[0] - self.lower[0]

    @property
    def height(self) -> float:
        """Metres."""
        return self.upper[1] - self.lower[1]

    def inwards(self, x: float) -> float:
        """Distance of an x of the asset from the hinge's axis, metres."""
        return self.upper[0] - x if self.right else x - self.lower[0]

    def add_part(
        self,
        builder: AssetBuilder,
        solid: Solid,
        finish: str,
        label: str,
        name: str | None = None,
        *,
        collider: str | bool = False,
        density: float | str | None = None,
        grain: Vec3 = (0.0, 0.0, 1.0),
    ) -> None:
        """Add a solid that is given with the hinge's axis on its left at the origin; arguments as of the builder."""
        placed = solid.mirrored_x() if self.right else solid
        builder.add(self.link, placed, finish, label, name, grain, collider=collider, density=density)


def hang_fridge_door(
    builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, rows: int, above: float, niche: bool = False
) -> None:
    """Add a door with everything on it, and its hinge.

    rows: bins on its inside. above: z below which there are no bins because of crispers, asset frame, metres. niche: a
    dispenser of water and ice in its front.
    """
    x = door.upper[0] if door.right else door.lower[0]
    builder.link(door.link, at=(x, -DOOR_GAP - look.thick, door.lower[1]))
    t, w, h = look.thick, door.width, door.height
    hole = _niche_hole(door, look) if niche else None
    add_face(builder, door, look, hole)
    if hole is not None:
        _dispenser(builder, door, hole)
    door.add_part(
        builder,
        gasket_frame((0.012, 0.012), (w - 0.012, h - 0.012), t + 2e-4, t + DOOR_GAP - 3e-4),
        "gasket_grey",
        "gasket",
        density="magnetic_gasket",
    )
    r = door.compartment
    a, b = sorted((door.inwards(r.lower[0]), door.inwards(r.upper[0])))
    c, d = r.lower[2] - door.lower[1], r.upper[2] - door.lower[1]
    a, b = max(a, 0.03) + 0.01, min(b, w - 0.03) - 0.014
    plug = board((a, t - 0.0002, c + 0.012), (b, t + 0.012, d - 0.012), 0.004, 2)
    door.add_part(builder, plug, LINER_FINISH, "liner", collider=f"{door.link}_liner", density="liner_plug")
    if rows:
        _bins(builder, door, look, rows, max(above - door.lower[1], c + 0.02), d - 0.015)
    add_pull(builder, door, look)
    span = (0.0, DOOR_TRAVEL) if door.right else (-DOOR_TRAVEL, 0.0)
    builder.hinge(door.joint, door.link, (0.0, 0.0, 1.0), span, f"{door.link}_handle_main", start_n=10.0)


def add_face(
    builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, hole: tuple[Vec2, Vec2] | None = None
) -> None:
    """Add the slab of a door in the form of its look; its collider is `<link>_main`."""
    t, w, h = look.thick, door.width, door.height
    name = f"{door.link}_main"
    if look.form is ApplianceFront.PANEL:
        for k, part in enumerate(fronts.front_parts(look.front, w, h)):
            finish = "glass_clear" if part.pane else door.face
            door.add_part(builder, part.solid, finish, "door", None if k else name, density="board", grain=part.grain)
        core = board((0.004, fronts.FRONT_THICKNESS + 2e-4, 0.004), (w - 0.004, t, h - 0.004), 0.002)
        door.add_part(builder, core, LINER_FINISH, "door", density="foamed_door_core")
        full_box = board((0.0, 0.0, 0.0), (w, t, h), 0.0)
        builder.add_collider(door.link, (full_box.mirrored_x() if door.right else full_box), LINER_FINISH, "door", name)
        return
    edge_radius, steps = {ApplianceFront.ROUND: (0.03, 5), ApplianceFront.SOFT: (0.011, 3)}.get(look.form, (0.003, 2))
    slab = board((0.0, (0.0042 if look.form is ApplianceFront.GLASS else 0.0), 0.0), (w, t, h), edge_radius, steps)
    shapes: tuple[Placed, ...] = (box_shape((0.0, 0.0, 0.0), (w, t, h)),)
    if hole is not None:
        slab = subtract(slab, _opening(hole))
        (x0, z0), (x1, z1) = hole
        shapes = (
            box_shape((0, 0, 0), (w, t, z0)),
            box_shape((0, 0, z1), (w, t, h)),
            box_shape((0, 0, z0), (x0, t, z1)),
            box_shape((x1, 0, z0), (w, t, z1)),
            box_shape((x0, NICHE_DEPTH, z0), (x1, t, z1)),
        )
    body = look.body if look.form is ApplianceFront.GLASS else door.face
    door.add_part(builder, slab.with_shapes(*shapes), body, "door", name, collider=name, density="foamed_door")
    if look.form is ApplianceFront.GLASS:
        pane = board((0.001, 0.0, 0.001), (w - 0.001, 0.004, h - 0.001), 0.0012)
        door.add_part(builder, subtract(pane, _opening(hole)) if hole else pane, door.face, "door", density="glass")
    if look.form is ApplianceFront.ROUND and h > 0.6:
        band = board((0.05, -0.0022, 0.0), (w - 0.05, 0.003, 0.012), 0.0018, 2)
        door.add_part(builder, band.translated(z=0.09), look.metal, "trim")


def _niche_hole(door: FridgeDoor, look: ApplianceLook) -> tuple[Vec2, Vec2]:
    """Corners of the dispenser's niche on the door, metres from the hinge's side and from its lower edge."""
    width, height = min(0.2, door.width - 0.15), 0.32
    z = min(max(1.0 - door.lower[1], 0.1), door.height - height - 0.2)
    middle = door.width / 2 - (0.012 if look.pull is not AppliancePull.LATCH else 0.0)
    return (middle - width / 2, z), (middle + width / 2, z + height)


def _opening(hole: tuple[Vec2, Vec2]) -> Solid:
    (x0, z0), (x1, z1) = hole
    return board((x0, -0.05, z0), (x1, NICHE_DEPTH, z1), 0.0)


def _dispenser(builder: AssetBuilder, door: FridgeDoor, hole: tuple[Vec2, Vec2]) -> None:
    (x0, z0), (x1, z1) = hole
    e, back, middle = 0.0015, NICHE_DEPTH, (x0 + x1) / 2
    dark = "plastic_black_gloss"
    outer, inner = ((x0, 0.0003, z0), (x1, back, z1)), ((x0 + e, 0.0003, z0 + e), (x1 - e, back - e, z1 - e))
    for corners in cavity_walls(outer, inner):
        door.add_part(builder, board(*corners, 0.0), dark, "dispenser", density="dispenser_lining")
    rim = 0.009
    ring = subtract(
        board((x0 - rim, -0.0018, z0 - rim), (x1 + rim, 0.0, z1 + rim + 0.062), 0.0006),
        board((x0, -0.1, z0), (x1, 0.1, z1), 0.0),
    )
    door.add_part(builder, ring, dark, "dispenser", density="dispenser_lining")
    for k, x in enumerate((-0.055, -0.018, 0.018, 0.055)):
        key = box((0.014, 0.0006, 0.014), (middle + x, -0.00215, z1 + 0.034), 0.0)
        door.add_part(builder, key, "display_blue" if k == 1 else "plastic_grey_light", "display", density=0.0)
    spout = box((0.05, 0.03, 0.03), (middle, back - 0.0165, z1 - e - 0.0155), 0.004, 2)
    paddle = box((0.04, 0.004, 0.09), (middle, back - 0.0125, z1 - 0.09), 0.0015)
    paddle = paddle.rotated("x", -0.12, (middle, back - 0.0125, z1 - 0.05))
    door.add_part(builder, spout, "plastic_grey_dark", "dispenser")
    door.add_part(builder, paddle, "plastic_grey_light", "dispenser")
    count = int((x1 - x0 - 0.03) / 0.012)
    for k in range(count):
        x = x0 + 0.015 + (x1 - x0 - 0.03) * (k + 0.5) / count
        slat = box((0.006, back - 0.012, 0.004), (x, (back - 0.004) / 2, z0 + e + 0.0023), 0.0008)
        door.add_part(builder, slat, "stainless_brushed", "dispenser")


def add_pull(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook) -> None:
    """Add the pull: near the free side at the height of a hand, or across the top where `door.across` is set."""
    w, h = door.width, door.height
    name = f"{door.link}_handle_main"
    latch = look.pull is AppliancePull.LATCH
    inset = 0.05 if look.pull is not AppliancePull.LEDGE else 0.016
    if door.across or latch:
        length = LATCH_LENGTH if latch else min(w - 0.12, max(0.24, look.share * 1.2 * w))
        middle = w / 2 if door.across else w - 0.03 - LATCH_LENGTH / 2
        z = h - min(door.pull_drop, 0.3 * h) if door.across else min(max(HAND_HEIGHT - door.lower[1], 0.1), h - 0.1)
        y = _depth(door, look, (middle - length / 2 + 0.05, z), (middle + length / 2 - 0.05, z))
        pull = handles.placed_handle(appliance_pull(look.pull, length), "z", 0.0, (middle, y, z))
    else:
        length = min(h - 0.12, max(0.26, look.share * h, 0.34 if look.pull is AppliancePull.PRO else 0.0))
        z_min, z_max = 0.06 + length / 2, h - 0.06 - length / 2
        z = min(max(HAND_HEIGHT - door.lower[1], z_min), z_max)
        inset = min(inset, 0.03) if look.form is ApplianceFront.PANEL and look.front in FRAMED_FRONTS else inset
        y = _depth(door, look, (w - inset, z - length / 2 + 0.05), (w - inset, z + length / 2 - 0.05))
        pull = handles.placed_handle(appliance_pull(look.pull, length), "y", -DOOR_TRAVEL, (w - inset, y, z))
    if door.right:
        first, *rest = pull.metal
        mirrored = first.with_shapes(*pull.shapes).mirrored_x()
        pull = handles.Handle((mirrored, *(s.mirrored_x() for s in rest)), mirrored.shapes)
    handles.add_handle(builder, door.link, pull, look.metal, name)


def _depth(door: FridgeDoor, look: ApplianceLook, *points: Vec2) -> float:
    """Distance of the feet of a pull behind the front plane, metres."""
    if look.form is not ApplianceFront.PANEL:
        return 0.0
    return fronts.face_depth(fronts.front_parts(look.front, door.width, door.height), points)


def _bins(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, rows: int, bottom: float, top: float) -> None:
    """Clear bins above each other; low and high are z on the door, metres."""
    t, r = look.thick, door.compartment
    a = min(door.inwards(r.lower[0]), door.inwards(r.upper[0])) + 0.012
    far = door.inwards(door.clearance_x) - 0.006
    # The far front corner swings round the hinge: by then it must have passed the wall beside it.
    b = math.sqrt(far * far - (t + DOOR_GAP + BIN_DEPTH) ** 2 + t * t)
    rows = min(rows, max(1, int((top - bottom) / MIN_BIN_PITCH)))
    pitch = (top - bottom) / rows
    for k in range(rows):
        _bin(builder, door, look, k, (max(a, t * 0.6), bottom + 0.012 + k * pitch), (b, bottom + (k + 1) * pitch))


def _bin(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, k: int, lower: Vec2, upper: Vec2) -> None:
    (x0, z), (x1, top) = lower, upper
    y0, y1, e = look.thick + 0.0124, look.thick + BIN_DEPTH, 0.004
    lip = min(0.085, 0.5 * (top - z))
    name = f"{door.name}_bin{k}"
    boards = (
        (board((x0, y0, z), (x1, y1, z + e), 0.001), f"{name}_bottom"),
        (board((x0, y1 - e, z + e), (x1, y1, z + lip), 0.001), f"{name}_front"),
        (board((x0, y0, z + e), (x0 + e, y1 - e, z + lip), 0.001), f"{name}_side_a"),
        (board((x1 - e, y0, z + e), (x1, y1 - e, z + lip), 0.001), f"{name}_side_b"),
    )
    for solid, collider in boards:
        door.add_part(builder, solid, "plastic_clear", "bin", collider=collider)
    rail = board((x0 - 0.001, y1 - 0.0055, z + lip), (x1 + 0.001, y1 + 0.0015, z + lip + 0.006), 0.001)
    door.add_part(builder, rail, look.trim, "bin")
    corners = ((x0 + e, y0, z + e), (x1 - e, y1 - e, top - 0.012))
    if door.right:
        corners = ((-x1 + e, y0, z + e), (-x0 - e, y1 - e, top - 0.012))
    # Ref: RoboCasa v1.0, Fridge: a region with `fridge` or `freezer` in its name is a shelf, and stays where it is.
    count = sum(region.name.startswith(BIN_REGION) for region in builder.regions)
    builder.region(f"{BIN_REGION}{count}", *corners, link=door.link)


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
