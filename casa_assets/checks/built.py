"""Which assets the stricter rows are for."""

from __future__ import annotations

from casa_assets.model.asset import Asset


def from_numbers(asset: Asset) -> bool:
    """Whether a family built it: it knows its own shape to the millimetre, and its seams are its own."""
    return asset.provenance.source == "family"


def is_built(asset: Asset) -> bool:
    """Whether it was built from numbers, or stands for a fixture that a runtime operates.

    What came as a mesh has the joints, seams and faces that it came with; the rows for those have wider limits.
    """
    return asset.contract is not None or from_numbers(asset)
