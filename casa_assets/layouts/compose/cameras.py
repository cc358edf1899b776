"""Cameras of a kitchen: from outside over all of it, into it, at each place of work, and as a robot sees it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.room import WallLine
from casa_assets.layouts.plan.runs import UnitSlot
from casa_assets.model.kitchen.plan import BaseKind
from casa_assets.model.kitchen.scene import Camera
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

FOV_DEG = 50.0
ASPECT = 4 / 3  # width over height of the overview
FRAME_FILL = 0.95  # share of the overview that the room fills
EYE_HEIGHT_M = 1.45  # of a robot of human height
ROBOT_EYE = "robot_eye_"  # begin of the names of its cameras
# Of a camera that looks at a wall: its distance, the height at which it does, the sine of its angle with the wall.
LEAST_BEFORE_WALL_M, WALL_MIDDLE_M, LEAST_SINE = 0.3, 1.2, 0.3
ROBOT_CLEARANCE_M = 0.3  # between the robot and what is on the floor
VIEW_ANGLES_DEG, VIEW_STEPS, VIEW_STEP_M = (-24, -16, -8, 0, 8, 16, 24), 40, 0.1  # rays that measure its view
Box = tuple[float, float, float, float]
WORKPLACES = {
    BaseKind.SINK: "sink",
    BaseKind.RANGE: "stove",
    BaseKind.HOB: "stove",
    BaseKind.FRIDGE: "fridge",
    BaseKind.OVEN: "oven",
    BaseKind.ISLAND: "island",
}


def cameras(kitchen: KitchenRequest) -> tuple[Camera, ...]:
    """Overview over the open side, straight from above, places of work, two robot eyes, one more per unseen wall."""
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    high = max((x1 - x0) / ASPECT, y1 - y0) / 2 / math.tan(math.radians(20.0)) * 1.06 + 2.4
    above = Pose(position=((x0 + x1) / 2, (y0 + y1) / 2, round(high, 4)))
    out = [_overview(kitchen, x0, y0, x1, y1), Camera(name="above", pose=above, fov_y_deg=40.0)]
    seen: set[str] = set()
    for row in kitchen.slots.values():
        for slot in row:
            name = WORKPLACES.get(slot.kind) if isinstance(slot.kind, BaseKind) else None
            if name is None or name in seen:
                continue
            seen.add(name)
            target = slot.line.frame.at(slot.middle, 0.45, 1.0)
            eye = slot.line.frame.at(slot.middle + 0.35, 1.95, 1.65)
            out.append(Camera(name=f"at_{name}", pose=look_at(eye, target), fov_y_deg=62.0))
    for k, (eye, target) in enumerate(_robot_eyes(kitchen)):
        out.append(_robot_eye(k, eye, target))
    for wall in kitchen.room.walls:
        if not wall.open and not any(_looks_at(camera, wall) for camera in out):
            eye, target = _before(kitchen, wall)
            out.append(_robot_eye(sum(c.name.startswith(ROBOT_EYE) for c in out), eye, target))
    return tuple(out)


def _robot_eye(number: int, eye: Vec3, target: Vec3) -> Camera:
    return Camera(name=f"{ROBOT_EYE}{number + 1}", pose=look_at(eye, target), fov_y_deg=58.0)


def _looks_at(camera: Camera, wall: WallLine) -> bool:
    """True if a camera before a wall has a part of it in the picture, not along the wall or from above."""
    eye = np.array(camera.pose.position)
    before = wall.frame.to_local(float(eye[0]), float(eye[1]))[1]
    if before < LEAST_BEFORE_WALL_M:
        return False
    points = np.array([wall.frame.at(share * wall.length, 0.0, WALL_MIDDLE_M) for share in (0.25, 0.5, 0.75)])
    is_square = before > LEAST_SINE * np.linalg.norm(points - eye, axis=1)
    x, y, back = camera.pose.inverse().apply(points).T
    half = -math.tan(math.radians(camera.fov_y_deg) / 2) * back
    return bool((is_square & (half > 0.0) & (np.abs(y) < half) & (np.abs(x) < half * ASPECT)).any())


def _before(kitchen: KitchenRequest, wall: WallLine) -> tuple[Vec3, Vec3]:
    """Eye of a robot in front of the middle of a wall, as far from it as there is room, and its target on the wall."""
    units = [_box(s) for s in _units_on_floor(kitchen)]
    middle, best = wall.length / 2, LEAST_BEFORE_WALL_M
    for step in range(1, VIEW_STEPS + 1):
        at = wall.frame.at(middle, step * VIEW_STEP_M)[:2]
        if not kitchen.room.contains(*at):
            break
        if all(_distance(box, at) > ROBOT_CLEARANCE_M for box in units):
            best = step * VIEW_STEP_M
    return wall.frame.at(middle, best, EYE_HEIGHT_M), wall.frame.at(middle, 0.0, WALL_MIDDLE_M)


def _robot_eyes(kitchen: KitchenRequest) -> list[tuple[Vec3, Vec3]]:
    """Eye and target of a robot in the left and in the right of the room, at places with free space and a long view."""
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    columns = [tuple(zip(*placed.outline, strict=True)) for placed in kitchen.room.columns]
    boxes = [(_box(s), s.top > EYE_HEIGHT_M - 0.2) for s in _units_on_floor(kitchen)]
    boxes += [((min(xs), min(ys), max(xs), max(ys)), True) for xs, ys in columns]
    found = []
    for shares, way in (((0.35, 0.28, 0.42, 0.5), 1.0), ((0.65, 0.72, 0.58, 0.5), -1.0)):
        places = [(x0 + fx * (x1 - x0), y0 + fy * (y1 - y0)) for fy in (0.3, 0.2, 0.4, 0.1) for fx in shares]
        target = ((x0 + x1) / 2 - way * 0.3, y1)
        best = max(places, key=lambda at: _view(kitchen, boxes, at, target))
        found.append(((*best, EYE_HEIGHT_M), (*target, 1.05)))
    return found


def _units_on_floor(kitchen: KitchenRequest) -> list[UnitSlot]:
    return [s for row in kitchen.slots.values() for s in row if not s.is_upper and s.kind is not BaseKind.GAP]


def _box(slot: UnitSlot) -> Box:
    """Least and greatest x and y of a unit on the floor."""
    corners = [slot.line.frame.at(u, v)[:2] for u in (slot.left, slot.right) for v in (0.0, slot.depth)]
    xs, ys = zip(*corners, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _view(kitchen: KitchenRequest, boxes: Sequence[tuple[Box, bool]], at: Vec2, target: Vec2) -> tuple[bool, float]:
    """True if a robot has room at a point, and its mean free sight from there in half metres."""
    free = kitchen.room.contains(*at) and all(_distance(box, at) > ROBOT_CLEARANCE_M for box, _ in boxes)
    ahead = math.atan2(target[1] - at[1], target[0] - at[0])
    tall = [box for box, high in boxes if high]
    total = 0.0
    for turn in VIEW_ANGLES_DEG:
        direction = (math.cos(ahead + math.radians(turn)), math.sin(ahead + math.radians(turn)))
        for step in range(1, VIEW_STEPS + 1):
            x, y = at[0] + VIEW_STEP_M * step * direction[0], at[1] + VIEW_STEP_M * step * direction[1]
            if not kitchen.room.contains(x, y) or any(_distance(box, (x, y)) <= 0 for box in tall):
                break
            total += VIEW_STEP_M
    return free, round(2 * total / len(VIEW_ANGLES_DEG)) / 2


def _distance(box: Box, at: Vec2) -> float:
    """Metres from a point to a box; none within."""
    return math.hypot(max(box[0] - at[0], 0.0, at[0] - box[2]), max(box[1] - at[1], 0.0, at[1] - box[3]))


def _overview(kitchen: KitchenRequest, x0: float, y0: float, x1: float, y1: float) -> Camera:
    """Camera on the side that the plan leaves open, high enough to see over objects in front."""
    sides = {w.frame.quarter_turns for w in kitchen.room.walls if w.open}
    turn = 0.5 if 3 in sides and 1 not in sides else -0.5 if 1 in sides and 3 not in sides else 0.0
    pitch = 0.62
    target = np.array([(x0 + x1) / 2, (y0 + y1) / 2 + 0.06 * (y1 - y0), 0.9])
    away = np.array([math.sin(turn) * math.cos(pitch), -math.cos(turn) * math.cos(pitch), math.sin(pitch)])
    back = kitchen.room.height
    corners = np.array([(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (0.0, back if y == y1 else 0.8 * back)])
    low, high = 1.0, 40.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (low, middle) if _fits(corners, target + middle * away, target) else (middle, high)
    return Camera(name="overview", pose=look_at(_vec3(target + high * away), _vec3(target)), fov_y_deg=FOV_DEG)


def _fits(points: np.ndarray, eye: np.ndarray, target: np.ndarray) -> bool:
    """True if the overview shows all points, with a little air round them."""
    seen = look_at(_vec3(eye), _vec3(target)).inverse().apply(points)
    reach = FRAME_FILL * math.tan(math.radians(FOV_DEG / 2)) * -seen[:, 2]
    is_shown = (seen[:, 2] < -0.1) & (np.abs(seen[:, 1]) < reach) & (np.abs(seen[:, 0]) < reach * ASPECT)
    return bool(is_shown.all())


def look_at(eye: Vec3, target: Vec3) -> Pose:
    """room_from_camera of a camera at `eye` that looks at `target`, its upper edge upwards."""
    back = np.array(eye) - np.array(target)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    m = np.stack([right, up, back], axis=1)
    w = math.sqrt(max(0.0, 1 + m[0, 0] + m[1, 1] + m[2, 2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + m[0, 0] - m[1, 1] - m[2, 2])) / 2, m[2, 1] - m[1, 2])
    y = math.copysign(math.sqrt(max(0.0, 1 - m[0, 0] + m[1, 1] - m[2, 2])) / 2, m[0, 2] - m[2, 0])
    z = math.copysign(math.sqrt(max(0.0, 1 - m[0, 0] - m[1, 1] + m[2, 2])) / 2, m[1, 0] - m[0, 1])
    q = np.round(np.array([w, x, y, z]), 9)
    q /= np.linalg.norm(q)
    return Pose(position=_vec3(np.round(eye, 6)), quaternion=(float(q[0]), float(q[1]), float(q[2]), float(q[3])))


def _vec3(values: np.ndarray | Vec3) -> Vec3:
    return (float(values[0]), float(values[1]), float(values[2]))
