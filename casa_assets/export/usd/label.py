"""Labels -> UsdSemantics."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd, UsdSemantics

from casa_assets.model.asset.asset import Asset

# The taxonomy of what a visual or collider is within its thing: handle, door, shelf.
PART = "part"


def attach(prim: Usd.Prim, taxonomy: str, labels: Sequence[str]) -> None:
    """Labels of one taxonomy on a prim."""
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(list(labels))


def attach_all(root: Usd.Prim, asset: Asset) -> None:
    """Classes from the category upwards, and the Wikidata item."""
    attach(root, "class", asset.labels.classes)
    attach(root, "wikidata_qcode", [asset.labels.qcode.id])
