"""Place the built assets of a kitchen in a Scene."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from casa_assets.core.rounding import decimals
from casa_assets.geometry.inertia import ready_to_simulate
from casa_assets.layouts.compose.cameras import cameras
from casa_assets.layouts.compose.light import lights
from casa_assets.layouts.order.build_order import DepthReference, HeightReference, Spot
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.wall_frame import turned_left
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Layer, Placement, Scene, Sky
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

MAIN_REGION = "main"
LID_SITE, LID_GAP_M = "lid_site", 0.0001


def compose(kitchen: KitchenRequest, assets: Mapping[str, Asset], scene_id: str) -> Scene:
    """The scene of a kitchen.

    Args:
        assets: by name of the ordered item; several names may have the same asset.
    """
    spots = {item.name: item.spot for item in kitchen.items}
    placements = tuple(
        Placement(
            name=item.name,
            asset=assets[item.name].id,
            pose=_pose_of_lid(spots[item.lid_of], assets[item.lid_of])
            if item.lid_of
            else pose_at_spot(assets[item.name], item.spot),
            layer=Layer(item.layer),
        )
        for item in kitchen.items
    )
    each = {a.id: a for a in (assets[item.name] for item in kitchen.items)}
    scene = Scene(
        id=scene_id,
        assets=tuple(each[k] for k in sorted(each)),
        placements=placements,
        cameras=cameras(kitchen),
        lights=lights(kitchen, placements, each),
        ambient=(0.4, 0.4, 0.41),
        sky=Sky(),
    )
    return ready_to_simulate(scene)


def _pose_of_lid(spot: Spot, asset: Asset) -> Pose:
    """room_from_asset of the lid of an asset that is placed at a spot, slightly above its closed position."""
    site = next(site for site in asset.sites if site.name == LID_SITE)
    closed = pose_at_spot(asset, spot) @ asset.asset_from_link(site.link) @ site.pose
    x, y, z = (decimals(float(c), 6) for c in closed.position)
    return Pose(position=(x, y, decimals(z + LID_GAP_M, 6)), quaternion=closed.quaternion)


def box_of(asset: Asset) -> tuple[Vec3, Vec3]:
    """Middle and size of what an asset takes up without handles and knobs: its region `main`; asset frame, metres."""
    for region in asset.regions:
        if region.name == MAIN_REGION and region.link == asset.root.name:
            middle = (asset.root.pose @ region.pose).position
            return middle, region.size
    low, high = asset.bounds
    middle = (low + high) / 2
    size = high - low
    return (float(middle[0]), float(middle[1]), float(middle[2])), (float(size[0]), float(size[1]), float(size[2]))


def pose_at_spot(asset: Asset, spot: Spot) -> Pose:
    """room_from_asset of an asset placed at a spot."""
    (x, y, z), (width, depth, height) = box_of(asset)
    back = {DepthReference.BACK: 0.5, DepthReference.MIDDLE: 0.0, DepthReference.FRONT: -0.5}[spot.depth_reference]
    up = {HeightReference.FOOT: -0.5, HeightReference.MIDDLE: 0.0, HeightReference.HEAD: 0.5}[spot.height_reference]
    if spot.turn_deg:
        # The bounding box of the turned item touches the line.
        angle = math.radians(spot.turn_deg)
        extent = abs(width * math.sin(angle)) + abs(depth * math.cos(angle))
        pose = turned_left(spot.frame.pose(spot.u, spot.v + back * extent, spot.z), spot.turn_deg)
        reference = np.array([x, y, z + up * height])
    else:
        pose = spot.frame.pose(spot.u, spot.v, spot.z)
        reference = np.array([x, y + back * depth, z + up * height])
        if spot.tilt_deg:
            half = math.radians(spot.tilt_deg) / 2
            pose = pose @ Pose(quaternion=(round(math.cos(half), 12), -round(math.sin(half), 12), 0.0, 0.0))
    px, py, pz = (decimals(float(c), 6) for c in pose.apply(-reference[None, :])[0])
    if spot.least_foot:
        pz = max(pz, decimals(spot.least_foot - (z - height / 2), 6))
    return Pose(position=(px, py, pz), quaternion=pose.quaternion)
