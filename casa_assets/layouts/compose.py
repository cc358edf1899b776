"""Place the built assets of a kitchen in a Scene: props, cameras, light, and the areas that doors and drawers sweep."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, about_axis, decimals, rng_for
from casa_assets.layouts.order.build_order import DepthReference, HeightReference, KitchenRequest, OrderItem, Spot
from casa_assets.layouts.plan.room import WallFrame, WallLine, turned_left
from casa_assets.layouts.plan.runs import UnitSlot
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.mesh.planar import distance, outline_of
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Link, MeshShape, Sphere
from casa_assets.model.kitchen.floor import Corners, Footprint, SweptArea
from casa_assets.model.kitchen.plan import BaseKind
from casa_assets.model.kitchen.scene import Camera, Layer, Light, LightKind, Placement, Scene, Sky
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3

HINGE_POSES = 10  # sampled poses of a hinge; the outline of a 90 degree arc is within 0.3 % of its radius
MIN_REACH_M = 0.06  # a part that reaches out less is a knob, a key or a rack that stays in its fixture
# Corners of a cube of side 1 around the origin.
CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5
MAIN_REGION = "main"
LID_SITE, LID_GAP_M = "lid_site", 0.0001
MAX_LAMPS = 3  # that are lights of the scene; more cost time and wash out the picture
FOV_DEG = 50.0
ASPECT = 4 / 3  # width over height of the overview
FRAME_FILL = 0.95  # share of the overview that the room fills
EYE_HEIGHT_M = 1.45  # of a robot of human height
ROBOT_EYE = "robot_eye_"  # begin of the names of its cameras
# Of a camera that looks at a wall: its distance, the height at which it does, the sine of its angle with the wall.
LEAST_BEFORE_WALL_M, WALL_MIDDLE_M, LEAST_SINE = 0.3, 1.2, 0.3
ROBOT_CLEARANCE_M = 0.3  # between the robot and what is on the floor
VIEW_ANGLES_DEG, VIEW_STEPS, VIEW_STEP_M = (-24, -16, -8, 0, 8, 16, 24), 40, 0.1  # rays that measure its view
Rect = tuple[float, float, float, float]
WORKPLACES = {
    BaseKind.SINK: "sink",
    BaseKind.RANGE: "stove",
    BaseKind.HOB: "stove",
    BaseKind.FRIDGE: "fridge",
    BaseKind.OVEN: "oven",
    BaseKind.ISLAND: "island",
}
Bounds = npt.NDArray[np.float64]  # (2, 3) lower and upper corner, metres, frame of the room
MIN_GAP_M = 0.025  # between props
WALL_GAP_M = 0.05
SET_DOWN_GAP_M = 0.0008  # over the surface
# A shorter worktop is left free; a longer one has at most one prop per this length.
MIN_STRETCH_M, STRETCH_PER_PROP_M = 0.5, 0.9
MAX_ON_WORKTOPS, MAX_ON_SHELVES, MAX_PER_SHELF = 5, 5, 2
MAX_TRIES = 24
# The worktop beside these appliances stays free, for what is put in and taken out, and beside all things on it that
# have something to be moved, for the hand that does it.
APPLIANCES = ("range", "hob", "microwave", "coffee_machine", "toaster_oven", "blender", "stand_mixer")
FREE_BESIDE_M = 0.36
RANDOM_LANE = "scene/props"


class AssetOutlines:
    """Points around the parts of an asset, computed once for all its placements."""

    def __init__(self, asset: Asset) -> None:
        self.asset = asset
        self.poses = {link.name: asset.asset_from_link(link.name) for link in asset.links}
        self.points = {k.name: self.poses[k.name].apply(_points(k)) for k in asset.links}

    def grip_point(self, joint: Joint) -> Vec3 | None:
        """Centre of the grip of a joint, joints at zero, asset frame, metres; None if it has no grip."""
        for link in self.asset.links:
            for collider in link.colliders:
                if collider.name == joint.grip:
                    return (self.poses[link.name] @ collider.pose).position
        return None

    def swept_points(self, joint: Joint) -> Floats:
        """(S, N, 3) points of everything that a joint moves, from closed to open, asset frame, metres."""
        moved = self.asset.carried_by([joint.child])
        closed = np.concatenate([points for name, points in self.points.items() if name in moved])
        lower, upper = joint.range
        opened = upper if abs(upper) >= abs(lower) else lower
        pose = self.poses[joint.child]
        axis = pose.rotation @ np.array(joint.axis)
        if joint.kind is JointKind.SLIDE:
            return np.stack([closed, closed + opened * axis])
        anchor = pose.apply(np.array([joint.anchor]))[0]
        turns = [about_axis(axis, a) for a in np.linspace(0.0, opened, HINGE_POSES)]
        return np.stack([(closed - anchor) @ turn.T + anchor for turn in turns])

    def swept_area(self, joint: Joint, world_from_asset: Pose, footprint: Footprint) -> SweptArea | None:
        """Area that a joint's parts sweep, or None if they stay within the fixture's footprint."""
        local = self.swept_points(joint)
        if not local.shape[1] or np.abs(local[-1] - local[0])[:, :2].max() < MIN_REACH_M:
            return None
        points = world_from_asset.apply(local.reshape(-1, 3)).reshape(local.shape)
        open_outline = outline_of(points[-1, :, :2])
        if len(open_outline) < 3 or distance(footprint.corners, open_outline).max() < MIN_REACH_M:
            return None
        is_side_hinge = joint.kind is JointKind.HINGE and abs(joint.axis[2]) > 0.5
        return SweptArea(
            outline=_corners(outline_of(points[..., :2].reshape(-1, 2))),
            open_outline=_corners(open_outline),
            bottom=round(float(points[..., 2].min()), 4),
            top=round(float(points[..., 2].max()), 4),
            sweeps_front=not is_side_hinge,
        )


def door_leaf_widths(asset: Asset, joint: Joint) -> tuple[float, float]:
    """Width of a door's leaf, and of the part that obstructs the open doorway; metres. Levers do not count."""
    link = asset.link(joint.child)
    leaf = tuple(c for c in link.colliders if c.label not in ("handle", "lever", "knob"))
    pose = asset.asset_from_link(link.name)
    points = pose.apply(_points(link.replace(colliders=leaf)))
    anchor, axis = pose.apply(np.array([joint.anchor]))[0], pose.rotation @ np.array(joint.axis)
    opened = (points - anchor) @ about_axis(axis, max(joint.range, key=abs)).T + anchor
    left, right = float(points[:, 0].min()), float(points[:, 0].max())
    obstructed = min(right, float(opened[:, 0].max())) - max(left, float(opened[:, 0].min()))
    return right - left, max(0.0, obstructed)


