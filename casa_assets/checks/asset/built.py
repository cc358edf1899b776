"""Select the assets that the stricter checks apply to: built by a family, or standing for a fixture."""

from __future__ import annotations

from casa_assets.model.asset.asset import Asset
from casa_assets.model.ingest.source import SourceKind

# Why a check is not asked of an asset, as reports say it.
NOT_BUILT = "it came as a mesh, and built things alone are held to this"
NO_JOINTS = "it has no joints"
NO_COLLIDERS = "none of its links has a collision shape"
UNSEEN = "nothing of it is seen"
NO_COMPILE = "model.xml does not compile"

_MESHES = frozenset(kind.value for kind in SourceKind)


def is_from_family(asset: Asset) -> bool:
    """True if a family built it, so that its shape is known exactly."""
    return asset.provenance.source == "family"


def is_fixture_like(asset: Asset) -> bool:
    """True if a family built it, or if it stands for a fixture that a runtime operates.

    What came as a mesh has the joints, seams and faces that it came with; the rows for those have wider limits.
    """
    return asset.contract is not None or is_from_family(asset)


def is_loose_mesh(asset: Asset) -> bool:
    """True if it was ingested as one rigid mesh; the filters (FLT) apply to those."""
    return asset.provenance.source in _MESHES and len(asset.links) == 1
