"""Volume, area, centre and inertia of triangle surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints


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

    Args:
        points: (P, 3) metres. faces: (F, 3), closed and outward.
    Returns:
        volume m^3; (3,) centre, metres; (3, 3) inertia about the centre, m^5.
    Ref: sums over tetrahedra to a common apex, Tonon 2004 in covariance form.
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
    """Share of the area whose normals, one per vertex, look against the fronts of its faces.

    Args:
        vertices: (V, 3). faces: (F, 3). normals: (V, 3).
        least_cosine: a normal whose cosine with the front of its face is smaller looks against it.
    """
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
