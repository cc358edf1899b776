"""Heights of an object's collision shapes over the ground, cell by cell, to set things on and into each other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.hull import hull_planes
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere

CELL_M = 0.003
# Two of the same shape, one lifted by `pitch`, may still touch between the centres of cells.
CELL_SLACK_M = 0.0006
# What has a handle at one side is so much longer than wide, and the middle of its area so far from that of its length.
LONG_SHARE, OFF_SHARE = 1.15, 0.04
# Regions of a rack that take one plate each.
SLOT = "slot_"
_ROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
_CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5


@dataclass(frozen=True)
class Silhouette:
    """Space that an object takes up, seen from above; frame of the asset, joints at zero, metres.

    Attributes:
        box: (2, 3) bounds of its collision shapes.
        low, high: (X, Y) lowest and highest point over each cell of `CELL_M`, the first at `box[0]`; inf and -inf in
            empty cells.
        slots: (S, 2, 3) bounds of the regions `slot_<n>`, each of which takes one plate on its edge.
    """

    box: Floats
    low: Floats
    high: Floats
    slots: Floats = field(default_factory=lambda: np.empty((0, 2, 3)))

    @property
    def pitch(self) -> float:
        """Height by which a second one is raised if stacked on the first, both facing the same way; metres."""
        filled = np.isfinite(self.low)
        return float((self.high[filled] - self.low[filled]).max()) + CELL_SLACK_M

    @property
    def body(self) -> Floats:
        """(2,) middle of the body without the handle that reaches out of it to one side; frame of the asset, metres.

        The body is taken to be as long as it is wide.
        """
        middle: Floats = self.box[:, :2].mean(axis=0)
        handle = self.handle
        size = np.ptp(self.box[:, :2], axis=0)
        return middle if handle is None else middle - handle * (size.max() - size.min()) / 2

    @property
    def handle(self) -> Floats | None:
        """(2,) direction along x or y in which a handle extends; None without a handle, or with two."""
        size = np.ptp(self.box[:, :2], axis=0)
        axis = int(np.argmax(size))
        centers = self.box[0, :2] + (np.argwhere(np.isfinite(self.low)) + 0.5) * CELL_M
        off = float((self.box[:, :2].mean(axis=0) - centers.mean(axis=0))[axis])
        if size[axis] < LONG_SHARE * size[1 - axis] or abs(off) < OFF_SHARE * size[axis]:
            return None
        direction = np.zeros(2)
        direction[axis] = np.sign(off)
        return direction


def silhouette(asset: Asset) -> Silhouette:
    """Heights of an object's collision shapes."""
    clouds = [
        asset.asset_from_link(link.name).apply(c.pose.apply(outline_points(c.shape)))
        for link in asset.links
        for c in link.colliders
    ]
    every = np.concatenate(clouds)
    box = np.array([every.min(axis=0), every.max(axis=0)])
    counts = np.maximum(1, np.ceil((box[1, :2] - box[0, :2]) / CELL_M).astype(int))
    low, high = np.full(counts, np.inf), np.full(counts, -np.inf)
    x, y = (box[0, k] + (np.arange(counts[k]) + 0.5) * CELL_M for k in (0, 1))
    for cloud in clouds:
        _raster(hull_planes(cloud), x, y, low, high)
    return Silhouette(box, low, high, _slots(asset))


def _slots(asset: Asset) -> Floats:
    found = [r for r in asset.regions if r.name.startswith(SLOT)]
    corners = [asset.asset_from_link(r.link).apply(r.pose.apply(_CUBE * np.array(r.size))) for r in found]
    return np.array([[c.min(axis=0), c.max(axis=0)] for c in corners]).reshape(-1, 2, 3)


def outline_points(shape: Shape) -> Floats:
    """(N, 3) points whose hull is a shape, or a little less where it is round; frame of the shape, metres."""
    if isinstance(shape, Hull | MeshShape):
        return np.asarray(shape.mesh.vertices)
    if isinstance(shape, Box):
        points: Floats = _CUBE * np.array(shape.size)
        return points
    ring = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=1)
    if isinstance(shape, Cylinder):
        half = shape.height / 2
        return np.concatenate([np.column_stack([shape.radius * ring, np.full(len(ring), z)]) for z in (-half, half)])
    half = shape.height / 2 if isinstance(shape, Capsule) else 0.0
    assert isinstance(shape, Sphere | Capsule)
    tilt = np.linspace(0.0, np.pi / 2, 7)[:, None, None]
    level = np.broadcast_to(np.sin(tilt), (len(tilt), len(ring), 1))
    dome = shape.radius * np.concatenate([np.cos(tilt) * ring, level], axis=-1).reshape(-1, 3)
    dome[:, 2] += half
    return np.concatenate([dome, dome * np.array([1.0, 1.0, -1.0])])


def _raster(planes: Floats, x: Floats, y: Floats, low: Floats, high: Floats) -> None:
    """Widen the heights in the cells over which a convex body lies.

    Args:
        planes: (F, 4) outward normals and offsets. x, y: centres of the cells.
    """
    across, along, offset = (planes[:, k, None, None] for k in (0, 1, 3))
    at = across * x[None, :, None] + along * y[None, None, :] + offset
    slope = planes[:, 2]
    below, above, upright = slope < -1e-9, slope > 1e-9, np.abs(slope) <= 1e-9
    bottom = (at[below] / -slope[below, None, None]).max(axis=0)
    top = (-at[above] / slope[above, None, None]).min(axis=0)
    inside = (bottom <= top) & (at[upright] <= 0.0).all(axis=0)
    low[inside] = np.minimum(low[inside], bottom[inside])
    high[inside] = np.maximum(high[inside], top[inside])
