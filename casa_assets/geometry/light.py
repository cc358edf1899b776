"""Asset -> the same asset without meshes: every mesh that collides becomes a box or a cylinder inside of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from casa_assets.errors import DegenerateShape
from casa_assets.geometry.hull import hull_planes
from casa_assets.model.asset import Asset, Collider, Link
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box, Cylinder, Hull, MeshShape

Floats = npt.NDArray[np.float64]

# Sizes are multiples of this, rounded down, metres: the last digits of a solver are no promise.
GRID = 1e-6
# Half the size of the smallest primitive, metres, for shapes that are too thin for the grid.
LEAST = 1e-5
# Frames whose box is this much of the hull's own bounds are tried no further: there is nothing to gain.
GOOD = 0.999


class Inside(NamedTuple):
    """A primitive inside a hull: half sizes (x, y, z) of a box, (radius, half height) of a cylinder, in a frame."""

    frame: Floats
    center: Floats
    half: Floats

    @property
    def volume(self) -> float:
        """m^3."""
        if len(self.half) == 3:
            return float(8 * self.half.prod())
        return float(2 * np.pi * self.half[0] ** 2 * self.half[1])


def lighten(asset: Asset) -> Asset:
    """The asset without visuals and materials; its colliders are primitives that nowhere stick out of what they were.

    So nothing that was apart touches. Mass, joints, sites and regions stay; effects on visuals are left out.
    """
    effects = _effects(asset)
    behavior = asset.behavior
    if behavior is not None and len(effects) < len(behavior.effects):
        behavior = behavior.replace(effects=tuple(behavior.effects[i] for i in effects))
    links = tuple(_light_link(link) for link in asset.links)
    return asset.replace(links=links, materials=(), behavior=behavior)


def inside(points: Floats) -> tuple[Box | Cylinder, Pose]:
    """The largest box or cylinder that was found inside the convex hull of (N, 3) points, and its pose in their frame.

    Raises:
        DegenerateShape: the points span no volume.
    """
    planes = hull_planes(points)
    best: Inside | None = None
    for frame in _frames(points):
        local = points @ frame
        full = float(np.ptp(local, axis=0).prod())
        for reach in (_box_reach(planes, frame), _rod_reach(planes, frame)):
            found = _largest(planes, frame, reach, local)
            if found is not None and (best is None or found.volume > best.volume * (1 + 1e-6)):
                best = found
        if best is not None and best.volume >= GOOD * full:
            break
    if best is None:
        raise DegenerateShape("nothing fits inside the hull")
    matrix = np.eye(4)
    matrix[:3, :3] = best.frame
    matrix[:3, 3] = np.round(best.frame @ best.center / GRID) * GRID
    # The centre was rounded by up to half a unit along each axis.
    half = np.maximum(np.floor((best.half - GRID) / GRID) * GRID, LEAST)
    pose = Pose.from_matrix(matrix)
    if len(half) == 3:
        x, y, z = (2 * float(h) for h in half)
        return Box(size=(x, y, z)), pose
    return Cylinder(radius=float(half[0]), height=2 * float(half[1])), pose


def _light_link(link: Link) -> Link:
    return link.replace(visuals=(), colliders=tuple(c for item in link.colliders for c in _light_collider(item)))


def _light_collider(item: Collider) -> tuple[Collider, ...]:
    """The collider as a primitive; a mesh without volume is left out, as it would hold nothing up anyway."""
    if not isinstance(item.shape, Hull | MeshShape):
        return (item,)
    try:
        shape, pose = inside(item.shape.mesh.vertices)
    except DegenerateShape:
        return ()
    return (item.replace(shape=shape, pose=item.pose @ pose),)


def _effects(asset: Asset) -> list[int]:
    """Indices of the effects that act on something other than a visual."""
    if asset.behavior is None:
        return []
    visuals = {v.name for link in asset.links for v in link.visuals}
    return [i for i, effect in enumerate(asset.behavior.effects) if effect.target not in visuals]


def _frames(points: Floats) -> list[Floats]:
    """Rotations (cloud from shape) worth trying: each axis of the cloud as z, then those of its covariance."""
    x, y, z = np.eye(3)
    axes = [np.stack([x, y, z], axis=1), np.stack([y, z, x], axis=1), np.stack([z, x, y], axis=1)]
    _, vectors = np.linalg.eigh(np.cov(points.T))
    a, b, c = (v * np.sign(v[np.argmax(np.abs(v))]) for v in vectors.T)
    return [*axes, np.stack([a, np.cross(c, a), c], axis=1), np.stack([b, np.cross(a, b), a], axis=1)]


def _box_reach(planes: Floats, frame: Floats) -> Floats:
    """(F, 3) how far a box of half size one along each axis reaches towards each plane."""
    return np.abs(planes[:, :3] @ frame)


def _rod_reach(planes: Floats, frame: Floats) -> Floats:
    """(F, 2) how far a cylinder of radius one, and of half height one, reaches towards each plane."""
    normals = planes[:, :3] @ frame
    return np.stack([np.hypot(normals[:, 0], normals[:, 1]), np.abs(normals[:, 2])], axis=1)


def _largest(planes: Floats, frame: Floats, reach: Floats, local: Floats) -> Inside | None:
    """First the largest of the cloud's own proportions, then as much wider as there is room.

    Both are linear programs in the centre and the half sizes: normal . centre + reach . half <= -offset.
    """
    spans = np.ptp(local, axis=0) / 2
    wide = spans if reach.shape[1] == 3 else np.array([min(spans[0], spans[1]), spans[2]])
    normals, offsets = planes[:, :3] @ frame, -planes[:, 3]
    free = [(None, None)] * 3
    first = linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([normals, reach @ wide]), b_ub=offsets, bounds=[*free, (0, None)]
    )
    if first.status != 0 or first.x[3] <= 0:
        return None
    least = [(float(0.999 * first.x[3] * w), None) for w in wide]
    second = linprog(
        [0, 0, 0, *(-1 / wide)], A_ub=np.column_stack([normals, reach]), b_ub=offsets, bounds=[*free, *least]
    )
    if second.status != 0:
        return Inside(frame, first.x[:3], first.x[3] * wide)
    return Inside(frame, second.x[:3], second.x[3:])
