"""Find the spaces of a kitchen in which people keep things, and what of each is taken already."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.layouts.compose.swept_areas import AssetOutlines
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.site import Region
from casa_assets.model.kitchen.habit import SpaceKind
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.model.pose import Pose

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1 in the frame of a space, metres

# A cooking zone or the tray of a coffee machine is a site: so much room is about it, width, depth and height, metres.
SITE_SIZE_M = (0.2, 0.2, 0.25)
UPRIGHT_COSINE = 0.9999
# What begins this little above a floor stands on it.
FLOOR_SLACK_M = 0.004
# A thing whose joints move it through less than this is no door: a knob, a key.
MIN_SWEEP_M = 0.03
_CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


@dataclass(frozen=True)
class Space:
    """A region of a thing in a kitchen in which other things stand.

    Attributes:
        placement, link, region: whose it is: a placement, its link, and the name of its region or site.
        kinds: names of the kinds of space that it is.
        pose: world_from_space: middle of its floor, x to the right along the front, y to the back, z up.
        size: width, depth, height, metres.
        is_round: a cylinder of that width. is_moving: it moves when a drawer, rack or door opens.
        is_site: no more than a point on which one thing stands.
        taken: what stands in it already, and what parts of other things sweep.
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

    @property
    def name(self) -> str:
        """`<placement>/<region>`."""
        return f"{self.placement}/{self.region}"


def find_spaces(scene: Scene, kinds: Mapping[str, SpaceKind]) -> tuple[Space, ...]:
    """All spaces of a scene that are of one of some kinds, in the order of its placements."""
    assets = scene.asset_of
    outlines = {asset.id: AssetOutlines(asset) for asset in scene.assets}
    bounds = {p.name: _solid_boxes(p, outlines[p.asset]) for p in scene.placements if p.layer is Layer.THINGS}
    found = []
    for place in scene.placements:
        if place.layer is not Layer.THINGS:
            continue
        for space in _spaces_of(place, assets[place.name], outlines[place.asset], kinds):
            others = [box for name, boxes in bounds.items() if name != place.name for box in boxes]
            found.append(replace(space, taken=tuple(taken_by(space, others))))
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


def _solid_boxes(place: Placement, outlines: AssetOutlines) -> list[Floats]:
    """(2, 3) boxes in the world around each link of a thing, and around all that each of its doors sweeps."""
    boxes = []
    for points in outlines.points.values():
        if len(points):
            boxes.append(box_around(place.pose.apply(points)))
    for joint in outlines.asset.joints:
        swept = outlines.swept_points(joint)
        if swept.size and float(np.abs(swept - swept[:1]).max()) > MIN_SWEEP_M:
            boxes.append(box_around(place.pose.apply(swept.reshape(-1, 3))))
    return boxes


def box_around(points: Floats) -> Floats:
    """(2, 3) bounds of (N, 3) points."""
    return np.array([points.min(axis=0), points.max(axis=0)])


def taken_by(space: Space, boxes: Iterable[Floats]) -> Iterator[Rect]:
    """What (2, 3) boxes of the world take of a space, each where it reaches into it."""
    to_space, size = space.pose.inverse(), np.array(space.size)
    for box in boxes:
        low, high = box_around(to_space.apply(np.where(_CUBE, box[1], box[0])))
        is_beside = (low[:2] >= size[:2] / 2) | (high[:2] <= -size[:2] / 2)
        if low[2] < size[2] and high[2] > FLOOR_SLACK_M and not is_beside.any():
            yield (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
