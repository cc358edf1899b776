"""An asset with some joints locked: moved parts stay at their given position and become one body with their carrier."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from casa_assets.model.asset.asset import Asset, Collider, Link
from casa_assets.model.pose import Pose


def with_joints_locked(asset: Asset, locked: Collection[str], positions: Mapping[str, float]) -> Asset:
    """The asset without some of its joints; the colliders of what they moved go to the link that carries it.

    States and named poses lose what they say of a locked joint. Behaviour that looks at one, or at a key that it moved,
    is left out.

    Args:
        locked: names of joints. positions: of joints, rad or m; a locked one stays at its own, 0 where it has none.
    """
    poses = {
        link.name: asset.parent_from_link(link.name, positions)
        if (joint := asset.joint_of(link.name)) is not None and joint.name in locked
        else link.pose
        for link in asset.links
    }
    joints = tuple(
        joint.replace(behind=None if joint.behind in locked else joint.behind)
        for joint in asset.joints
        if joint.name not in locked
    )
    behavior = asset.behavior
    if behavior is not None:
        held = asset.carried_by([joint.child for joint in asset.joints if joint.name in locked])
        keys = {collider.name for link in asset.links if link.name in held for collider in link.colliders}
        if set(behavior.joints) & set(locked) or set(behavior.contacts) & keys:
            behavior = None
    moved = {joint.child for joint in joints}
    links = [link.replace(pose=poses[link.name]) for link in asset.links]
    return asset.replace(
        links=_on_their_carriers(links, moved),
        joints=joints,
        states=tuple(state for state in asset.states if state.joint not in locked),
        keyframes=tuple(
            key.replace(joints=tuple(at for at in key.joints if at.joint not in locked)) for key in asset.keyframes
        ),
        behavior=behavior,
    )


def _on_their_carriers(links: list[Link], moved: Collection[str]) -> tuple[Link, ...]:
    """The links, with the colliders of those that are rigidly attached on the nearest that moves, or the root."""
    carrier_from: dict[str, tuple[str, Pose]] = {}
    colliders: dict[str, list[Collider]] = {link.name: [] for link in links}
    for link in links:
        if link.parent is None or link.name in moved:
            carrier_from[link.name] = (link.name, Pose())
        else:
            carrier, pose = carrier_from[link.parent]
            carrier_from[link.name] = (carrier, pose @ link.pose)
        carrier, pose = carrier_from[link.name]
        colliders[carrier] += [c.replace(pose=pose @ c.pose) for c in link.colliders]
    return tuple(link.replace(colliders=tuple(colliders[link.name])) for link in links)