def _points(link: Link) -> Floats:
    """(N, 3) vertices of the colliders of a link, or corners of boxes around round ones; link frame, metres."""
    out = [np.empty((0, 3))]
    for collider in link.colliders:
        shape = collider.shape
        if isinstance(shape, Hull | MeshShape):
            points = np.asarray(shape.mesh.vertices)
        elif isinstance(shape, Box):
            points = CUBE * np.array(shape.size)
        elif isinstance(shape, Sphere):
            points = CUBE * (2 * shape.radius)
        else:
            assert isinstance(shape, Cylinder | Capsule)
            height = shape.height + (2 * shape.radius if isinstance(shape, Capsule) else 0.0)
            points = CUBE * np.array([2 * shape.radius, 2 * shape.radius, height])
        out.append(collider.pose.apply(points))
    return np.concatenate(out)


def _corners(points: Floats) -> Corners:
    return tuple((round(float(x), 4), round(float(y), 4)) for x, y in points)


def box_around(points: Floats) -> Floats:
    """(2, 3) bounds of (N, 3) points."""
    return np.array([points.min(axis=0), points.max(axis=0)])


def box_in_world(world_from_frame: Pose, box: Floats) -> Floats:
    """(2, 3) bounds in the world of a (2, 3) box given in another frame."""
    return box_around(world_from_frame.apply(np.where(CUBE > 0, box[1], box[0])))


