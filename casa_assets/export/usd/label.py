"""Labels -> UsdSemantics; behaviour, contract and grips -> attributes in the namespace `casa`."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd, UsdSemantics

from casa_assets.export.usd.joint import SCOPE
from casa_assets.model.asset.asset import Asset

# The taxonomy of the part of an asset that a visual or collider is: handle, door, shelf.
PART = "part"


def attach(prim: Usd.Prim, taxonomy: str, labels: Sequence[str]) -> None:
    """Set the labels of one taxonomy on a prim."""
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(list(labels))


def attach_all(root: Usd.Prim, asset: Asset) -> None:
    """Attach classes from the category upwards, the Wikidata item, and the portion of a cut object."""
    attach(root, "class", asset.labels.classes)
    attach(root, "wikidata_qcode", [asset.labels.qcode.id])
    if asset.labels.portion is not None:
        attach(root, "portion", [asset.labels.portion.value])


def define_behavior(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """`casa:behavior` (JSON) and `casa:contract` on the root, `casa:grip` and `casa:behind` on joints."""
    if asset.contract is not None:
        _set_text(root, "contract", asset.contract)
    if asset.behavior is not None:
        _set_text(root, "behavior", asset.behavior.to_json())
    for joint in asset.joints:
        prim = stage.GetPrimAtPath(root.GetPath().AppendChild(SCOPE).AppendChild(joint.name))
        for name, value in (("grip", joint.grip), ("behind", joint.behind)):
            if value is not None:
                _set_text(prim, name, value)


def _set_text(prim: Usd.Prim, name: str, value: str) -> None:
    prim.CreateAttribute(f"casa:{name}", Sdf.ValueTypeNames.String, True, Sdf.VariabilityUniform).Set(value)
