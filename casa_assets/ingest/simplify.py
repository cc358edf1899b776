"""Fewer faces where there are too many to load and render quickly; uv seams and outlines stay."""

from __future__ import annotations

import meshoptimizer
import numpy as np
import numpy.typing as npt

from casa_assets.geometry.topology import merge_rows
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.mesh import Mesh

Ints = npt.NDArray[np.int64]

# Largest error of the simplified surface, as a part of the mesh's extent.
TARGET_ERROR = 0.01


def simplify(draft: Draft, limit: int) -> Draft:
    """Bring the number of faces down to about `limit`, each part by its share.

    Works on the parts' own vertices, so uv coordinates stay exact.
    """
    before = sum(len(p.mesh.faces) for p in draft.parts)
    if before <= limit:
        return draft
    parts = tuple(
        p.replace(mesh=simplified(p.mesh, max(12, int(len(p.mesh.faces) * limit / before)))) for p in draft.parts
    )
    after = sum(len(p.mesh.faces) for p in parts)
    note = warning("MSH015", "faces", f"simplified from {before} to {after} faces")
    return draft.replace(parts=parts, notes=draft.noted(note))


def simplified(mesh: Mesh, target: int) -> Mesh:
    """The mesh with about `target` faces (more where seams or the error bound forbid it)."""
    columns = [np.round(mesh.vertices / max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-30), 7)]
    columns += [np.round(a, 6) for a in (mesh.uv, mesh.normals) if a is not None]
    columns += [mesh.colors.astype(np.float64)] if mesh.colors is not None else []
    first, place = merge_rows(np.column_stack(columns))
    index = place[mesh.faces.astype(np.int64)].ravel().astype(np.uint32)
    points = np.ascontiguousarray(mesh.vertices[first], dtype=np.float32)
    out = np.zeros(len(index), dtype=np.uint32)
    if mesh.uv is None:
        count = meshoptimizer.simplify(out, index, points, target_index_count=target * 3, target_error=TARGET_ERROR)
    else:
        uv = np.ascontiguousarray(mesh.uv[first], dtype=np.float32)
        count = meshoptimizer.simplify_with_attributes(
            out,
            index,
            points,
            uv,
            np.array([0.5, 0.5], dtype=np.float32),
            target_index_count=target * 3,
            target_error=TARGET_ERROR,
        )
    return _picked(mesh, first, out[:count].astype(np.int64))


def _picked(mesh: Mesh, first: Ints, index: Ints) -> Mesh:
    used, faces = np.unique(index, return_inverse=True)
    rows = first[used]
    return Mesh(
        vertices=mesh.vertices[rows],
        faces=faces.reshape(-1, 3),
        uv=None if mesh.uv is None else mesh.uv[rows],
        normals=None if mesh.normals is None else mesh.normals[rows],
        colors=None if mesh.colors is None else mesh.colors[rows],
    )
