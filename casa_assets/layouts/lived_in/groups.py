"""Arrange the objects of a group to each other: a stack of plates, a row of mugs, fruit in a bowl."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Floats, about_axis
from casa_assets.layouts.compose.compose import box_in_world
from casa_assets.layouts.lived_in.spaces import CELL_M, Silhouette
from casa_assets.model.kitchen.habit import Arrangement
from casa_assets.model.pose import Pose

# Between the objects of a group, and over what each stands on, metres.
GAP_M, SET_DOWN_GAP_M = 0.008, 0.0003
# How much the objects of a row differ in direction and line, degrees and metres; at rest nobody sets them down alike.
ROW_TURN_DEG, ROW_SHIFT_M = 5.0, 0.004
# Places that are tried for each thing in a vessel, and how little above its floor it stands at most.
HEAP_TRIES, ON_FLOOR_M = 120, 0.0012
HOB_TURN_DEG = 30.0
# A plate leans in its slot, by less than this, and this far from what it leans on and from the wires in front of it.
MAX_LEAN_RAD, SLOT_GAP_M = 0.15, 0.0004
_SIDES = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])


@dataclass(frozen=True)
class Group:
    """Objects and their relative poses.

    Attributes:
        poses: group_from_asset of each; the middle of the group's footprint is the origin, its foot at z = 0.
        size: width, depth and height of the group, metres.
        body: point to place over a site, such as the middle of a pan without its handle; frame of the group, metres.
    """

    poses: tuple[Pose, ...]
    size: tuple[float, float, float]
    body: tuple[float, float] = (0.0, 0.0)


def arrange(arrangement: Arrangement, members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """A group of objects, a vessel or rack first; None if they do not fit together, such as a melon and a cup."""
    if arrangement is Arrangement.STACK:
        return _stack(members)
    if arrangement is Arrangement.HEAP:
        return _heap(members, rng)
    if arrangement is Arrangement.ON_EDGE:
        return _on_edge(members, rng)
    return _side_by_side(members, _turns(arrangement, members, rng), rng)


def _turns(arrangement: Arrangement, members: Sequence[Silhouette], rng: np.random.Generator) -> list[float]:
    """Angle of each member, radians."""
    if arrangement is Arrangement.LOOSE:
        return [float(rng.uniform(-math.pi, math.pi)) for _ in members]
    if arrangement is Arrangement.HANDLE_FRONT:
        jitter = [math.radians(float(rng.uniform(-HOB_TURN_DEG, HOB_TURN_DEG))) for _ in members]
        # The handle is turned to the front, -y.
        handles = [m.handle for m in members]
        to_front = [0.0 if h is None else -math.pi / 2 - math.atan2(float(h[1]), float(h[0])) for h in handles]
        return [a + j for a, j in zip(to_front, jitter, strict=True)]
    jitter = [math.radians(float(rng.uniform(-ROW_TURN_DEG, ROW_TURN_DEG))) for _ in members]
    if arrangement is Arrangement.ROW:
        return jitter
    # From front to back: a quarter turn for what is longer from left to right, its head to the back.
    wide = [np.ptp(m.box[:, 0]) > np.ptp(m.box[:, 1]) for m in members]
    return [(math.pi / 2 if w else 0.0) + 0.4 * j for w, j in zip(wide, jitter, strict=True)]


def turned_box(member: Silhouette, angle: float) -> Floats:
    """(2, 2) bounds seen from above of an object that is turned; frame of the asset, metres."""
    filled = np.argwhere(np.isfinite(member.low))
    centers = member.box[0, :2] + (filled + 0.5) * CELL_M
    corners = (centers[:, None] + CELL_M / 2 * _SIDES).reshape(-1, 2)
    points = corners @ about_axis(np.array([0.0, 0.0, 1.0]), angle)[:2, :2].T
    return np.array([points.min(axis=0), points.max(axis=0)])


def _upright(x: float, y: float, z: float, angle: float = 0.0) -> Pose:
    return Pose(position=(x, y, z), quaternion=(math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)))


def _side_by_side(members: Sequence[Silhouette], turns: Sequence[float], rng: np.random.Generator) -> Group:
    boxes = [turned_box(member, turn) for member, turn in zip(members, turns, strict=True)]
    width = sum(float(np.ptp(b[:, 0])) for b in boxes) + GAP_M * (len(boxes) - 1)
    poses, x, front, back = [], -width / 2, 0.0, 0.0
    for member, turn, box in zip(members, turns, boxes, strict=True):
        shift = float(rng.uniform(-ROW_SHIFT_M, ROW_SHIFT_M)) if len(boxes) > 1 else 0.0
        y = shift - float(box.mean(axis=0)[1])
        poses.append((x - float(box[0, 0]), y, -float(member.box[0, 2]) + SET_DOWN_GAP_M, turn))
        front, back = min(front, y + float(box[0, 1])), max(back, y + float(box[1, 1]))
        x += float(np.ptp(box[:, 0])) + GAP_M
    middle = (front + back) / 2
    height = max(float(np.ptp(m.box[:, 2])) for m in members)
    centered = tuple(_upright(px, py - middle, pz, turn) for px, py, pz, turn in poses)
    x, y, _ = (float(c) for c in centered[0].apply(np.array([[*members[0].body, 0.0]]))[0])
    return Group(centered, (width, back - front, height), (x, y) if len(members) == 1 else (0.0, 0.0))


def _stack(members: Sequence[Silhouette]) -> Group:
    first, pitch = members[0], members[0].pitch
    (x, y, _), foot = (float(c) for c in first.box.mean(axis=0)), float(first.box[0, 2])
    poses = [_upright(-x, -y, -foot + SET_DOWN_GAP_M + k * pitch) for k in range(len(members))]
    width, depth, height = (float(s) for s in np.ptp(first.box, axis=0))
    return Group(tuple(poses), (width, depth, height + (len(members) - 1) * pitch))


def _heap(members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """The first object upright, the others next to each other on its floor, each in a free place near its middle.

    No object leans against a wall or lies on another: in the light form of a scene, in which shapes are smaller, it
    would slide down. None if a place is not found for one of them.
    """
    vessel, *rest = members
    middle, foot = vessel.box.mean(axis=0), float(vessel.box[0, 2])
    ground = np.where(np.isfinite(vessel.high), vessel.high, np.inf)
    floor = float(ground.min())
    poses = [(0.0, 0.0, 0.0)]
    top = float(vessel.box[1, 2])
    for member in rest:
        low, extent = float(member.box[0, 2]), np.array(member.low.shape)
        room, filled = np.array(ground.shape) - extent, np.isfinite(member.low)
        if (room < 0).any():
            return None
        best: tuple[float, int, int, float] | None = None
        for _ in range(HEAP_TRIES):
            i, j = (int(rng.integers(0, r + 1)) for r in room)
            under = ground[i : i + extent[0], j : j + extent[1]]
            z = float((under[filled] - member.low[filled]).max())
            off_middle = float(np.hypot(*(np.array([i, j]) - room / 2)))
            if z + low < floor + ON_FLOOR_M and (best is None or off_middle < best[0]):
                best = (off_middle, i, j, z)
        if best is None:
            return None
        _, i, j, z = best
        # Nothing fits above or below it any more.
        ground[i : i + extent[0], j : j + extent[1]][filled] = np.inf
        corner = vessel.box[0, :2] + CELL_M * np.array([i, j]) - member.box[0, :2]
        poses.append((float(corner[0]), float(corner[1]), z + SET_DOWN_GAP_M))
        top = max(top, z + float(member.box[1, 2]))
    width, depth, _ = (float(s) for s in np.ptp(vessel.box, axis=0))
    lifted = [_upright(x - float(middle[0]), y - float(middle[1]), z - foot + SET_DOWN_GAP_M) for x, y, z in poses]
    return Group(tuple(lifted), (width, depth, top - foot))


def _on_edge(members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """The first object, a rack, upright; the others in its slots, leaning left; None: too few, or one does not fit."""
    rack, *plates = members
    spare = len(rack.slots) - len(plates)
    if spare < 0:
        return None
    first = int(rng.integers(0, spare + 1))
    spots = [_in_slot(rack, slot, plate) for slot, plate in zip(rack.slots[first:], plates, strict=False)]
    middle, foot = rack.box.mean(axis=0), float(rack.box[0, 2])
    poses, boxes = [_upright(-float(middle[0]), -float(middle[1]), SET_DOWN_GAP_M - foot)], [rack.box]
    for plate, spot in zip(plates, spots, strict=True):
        if spot is None:
            return None
        pose = poses[0] @ spot
        poses.append(pose)
        boxes.append(box_in_world(spot, plate.box))
    low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    # Plates may stand out at the left: the origin is the middle of all.
    off = Pose(position=(float(middle[0] - (low + high)[0] / 2), float(middle[1] - (low + high)[1] / 2), 0.0))
    width, depth, height = (float(s) for s in high - low)
    return Group(tuple(off @ pose for pose in poses), (width, depth, height))


def _in_slot(rack: Silhouette, slot: Floats, plate: Silhouette) -> Pose | None:
    """rack_from_plate of a plate in a slot: its foot on the tips of the left tines, its rim before the right ones.

    `slot`: (2, 3) bounds between the tines.
    """
    (half_x, half_y, _), (wide, _, high) = np.ptp(plate.box, axis=0) / 2, slot[1] - slot[0]
    thick, lowest_by_x = float(np.ptp(plate.box[:, 2])), plate.low.min(axis=1)
    rim_low = float(lowest_by_x[np.isfinite(lowest_by_x)][-1] - plate.box[0, 2])
    play = wide - 2 * SLOT_GAP_M - thick
    if play <= 0:
        return None
    lean = min(MAX_LEAN_RAD, math.asin(min(1.0, play / high)))
    sine, cosine = math.sin(lean), math.cos(lean)
    z = slot[0, 2] + SET_DOWN_GAP_M + half_x * cosine - rim_low * sine
    x = slot[0, 0] + SLOT_GAP_M - (z - slot[1, 2]) / cosine * sine
    y = float(slot[:, 1].mean())
    # Where the plate is wide it must be above the walls of the rack.
    i0, i1 = ((slot[:, 0] - rack.box[0, 0]) / CELL_M).astype(int)
    ys = rack.box[0, 1] + (np.arange(rack.high.shape[1]) + 0.5) * CELL_M - y
    round_ = np.sqrt(np.maximum(0.0, 1.0 - (ys / half_y) ** 2))
    lowest = np.where(np.abs(ys) < half_y, z - half_x * cosine * round_ + rim_low * sine, np.inf)
    if (rack.high[i0 + 1 : i1].max(axis=0) > lowest + CELL_M / 2).any():
        return None
    turned = Pose(quaternion=(math.cos(math.pi / 4 - lean / 2), 0.0, math.sin(math.pi / 4 - lean / 2), 0.0))
    own = np.array([*plate.box[:, :2].mean(axis=0), plate.box[0, 2]])
    shift = turned.apply(own[None])[0]
    return turned.replace(position=(float(x - shift[0]), float(y - shift[1]), float(z - shift[2])))
