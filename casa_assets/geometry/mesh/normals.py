"""Shading normals: smooth over gentle bends, sharp over creases."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import merge_rows, weld
from casa_assets.model.asset.mesh import Mesh

# Ref: Blender's default auto-smooth angle.
CREASE_DEG = 30.0


def with_normals(mesh: Mesh, crease_deg: float = CREASE_DEG) -> Mesh:
    """The mesh with unit vertex normals; vertices are split where faces meet at more than `crease_deg`.

    Uv seams stay, but do not break the shading: faces are neighbours where their positions meet.
    """
    faces = mesh.faces.astype(np.int64)
    _, place = weld(mesh.vertices)
    normals, areas = face_normals(mesh.vertices, faces)
    corner_point = place[faces].ravel()
    corner_face = np.repeat(np.arange(len(faces)), 3)
    smooth = _corner_normals(corner_point, corner_face, normals, areas, np.cos(np.radians(crease_deg)))
    index = faces.ravel()
    first, vertex = merge_rows(np.column_stack([index, np.round(smooth, 4)]))
    unit = smooth[first]
    return Mesh(
        vertices=mesh.vertices[index[first]],
        faces=vertex.reshape(-1, 3),
        uv=None if mesh.uv is None else mesh.uv[index[first]],
        normals=unit,
        colors=None if mesh.colors is None else mesh.colors[index[first]],
    )


def _corner_normals(
    point: npt.NDArray[np.int64],
    face: npt.NDArray[np.int64],
    normals: Floats,
    areas: Floats,
    least_cosine: float,
) -> Floats:
    """(3F, 3) unit normal of each corner: area-weighted mean over the faces at its point that bend gently."""
    order = np.argsort(point, kind="stable")
    count = np.bincount(point)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    summed = np.zeros((len(point), 3))
    here_face = face[order]
    here_start, here_count = start[point[order]], count[point[order]]
    for k in range(int(count.max()) if len(count) else 0):
        live = np.flatnonzero(here_count > k)
        other = here_face[here_start[live] + k]
        own = normals[here_face[live]]
        gentle = np.einsum("ij,ij->i", own, normals[other]) >= least_cosine
        summed[live[gentle]] += normals[other[gentle]] * areas[other[gentle], None]
    length = np.linalg.norm(summed, axis=1)
    flat = length <= 1e-300
    summed[flat] = normals[here_face[flat]]
    length = np.maximum(np.linalg.norm(summed, axis=1), 1e-300)
    out = np.empty_like(summed)
    out[order] = summed / length[:, None]
    out[np.linalg.norm(out, axis=1) < 0.5] = (0.0, 0.0, 1.0)
    return out
