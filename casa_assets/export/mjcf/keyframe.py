"""Keyframe -> `<key>`: every joint of the document in its order."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Asset


def add_all(root: etree._Element, asset: Asset, placed: tuple[float, ...] = ()) -> None:
    """`<keyframe>` with one `<key>` for each named pose; `placed` are the positions of a free base."""
    if not asset.keyframes:
        return
    block = etree.SubElement(root, "keyframe")
    order = joints(asset, asset.root.name)
    for key in asset.keyframes:
        stands = {at.joint: at.value for at in key.joints}
        values = [*placed, *(stands.get(name, 0.0) for name in order)]
        etree.SubElement(block, "key", {"name": key.name, "qpos": number.numbers(values)})


def joints(asset: Asset, link: str) -> list[str]:
    """Names of the joints of a link and of all that it carries, in the order of the document."""
    moved_by = asset.joint_of(link)
    found = [moved_by.name] if moved_by else []
    for carried in asset.links:
        if carried.parent == link:
            found += joints(asset, carried.name)
    return found
