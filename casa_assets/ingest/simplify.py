"""Simplify meshes that have too many faces; texture seams and outlines stay."""

from __future__ import annotations

import numpy as np
from opengl_decimate import CollapseSequence, SimplifyOptions, collapse_sequence

from casa_assets.core.typing import Ints
from casa_assets.geometry.mesh.topology import merge_rows
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.submesh import submesh
from casa_assets.model.asset.mesh import Mesh

# Largest error of the simplified surface, as a part of the mesh's extent.
TARGET_ERROR = 0.01
# The same while every seam of the texture keeps its line. Where that would cost more, as it does with a texture of many
# small pieces, points may also leave a seam; each side still keeps its own texture coordinates.
SEAM_ERROR = 0.005


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
    """The mesh with about `target` faces (more where the error bound forbids it), over a part of its own vertices."""
    for lock_seams, bound in ((True, SEAM_ERROR), (False, TARGET_ERROR)):
        corners, sequence = _collapses(mesh, lock_seams)
        steps = sequence.steps_for(target_count=target, target_error=bound)
        if sequence.triangles_after(steps) <= target:
            break
    _, _, _, rows = sequence.state(steps)
    # The vertex whose attributes a corner takes also gives its place, so that both fit each other.
    return submesh(mesh, corners[rows]) if len(rows) else mesh


def _collapses(mesh: Mesh, lock_seams: bool) -> tuple[Ints, CollapseSequence]:
    """Collapses of edges until nothing is left to collapse, and the vertex of the mesh behind each of their vertices.

    Lengths and errors are parts of the mesh's extent.
    """
    extent = max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-30)
    places = np.round((mesh.vertices - mesh.vertices.min(axis=0)) / extent, 7)
    carried = {"TEXCOORD_0": mesh.uv, "NORMAL": mesh.normals, "COLOR_0": mesh.colors}
    values = {name: np.round(array.astype(np.float64), 6) for name, array in carried.items() if array is not None}
    first, place = merge_rows(np.column_stack([places, *values.values()]))
    attributes = {"POSITION": places[first]} | {name: array[first] for name, array in values.items()}
    index = place[mesh.faces.astype(np.int64)].ravel()
    # At the end of an edge: a point in between would have to have texture coordinates made up for it.
    options = SimplifyOptions(target_ratio=1.0, placement="endpoint", lock_seams=lock_seams)
    return first, collapse_sequence(attributes, index, options)
