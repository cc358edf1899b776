"""Drawers: fronts with boxes on runners, crispers of refrigerators, and boxes behind the fronts of imported bodies."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.ext.records import Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, board, box
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.appliance import ApplianceLook
from casa_assets.kitchenware.parts.doors import EDGE_PULL_ROOM, placed_edge_pull
from casa_assets.kitchenware.parts.fronts import FRONT_THICKNESS, CabinetLook, FrontEdge
from casa_assets.kitchenware.parts.handles import HandleKind

SIDE_THICKNESS, BASE_THICKNESS = 0.014, 0.008  # thickness of a drawer's sides and bottom, metres
RUNNER_THICKNESS = 0.008  # of the runner, which fills most of the room beside the box
SIDE_CLEARANCE = 0.013  # room beside the box, as side-mounted runners need it
MAX_TRAVEL = 0.65  # metres; runners of full extension are hardly made longer
DEEP_FRONT = 0.28  # height from which a pull is high on a front, metres
RING_FOOT = 0.024  # of a ring's foot from the upper edge of a deep front, which it hangs down from, metres
BASE_RAISE = 0.006  # the bottom sits in a groove so far above the lower edge of the sides


def min_front_height(look: CabinetLook, boarded: bool = True) -> float:
    """Height of the lowest front behind which there is room for a drawer's box, metres.

    boarded: whether it runs over a board, which takes a part of its room, or over another drawer.
    """
    return (0.155 if look.handle is HandleKind.FINGER_GROOVE else 0.115) + (0.018 if boarded else 0.0)


@dataclass(frozen=True)
class CabinetDrawer:
    """A drawer.

    link, joint, region: names. x, z, width, height: lower left corner and size of its front, metres. lower, upper:
    corners of its room, from the carcass's front edge to the inner face of its back.
    """

    link: str
    joint: str
    region: str
    x: float
    z: float
    width: float
    height: float
    lower: Vec3
    upper: Vec3


def add_drawer(builder: AssetBuilder, look: CabinetLook, d: CabinetDrawer) -> None:
    """Put a drawer into a cabinet; its region moves with it. The front's face lies in y = 0."""
    builder.link(d.link, at=(d.x, 0.0, d.z))
    grip = f"{d.link}_handle"
    w, h, kind = d.width, d.height, look.handle
    if kind is HandleKind.EDGE_PULL:
        h -= EDGE_PULL_ROOM
    groove = FrontEdge.TOP if kind is HandleKind.FINGER_GROOVE else None
    parts = fronts.front_parts(look.front, w, h, FRONT_THICKNESS, drawer=True, groove=groove)
    size = (w, FRONT_THICKNESS, h)
    main = f"{d.link}_main"
    fronts.add_front(builder, d.link, parts, size, look.face, "", label="drawer", name=main, groove=groove, grip=grip)
    if kind is HandleKind.EDGE_PULL:
        pull = placed_edge_pull(FrontEdge.TOP, w, h, max(look.length, 0.3 * w), (0.0, 0.0, 0.0))
        handles.add_handle(builder, d.link, pull, look.metal, grip)
    elif groove is None:
        kind = HandleKind.BAR if kind is HandleKind.TEE and w > 0.5 else kind
        length = handles.handle_length(kind, min(max(look.length, 0.22 * w), 0.6 * w))
        # Pulls sit in the middle of a front, but high on a deep one, where a hand need not reach far down.
        z = h / 2
        if h >= DEEP_FRONT:
            rail = fronts.frame_widths(look.front, w, h, drawer=True)[1]
            z = h - rail / 2 if fronts.has_frame(look.front) else 0.8 * h
            z = max(z, h - RING_FOOT) if kind is HandleKind.RING else z
        half = max(0.0, length / 2 - 0.03)
        y = fronts.face_depth(parts, [(w / 2 - half, z), (w / 2, z), (w / 2 + half, z)])
        lift = 0.02 if kind is HandleKind.RING and h < DEEP_FRONT else 0.0
        pull = handles.placed_handle(handles.handle(kind, length), "x", 0.0, (w / 2, y, z + lift))
        handles.add_handle(builder, d.link, pull, look.metal, grip)
    depth = _box(builder, look, d)
    builder.slide(d.joint, d.link, (0.0, 1.0, 0.0), (-min(MAX_TRAVEL, round(depth - 0.06, 3)), 0.0), grip)


