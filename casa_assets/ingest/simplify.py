"""Simplify meshes that have too many faces; texture seams and outlines stay."""

from __future__ import annotations

import ctypes

import meshoptimizer
import numpy as np
import numpy.typing as npt

from casa_assets.geometry.mesh.topology import merge_rows
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.submesh import submesh
from casa_assets.model.asset.mesh import Mesh

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
        count = _with_uv(out, index, points, np.ascontiguousarray(mesh.uv[first], dtype=np.float32), target)
    # A part of a few tiny components can collapse entirely; it stays as it is.
    return submesh(mesh, first[out[:count]].reshape(-1, 3)) if count else mesh


def _with_uv(
    out: npt.NDArray[np.uint32],
    index: npt.NDArray[np.uint32],
    points: npt.NDArray[np.float32],
    uv: npt.NDArray[np.float32],
    target: int,
) -> int:
    """Number of indices written to `out`; stretching the texture counts as an error too."""
    # The binding declares no argument types for this function, so numbers have to be of their C types already.
    return int(
        meshoptimizer.simplify_with_attributes(
            out,
            index,
            points,
            uv,
            np.array([0.5, 0.5], dtype=np.float32),
            index_count=ctypes.c_size_t(len(index)),
            vertex_count=ctypes.c_size_t(len(points)),
            vertex_positions_stride=ctypes.c_size_t(points.strides[0]),
            vertex_attributes_stride=ctypes.c_size_t(uv.strides[0]),
            attribute_count=ctypes.c_size_t(2),
            target_index_count=ctypes.c_size_t(target * 3),
            target_error=ctypes.c_float(TARGET_ERROR),
            options=ctypes.c_uint(0),
        )
    )
