"""Doors of cabinets on a hinge, with their handles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.ext.records import Pose, Vec3, Vec4
from casa_assets.ext.solids import AssetBuilder, axis_turn, rod
from casa_assets.kitchenware.parts import fronts, handles
from casa_assets.kitchenware.parts.fronts import FRONT_THICKNESS, CabinetLook, FrontEdge, FrontPart
from casa_assets.kitchenware.parts.handles import HandleKind

# Ref: RoboCasa v1.0, HingeCabinet: leftdoorhinge -1.57..0, rightdoorhinge 0..1.57. A door whose handle stands out stops
# a little before, so that nothing of it ever leaves its own width: its neighbours open at the same time.
DOOR_TRAVEL = 1.57
HANDLE_CLEARANCE = 0.001  # metres that a handle keeps from the edge of its door's room
HAND_HEIGHT = 1.05  # metres above the floor at which tall doors are taken
MIN_UPRIGHT_BAR_DOOR = 0.3  # metres; lower doors have no room for a bar that stands upright
EDGE_PULL_ROOM = 0.0026  # room for the sheet of an edge pull

HingeSide = StrEnum("HingeSide", "LEFT RIGHT")

# Height of a door's handle: high on base units, low on wall units, in the middle of tall ones.
HandleHeight = StrEnum("HandleHeight", "HIGH LOW MIDDLE")


@dataclass(frozen=True)
class CabinetDoor:
    """A door; lengths in metres, gaps are the caller's.

    link, joint: their names. hinge: its side. x, z: lower left corner of its room; width, height: of its room.
    handle_height: where its handle is. turn: angle about z of the plane in which it lies, rad; (x, y) is its origin.
    """

    link: str
    joint: str
    hinge: HingeSide
    x: float
    z: float
    width: float
    height: float
    handle_height: HandleHeight
    turn: float = 0.0
    y: float = 0.0


def hang_door(builder: AssetBuilder, look: CabinetLook, door: CabinetDoor) -> None:
    """Put a door on the cabinet. Its face lies in y = 0 where it is not turned."""
    kind = look.handle
    if kind is HandleKind.FINGER_GROOVE and door.handle_height is HandleHeight.MIDDLE:
        kind = HandleKind.EDGE_PULL
    if kind is HandleKind.CUP or (kind not in handles.EDGE_HANDLES and door.height < MIN_UPRIGHT_BAR_DOOR):
        kind = HandleKind.KNOB
    free = FrontEdge.RIGHT if door.hinge is HingeSide.LEFT else FrontEdge.LEFT
    edges = {HandleHeight.HIGH: FrontEdge.TOP, HandleHeight.LOW: FrontEdge.BOTTOM, HandleHeight.MIDDLE: free}
    edge = edges[door.handle_height]
    w, h, x, z = door.width, door.height, 0.0, 0.0
    if kind is HandleKind.EDGE_PULL:
        w, h, x, z = _shortened(w, h, edge)
    start = x if door.hinge is HingeSide.LEFT else x - door.width
    along = axis_turn("z", door.turn)
    axis = along.apply(np.array([[0.0 if door.hinge is HingeSide.LEFT else door.width, 0.0, 0.0]]))[0]
    builder.link(door.link, at=Pose(position=(door.x + float(axis[0]), door.y + float(axis[1]), door.z)) @ along)
    groove = edge if kind is HandleKind.FINGER_GROOVE else None
    parts = fronts.front_parts(look.front, w, h, FRONT_THICKNESS, groove=groove)
    grip = f"{door.link}_handle"
    glass = fronts.glass_of(look.front)
    main = f"{door.link}_main"
    corner = (start, 0.0, z)
    size = (w, FRONT_THICKNESS, h)
    fronts.add_front(builder, door.link, parts, size, look.face, glass, name=main, at=corner, groove=groove, grip=grip)
    if kind is HandleKind.EDGE_PULL:
        pull: handles.Handle | None = placed_edge_pull(edge, w, h, look.length, corner, door.hinge)
    else:
        pull = None if groove else _handle(look, door, kind, parts, corner)
    if pull is not None:
        handles.add_handle(builder, door.link, pull, look.metal, grip)
    count = 2 if h < 0.9 else 3 if h < 1.6 else 4
    x = corner[0] + (0.032 if door.hinge is HingeSide.LEFT else w - 0.032)
    rim = min(0.1, 0.25 * h)
    for k in range(count):
        z = corner[2] + rim + (h - 2 * rim) * k / (count - 1)
        cup = rod(0.0125, 0.003, 0.0006, "y").translated(x, FRONT_THICKNESS + 0.0003, z)
        builder.draw(door.link, cup, "nickel_satin", "hinge")
    travel = max_swing(pull) if pull is not None else DOOR_TRAVEL
    span = (-travel, 0.0) if door.hinge is HingeSide.LEFT else (0.0, travel)
    builder.hinge(door.joint, door.link, (0.0, 0.0, 1.0), span, grip)


def max_swing(pull: handles.Handle) -> float:
    """Largest angle of a door about the axis x = y = 0 with its handle within the door's own width, radians."""
    points = np.concatenate([s.points for s in (*pull.metal, *pull.leather)])
    out = points[points[:, 1] < 0.0]
    if not len(out):
        return DOOR_TRAVEL
    # At the angle a, a point that is x from the axis and y before it has come to x cos a - y sin a.
    x, y = np.abs(out[:, 0]) - HANDLE_CLEARANCE, -out[:, 1]
    return min(DOOR_TRAVEL, math.floor(float(np.arctan2(x, y).min()) * 100) / 100)


