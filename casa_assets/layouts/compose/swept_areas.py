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

    def moved_points(self, joint: Joint) -> Floats:
        """(N, 3) points of everything that a joint moves, joints at zero, asset frame, metres."""
        links = [joint.child]
        for link in self.asset.links:
            if link.parent in links:
                links.append(link.name)
        return np.concatenate([self.points[name] for name in links])

    def swept_points(self, joint: Joint) -> Floats:
        """(S, N, 3) points of everything that a joint moves, from closed to open, asset frame, metres."""
        closed = self.moved_points(joint)
        lower, upper = joint.range
        opened = upper if abs(upper) >= abs(lower) else lower
        pose = self.poses[joint.child]
        axis = pose.rotation @ np.array(joint.axis)
        if joint.kind is JointKind.SLIDE:
            return np.stack([closed, closed + opened * axis])
        anchor = pose.apply(np.array([joint.anchor]))[0]
        return np.stack(
            [(closed - anchor) @ about_axis(axis, a).T + anchor for a in np.linspace(0.0, opened, HINGE_POSES)]
        )

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
