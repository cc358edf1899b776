"""Find the spaces of a kitchen in which people keep things, and what of each is free."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from casa_assets.core.numeric import Floats, Mask
from casa_assets.layouts.compose import CUBE, AssetOutlines, box_around, box_in_world
from casa_assets.mesh.solid.solids import hull_planes
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, MeshShape, Region, Shape, Sphere
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.registry.rows import SpaceKind

CELL_M = 0.003
# Two of the same shape, one lifted by `pitch`, may still touch between the centres of cells.
CELL_SLACK_M = 0.0006
# What has a handle at one side is so much longer than wide, and the middle of its area so far from that of its length.
LONG_SHARE, OFF_SHARE = 1.15, 0.04
# Regions of a rack that take one plate each.
SLOT = "slot_"
# A cooking zone or the tray of a coffee machine is a site: so much room is about it, width, depth and height, metres.
SITE_SIZE_M = (0.2, 0.2, 0.25)
UPRIGHT_COSINE = 0.9999
# What begins this little above a floor stands on it.
FLOOR_SLACK_M = 0.004
# A thing whose joints move it through less than this is no door: a knob, a key.
MIN_SWEEP_M = 0.03
_NOTHING = np.empty((0, 2, 3))
FREE_CELL_M = 0.01
THING_M, THING_GAP_M = 0.1, 0.02
Rect = tuple[float, float, float, float]  # x0, y0, x1, y1 in the frame of a space, metres
_ROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


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
        """(2,) middle of the body, taken to be as long as wide, without its handle; frame of the asset, metres."""
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
    box = box_around(every)
    counts = np.maximum(1, np.ceil((box[1, :2] - box[0, :2]) / CELL_M).astype(int))
    low, high = np.full(counts, np.inf), np.full(counts, -np.inf)
    x, y = (box[0, k] + (np.arange(counts[k]) + 0.5) * CELL_M for k in (0, 1))
    for cloud in clouds:
        _raster(hull_planes(cloud), x, y, low, high)
    slots = [r for r in asset.regions if r.name.startswith(SLOT)]
    corners = [asset.asset_from_link(r.link).apply(r.pose.apply(CUBE * np.array(r.size))) for r in slots]
    return Silhouette(box, low, high, np.array([box_around(c) for c in corners]).reshape(-1, 2, 3))


def outline_points(shape: Shape) -> Floats:
    """(N, 3) points whose hull is a shape, or a little less where it is round; frame of the shape, metres."""
    if isinstance(shape, Hull | MeshShape):
        return np.asarray(shape.mesh.vertices)
    if isinstance(shape, Box):
        points: Floats = CUBE * np.array(shape.size)
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
    """Widen the heights in the cells, by their centres, over which a convex body of (F, 4) outward planes lies."""
    across, along, offset = (planes[:, k, None, None] for k in (0, 1, 3))
    at = across * x[None, :, None] + along * y[None, None, :] + offset
    slope = planes[:, 2]
    below, above, upright = slope < -1e-9, slope > 1e-9, np.abs(slope) <= 1e-9
    bottom = (at[below] / -slope[below, None, None]).max(axis=0)
    top = (-at[above] / slope[above, None, None]).min(axis=0)
    inside = (bottom <= top) & (at[upright] <= 0.0).all(axis=0)
    low[inside] = np.minimum(low[inside], bottom[inside])
    high[inside] = np.maximum(high[inside], top[inside])


@dataclass(frozen=True)
class Space:
    """A region of an object in a kitchen in which other objects can be placed.

    Attributes:
        placement, link, region: what it belongs to: a placement, its link, and the name of its region or site.
        kinds: names of the kinds of space that it is.
        pose: world_from_space: middle of its floor, x to the right along the front, y to the back, z up.
        size: width, depth, height, metres.
        is_round: a cylinder of that width. is_moving: it moves when a drawer, rack or door opens.
        is_site: only a point, on which one object is placed.
        taken: rectangles of objects that are already in it, and of areas that parts of other objects sweep.
    """

    placement: str
    link: str
    region: str
    kinds: tuple[str, ...]
    pose: Pose
    size: tuple[float, float, float]
    is_round: bool = False
    is_moving: bool = False
    is_site: bool = False
    taken: tuple[Rect, ...] = ()


def find_spaces(scene: Scene, kinds: Mapping[str, SpaceKind]) -> tuple[Space, ...]:
    """All spaces of a scene that are of one of some kinds, in the order of its placements."""
    assets = scene.asset_of
    outlines = {asset.id: AssetOutlines(asset) for asset in scene.assets}
    things = [p for p in scene.placements if p.layer is Layer.THINGS]
    boxes = {p.name: _solid_boxes(p, outlines[p.asset]) for p in things}
    found = []
    for place in things:
        others = np.concatenate([_NOTHING, *(box for name, box in boxes.items() if name != place.name)])
        spaces = _spaces_of(place, assets[place.name], outlines[place.asset], kinds)
        found += [replace(space, taken=taken_by(space, others)) for space in spaces]
    return tuple(found)


def _spaces_of(
    place: Placement, asset: Asset, outlines: AssetOutlines, kinds: Mapping[str, SpaceKind]
) -> Iterator[Space]:
    sites = [Region(name=s.name, link=s.link, pose=s.pose, size=SITE_SIZE_M) for s in asset.sites]
    for number, region in enumerate((*asset.regions, *sites)):
        is_site = number >= len(asset.regions)
        down = Pose() if is_site else Pose(position=(0.0, 0.0, -region.size[2] / 2))
        pose = place.pose @ outlines.poses[region.link] @ region.pose @ down
        if pose.rotation[2, 2] < UPRIGHT_COSINE:
            continue
        floor = pose.position[2]
        names = tuple(
            name
            for name, kind in kinds.items()
            if kind.holds(asset.labels.category, region.name, floor)
            and all(have >= least for have, least in zip(region.size, kind.min_size_m, strict=True))
        )
        if names:
            yield Space(
                placement=place.name,
                link=region.link,
                region=region.name,
                kinds=names,
                pose=pose,
                size=region.size,
                is_round=region.kind == "cylinder",
                is_moving=asset.is_moved(region.link),
                is_site=is_site,
            )


def _solid_boxes(place: Placement, outlines: AssetOutlines) -> Floats:
    """(N, 2, 3) boxes in the world around the collision shapes of a thing, and around what its doors sweep."""
    clouds = [
        outlines.poses[link.name].apply(collider.pose.apply(outline_points(collider.shape)))
        for link in outlines.asset.links
        for collider in link.colliders
    ]
    for joint in outlines.asset.joints:
        swept = outlines.swept_points(joint)
        if swept.size and float(np.abs(swept - swept[:1]).max()) > MIN_SWEEP_M:
            clouds.append(swept.reshape(-1, 3))
    return np.array([box_around(place.pose.apply(cloud)) for cloud in clouds]).reshape(-1, 2, 3)


def taken_by(space: Space, boxes: Floats) -> tuple[Rect, ...]:
    """Rectangles that (N, 2, 3) boxes of the world take of a space, each where it reaches into it."""
    if not len(boxes):
        return ()
    corners = np.where(CUBE > 0, boxes[:, 1, None], boxes[:, 0, None])
    local = space.pose.inverse().apply(corners.reshape(-1, 3)).reshape(-1, 8, 3)
    low, high, half = local.min(axis=1), local.max(axis=1), np.array(space.size) / 2
    reaches = (low[:, 2] < space.size[2]) & (high[:, 2] > FLOOR_SLACK_M)
    reaches &= (low[:, :2] < half[:2]).all(axis=1) & (high[:, :2] > -half[:2]).all(axis=1)
    rects = np.concatenate([low[:, :2], high[:, :2]], axis=1)[reaches].tolist()
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in rects)


def free_cells(space: Space) -> Mask:
    """(X, Y) which cells of `CELL_M` of a space's floor are free over its whole height, from its left front corner."""
    width, depth, _ = space.size
    counts = [max(1, math.floor(side / FREE_CELL_M + 1e-6)) for side in (width, depth)]
    x, y = (-side / 2 + (np.arange(n) + 0.5) * FREE_CELL_M for side, n in zip((width, depth), counts, strict=True))
    free = np.ones(counts, dtype=bool)
    half = FREE_CELL_M / 2 - 1e-6  # what ends where a cell begins takes none of it
    for x0, y0, x1, y1 in space.taken:
        over_x, over_y = (x + half > x0) & (x - half < x1), (y + half > y0) & (y - half < y1)
        free &= ~(over_x[:, None] & over_y[None, :])
    if space.is_round:
        free &= np.hypot(np.abs(x)[:, None] + half, np.abs(y)[None, :] + half) <= width / 2
    return free


