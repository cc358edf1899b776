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

# Share of the visible samples of a component that show its back, from which on it is a sheet; a choice.
MIN_BACK_SHARE = 0.05


def add_back_faces(draft: Draft, category: Category, missing_share: float) -> Draft:
    """Add reversed copies of the faces of open components whose backs are visible.

    It runs after all stages that measure the surface, since only the looks change.

    Args:
        draft: metres, as it rests.
        category: something solid that lacks a side is left as it is, since nobody looks into an apple.
        missing_share: share of the outline, seen from some side, that shows backs; from it on that side is missing.
    """
    points, ids = draft.surface.points, draft.surface.welded_faces
    visibility = measure_visibility(points, ids)
    if category.build in (MatterFill.SOLID, MatterFill.FILLED) and float(visibility.behind.max()) > missing_share:
        return draft
    needs_backs = _sheets(ids, len(points), visibility)
    if not needs_backs.any():
        return draft
    parts, start = [], 0
    for part in draft.parts:
        rows = needs_backs[start : start + len(part.mesh.faces)]
        parts.append(part.replace(mesh=_with_backs(part.mesh, rows)) if rows.any() else part)
        start += len(rows)
    message = (
        f"{needs_backs.mean():.0%} of the faces belong to sheets that are seen from both sides; they have two sides now"
    )
    return draft.replace(parts=tuple(parts), notes=draft.noted(warning("MSH060", "faces", message)))


def _sheets(ids: Ints, count: int, visibility: Visibility) -> Mask:
    """(F,) faces of open components that show their backs."""
    component = face_components(ids, count)
    ends, uses, _ = edge_counts(ids)
    component_of_point = np.zeros(count, dtype=np.int64)
    component_of_point[ids] = component[:, None]
    is_open = np.zeros(int(component.max()) + 1, dtype=bool)
    is_open[component_of_point[ends[uses == 1, 0]]] = True
    component_of_sample, total = component[visibility.face], len(is_open)
    seen_count = np.bincount(component_of_sample[visibility.front | visibility.back], minlength=total)
    back_count = np.bincount(component_of_sample[visibility.back], minlength=total)
    return np.asarray((is_open & (back_count > MIN_BACK_SHARE * np.maximum(seen_count, 1)))[component])


def _with_backs(mesh: Mesh, rows: Mask) -> Mesh:
    """The mesh with reversed copies of some of its faces added; the copies use separate vertices."""
    complete = mesh if mesh.normals is not None else with_normals(mesh)
    assert complete.normals is not None
    used, local = np.unique(complete.faces[rows], return_inverse=True)
    back_faces = local.reshape(-1, 3)[:, ::-1] + len(complete.vertices)
    return Mesh(
        vertices=np.concatenate([complete.vertices, complete.vertices[used]]),
        faces=np.concatenate([complete.faces, back_faces]),
        uv=None if complete.uv is None else np.concatenate([complete.uv, complete.uv[used]]),
        normals=np.concatenate([complete.normals, -complete.normals[used]]),
    )
