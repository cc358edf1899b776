"""Drawers: a front, a box with sides of real thickness behind it, on runners."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.blocks import board
from casa_assets.families.parts.fronts import fronts
from casa_assets.families.parts.fronts.doors import EDGE_PULL_ROOM, placed_edge_pull
from casa_assets.families.parts.fronts.fronts import FRONT_THICKNESS, FrontEdge
from casa_assets.families.parts.fronts.look import CabinetLook
from casa_assets.families.parts.hardware import handles
from casa_assets.families.parts.hardware.handles import HandleKind

SIDE_THICKNESS, BASE_THICKNESS = 0.014, 0.008  # thickness of a drawer's sides and bottom, metres
RUNNER_THICKNESS = 0.008  # of the runner, which fills most of the room beside the box
SIDE_CLEARANCE = 0.013  # room beside the box, as side-mounted runners need it
MAX_TRAVEL = 0.65  # metres; runners of full extension are hardly made longer
DEEP_FRONT = 0.28  # height from which a pull is high on a front, metres
RING_FOOT = 0.024  # of a ring's foot from the upper edge of a deep front, which it hangs down from, metres
BASE_RAISE = 0.006  # the bottom sits in a groove so far above the lower edge of the sides


def min_front_height(look: CabinetLook, boarded: bool = True) -> float:
    """Height of the lowest front behind which there is room for a drawer's box, metres.

    Args:
        boarded: whether it runs over a board, which takes a part of its room, or over another drawer.
    """
    return (0.155 if look.handle is HandleKind.FINGER_GROOVE else 0.115) + (0.018 if boarded else 0.0)


@dataclass(frozen=True)
class CabinetDrawer:
    """A drawer.

    Attributes:
        link, joint, region: their names.
        x, z, width, height: lower left corner and size of its front, metres.
        left, right: inner faces of the carcass. floor, ceiling: of its room. front, back: y of the carcass's front edge
            and of the inner face of its back.
    """

    link: str
    joint: str
    region: str
    x: float
    z: float
    width: float
    height: float
    left: float
    right: float
    floor: float
    ceiling: float
    front: float
    back: float


def add_drawer(builder: AssetBuilder, look: CabinetLook, d: CabinetDrawer) -> None:
    """Put a drawer into a cabinet; its region moves with it. The front's face lies in y = 0."""
    builder.link(d.link, at=(d.x, 0.0, d.z))
    grip = f"{d.link}_handle"
    _front(builder, look, d, grip)
    depth = _box(builder, look, d)
    builder.slide(d.joint, d.link, (0.0, 1.0, 0.0), (-min(MAX_TRAVEL, round(depth - 0.06, 3)), 0.0), grip)


def _front(builder: AssetBuilder, look: CabinetLook, d: CabinetDrawer, grip: str) -> None:
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


def _box(builder: AssetBuilder, look: CabinetLook, d: CabinetDrawer) -> float:
    """The box behind the front, in the link's frame; returns its depth."""
    x0, x1 = d.left + SIDE_CLEARANCE - d.x, d.right - SIDE_CLEARANCE - d.x
    y0, y1 = FRONT_THICKNESS, d.back - 0.03
    bottom, top = d.floor + 0.008 - d.z, d.ceiling - 0.016 - d.z
    top = min(top, bottom + 0.22)  # boxes of drawers are not made higher, whatever the front
    across, along = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    for x in (x0, x1 - SIDE_THICKNESS):
        side = board((x, y0 + SIDE_THICKNESS, bottom), (x + SIDE_THICKNESS, y1, top))
        builder.add(d.link, side, look.tray, label="drawer", grain=along, density="board")
    for y, end_top in ((y0, top - 0.0015), (y1 - SIDE_THICKNESS, top - 0.0015)):
        inner = (x0 + SIDE_THICKNESS, x1 - SIDE_THICKNESS) if y > y0 else (x0, x1)
        end = board((inner[0], y, bottom), (inner[1], y + SIDE_THICKNESS, end_top))
        builder.add(d.link, end, look.tray, label="drawer", grain=across, density="board")
    base = bottom + BASE_RAISE + BASE_THICKNESS
    floor = board(
        (x0 + SIDE_THICKNESS, y0 + SIDE_THICKNESS, bottom + BASE_RAISE),
        (x1 - SIDE_THICKNESS, y1 - SIDE_THICKNESS, base),
        0.0,
    )
    builder.add(d.link, floor, look.tray, label="drawer", name=f"{d.link}_base", density="board")
    builder.region(
        d.region,
        (x0 + SIDE_THICKNESS, y0 + SIDE_THICKNESS, base),
        (x1 - SIDE_THICKNESS, y1 - SIDE_THICKNESS, top),
        link=d.link,
    )
    for x in (d.left, d.right - RUNNER_THICKNESS):
        z = d.z + bottom + 0.02
        runner = board((x, d.front + 0.004, z), (x + RUNNER_THICKNESS, y1 - 0.01, z + 0.035), 0.0008)
        builder.add(ROOT, runner, "steel_galvanised", label="runner", collider=False, density="drawer_runner")
    return y1 - y0
