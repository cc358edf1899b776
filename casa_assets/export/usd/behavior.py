"""Behaviour, contract and grips -> attributes in a namespace of our own, and custom data."""

from __future__ import annotations

from pxr import Sdf, Usd

from casa_assets.export.usd.joint import SCOPE
from casa_assets.model.asset.asset import Asset


def define_all(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """`casa:behavior` (JSON) and `casa:contract` on the root, `casa:grip` and `casa:behind` on joints."""
    text = Sdf.ValueTypeNames.String
    if asset.contract is not None:
        root.CreateAttribute("casa:contract", text, True, Sdf.VariabilityUniform).Set(asset.contract)
    if asset.behavior is not None:
        root.CreateAttribute("casa:behavior", text, True, Sdf.VariabilityUniform).Set(asset.behavior.to_json())
    for joint in asset.joints:
        prim = stage.GetPrimAtPath(root.GetPath().AppendChild(SCOPE).AppendChild(joint.name))
        for name, value in (("grip", joint.grip), ("behind", joint.behind)):
            if value is not None:
                prim.CreateAttribute(f"casa:{name}", text, True, Sdf.VariabilityUniform).Set(value)
