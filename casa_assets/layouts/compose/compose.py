"""Place the built assets of a kitchen in a Scene: light, and the areas that doors and drawers sweep."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np

from casa_assets.core.numeric import Floats, about_axis, decimals
from casa_assets.layouts.compose.cameras import cameras
from casa_assets.layouts.order.build_order import DepthReference, HeightReference, Spot
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.wall_frame import turned_left
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.mesh.planar import distance, outline_of
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Link, MeshShape, Sphere
from casa_assets.model.kitchen.floor import Corners, Footprint, SweptArea
from casa_assets.model.kitchen.scene import Layer, Light, LightKind, Placement, Scene, Sky
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Swept areas ----------------------------------------------------------------------------------------------------------
# Compute the areas that doors, flaps and drawers of a placed asset sweep, seen from above.

HINGE_POSES = 10  # sampled poses of a hinge; the outline of a 90 degree arc is within 0.3 % of its radius
MIN_REACH_M = 0.06  # a part that reaches out less is a knob, a key or a rack that stays in its fixture
_CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5


class AssetOutlines:
    """Points around the parts of an asset, computed once for all its placements."""

    def __init__(self, asset: Asset) -> None:
        self.asset = asset
        self.poses: dict[str, Pose] = {}
        for link in asset.links:
            self.poses[link.name] = link.pose if link.parent is None else self.poses[link.parent] @ link.pose
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
        links = [joint.child]
        for link in self.asset.links:
            links += [link.name] if link.parent in links else []
        closed = np.concatenate([self.points[name] for name in links])
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
            points = _CUBE * np.array(shape.size)
        elif isinstance(shape, Sphere):
            points = _CUBE * (2 * shape.radius)
        else:
            assert isinstance(shape, Cylinder | Capsule)
            height = shape.height + (2 * shape.radius if isinstance(shape, Capsule) else 0.0)
            points = _CUBE * np.array([2 * shape.radius, 2 * shape.radius, height])
        out.append(collider.pose.apply(points))
    return np.concatenate(out)


def _corners(points: Floats) -> Corners:
    return tuple((round(float(x), 4), round(float(y), 4)) for x, y in points)


def box_around(points: Floats) -> Floats:
    """(2, 3) bounds of (N, 3) points."""
    return np.array([points.min(axis=0), points.max(axis=0)])


def box_in_world(world_from_frame: Pose, box: Floats) -> Floats:
    """(2, 3) bounds in the world of a (2, 3) box given in another frame."""
    return box_around(world_from_frame.apply(np.where(_CUBE > 0, box[1], box[0])))


# Light ----------------------------------------------------------------------------------------------------------------
# Light of a kitchen: the sun and the sky through the windows, the lamps, and what the room throws back.

MAX_LAMPS = 3  # that are lights of the scene; more cost time and wash out the picture


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


# Compose --------------------------------------------------------------------------------------------------------------

MAIN_REGION = "main"
LID_SITE, LID_GAP_M = "lid_site", 0.0001


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
