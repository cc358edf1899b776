"""Outlines in a plane: area, hull, distance, overlap; and whether a thing stands on the outline of its foot."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.outline import Outline, edge_normals
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Asset

# What ends so near above the lowest point stands there, too, metres: a thing rocks by no more.
LEVEL_M = 0.002
# The middle of mass has to be so far inside of what it stands on, metres.
MARGIN_M = 0.004


def signed_area(outline: Floats) -> float:
    """Area within an outline, (N, 2) corners in order; negative where they go round clockwise."""
    x, y = outline[:, 0], outline[:, 1]
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2


def counter_clockwise(outline: Floats) -> Floats:
    """An outline, (N, 2) corners in order, turned round where it is clockwise."""
    return outline[::-1] if signed_area(outline) < 0 else outline


def outline_of(points: Outline) -> Floats:
    """(M, 2) corners of the convex hull of (N, 2) points, to 1e-6, counter-clockwise from the leftmost one."""
    corners: Floats = np.unique(np.round(np.asarray(points, dtype=np.float64), 6), axis=0)
    if len(corners) < 3:
        return corners
    try:
        around: Ints = ConvexHull(corners).vertices.astype(np.int64)
    except QhullError:  # all lie on a line
        return corners[[0, -1]]
    return np.asarray(corners[np.roll(around, -int(np.argmin(around)))])


def distance(outline: Outline, points: Floats) -> Floats:
    """(N,) distance of (N, 2) points from a convex outline, 0 inside, metres."""
    a = np.asarray(outline, dtype=np.float64)
    b = np.roll(a, -1, axis=0)
    edge = b - a
    length = np.maximum((edge**2).sum(axis=1), 1e-18)
    from_a = points[:, None, :] - a[None]
    along = np.clip((from_a * edge).sum(axis=2) / length, 0.0, 1.0)
    away = np.sqrt(((from_a - along[..., None] * edge) ** 2).sum(axis=2)).min(axis=1)
    inside = ((edge[:, 0] * from_a[..., 1] - edge[:, 1] * from_a[..., 0]) >= 0).all(axis=1)
    return np.asarray(np.where(inside, 0.0, away))


def length_inside(outline: Outline, start: tuple[float, float], end: tuple[float, float]) -> float:
    """Length of the part of a straight line that lies inside a convex outline, metres."""
    a = np.asarray(outline, dtype=np.float64)
    normals = edge_normals(a)
    p, q = np.array(start), np.array(end)
    low, high = 0.0, 1.0
    for normal, corner in zip(normals, a, strict=True):
        here, step = float(normal @ (p - corner)), float(normal @ (q - p))
        if abs(step) < 1e-12:
            if here > 0:
                return 0.0
        elif step > 0:
            high = min(high, -here / step)
        else:
            low = max(low, -here / step)
    return max(0.0, high - low) * float(np.linalg.norm(q - p))


def stands_by_itself(asset: Asset) -> bool:
    """True if the centre of mass of an asset, joints at zero, is over the footprint of its collision shapes."""
    points = [np.empty((0, 3))]
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        points += [pose.apply(tessellate(c.shape, c.pose)[0]) for c in link.colliders]
    every = np.concatenate(points)
    if not len(every):
        return False
    foot = every[every[:, 2] < every[:, 2].min() + LEVEL_M]
    corners = outline_of(foot[:, :2])
    if len(corners) < 3:
        return False
    edges = np.roll(corners, -1, axis=0) - corners
    to_middle = asset.center_of_mass[:2] - corners
    # Counter-clockwise: what is inside is on the left of every edge.
    left = (edges[:, 0] * to_middle[:, 1] - edges[:, 1] * to_middle[:, 0]) / np.linalg.norm(edges, axis=1)
    return bool(left.min() >= MARGIN_M)
