"""Labels, states, grips, behaviour and the kind of base -> `<custom>` texts, which MuJoCo stores but does not use."""

from __future__ import annotations

import json
from typing import Any

from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.formats.behavior_schema import BehaviorFile


def add_all(root: etree._Element, asset: Asset) -> None:
    """`<custom>` with the texts of an asset."""
    custom = etree.SubElement(root, "custom")
    for name, data in texts(asset).items():
        etree.SubElement(custom, "text", {"name": name, "data": data})


def texts(asset: Asset, prefix: str = "") -> dict[str, str]:
    """Texts of an asset in a model, by name.

    Always `base`, `class` (from the category upwards) and `qcode`; if the asset has them `portion`, `contract`,
    `state__<name>`, `label__<label>` (names of geoms), `grip__<joint>` (name of a geom), `behind__<joint>` (name of a
    joint) and `behavior` (JSON).

    Args:
        prefix: prefix of the names of its geoms and joints in the document; names in the JSON have no prefix.
    """
    found = {
        "base": asset.base.value,
        "class": " ".join(asset.labels.classes),
        "qcode": asset.labels.qcode.id,
    }
    if asset.labels.portion is not None:
        found["portion"] = asset.labels.portion.value
    for state in asset.states:
        found[f"state__{state.name}"] = f"{prefix}{state.joint} {state.value} {number.numbers(state.interval)}"
    if asset.contract is not None:
        found["contract"] = asset.contract
    found |= {
        f"label__{label}": " ".join(prefix + name for name in names) for label, names in geoms_by_label(asset).items()
    }
    found |= {f"grip__{joint.name}": prefix + joint.grip for joint in asset.joints if joint.grip is not None}
    found |= {f"behind__{joint.name}": prefix + joint.behind for joint in asset.joints if joint.behind is not None}
    if asset.behavior is not None:
        found["behavior"] = asset.behavior.to_json()
    return found


def geoms_by_label(asset: Asset) -> dict[str, list[str]]:
    """Label -> names of the geoms that carry it, sorted."""
    found: dict[str, list[str]] = {}
    for link in asset.links:
        parts = [(c.label, c.name) for c in link.colliders] + [(v.label, v.name) for v in link.visuals]
        for label, name in parts:
            if label is not None:
                found.setdefault(label, []).append(name)
    return {label: sorted(found[label]) for label in sorted(found)}


def behavior_file(asset: Asset) -> bytes:
    """The state machine, the named states of joints and the named poses as JSON for people and programs."""
    assert asset.behavior is not None, "the caller checks"
    data: dict[str, Any] = {
        "behavior": asset.behavior.model_dump(mode="json", exclude_none=True),
        "states": [state.model_dump(mode="json") for state in asset.states],
        "keyframes": [key.model_dump(mode="json") for key in asset.keyframes],
    }
    BehaviorFile.model_validate(data)
    return (json.dumps(data, indent=1, sort_keys=True) + "\n").encode("ascii")
