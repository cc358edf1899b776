"""Labels, states and the kind of base -> `<custom>` texts, which MuJoCo keeps and does not interpret."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset import Asset


def add_all(root: etree._Element, asset: Asset) -> None:
    """`<custom>` with `base`, `class` (from the category upwards), `qcode` and one `state__...` per named state."""
    texts = {
        "base": asset.base.value,
        "class": " ".join(asset.labels.classes),
        "qcode": asset.labels.qcode.id,
    }
    for state in asset.states:
        texts[f"state__{state.name}"] = f"{state.joint} {state.value} {number.numbers(state.interval)}"
    custom = etree.SubElement(root, "custom")
    for name, data in texts.items():
        etree.SubElement(custom, "text", {"name": name, "data": data})
