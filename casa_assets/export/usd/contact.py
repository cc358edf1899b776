"""Exclusions -> filtered pairs."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdPhysics

from casa_assets.model.asset.asset import Asset


def filter_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Filter each excluded pair, on its first link."""
    for pair in asset.exclusions:
        api = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(root.AppendChild(pair.first)))
        api.CreateFilteredPairsRel().AddTarget(root.AppendChild(pair.second))


def filter_pair(layer: Sdf.Layer, first: Sdf.Path, second: Sdf.Path) -> None:
    """Filter the contacts of two bodies of referenced assets, in addition to the assets' own filters."""
    spec = Sdf.CreatePrimInLayer(layer, first)
    if not spec.HasInfo("apiSchemas"):
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["PhysicsFilteredPairsAPI"]))
    path = first.AppendProperty("physics:filteredPairs")
    pairs = layer.GetRelationshipAtPath(path) or Sdf.RelationshipSpec(spec, "physics:filteredPairs", custom=False)
    pairs.targetPathList.prependedItems = [*pairs.targetPathList.prependedItems, second]