def largest_box(space: Space) -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Size of the box over the largest free rectangle of the floor, and its middle in the frame of the space, metres.

    It is as high as the space, and zero if nothing is free.
    """
    free = free_cells(space)
    best, found = 0, (0, 0, 0, 0)
    runs = np.zeros(free.shape[1], dtype=int)
    for i, row in enumerate(free):
        runs = np.where(row, runs + 1, 0)
        area, (start, end, length) = _largest_under([*runs.tolist(), 0])
        if area > best:
            best, found = area, (i + 1 - length, start, i + 1, end)
    i0, j0, i1, j1 = found
    width, depth, height = space.size
    size = ((i1 - i0) * FREE_CELL_M, (j1 - j0) * FREE_CELL_M, height if best else 0.0)
    return size, ((i0 + i1) / 2 * FREE_CELL_M - width / 2, (j0 + j1) / 2 * FREE_CELL_M - depth / 2)


def _largest_under(heights: list[int]) -> tuple[int, tuple[int, int, int]]:
    """Area of the largest rectangle under a histogram that ends in 0, and its first column, the one after, its height.

    Columns that may still grow to the right are kept on a stack, each with where it begins, the lowest first.
    """
    best, found = 0, (0, 0, 0)
    growing: list[tuple[int, int]] = []
    for j, height in enumerate(heights):
        start = j
        while growing and growing[-1][1] >= height:
            start, tall = growing.pop()
            if tall * (j - start) > best:
                best, found = tall * (j - start), (start, j, tall)
        growing.append((start, height))
    return best, found


def count_of_things(space: Space) -> int:
    """Number of 10 cm cubes that fit on its floor in rows, 2 cm apart; 0 if it is lower than a cube, 1 for a site."""
    if space.size[2] < THING_M:
        return 0
    if space.is_site:
        return 1
    free = free_cells(space)
    side, pitch = round(THING_M / FREE_CELL_M), round((THING_M + THING_GAP_M) / FREE_CELL_M)
    count, j = 0, 0
    while j + side <= free.shape[1]:
        i, row = 0, 0
        while i + side <= free.shape[0]:
            if free[i : i + side, j : j + side].all():
                row, i = row + 1, i + pitch
            else:
                i += 1
        count += row
        j += pitch if row else 1
    return count


def world_bounds(space: Space) -> Floats:
    """(2, 3) bounds of a space in the world, metres."""
    width, depth, height = space.size
    box = np.array([(-width / 2, -depth / 2, 0.0), (width / 2, depth / 2, height)])
    return box_in_world(space.pose, box)