def lights(kitchen: KitchenRequest) -> tuple[Light, ...]:
    """A sun with shadows, light from the open side without, and the lamps under the ceiling."""
    (x0, y0), (x1, _) = kitchen.room.bounds()
    x, lamp_color = (x0 + x1) / 2, blackbody(kitchen.style.lamp_kelvin)
    sun_color = blackbody(kitchen.style.daylight_kelvin)
    sun, fill = _scaled(sun_color, 0.55), _scaled(sun_color, 0.24)
    out = [
        Light(name="sun", position=(x - 2.0, y0 - 1.5, 5.5), direction=(0.34, 0.5, -0.8), color=sun),
        Light(
            name="fill", position=(x + 2.0, y0 - 1.0, 4.0), direction=(-0.55, 0.6, -0.55), color=fill, castshadow=False
        ),
    ]
    lamps = [item for item in kitchen.items if item.role == "lamp"]
    for k, item in enumerate(lamps[:MAX_LAMPS]):
        x, y, _ = item.spot.frame.at(item.spot.u, item.spot.v)
        out.append(
            Light(
                name=f"lamp_{k + 1}",
                kind=LightKind.POINT,
                position=(x, y, round(kitchen.room.height - 0.55, 4)),
                direction=(0.0, 0.0, -1.0),
                color=_scaled(lamp_color, 0.34 / min(len(lamps), MAX_LAMPS) ** 0.5),
                castshadow=False,
                attenuation=(1.0, 0.1, 0.12),
            )
        )
    return tuple(out)


def blackbody(kelvin: float) -> Vec3:
    """Linear RGB of a colour temperature, brightest channel 1, mixed half and half with white (adaptation of the eye).

    Ref: Mitchell Charity, blackbody colour datafile, 10 degree observer; to within 0.05.
    """
    points: tuple[tuple[float, Vec3], ...] = (
        (2000.0, (1.0, 0.25, 0.01)),
        (2700.0, (1.0, 0.4, 0.1)),
        (3500.0, (1.0, 0.55, 0.25)),
        (4500.0, (1.0, 0.71, 0.49)),
        (5500.0, (1.0, 0.84, 0.74)),
        (6500.0, (1.0, 0.95, 0.98)),
        (9000.0, (0.67, 0.75, 1.0)),
    )
    for (k0, c0), (k1, c1) in itertools.pairwise(points):
        if kelvin <= k1:
            t = min(1.0, max(0.0, (kelvin - k0) / (k1 - k0)))
            mixed = [a + t * (b - a) for a, b in zip(c0, c1, strict=True)]
            break
    else:
        mixed = list(points[-1][1])
    return (round(0.5 + mixed[0] / 2, 4), round(0.5 + mixed[1] / 2, 4), round(0.5 + mixed[2] / 2, 4))


def _scaled(color: Vec3, factor: float) -> Vec3:
    return (round(color[0] * factor, 5), round(color[1] * factor, 5), round(color[2] * factor, 5))


def compose(kitchen: KitchenRequest, assets: Mapping[str, Asset], scene_id: str) -> Scene:
    """The scene of a kitchen; `assets`: by name of the ordered item, several of which may have the same one."""
    by_name = {item.name: item for item in kitchen.items}
    placements = []
    for item in kitchen.items:
        asset = assets[item.name]
        pose = pose_at_spot(asset, item.spot)
        if item.lid_of:
            # Slightly above its closed position on the thing that it is the lid of.
            vessel = assets[item.lid_of]
            site = next(site for site in vessel.sites if site.name == LID_SITE)
            at = pose_at_spot(vessel, by_name[item.lid_of].spot)
            closed = at @ vessel.asset_from_link(site.link) @ site.pose
            x, y, z = (decimals(float(c), 6) for c in closed.position)
            pose = Pose(position=(x, y, decimals(z + LID_GAP_M, 6)), quaternion=closed.quaternion)
        placements.append(Placement(name=item.name, asset=asset.id, pose=pose, layer=Layer(item.layer)))
    each = {a.id: a for a in (assets[item.name] for item in kitchen.items)}
    scene = Scene(
        id=scene_id,
        assets=tuple(each[k] for k in sorted(each)),
        placements=tuple(placements),
        cameras=cameras(kitchen),
        lights=lights(kitchen),
        ambient=(0.4, 0.4, 0.41),
        sky=Sky(),
    )
    return ready_to_simulate(scene)


