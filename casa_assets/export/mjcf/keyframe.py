"""Keyframe -> `<key>`: every joint of the document in its order."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.joint import joint_positions


def add_all(root: etree._Element, asset: Asset, free_joint: tuple[float, ...] = ()) -> None:
    """`<keyframe>` with one `<key>` for each named pose; `free_joint`: position of a free base."""
    if not asset.keyframes:
        return
    block = etree.SubElement(root, "keyframe")
    joints = joint_order(asset, asset.root.name)
    for key in asset.keyframes:
        positions = joint_positions(key.joints)
        values = [*free_joint, *(positions.get(name, 0.0) for name in joints)]
        etree.SubElement(block, "key", {"name": key.name, "qpos": number.numbers(values)})


def joint_order(asset: Asset, link: str) -> list[str]:
    """Names of the joints of a link and of all that it carries, in the order of the document."""
    joint = asset.joint_of(link)
    found = [joint.name] if joint else []
    for carried in asset.links:
        if carried.parent == link:
            found += joint_order(asset, carried.name)
    return found
