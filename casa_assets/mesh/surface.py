"""Measure surfaces (volume, area, centre, inertia), and compute shading normals."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.topology import merge_rows, weld
from casa_assets.model.asset.parts import Mesh


def face_normals(points: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """(F, 3) unit normals (zero where the face has no area) and (F,) areas in units squared."""
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-300)[:, None], length / 2


def signed_volume(points: Floats, faces: Ints) -> float:
    """Volume that the surface bounds, positive where it winds outwards; meaningless where it is open."""
    corners = points[faces] - points.mean(axis=0)
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def winding_number(points: Floats, faces: Ints, spot: Floats) -> float:
    """Winding number of a closed surface about a (3,) point: 1 within an outward one, -1 within an inward one, else 0.

    Ref: solid angles of the triangles, Van Oosterom and Strackee 1983.
    """
    a, b, c = np.swapaxes(points[faces] - spot, 0, 1)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(above, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2 * np.pi))


def solid_moments(points: Floats, faces: Ints) -> tuple[float, Floats, Floats]:
    """Volume, centre and inertia of the solid inside a closed surface, at density 1.

    `points`: (P, 3) metres. `faces`: (F, 3), closed and outward. Returns volume m^3; (3,) centre, metres; (3, 3)
    inertia about the centre, m^5. Ref: sums over tetrahedra to a common apex, Tonon 2004 in covariance form.
    """
    apex = points.mean(axis=0)
    corners = points[faces] - apex
    det = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = float(det.sum() / 6)
    total = corners.sum(axis=1)
    center = (det[:, None] * total).sum(axis=0) / 24 / volume if volume else np.zeros(3)
    second = np.einsum("n,nki,nkj->ij", det, corners, corners) + np.einsum("n,ni,nj->ij", det, total, total)
    covariance = second / 120 - volume * np.outer(center, center)
    inertia = np.trace(covariance) * np.eye(3) - covariance
    return volume, center + apex, inertia


def backward_share(
    vertices: Floats, faces: npt.NDArray[np.integer[Any]], normals: Floats, least_cosine: float = 0.0
) -> float:
    """Share of the area whose normals, one per vertex, have less than the least cosine with the front of the face."""
    fronts, areas = face_normals(vertices, faces.astype(np.int64))
    behind = np.einsum("fkj,fj->fk", normals[faces], fronts) < least_cosine
    return float((behind.mean(axis=1) * areas).sum() / max(float(areas.sum()), 1e-300))


def shell_moments(points: Floats, faces: Ints) -> tuple[float, Floats, Floats]:
    """Area, centre and inertia of a thin surface, at area density 1: m^2, (3,) m, (3, 3) m^4."""
    corners = points[faces]
    _, area = face_normals(points, faces)
    whole = float(area.sum())
    mid = corners.mean(axis=1)
    center = (area[:, None] * mid).sum(axis=0) / whole
    local = corners - center
    total = local.sum(axis=1)
    second = np.einsum("n,nki,nkj->ij", area, local, local) + np.einsum("n,ni,nj->ij", area, total, total)
    covariance = second / 12
    return whole, center, np.trace(covariance) * np.eye(3) - covariance


def shifted_inertia(inertia: Floats, mass: float, offset: Floats) -> Floats:
    """(3, 3) inertia about a point at `offset` from the centre of mass (parallel axes), kg*m^2."""
    return inertia + mass * (float(offset @ offset) * np.eye(3) - np.outer(offset, offset))


# Normals --------------------------------------------------------------------------------------------------------------

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
    point: npt.NDArray[np.int64], face: npt.NDArray[np.int64], normals: Floats, areas: Floats, least_cosine: float
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
