"""Find the spaces of a kitchen in which people keep things, and what of each is taken already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.layouts.compose.swept_areas import AssetOutlines
from casa_assets.layouts.lived_in.silhouette import outline_points
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
_NOTHING = np.empty((0, 2, 3))
_CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


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

    @property
    def name(self) -> str:
        """`<placement>/<region>`."""
        return f"{self.placement}/{self.region}"


def find_spaces(scene: Scene, kinds: Mapping[str, SpaceKind]) -> tuple[Space, ...]:
    """All spaces of a scene that are of one of some kinds, in the order of its placements."""
    assets = scene.asset_of
    outlines = {asset.id: AssetOutlines(asset) for asset in scene.assets}
    things = [p for p in scene.placements if p.layer is Layer.THINGS]
    boxes = {p.name: _solid_boxes(p, outlines[p.asset]) for p in things}
    found = []
    for place in things:
        others = np.concatenate([_NOTHING, *(box for name, box in boxes.items() if name != place.name)])
        for space in _spaces_of(place, assets[place.name], outlines[place.asset], kinds):
            found.append(replace(space, taken=taken_by(space, others)))
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


def box_around(points: Floats) -> Floats:
    """(2, 3) bounds of (N, 3) points."""
    return np.array([points.min(axis=0), points.max(axis=0)])


def box_in_world(world_from_frame: Pose, box: Floats) -> Floats:
    """(2, 3) bounds in the world of a (2, 3) box given in another frame."""
    return box_around(world_from_frame.apply(np.where(_CUBE, box[1], box[0])))


def taken_by(space: Space, boxes: Floats) -> tuple[Rect, ...]:
    """What (N, 2, 3) boxes of the world take of a space, each where it reaches into it."""
    if not len(boxes):
        return ()
    corners = np.where(_CUBE, boxes[:, 1, None], boxes[:, 0, None])
    local = space.pose.inverse().apply(corners.reshape(-1, 3)).reshape(-1, 8, 3)
    low, high, half = local.min(axis=1), local.max(axis=1), np.array(space.size) / 2
    reaches = (low[:, 2] < space.size[2]) & (high[:, 2] > FLOOR_SLACK_M)
    reaches &= (low[:, :2] < half[:2]).all(axis=1) & (high[:, :2] > -half[:2]).all(axis=1)
    rects = np.concatenate([low[:, :2], high[:, :2]], axis=1)[reaches].tolist()
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in rects)
