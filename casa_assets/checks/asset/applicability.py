"""Which assets a check applies to, the reasons why it does not, and the parts of an asset with their pointers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.asset import Asset, Collider, Link, Visual
from casa_assets.model.asset.provenance import UNFOUND_PARTS
from casa_assets.model.ingest.source import SourceKind

# Reasons as reports give them.
NOT_BUILT = "it came as a mesh, and built things alone are held to this"
NO_JOINTS = "it has no joints"
NO_COLLIDERS = "none of its links has a collision shape"
NO_VISUALS = "nothing of it is seen"
NO_COMPILE = "model.xml does not compile"

_MESHES = frozenset(kind.value for kind in SourceKind)


def is_from_family(asset: Asset) -> bool:
    """True if a family built it, so that its shape is known exactly."""
    return asset.provenance.source == "family"


def is_fixture_like(asset: Asset) -> bool:
    """True if a family built it, or if it represents a fixture that a runtime operates.

    Assets from meshes keep the joints, seams and faces that they came with; the checks for those have wider limits.
    """
    return asset.contract is not None or is_from_family(asset)


def is_loose_mesh(asset: Asset) -> bool:
    """True if it was ingested as one rigid mesh; the filters (FLT) apply to those.

    False for an asset that has one link only because its moving parts are still to be found.
    """
    is_one_link = asset.provenance.source in _MESHES and len(asset.links) == 1
    return is_one_link and all(g.subject != UNFOUND_PARTS for g in asset.provenance.guesses)


def visuals_of(asset: Asset) -> Iterator[tuple[str, Link, Visual]]:
    """(pointer, link, visual) of all that is seen."""
    for link in asset.links:
        for visual in link.visuals:
            yield f"links/{link.name}/visuals/{visual.name}", link, visual


def colliders_of(asset: Asset) -> Iterator[tuple[str, Link, Collider]]:
    """(pointer, link, collider) of all collision shapes."""
    for link in asset.links:
        for collider in link.colliders:
            yield f"links/{link.name}/colliders/{collider.name}", link, collider


def merged_mesh(visuals: Sequence[Visual]) -> tuple[Floats, Ints]:
    """(P, 3) vertices and (F, 3) faces of several visuals of one link, in their order; metres, link frame."""
    starts = np.cumsum([0, *(len(v.mesh.vertices) for v in visuals)])
    faces = np.concatenate([v.mesh.faces + s for v, s in zip(visuals, starts, strict=False)]).astype(np.int64)
    return np.concatenate([v.mesh.vertices for v in visuals]), faces
