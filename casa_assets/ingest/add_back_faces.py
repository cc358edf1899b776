"""Add back faces to sheets that are seen from both sides, since simulators draw front faces only."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Ints, Mask
from casa_assets.geometry.mesh.normals import with_normals
from casa_assets.geometry.mesh.topology import edge_counts, face_components
from casa_assets.geometry.mesh.visibility import Visibility, measure_visibility
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.registry.category import Category, MatterFill

# Share of what is seen of a piece that are backs, from which on it is a sheet and not a wall with a gap.
MIN_BACK_SHARE = 0.05


def add_back_faces(draft: Draft, category: Category, missing: float) -> Draft:
    """Add turned copies of the faces of open pieces whose backs are seen; the last stage, as it changes looks alone.

    Args:
        draft: metres, as it rests.
        category: a full thing that lacks a side is left as it is, for nobody looks into an apple.
        missing: share of the outline of a full thing that is hollow from some side, from which on it lacks that side.
    """
    points, ids = draft.surface.points, draft.surface.welded_faces
    seen = measure_visibility(points, ids)
    if category.build in (MatterFill.SOLID, MatterFill.FILLED) and float(seen.behind.max()) > missing:
        return draft
    bare = _sheets(ids, len(points), seen)
    if not bare.any():
        return draft
    parts, start = [], 0
    for part in draft.parts:
        rows = bare[start : start + len(part.mesh.faces)]
        parts.append(part.replace(mesh=_with_backs(part.mesh, rows)) if rows.any() else part)
        start += len(rows)
    message = f"{bare.mean():.0%} of the faces belong to sheets that are seen from both sides; they have two sides now"
    return draft.replace(parts=tuple(parts), notes=draft.noted(warning("MSH060", "faces", message)))


def _sheets(ids: Ints, count: int, seen: Visibility) -> Mask:
    """(F,) faces of open pieces that show their backs."""
    piece = face_components(ids, count)
    ends, uses, _ = edge_counts(ids)
    of_point = np.zeros(count, dtype=np.int64)
    of_point[ids] = piece[:, None]
    is_open = np.zeros(int(piece.max()) + 1, dtype=bool)
    is_open[of_point[ends[uses == 1, 0]]] = True
    own, total = piece[seen.face], len(is_open)
    shown = np.bincount(own[seen.front | seen.back], minlength=total)
    behind = np.bincount(own[seen.back], minlength=total)
    return np.asarray((is_open & (behind > MIN_BACK_SHARE * np.maximum(shown, 1)))[piece])


def _with_backs(mesh: Mesh, rows: Mask) -> Mesh:
    """The mesh and turned copies of some of its faces, with vertices of their own."""
    whole = mesh if mesh.normals is not None else with_normals(mesh)
    assert whole.normals is not None
    used, local = np.unique(whole.faces[rows], return_inverse=True)
    turned = local.reshape(-1, 3)[:, ::-1] + len(whole.vertices)
    return Mesh(
        vertices=np.concatenate([whole.vertices, whole.vertices[used]]),
        faces=np.concatenate([whole.faces, turned]),
        uv=None if whole.uv is None else np.concatenate([whole.uv, whole.uv[used]]),
        normals=np.concatenate([whole.normals, -whole.normals[used]]),
    )
