"""Drawers: fronts with boxes on runners, crispers of refrigerators, and boxes behind the fronts of imported bodies."""

from __future__ import annotations

from casa_assets.ext.records import Vec2, Vec3
from casa_assets.ext.solids import ROOT, AssetBuilder, board, box
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.appliance import ApplianceLook
from casa_assets.kitchenware.parts.cases import tub_walls
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

CRISPER_WALL = 0.0035  # metres; injection moulded
LIP_DEPTH = 0.024  # how far the lip of a crisper stands out before its front
CRISPER_PULL = 0.62  # part of its depth that a crisper slides out
DRAWER_SIDE_CLEARANCE, DRAWER_TOP_CLEARANCE = 0.008, 0.014
DRAWER_SIDE_THICKNESS, DRAWER_BASE_THICKNESS = 0.01, 0.006
DRAWER_MAX_HEIGHT = 0.22


def min_front_height(look: CabinetLook, boarded: bool = True) -> float:
    """Height of the lowest front with room for a drawer's box over a board, or over another drawer; metres."""
    return (0.155 if look.handle is HandleKind.FINGER_GROOVE else 0.115) + (0.018 if boarded else 0.0)


def add_drawer(
    builder: AssetBuilder, look: CabinetLook, names: tuple[str, str, str], at: Vec2, size: Vec2, room: tuple[Vec3, Vec3]
) -> None:
    """Put a drawer into a cabinet; its region moves with it. The front's face lies in y = 0.

    names: of its link, its joint and its region. at, size: lower left corner (x, z) and size of its front, metres.
    room: corners of the space for its box, from the carcass's front edge to the inner face of its back.
    """
    (link, joint, region), (x, z0), (w, h), kind = names, at, size, look.handle
    builder.link(link, at=(x, 0.0, z0))
    grip = f"{link}_handle"
    if kind is HandleKind.EDGE_PULL:
        h -= EDGE_PULL_ROOM
    groove = FrontEdge.TOP if kind is HandleKind.FINGER_GROOVE else None
    parts = fronts.front_parts(look.front, w, h, FRONT_THICKNESS, drawer=True, groove=groove)
    main, size_of = f"{link}_main", (w, FRONT_THICKNESS, h)
    fronts.add_front(builder, link, parts, size_of, look.face, "", label="drawer", name=main, groove=groove, grip=grip)
    pull = None
    if kind is HandleKind.EDGE_PULL:
        pull = placed_edge_pull(FrontEdge.TOP, w, h, max(look.length, 0.3 * w), (0.0, 0.0, 0.0))
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
    if pull:
        handles.add_handle(builder, link, pull, look.metal, grip)
    depth = _box(builder, look, link, region, at, room)
    builder.slide(joint, link, (0.0, 1.0, 0.0), (-min(MAX_TRAVEL, round(depth - 0.06, 3)), 0.0), grip)


def _box(builder: AssetBuilder, look: CabinetLook, link: str, region: str, at: Vec2, room: tuple[Vec3, Vec3]) -> float:
    """The box behind the front, in the link's frame; returns its depth."""
    (x, z0), (lower, upper), t = at, room, SIDE_THICKNESS
    x0, x1 = lower[0] + SIDE_CLEARANCE - x, upper[0] - SIDE_CLEARANCE - x
    y0, y1 = FRONT_THICKNESS, upper[1] - 0.03
    bottom, top = lower[2] + 0.008 - z0, upper[2] - 0.016 - z0
    top = min(top, bottom + 0.22)  # boxes of drawers are not made higher, whatever the front
    across, along = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    sides = [board((x, y0 + t, bottom), (x + t, y1, top)) for x in (x0, x1 - t)]
    builder.add(link, sides, look.tray, "drawer", grain=along, density="board")
    back, end_top = y1 - t, top - 0.0015
    ends = [board((x0, y0, bottom), (x1, y0 + t, end_top)), board((x0 + t, back, bottom), (x1 - t, back + t, end_top))]
    builder.add(link, ends, look.tray, "drawer", grain=across, density="board")
    base = bottom + BASE_RAISE + BASE_THICKNESS
    floor = board((x0 + t, y0 + t, bottom + BASE_RAISE), (x1 - t, y1 - t, base), 0.0)
    builder.add(link, floor, look.tray, "drawer", name=f"{link}_base", density="board")
    builder.region(region, (x0 + t, y0 + t, base), (x1 - t, y1 - t, top), link=link)
    z = z0 + bottom + 0.02
    for x in (lower[0], upper[0] - RUNNER_THICKNESS):
        runner = board((x, lower[1] + 0.004, z), (x + RUNNER_THICKNESS, y1 - 0.01, z + 0.035), 0.0008)
        builder.draw(ROOT, runner, "steel_galvanised", "runner", density="drawer_runner")
    return y1 - y0


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
    walls = tub_walls(((-half, 0.0, 0.0), (half, d, h - rim)), ((-half + e, e + 0.002, e), (half - e, d - e, h)))
    for corners, part in zip(walls, ("bottom", "front", "back", "left", "right"), strict=True):
        builder.add(name, board(*corners, 0.001), finish, "drawer", collider=f"{name}_{part}", density="ribbed_plastic")
    rims = [board((-half - 0.002, -0.003, h - 0.03), (half + 0.002, e + 0.003, h), 0.002, 2)]
    for x0, x1 in ((-half - 0.002, -half + e + 0.002), (half - e - 0.002, half + 0.002)):
        rims.append(board((x0, e + 0.0032, h - rim), (x1, d, h), 0.001))
    builder.draw(name, rims, look.trim, "drawer", density="ribbed_plastic")
    width = min(0.3, 0.7 * w)
    lip = box((width, LIP_DEPTH - 0.0034, 0.007), (0.0, -0.0032 - (LIP_DEPTH - 0.0034) / 2, h - 0.0065), 0.002, 2)
    hook = box((width, 0.006, 0.014), (0.0, -LIP_DEPTH + 0.003, h - 0.014), 0.002)
    collider_box = board((-width / 2, -LIP_DEPTH, h - 0.021), (width / 2, -0.003, h - 0.003), 0.0)
    builder.draw(name, (lip, hook), look.trim, "handle", density="ribbed_plastic")
    builder.add_collider(name, collider_box, look.trim, "handle", f"{name}_handle_main")
    travel = crisper_travel(d)
    span, grip = (-travel, 0.0), f"{name}_handle_main"
    builder.slide(f"{name}_joint", name, (0.0, 1.0, 0.0), span, grip, start_n=6.0, behind=behind)
    builder.region(name, (-half + e, e + 0.002, e), (half - e, d - e, h - 0.004), link=name)


def add_drawer_box(builder: AssetBuilder, link: str, region: str, lower: Vec3, upper: Vec3, finish: str) -> float:
    """A box behind a front, on its link, in a room between two corners in that frame; returns its depth, metres."""
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
