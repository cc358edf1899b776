"""Joints and objects of a scene in its named poses: as it begins, closed, open."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE, OPEN_POSE, START_POSE, Placement
from casa_assets.model.pose import Pose


def own_pose(place: Placement, name: str) -> str:
    """Named pose that the asset of a placement has in a named pose of the scene.

    An object stays closed in the open pose of the kitchen: lids of jars in a cupboard stay on.
    """
    return CLOSED_POSE if place.resting is not None and name == OPEN_POSE else name


def key_positions(place: Placement, asset: Asset) -> dict[str, dict[str, float]]:
    """Name of each scene pose -> joint positions of a placement, rad or m; joints that are not named are at zero."""
    keyframes = {key.name: joint_positions(key.joints) for key in asset.keyframes}
    closed = keyframes.get(CLOSED_POSE, {})
    return {
        START_POSE: joint_positions(place.joints),
        CLOSED_POSE: closed,
        OPEN_POSE: keyframes.get(own_pose(place, OPEN_POSE), closed),
    }


def carried_pose(
    place: Placement, placements: Mapping[str, Placement], assets: Mapping[str, Asset], name: str
) -> Pose | None:
    """Return world_from_asset of an object in a named pose, or None if it is in its start pose.

    Args:
        place: placement of the object; one without a support stays in place.
        placements, assets: of the scene, by name of the placement.
    """
    rest = place.resting
    if rest is None:
        return None
    holder, asset = placements[rest.placement], assets[rest.placement]
    positions = key_positions(holder, asset)
    if not asset.is_moved(rest.link) or positions[name] == positions[START_POSE]:
        return None
    at_start, now = (asset.asset_from_link(rest.link, positions[key]) for key in (START_POSE, name))
    return holder.pose @ now @ at_start.inverse() @ holder.pose.inverse() @ place.pose
