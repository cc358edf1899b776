"""Drop products of inertia that no joint can feel, and list pairs of links that never touch."""

from __future__ import annotations

import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Base, Joint, JointKind, Link
from casa_assets.model.kitchen.scene import PlacedLink, Scene

# What moves is beside what is fixed where the boxes around them are this near while all is shut, metres.
ADJACENT_M = 0.1
# Sine of the angle by which an axis may lean and still be one of the link's own.
AXIS_ALIGNED_SINE = 1e-9


def ready_to_simulate(scene: Scene) -> Scene:
    """Drop unfelt products of inertia from a scene, and exclude pairs of links that never touch."""
    return scene.replace(assets=tuple(map(drop_unfelt_products, scene.assets)), exclusions=adjacent_links(scene))


def adjacent_links(scene: Scene) -> tuple[tuple[PlacedLink, PlacedLink], ...]:
    """Pair every moving link with the fixed links next to it while everything is shut, including its own frame.

    A door and the frame, walls and worktops around it are so close that a simulator checks them for contact at every
    step, although they never touch: the joint holds the door, and every scene is checked to be free of collisions over
    the whole range of each joint. The pairs are in the order of the placements and their links.
    """
    moving, fixed = _boxes(scene)
    if not moving or not fixed:
        return ()
    own, other = (np.array(list(side.values())) for side in (moving, fixed))
    gaps = np.maximum(own[:, None, 0] - other[None, :, 1], other[None, :, 0] - own[:, None, 1])
    near = (gaps <= ADJACENT_M).all(axis=-1)
    bodies, frames = list(moving), list(fixed)
    return tuple((bodies[i], frames[j]) for i, j in np.argwhere(near))


def drop_unfelt_products(asset: Asset) -> Asset:
    """Drop the products of inertia of links whose joints cannot feel them.

    A link that never turns does not need its inertia. A link that turns about one axis of its link frame, on a parent
    that does not turn, needs only the moment about that axis. MuJoCo aligns its bounding volume hierarchy with the axes
    of inertia: the arbitrarily tilted ones of a cupboard give straight panels boxes that all overlap.
    """
    if asset.base is Base.FREE:
        return asset
    return asset.replace(links=tuple(_straight(asset, link) for link in asset.links))


def _boxes(scene: Scene) -> tuple[dict[PlacedLink, Floats], dict[PlacedLink, Floats]]:
    """Bounding boxes, (2, 3) corners, of moving and of fixed links with every joint at zero, world frame, metres."""
    moving: dict[PlacedLink, Floats] = {}
    fixed: dict[PlacedLink, Floats] = {}
    assets = scene.asset_of
    for place in scene.placements:
        asset = assets[place.name]
        for link in asset.links if asset.base is Base.FIXED else ():
            box = link_bounds(link, place.pose @ asset.asset_from_link(link.name))
            if box is not None:
                side = moving if _movers(asset, link) else fixed
                side[PlacedLink(placement=place.name, link=link.name)] = box
    return moving, fixed


def _movers(asset: Asset, link: Link) -> tuple[Joint, ...]:
    """The joints that move a link, its own first."""
    own = asset.joint_of(link.name)
    carried = () if link.parent is None else _movers(asset, asset.link(link.parent))
    return carried if own is None else (own, *carried)


def _straight(asset: Asset, link: Link) -> Link:
    turning = [joint for joint in _movers(asset, link) if joint.kind is JointKind.HINGE]
    inertial = link.inertial
    if not any(inertial.inertia[3:]) or len(turning) > 1:
        return link
    if turning:
        asset_from_axis = asset.asset_from_link(turning[0].child).rotation @ np.array(turning[0].axis)
        axis = np.abs(asset.asset_from_link(link.name).rotation.T @ asset_from_axis)
        if np.sort(axis)[1] > AXIS_ALIGNED_SINE:
            return link
    return link.replace(inertial=inertial.replace(inertia=(*inertial.inertia[:3], 0.0, 0.0, 0.0)))