def _box(builder: AssetBuilder, look: CabinetLook, d: CabinetDrawer) -> float:
    """The box behind the front, in the link's frame; returns its depth."""
    x0, x1 = d.lower[0] + SIDE_CLEARANCE - d.x, d.upper[0] - SIDE_CLEARANCE - d.x
    y0, y1 = FRONT_THICKNESS, d.upper[1] - 0.03
    bottom, top = d.lower[2] + 0.008 - d.z, d.upper[2] - 0.016 - d.z
    top = min(top, bottom + 0.22)  # boxes of drawers are not made higher, whatever the front
    across, along = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    sides = [board((x, y0 + SIDE_THICKNESS, bottom), (x + SIDE_THICKNESS, y1, top)) for x in (x0, x1 - SIDE_THICKNESS)]
    builder.add(d.link, sides, look.tray, "drawer", grain=along, density="board")
    for y, end_top in ((y0, top - 0.0015), (y1 - SIDE_THICKNESS, top - 0.0015)):
        inner = (x0 + SIDE_THICKNESS, x1 - SIDE_THICKNESS) if y > y0 else (x0, x1)
        end = board((inner[0], y, bottom), (inner[1], y + SIDE_THICKNESS, end_top))
        builder.add(d.link, end, look.tray, "drawer", grain=across, density="board")
    base = bottom + BASE_RAISE + BASE_THICKNESS
    floor = board(
        (x0 + SIDE_THICKNESS, y0 + SIDE_THICKNESS, bottom + BASE_RAISE),
        (x1 - SIDE_THICKNESS, y1 - SIDE_THICKNESS, base),
        0.0,
    )
    builder.add(d.link, floor, look.tray, "drawer", name=f"{d.link}_base", density="board")
    builder.region(
        d.region,
        (x0 + SIDE_THICKNESS, y0 + SIDE_THICKNESS, base),
        (x1 - SIDE_THICKNESS, y1 - SIDE_THICKNESS, top),
        link=d.link,
    )
    for x in (d.lower[0], d.upper[0] - RUNNER_THICKNESS):
        z = d.z + bottom + 0.02
        runner = board((x, d.lower[1] + 0.004, z), (x + RUNNER_THICKNESS, y1 - 0.01, z + 0.035), 0.0008)
        builder.draw(ROOT, runner, "steel_galvanised", "runner", density="drawer_runner")
    return y1 - y0


CRISPER_WALL = 0.0035  # metres; injection moulded
LIP_DEPTH = 0.024  # how far the lip of a crisper stands out before its front
CRISPER_PULL = 0.62  # part of its depth that a crisper slides out


def crisper_travel(depth: float) -> float:
    """How far a crisper of a depth slides out, metres."""
    return round(CRISPER_PULL * depth, 3)


def crisper_reach(front: float, back: float) -> float:
    """How far before y = 0 the lip of a crisper between two y comes, metres."""
    return crisper_travel(back - front - LIP_DEPTH) - front


def add_crisper(
    builder: AssetBuilder,
    name: str,
    behind: str,
    lower: Vec3,
    upper: Vec3,
    look: ApplianceLook,
    finish: str = "plastic_clear",
) -> None:
    """A drawer in a room, open on top; its link is `name`, its joint `<name>_joint`.

    behind: joint of the door in front of it. lower, upper: corners of the space it may take, metres; lower[1] is where
    its lip begins. finish: of its body.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    builder.link(name, at=((x0 + x1) / 2, y0 + LIP_DEPTH, z0))
    w, d, h, e = x1 - x0, y1 - y0 - LIP_DEPTH, z1 - z0, CRISPER_WALL
    half, rim = w / 2, 0.012
    for solid, part in (
        (board((-half, 0.0, 0.0), (half, d, e), 0.001), "bottom"),
        (board((-half, 0.0, e), (half, e + 0.002, h - rim), 0.001), "front"),
        (board((-half, d - e, e), (half, d, h - rim), 0.001), "back"),
        (board((-half, e + 0.002, e), (-half + e, d - e, h - rim), 0.001), "left"),
        (board((half - e, e + 0.002, e), (half, d - e, h - rim), 0.001), "right"),
    ):
        builder.add(name, solid, finish, "drawer", collider=f"{name}_{part}", density="ribbed_plastic")
    for solid in (
        board((-half - 0.002, -0.003, h - 0.03), (half + 0.002, e + 0.003, h), 0.002, 2),
        board((-half - 0.002, e + 0.0032, h - rim), (-half + e + 0.002, d, h), 0.001),
        board((half - e - 0.002, e + 0.0032, h - rim), (half + 0.002, d, h), 0.001),
    ):
        builder.draw(name, solid, look.trim, "drawer", density="ribbed_plastic")
    width = min(0.3, 0.7 * w)
    lip = box((width, LIP_DEPTH - 0.0034, 0.007), (0.0, -0.0032 - (LIP_DEPTH - 0.0034) / 2, h - 0.0065), 0.002, 2)
    hook = box((width, 0.006, 0.014), (0.0, -LIP_DEPTH + 0.003, h - 0.014), 0.002)
    collider_box = board((-width / 2, -LIP_DEPTH, h - 0.021), (width / 2, -0.003, h - 0.003), 0.0)
    builder.draw(name, (lip, hook), look.trim, "handle", density="ribbed_plastic")
    builder.add_collider(name, collider_box, look.trim, "handle", f"{name}_handle_main")
    travel = crisper_travel(d)
    builder.slide(
        f"{name}_joint", name, (0.0, 1.0, 0.0), (-travel, 0.0), f"{name}_handle_main", start_n=6.0, behind=behind
    )
    builder.region(name, (-half + e, e + 0.002, e), (half - e, d - e, h - 0.004), link=name)


DRAWER_SIDE_CLEARANCE, DRAWER_TOP_CLEARANCE = 0.008, 0.014
DRAWER_SIDE_THICKNESS, DRAWER_BASE_THICKNESS = 0.01, 0.006
DRAWER_MAX_HEIGHT = 0.22


def add_drawer_box(builder: AssetBuilder, link: str, region: str, lower: Vec3, upper: Vec3, finish: str) -> float:
    """A box behind a front, on its link; returns how deep it is, metres.

    link: of the drawer, its frame that of the room. region: name of its inside. lower, upper: corners of its room.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
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
        builder.add(link, board(low, high, 0.0005), finish, "drawer", grain=grain, density=0.0)
    builder.region(region, (x0 + side, y0 + side, z0 + base), (x1 - side, y1 - side, z1), link=link)
    return y1 - y0