def box_of(asset: Asset) -> tuple[Vec3, Vec3]:
    """Middle and size of what an asset takes up without handles and knobs: its region `main`; asset frame, metres."""
    for region in asset.regions:
        if region.name == MAIN_REGION and region.link == asset.root.name:
            return (asset.root.pose @ region.pose).position, region.size
    low, high = asset.bounds
    x, y, z = (float(c) for c in (low + high) / 2)
    width, depth, height = (float(c) for c in high - low)
    return (x, y, z), (width, depth, height)


def pose_at_spot(asset: Asset, spot: Spot) -> Pose:
    """room_from_asset of an asset placed at a spot."""
    (x, y, z), (width, depth, height) = box_of(asset)
    back = {DepthReference.BACK: 0.5, DepthReference.MIDDLE: 0.0, DepthReference.FRONT: -0.5}[spot.depth_reference]
    up = {HeightReference.FOOT: -0.5, HeightReference.MIDDLE: 0.0, HeightReference.HEAD: 0.5}[spot.height_reference]
    if spot.turn_deg:
        # The bounding box of the turned item touches the line.
        angle = math.radians(spot.turn_deg)
        extent = abs(width * math.sin(angle)) + abs(depth * math.cos(angle))
        pose = turned_left(spot.frame.pose(spot.u, spot.v + back * extent, spot.z), spot.turn_deg)
        reference = np.array([x, y, z + up * height])
    else:
        pose = spot.frame.pose(spot.u, spot.v, spot.z)
        reference = np.array([x, y + back * depth, z + up * height])
        if spot.tilt_deg:
            half = math.radians(spot.tilt_deg) / 2
            pose = pose @ Pose(quaternion=(round(math.cos(half), 12), -round(math.sin(half), 12), 0.0, 0.0))
    px, py, pz = (decimals(float(c), 6) for c in pose.apply(-reference[None, :])[0])
    if spot.least_foot:
        pz = max(pz, decimals(spot.least_foot - (z - height / 2), 6))
    return Pose(position=(px, py, pz), quaternion=pose.quaternion)


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


