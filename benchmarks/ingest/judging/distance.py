"""Distances between surfaces: random samples, a KD-tree for what is near, then exact point to triangle distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, cKDTree

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Surface = tuple[Floats, Ints]

# Points that a surface is found again by; of each query the triangles of this many nearest ones are measured exactly.
INDEX_POINTS = 60_000
NEAREST = 24


@dataclass(frozen=True)
class Ruler:
    """A surface that distances are taken to: (F, 3, 3) corners, points on it, and the face that each lies on."""

    corners: Floats
    tree: cKDTree
    face: Ints


def ruler(surface: Surface, seed: int = 0) -> Ruler:
    """Prepare a surface, (P, 3) points and (F, 3) faces, for distances to it."""
    points, faces = surface
    corners = points[faces]
    samples, face = sample(surface, INDEX_POINTS, seed)
    middles = corners.mean(axis=1)  # so that no small face is missed
    return Ruler(corners, cKDTree(np.concatenate([samples, middles])), np.concatenate([face, np.arange(len(faces))]))


def sample(surface: Surface, count: int, seed: int = 0) -> tuple[Floats, Ints]:
    """(count, 3) points spread over the area, and the face of each."""
    points, faces = surface
    corners = points[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(seed)
    face = rng.choice(len(faces), size=count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (corners[face, k] for k in range(3))
    return a + u[:, None] * (b - a) + v[:, None] * (c - a), face.astype(np.int64)


def distances(queries: Floats, to: Ruler) -> Floats:
    """(N,) distance of each query to the surface."""
    _, near = to.tree.query(queries, k=min(NEAREST, to.tree.n))
    faces = to.face[near]
    out = np.full(len(queries), np.inf)
    for k in range(faces.shape[1]):
        out = np.minimum(out, _to_triangle(queries, to.corners[faces[:, k]]))
    return out


def outside(queries: Floats, clouds: list[Floats], to: Ruler) -> Floats:
    """(N,) distance to the union of convex shapes, 0 within it; `to` is the surface of that union."""
    return np.where(inside(queries, clouds), 0.0, distances(queries, to))


def inside(queries: Floats, clouds: list[Floats]) -> npt.NDArray[np.bool_]:
    """(N,) whether each query lies in one of the convex shapes."""
    within = np.zeros(len(queries), dtype=bool)
    for cloud in clouds:
        planes = ConvexHull(cloud).equations
        rest = np.flatnonzero(~within)
        for start in range(0, len(rest), 4096):
            rows = rest[start : start + 4096]
            within[rows] = (queries[rows] @ planes[:, :3].T + planes[:, 3] <= 1e-9).all(axis=1)
    return within


def touchable(surface: Surface, clouds: list[Floats], slit: float, count: int) -> Floats:
    """(N, 3) points of the surface of a union, without the walls of slits between shapes that all but touch.

    Args:
        slit: widest gap that nothing can enter, metres. count: points drawn; N is at most that.
    """
    points, face = sample(surface, count)
    corners = surface[0][surface[1]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    free: Floats = points[~inside(points + slit * normals[face], clouds)]
    return free


def _to_triangle(p: Floats, corners: Floats) -> Floats:
    """(N,) exact distance of each point to its own triangle: to the face where it lies above it, else to an edge."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.einsum("ij,ij->i", normal, normal)
    safe = np.maximum(size, 1e-300)
    v = np.einsum("ij,ij->i", np.cross(p - a, c - a), normal) / safe
    w = np.einsum("ij,ij->i", np.cross(b - a, p - a), normal) / safe
    above = (v >= 0) & (w >= 0) & (v + w <= 1) & (size > 1e-300)
    height = np.abs(np.einsum("ij,ij->i", p - a, normal)) / np.sqrt(safe)
    edge = np.minimum(np.minimum(_to_edge(p, a, b), _to_edge(p, b, c)), _to_edge(p, c, a))
    return np.where(above, height, edge)


def _to_edge(p: Floats, a: Floats, b: Floats) -> Floats:
    along = b - a
    t = np.einsum("ij,ij->i", p - a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    far: Floats = np.linalg.norm(p - a - np.clip(t, 0, 1)[:, None] * along, axis=1)
    return far
