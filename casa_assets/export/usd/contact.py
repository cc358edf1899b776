"""Exclusions -> filtered pairs."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdPhysics

from casa_assets.model.asset import Asset


def filter_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Each pair once, on its first link."""
    for pair in asset.exclusions:
        api = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(root.AppendChild(pair.first)))
        api.CreateFilteredPairsRel().AddTarget(root.AppendChild(pair.second))
