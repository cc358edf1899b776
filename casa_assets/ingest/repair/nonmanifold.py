"""Remove faces at edges where more than two meet: fins that stick out of a closed surface, and tangles."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Ints, Mask
from casa_assets.geometry.mesh.topology import edge_counts, manifold_patches
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.repair.holes import close_holes
from casa_assets.ingest.submesh import submesh
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.issue import Issue

# Meshes with a larger share, or number, of nonmanifold edges are built that way and are left as they are; choices.
MAX_NONMANIFOLD_SHARE = 0.005
MAX_NONMANIFOLD_EDGES = 400
# Cutting out faces may expose further nonmanifold edges, which are cut out in turn.
MAX_ROUNDS = 3
# A patch of more faces than these is meant: a leaf, a strap, a label that stands off.
MAX_FIN_FACES = 2


def cut_nonmanifold_faces(draft: Draft) -> Draft:
    """Cut out nonmanifold faces and close the holes; only holes are closed where that would not halve unsound edges."""
    closed = close_holes(draft)
    ids = closed.surface.welded_faces
    if not _is_rare(ids):
        return closed
    before = _unsound(ids)
    remaining, cut_corners = draft, []
    for _ in range(MAX_ROUNDS):
        bad = _touching(remaining.surface.welded_faces)
        if not bad.any():
            break
        if bad.all():
            return closed
        cut_corners.append(remaining.surface.vertices[remaining.surface.faces[bad]].reshape(-1, 3))
        remaining = remaining.replace(parts=_without(remaining.parts, bad))
    closed = close_holes(remaining, np.concatenate(cut_corners))
    after = _unsound(closed.surface.welded_faces)
    if after * 2 > before:
        return closed
    message = f"{before} unsound edges became {after}: the faces around tangled ones were cut out and closed anew"
    return closed.replace(notes=draft.noted(warning("MSH045", "edges", message)))


def _unsound(ids: Ints) -> int:
    return int((edge_counts(ids)[1] != 2).sum())


def _is_rare(ids: Ints) -> bool:
    _, uses, _ = edge_counts(ids)
    tangled = int((uses > 2).sum())
    return 0 < tangled <= min(MAX_NONMANIFOLD_EDGES, MAX_NONMANIFOLD_SHARE * len(uses))


def _touching(ids: Ints) -> Mask:
    """(F,) faces at the ends of nonmanifold edges, and where boundary loops touch, so that simple holes are left."""
    edges, uses, _ = edge_counts(ids)
    count = int(ids.max()) + 1
    ends: Mask = np.bincount(edges[uses == 1].ravel(), minlength=count) > 2
    ends[edges[uses > 2].ravel()] = True
    found: Mask = np.any(ends[ids], axis=1)
    return found


def _without(parts: tuple[RawPart, ...], bad: Mask) -> tuple[RawPart, ...]:
    out, start = [], 0
    for part in parts:
        rows = bad[start : start + len(part.mesh.faces)]
        start += len(part.mesh.faces)
        if not rows.all():
            out.append(
                part.replace(mesh=submesh(part.mesh, part.mesh.faces[~rows].astype(np.int64))) if rows.any() else part
            )
    return tuple(out)


def sheet_fins(ids: Ints) -> tuple[Mask, list[Issue]]:
    """(F,) True for fins, a few faces that hang by an edge on a closed surface, and a note if any were found.

    No face counts as a fin if the rest would stay open: then a single face may be all that is left of a wall.

    Args:
        ids: (F, 3) indices of welded points.
    """
    none = np.zeros(len(ids), dtype=bool)
    edges, uses, _ = edge_counts(ids)
    if not len(ids) or not (uses > 2).any() or not (uses == 1).any():
        return none, []
    patch = manifold_patches(ids)
    small = np.bincount(patch)[patch] <= MAX_FIN_FACES
    stands, hangs = (np.isin(patch, patch[_has(ids, edges[mask])]) for mask in (uses == 1, uses > 2))
    is_fin = small & stands & hangs
    if not is_fin.any() or is_fin.all() or (edge_counts(ids[~is_fin])[1] != 2).any():
        return none, []
    count = int(is_fin.sum())
    subject = "1 face that stood off a closed surface like a fin was"
    if count != 1:
        subject = f"{count} faces that stood off a closed surface like fins were"
    message = f"{subject} taken away"
    return is_fin, [warning("MSH046", "faces", message)]


def _has(ids: Ints, edges: Ints) -> Mask:
    """(F,) faces that have one of the edges. edges: (E, 2) with ascending ends."""
    base = int(ids.max()) + 1
    sides = np.sort(np.stack([ids[:, [0, 1]], ids[:, [1, 2]], ids[:, [2, 0]]]), axis=2)
    found: Mask = np.any(np.isin(sides[:, :, 0] * base + sides[:, :, 1], edges[:, 0] * base + edges[:, 1]), axis=0)
    return found