def placed_edge_pull(
    edge: FrontEdge, w: float, h: float, length: float, corner: Vec3, hinge: HingeSide | None = None
) -> handles.Handle:
    """An edge pull on an edge of a front whose lower left front corner is given; of a door away from its hinge."""
    level = edge in (FrontEdge.TOP, FrontEdge.BOTTOM)
    pull_length = min(length, (w if level else h) - 0.05)
    if level and hinge is not None:
        pull_length = min(pull_length, 0.5 * w)
    pull = handles.edge_pull(pull_length)
    free = {None: w / 2, HingeSide.LEFT: w - 0.025 - pull_length / 2, HingeSide.RIGHT: 0.025 + pull_length / 2}
    angle = {FrontEdge.TOP: 0.0, FrontEdge.BOTTOM: math.pi, FrontEdge.RIGHT: math.pi / 2, FrontEdge.LEFT: -math.pi / 2}[
        edge
    ]
    x = {FrontEdge.LEFT: 0.0, FrontEdge.RIGHT: w}.get(edge, free[hinge])
    # A tall door is taken at hand height whatever its own height.
    z = {FrontEdge.BOTTOM: 0.0, FrontEdge.TOP: h}.get(edge, h / 2)
    return handles.placed_handle(pull, "y", angle, (corner[0] + x, corner[1], corner[2] + z))


def _shortened(w: float, h: float, edge: FrontEdge) -> Vec4:
    if edge in (FrontEdge.TOP, FrontEdge.BOTTOM):
        return w, h - EDGE_PULL_ROOM, 0.0, EDGE_PULL_ROOM if edge is FrontEdge.BOTTOM else 0.0
    return w - EDGE_PULL_ROOM, h, EDGE_PULL_ROOM if edge is FrontEdge.LEFT else 0.0, 0.0


def _handle(
    look: CabinetLook, door: CabinetDoor, kind: HandleKind, parts: tuple[FrontPart, ...], corner: Vec3
) -> handles.Handle:
    w, h = door.width, door.height
    stile, rail = fronts.frame_widths(look.front, w, h)
    inset = stile / 2 if fronts.has_frame(look.front) else min(0.045, 0.3 * w)
    upright = kind not in handles.LEVEL_HANDLES
    length = handles.handle_length(kind, min(look.length, 0.6 * h))
    if not upright:  # neighbours' handles keep clear of each other
        inset = max(inset, length / 2 + 0.005)
    offset = (length / 2 if upright else 0.02) + max(0.045, 0.5 * rail)
    low = offset + (length - 0.02 if kind is HandleKind.RING else 0.0)  # a ring hangs down from its foot
    z = {HandleHeight.HIGH: h - offset, HandleHeight.LOW: low}.get(
        door.handle_height, min(max(HAND_HEIGHT - door.z, offset), h - offset)
    )
    x = w - inset if door.hinge is HingeSide.LEFT else inset
    half = max(0.0, length / 2 - 0.03) if upright else 0.0
    y = fronts.face_depth(parts, [(x, z - half), (x, z + half)])
    pull = handles.handle(kind, length)
    angle = math.pi / 2 if upright else 0.0
    return handles.placed_handle(pull, "y", angle, (corner[0] + x, corner[1] + y, corner[2] + z))
