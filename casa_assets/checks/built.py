"""Which assets the stricter rows are for."""

from __future__ import annotations

from casa_assets.model.asset import Asset
from casa_assets.model.source import SourceKind

_MESHES = frozenset(kind.value for kind in SourceKind)


def from_numbers(asset: Asset) -> bool:
    """Whether a family built it: it knows its own shape to the millimetre, and its seams are its own."""
    return asset.provenance.source == "family"


def is_built(asset: Asset) -> bool:
    """Whether it was built from numbers, or stands for a fixture that a runtime operates.

    What came as a mesh has the joints, seams and faces that it came with; the rows for those have wider limits.
    """
    return asset.contract is not None or from_numbers(asset)


def is_loose_mesh(asset: Asset) -> bool:
    """Whether it came as one rigid mesh from somebody else: what may be wrong with those is filtered out."""
    return asset.provenance.source in _MESHES and len(asset.links) == 1
