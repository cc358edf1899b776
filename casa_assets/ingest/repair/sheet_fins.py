"""Find sheet fins: a few faces that hang by an edge on a surface which bounds a volume without them."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Ints, Mask
from casa_assets.geometry.mesh.topology import edge_counts, manifold_patches
from casa_assets.ingest.draft import warning
from casa_assets.model.issue import Issue

# A patch of more faces than these was meant: a leaf, a strap, a label that stands off.
MOST_FACES = 2


def sheet_fins(ids: Ints) -> tuple[Mask, list[Issue]]:
    """(F,) True for faces that are fins, and a note where there are some.

    Nothing is one where the rest would stay open: there a lone face may be all that is left of a wall.

    Args:
        ids: (F, 3) indices of welded points.
    """
    none = np.zeros(len(ids), dtype=bool)
    edges, uses, _ = edge_counts(ids)
    if not len(ids) or not (uses > 2).any() or not (uses == 1).any():
        return none, []
    patch = manifold_patches(ids)
    small = np.bincount(patch)[patch] <= MOST_FACES
    stands, hangs = (np.isin(patch, patch[_has(ids, edges[mask])]) for mask in (uses == 1, uses > 2))
    found = small & stands & hangs
    if not found.any() or found.all() or (edge_counts(ids[~found])[1] != 2).any():
        return none, []
    count = int(found.sum())
    what = "1 face that stood off a closed surface like a fin was"
    if count != 1:
        what = f"{count} faces that stood off a closed surface like fins were"
    message = f"{what} taken away"
    return found, [warning("MSH046", "faces", message)]


def _has(ids: Ints, edges: Ints) -> Mask:
    """(F,) faces with one of some edges. edges: (E, 2) with ascending ends."""
    base = int(ids.max()) + 1
    sides = np.sort(np.stack([ids[:, [0, 1]], ids[:, [1, 2]], ids[:, [2, 0]]]), axis=2)
    found: Mask = np.any(np.isin(sides[:, :, 0] * base + sides[:, :, 1], edges[:, 0] * base + edges[:, 1]), axis=0)
    return found