def _box(slot: UnitSlot) -> Rect:
    corners = [slot.line.frame.at(u, v)[:2] for u in (slot.left, slot.right) for v in (0.0, slot.depth)]
    xs, ys = zip(*corners, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _view(kitchen: KitchenRequest, boxes: Sequence[tuple[Rect, bool]], at: Vec2, target: Vec2) -> tuple[bool, float]:
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


def _distance(box: Rect, at: Vec2) -> float:
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


@dataclass(frozen=True)
class SupportSurface:
    """A worktop or shelf board: pose of the centre of its upper face in the room, size, and free height, metres."""

    pose: Pose
    width: float
    depth: float
    height: float
    is_shelf: bool


def scatter_props(
    kitchen: KitchenRequest, assets: Mapping[str, Asset], props: Sequence[tuple[PresetChoice, Asset]], seed: int = 0
) -> tuple[tuple[OrderItem, Asset], ...]:
    """Choose props and free places for them on the worktops and shelves of a kitchen.

    `assets`: by name of the ordered item. `props`: presets that the style scatters, the likeliest first.
    """
    rng = rng_for(seed, f"{RANDOM_LANE}/{kitchen.plan.id}/{kitchen.style.id}")
    bounds = {
        item.name: box_in_world(pose_at_spot(assets[item.name], item.spot), assets[item.name].bounds)
        for item in kitchen.items
    }
    occupied = [bounds[item.name] for item in kitchen.items if item.layer == "things"]
    beside = np.array([[-FREE_BESIDE_M, -FREE_BESIDE_M, -9.0], [FREE_BESIDE_M, FREE_BESIDE_M, 9.0]])
    kept_free = [
        bounds[item.name] + beside
        for item in kitchen.items
        if item.role in APPLIANCES or (item.layer == "things" and assets[item.name].joints)
    ]
    out: list[tuple[OrderItem, Asset]] = []
    queue = list(props)
    counts: dict[str, int] = {}
    on_worktops = on_shelves = 0
    surfaces = list(_surfaces(kitchen, assets))
    surfaces = [surfaces[int(k)] for k in rng.permutation(len(surfaces))]
    for surface in surfaces:
        room = MAX_ON_SHELVES - on_shelves if surface.is_shelf else MAX_ON_WORKTOPS - on_worktops
        share = MAX_PER_SHELF if surface.is_shelf else max(1, int(surface.width / STRETCH_PER_PROP_M))
        for _ in range(min(room, share)):
            found = _put(surface, queue, occupied if surface.is_shelf else occupied + kept_free, rng)
            if found is None:
                break
            index, spot, box = found
            choice, asset = queue.pop(index)
            queue.append((choice, asset))  # it comes again after all others
            counts[choice.family] = counts.get(choice.family, 0) + 1
            name = f"prop_{choice.family}_{counts[choice.family]}"
            out.append((OrderItem(name, "prop", choice, spot), asset))
            occupied.append(box)
            on_shelves += surface.is_shelf
            on_worktops += not surface.is_shelf
    return tuple(out)


def _surfaces(kitchen: KitchenRequest, assets: Mapping[str, Asset]) -> Iterator[SupportSurface]:
    for item in kitchen.items:
        if item.role not in ("counter", "shelf", "larder"):
            continue
        asset = assets[item.name]
        pose = pose_at_spot(asset, item.spot)
        for region in asset.regions:
            is_shelf = region.name.startswith("level")
            if region.link != asset.root.name or not (is_shelf or region.name.startswith("top")):
                continue
            width, depth, height = region.size
            if not is_shelf and (width < MIN_STRETCH_M or depth < 0.4):
                continue
            low = pose @ asset.root.pose @ region.pose @ Pose(position=(0.0, 0.0, -height / 2))
            yield SupportSurface(low, width, depth, height, is_shelf)


def _put(
    surface: SupportSurface,
    props: Sequence[tuple[PresetChoice, Asset]],
    occupied: Sequence[Bounds],
    rng: np.random.Generator,
) -> tuple[int, Spot, Bounds] | None:
    """Index of the first prop that fits in a free place, its spot and its bounds."""
    lower, upper = np.reshape([*occupied], (-1, 2, 3)).transpose(1, 0, 2)
    for index, (_, asset) in enumerate(props):
        low, high = asset.bounds
        reach = np.hypot(*np.maximum(np.abs(low[:2]), np.abs(high[:2])))
        tall = float(high[2] - low[2])
        if tall > surface.height - 0.02 or 2 * reach > min(surface.width, surface.depth) + 0.04:
            continue
        for _ in range(MAX_TRIES):
            turn = float(rng.integers(-14, 15))
            half = _half_extents(asset, turn)
            side = surface.width / 2 - half[0] - 0.02
            if side <= 0:
                break
            x = float(rng.uniform(-side, side))
            back = surface.depth / 2 - half[1] - (0.01 if surface.is_shelf else WALL_GAP_M)
            y = 0.0 if surface.is_shelf else back - float(rng.uniform(0.0, 0.04))
            if back <= -surface.depth / 2 + half[1]:
                break
            spot = _spot(surface, x, y, turn)
            box = box_in_world(pose_at_spot(asset, spot), asset.bounds)
            # Closer than the gap to one of the others; one may rest on another.
            apart = np.array([MIN_GAP_M, MIN_GAP_M, -0.002])
            if not ((box[0] < upper + apart) & (lower < box[1] + apart)).all(axis=1).any():
                return index, spot, box
    return None


def _spot(surface: SupportSurface, x: float, y: float, turn: float) -> Spot:
    px, py, pz = (float(c) for c in surface.pose.apply(np.array([[x, y, SET_DOWN_GAP_M]]))[0])
    along = surface.pose.rotation[:, 0]
    turn_deg = round(math.degrees(math.atan2(float(along[1]), float(along[0]))), 4) % 360.0
    quarters, more = divmod(turn_deg, 90.0)
    frame = WallFrame(round(px, 4), round(py, 4), int(quarters), more)
    return Spot(frame, 0.0, 0.0, round(pz, 5), turn, DepthReference.MIDDLE)


def _half_extents(asset: Asset, turn: float) -> Floats:
    """Half the width and depth of the bounds of an asset that is turned by degrees."""
    low, high = asset.bounds
    w, d = np.maximum(np.abs(low[:2]), np.abs(high[:2]))
    a = math.radians(turn)
    c, s = abs(math.cos(a)), abs(math.sin(a))
    return np.array([w * c + d * s, w * s + d * c])
