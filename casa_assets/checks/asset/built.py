"""Which assets the stricter rows are for."""

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
    """Whether a family built it: it knows its own shape to the millimetre, and its seams are its own."""
    return asset.provenance.source == "family"


def is_fixture_like(asset: Asset) -> bool:
    """Whether it was built from numbers, or stands for a fixture that a runtime operates.

    What came as a mesh has the joints, seams and faces that it came with; the rows for those have wider limits.
    """
    return asset.contract is not None or is_from_family(asset)


def is_loose_mesh(asset: Asset) -> bool:
    """Whether it came as one rigid mesh from somebody else: what may be wrong with those is filtered out."""
    return asset.provenance.source in _MESHES and len(asset.links) == 1
