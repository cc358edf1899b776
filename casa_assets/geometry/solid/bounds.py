"""Axis-aligned bounds of collision shapes at a pose: exact for each kind, not the bounds of bounds."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Link
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Shape, Sphere
from casa_assets.model.pose import Pose


def shape_bounds(shape: Shape, pose: Pose) -> Floats:
    """(2, 3) lower and upper corner of a shape, metres, in the frame that `pose` (frame_from_shape) leads to."""
    center, axis = np.array(pose.position), pose.rotation[:, 2]
    if isinstance(shape, Box):
        half = np.abs(pose.rotation) @ (np.array(shape.size) / 2)
    elif isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Capsule):
        half = np.abs(axis) * shape.height / 2 + shape.radius
    elif isinstance(shape, Cylinder):
        # A disc of radius r with unit normal n reaches r * sqrt(1 - n_i^2) along axis i.
        half = np.abs(axis) * shape.height / 2 + shape.radius * np.sqrt(np.clip(1.0 - axis**2, 0.0, 1.0))
    else:
        points = pose.apply(shape.mesh.vertices)
        return np.array([points.min(axis=0), points.max(axis=0)])
    return np.array([center - half, center + half])


def link_bounds(link: Link, pose: Pose | None = None) -> Floats | None:
    """(2, 3) corners of all colliders of a link, metres; in link frame, or in the frame of `pose` (frame_from_link).

    Returns:
        None if the link has no colliders.
    """
    frame = pose or Pose()
    corners = [shape_bounds(c.shape, frame @ c.pose) for c in link.colliders]
    if not corners:
        return None
    return np.array([np.min([c[0] for c in corners], axis=0), np.max([c[1] for c in corners], axis=0)])
