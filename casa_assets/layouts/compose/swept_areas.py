"""Compute the areas that doors, flaps and drawers of a placed asset sweep, seen from above."""

from __future__ import annotations

import numpy as np

from casa_assets.core.rotation import about_axis
from casa_assets.core.typing import Floats
from casa_assets.geometry.planar import distance, outline_of
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.model.asset.link import Link
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Sphere
from casa_assets.model.kitchen.floor import Corners, Footprint, SweptArea
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

HINGE_POSES = 10  # poses of a hinge between shut and open: an arc of 90 degrees is met to 0.3 % of its radius
# A part that reaches out less than this is a knob, a key or a rack that stays in its fixture; metres.
MIN_REACH_M = 0.06
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
        """Middle of what a hand takes, asset frame, metres."""
        for link in self.asset.links:
            for collider in link.colliders:
                if collider.name == joint.grip:
                    return (self.poses[link.name] @ collider.pose).position
        return None

    def moved_points(self, joint: Joint) -> Floats:
        """(N, 3) points of all that a joint moves, while all joints are at zero; asset frame."""
        moved = [joint.child]
        for link in self.asset.links:
            if link.parent in moved:
                moved.append(link.name)
        return np.concatenate([self.points[name] for name in moved])

    def swept_points(self, joint: Joint) -> Floats:
        """(S, N, 3) points of all that a joint moves, from shut to open; asset frame."""
        shut = self.moved_points(joint)
        low, high = joint.range
        far = high if abs(high) >= abs(low) else low
        pose = self.poses[joint.child]
        axis = pose.rotation @ np.array(joint.axis)
        if joint.kind is JointKind.SLIDE:
            return np.stack([shut, shut + far * axis])
        anchor = pose.apply(np.array([joint.anchor]))[0]
        return np.stack([(shut - anchor) @ about_axis(axis, a).T + anchor for a in np.linspace(0.0, far, HINGE_POSES)])

    def swept_area(self, joint: Joint, world: Pose, foot: Footprint) -> SweptArea | None:
        """Area that a joint's parts sweep, or None where they stay within the fixture's footprint."""
        passed = self.swept_points(joint)
        if not passed.shape[1] or np.abs(passed[-1] - passed[0])[:, :2].max() < MIN_REACH_M:
            return None
        points = world.apply(passed.reshape(-1, 3)).reshape(passed.shape)
        last = outline_of(points[-1, :, :2])
        if len(last) < 3 or distance(foot.corners, last).max() < MIN_REACH_M:
            return None
        upright = joint.kind is JointKind.HINGE and abs(joint.axis[2]) > 0.5
        return SweptArea(
            outline=_corners(outline_of(points[..., :2].reshape(-1, 2))),
            open_outline=_corners(last),
            bottom=round(float(points[..., 2].min()), 4),
            top=round(float(points[..., 2].max()), 4),
            sweeps_front=not upright,
        )


def door_leaf_widths(asset: Asset, joint: Joint) -> tuple[float, float]:
    """Width of a door's leaf, and of the part that obstructs the open doorway; metres. Levers do not count."""
    link = asset.link(joint.child)
    slabs = [c for c in link.colliders if c.label not in ("handle", "lever", "knob")]
    points = asset.asset_from_link(link.name).apply(_points(link.replace(colliders=tuple(slabs))))
    outlines = AssetOutlines(asset)
    pose = outlines.poses[joint.child]
    anchor, axis = pose.apply(np.array([joint.anchor]))[0], pose.rotation @ np.array(joint.axis)
    far = max(joint.range, key=abs)
    opened = (points - anchor) @ about_axis(axis, far).T + anchor
    low, high = float(points[:, 0].min()), float(points[:, 0].max())
    taken = min(high, float(opened[:, 0].max())) - max(low, float(opened[:, 0].min()))
    return high - low, max(0.0, taken)


def _points(link: Link) -> Floats:
    """(N, 3) points around the colliders of a link, its own frame."""
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
