"""Move an asset so that its frame, and that of every body that is not rotated, is in the middle of its region `main`.

RoboCasa v1.0 places a fixture by the frame of its body `object`, and interprets the position of a region in that frame,
whichever body the region belongs to. It also assumes half of a fixture's size on each side of the frame (counters), and
recognises a top drawer by the height of the frame. All of this is correct if frames are in the middle of `main`.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import decimals
from casa_assets.model.asset.asset import Asset, Collider, Inertial, Joint, Link, Region, Site, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

MAIN = "main"
Offset = npt.NDArray[np.float64]
# A quaternion this close to none is none: frames of families are turned by quarter turns or not at all.
MAX_TURN = 1e-9
T = TypeVar("T", Site, Region, Collider)


def main_region(asset: Asset) -> Region:
    """The region `main` of an asset. Raises KeyError if it does not exist."""
    return {region.name: region for region in asset.regions}[MAIN]


def main_center(asset: Asset) -> Vec3:
    """Middle of `main` in the asset frame, metres."""
    main = main_region(asset)
    return _vec3(np.array((asset.asset_from_link(main.link) @ main.pose).position))


def centered(asset: Asset) -> Asset:
    """The asset with its origin in the middle of `main`; bodies that are not rotated have their frames there too."""
    return moved(asset, np.array(main_center(asset)))


def moved(asset: Asset, center: Offset) -> Asset:
    """The asset with its origin, and the frames of bodies that are not rotated, at a given point, metres."""
    frames: dict[str, Pose] = {}  # link -> its new frame in the centred asset
    links, offsets = [], {}
    for link in asset.links:
        old = asset.asset_from_link(link.name)
        is_turned = max(abs(q) for q in old.quaternion[1:]) > MAX_TURN
        place = _vec3(np.array(old.position) - center)
        frames[link.name] = Pose(position=place, quaternion=old.quaternion) if is_turned else Pose()
        offsets[link.name] = np.zeros(3) if is_turned else np.array(place)
        parent = Pose() if link.parent is None else frames[link.parent]
        links.append(_moved_link(link, offsets[link.name]).replace(pose=parent.inverse() @ frames[link.name]))
    return asset.replace(
        links=tuple(links),
        joints=tuple(_moved_joint(joint, offsets[joint.child]) for joint in asset.joints),
        sites=tuple(_moved(site, offsets[site.link]) for site in asset.sites),
        regions=tuple(_moved(region, offsets[region.link]) for region in asset.regions),
    )


def _moved_link(link: Link, offset: Offset) -> Link:
    if not offset.any():
        return link
    inertial = link.inertial
    return link.replace(
        inertial=Inertial(
            mass=inertial.mass,
            center_of_mass=_vec3(np.array(inertial.center_of_mass) + offset),
            inertia=inertial.inertia,
        ),
        visuals=tuple(_moved_visual(visual, offset) for visual in link.visuals),
        colliders=tuple(_moved(collider, offset) for collider in link.colliders),
    )


def _moved_visual(visual: Visual, offset: Offset) -> Visual:
    mesh = visual.mesh
    return visual.replace(mesh=mesh.with_vertices(mesh.vertices + offset, mesh.normals))


def _moved_joint(joint: Joint, offset: Offset) -> Joint:
    return joint.replace(anchor=_vec3(np.array(joint.anchor) + offset))


def _moved(thing: T, offset: Offset) -> T:
    pose = Pose(position=_vec3(np.array(thing.pose.position) + offset), quaternion=thing.pose.quaternion)
    return thing.replace(pose=pose)


def _vec3(values: Offset) -> Vec3:
    """Round to ten decimals: sums of lengths in metres must not leave errors such as 1e-17."""
    x, y, z = (decimals(float(v), 10) for v in values)
    return x, y, z
