"""Asset -> the same asset without meshes: every mesh that collides becomes a box or a cylinder inside of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from casa_assets.errors import DegenerateShape
from casa_assets.geometry.hull import hull_planes, hull_volume
from casa_assets.model.asset import Asset, Collider, Link
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box, Cylinder, Hull, MeshShape

Floats = npt.NDArray[np.float64]

# Sizes are multiples of this, rounded down, metres: the last digits of a solver are no promise.
GRID = 1e-6
# Half the size of the smallest primitive, metres, for shapes that are too thin for the grid.
LEAST = 1e-5
# Share of a hull that one primitive has to fill for the search to end.
FULL = 0.97
# A further box is worth this share of the hull, and there are no more than so many.
WORTH, MORE = 0.04, 3
# Between the name of a collider and the number of a further box of it.
FURTHER = "_more_"


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


def original(name: str) -> str:
    """Name of the collider that a further box of a light asset belongs to; of any other, its own."""
    head, sign, tail = name.rpartition(FURTHER)
    return head if sign and tail.isdigit() else name


def inside(points: Floats) -> tuple[tuple[Box | Cylinder, Pose], ...]:
    """A box, a few boxes or a cylinder inside the convex hull of (N, 3) points, and their poses in its frame.

    Where a box leaves much of the hull empty (the corner of a worktop), a few more follow, which do not overlap it or
    each other; they stand where one cylinder would fill less.

    Raises:
        DegenerateShape: the points span no volume.
    """
    planes, volume = hull_planes(points), hull_volume(points)
    boxes: list[Inside] = []
    rods: list[Inside] = []
    for frame in _frames(points):
        spans = np.ptp(points @ frame, axis=0) / 2
        round_ = np.array([min(spans[0], spans[1]), spans[2]])
        boxes += _largest(planes, frame, _box_reach(planes, frame), spans)
        rods += _largest(planes, frame, _rod_reach(planes, frame), round_)
        if any(found.volume >= FULL * volume for found in (*boxes, *rods)):
            break
    if not boxes or not rods:
        raise DegenerateShape("nothing fits inside the hull")
    # Of equals the first: a later frame has to be better by more than rounding.
    box, rod = (max(found, key=lambda f: float(f"{f.volume:.6g}")) for found in (boxes, rods))
    several = [box, *_beside(planes, box, volume)]
    best = [rod] if rod.volume > sum(one.volume for one in several) else several
    return tuple(_rounded(found) for found in best)


def _beside(planes: Floats, first: Inside, volume: float) -> list[Inside]:
    """The largest boxes in what is left of a hull on each side of a box, largest first."""
    if first.volume >= FULL * volume:
        return []
    found: list[Inside] = []
    rest = planes
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = sign * first.frame[:, axis]
            face = sign * first.center[axis] + first.half[axis]
            beyond = np.vstack([rest, [*-normal, face]])
            boxes = _largest(beyond, first.frame, _box_reach(beyond, first.frame), first.half)
            found += [box for box in boxes if box.volume >= WORTH * volume]
            # What comes after stays on the near side of this face.
            rest = np.vstack([rest, [*normal, -face]])
    return sorted(found, key=lambda box: -box.volume)[:MORE]


def _rounded(found: Inside) -> tuple[Box | Cylinder, Pose]:
    matrix = np.eye(4)
    matrix[:3, :3] = found.frame
    matrix[:3, 3] = np.round(found.frame @ found.center / GRID) * GRID
    # The centre was rounded by up to half a unit along each axis.
    half = np.maximum(np.floor((found.half - GRID) / GRID) * GRID, LEAST)
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
        found = inside(item.shape.mesh.vertices)
    except DegenerateShape:
        return ()
    names = [item.name, *(f"{item.name}{FURTHER}{k}" for k in range(1, len(found)))]
    pairs = zip(names, found, strict=True)
    return tuple(item.replace(name=name, shape=shape, pose=item.pose @ pose) for name, (shape, pose) in pairs)


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


def _largest(planes: Floats, frame: Floats, reach: Floats, wide: Floats) -> list[Inside]:
    """None or one: first the largest of the proportions of `wide`, then as much wider as there is room.

    Both are linear programs in the centre and the half sizes: normal . centre + reach . half <= -offset.
    """
    normals, offsets = planes[:, :3] @ frame, -planes[:, 3]
    free = [(None, None)] * 3
    first = linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([normals, reach @ wide]), b_ub=offsets, bounds=[*free, (0, None)]
    )
    if first.status != 0 or first.x[3] <= 0:
        return []
    least = [(float(0.999 * first.x[3] * w), None) for w in wide]
    second = linprog(
        [0, 0, 0, *(-1 / wide)], A_ub=np.column_stack([normals, reach]), b_ub=offsets, bounds=[*free, *least]
    )
    if second.status != 0:
        return [Inside(frame, first.x[:3], first.x[3] * wide)]
    return [Inside(frame, second.x[:3], second.x[3:])]
