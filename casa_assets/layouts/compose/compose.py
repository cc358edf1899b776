"""Place the built assets of a kitchen in a Scene."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from casa_assets.core.rounding import decimals
from casa_assets.geometry.inertia import ready_to_simulate
from casa_assets.layouts.compose.cameras import cameras
from casa_assets.layouts.compose.light import lights, sky
from casa_assets.layouts.order.build_order import DepthReference, HeightReference, Spot
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.wall_frame import turned_left
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

MAIN_REGION = "main"


def compose(kitchen: KitchenRequest, assets: Mapping[str, Asset], scene_id: str) -> Scene:
    """The scene of a kitchen.

    Args:
        assets: by name of what was wanted; the same asset may be under many names.
        scene_id: of the scene.
    """
    placements = tuple(
        Placement(
            name=w.name,
            asset=assets[w.name].id,
            pose=pose_at_spot(assets[w.name], w.spot),
            layer=Layer(w.layer),
        )
        for w in kitchen.items
    )
    each = {a.id: a for a in (assets[w.name] for w in kitchen.items)}
    scene = Scene(
        id=scene_id,
        assets=tuple(each[k] for k in sorted(each)),
        placements=placements,
        cameras=cameras(kitchen),
        lights=lights(kitchen, placements, each),
        ambient=(0.4, 0.4, 0.41),
        sky=sky(),
    )
    return ready_to_simulate(scene)


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
    (x, y, z), (_, depth, height) = box_of(asset)
    own = {DepthReference.BACK: depth / 2, DepthReference.MIDDLE: 0.0, DepthReference.FRONT: -depth / 2}[
        spot.depth_reference
    ]
    end = {HeightReference.FOOT: -height / 2, HeightReference.MIDDLE: 0.0, HeightReference.HEAD: height / 2}[
        spot.height_reference
    ]
    # A thing that is turned stands with its turned box against the line.
    if spot.turn_deg:
        angle = math.radians(spot.turn_deg)
        (_, wide), (w, d) = (0.0, 0.0), (_size(asset)[0], depth)
        wide = abs(w * math.sin(angle)) + abs(d * math.cos(angle))
        toward = {DepthReference.BACK: wide / 2, DepthReference.MIDDLE: 0.0, DepthReference.FRONT: -wide / 2}[
            spot.depth_reference
        ]
        there = turned_left(spot.frame.pose(spot.u, spot.v + toward, spot.z), spot.turn_deg)
        mark = np.array([x, y, z + end])
    else:
        there = spot.frame.pose(spot.u, spot.v, spot.z)
        mark = np.array([x, y + own, z + end])
    moved = there.apply(-mark[None, :])[0]
    position = tuple(decimals(float(c), 6) for c in moved)
    return Pose(position=(position[0], position[1], position[2]), quaternion=there.quaternion)


def _size(asset: Asset) -> Vec3:
    return box_of(asset)[1]
