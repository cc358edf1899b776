"""Split a mesh into connected parts, and measure how much of its hull each fills."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.mesh.measure import face_normals, signed_volume
from casa_assets.geometry.mesh.topology import face_components
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.geometry.solid.manifold import closed_solid

# Thickness that a flat part is given, metres: about the thinnest that contacts hold.
SHEET_M = 0.001


@dataclass(frozen=True)
class ConnectedPart:
    """A connected part: its points and faces, the volume of its hull, how much of that it fills (0..1)."""

    points: Floats
    faces: Ints
    hull_volume: float
    hull_fill: float


def connected_parts(points: Floats, ids: Ints, max_parts: int) -> list[ConnectedPart]:
    """Connected parts that have a volume, largest first, without specks; none if more than `max_parts` are left."""
    label = face_components(ids, len(points))
    count = int(label.max()) + 1
    if count > 40 * max_parts:
        return []
    order = np.argsort(label, kind="stable")
    face_groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    extent = float(np.ptp(points, axis=0).max())
    large = [
        face_rows
        for face_rows in face_groups
        if np.ptp(points[ids[face_rows]].reshape(-1, 3), axis=0).max() > 0.02 * extent
    ]
    if len(large) > max_parts:
        return []
    parts = []
    for face_rows in large:
        used, local = np.unique(ids[face_rows], return_inverse=True)
        part = measure_part(points[used], local.reshape(-1, 3), close_gaps=False)
        if part is not None:
            parts.append(part)
    return sorted(parts, key=lambda p: -p.hull_volume)


def measure_part(points: Floats, faces: Ints, close_gaps: bool) -> ConnectedPart | None:
    """Measure a part; a flat one is given a thickness. Return None if it has no extent."""
    if thickness(points) < SHEET_M / 4:
        normals, areas = face_normals(points, faces)
        normal = (
            np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1] if len(points) > 2 else normals[0]
        )
        if areas.sum() <= 0:
            return None
        points = np.concatenate([points + normal * SHEET_M / 2, points - normal * SHEET_M / 2])
        return _convex_piece(points)
    try:
        hull = convex_hull(points)
    except DegenerateShape:
        return None
    hull_volume = signed_volume(*hull)
    solid = closed_solid(points, faces)
    if solid is not None and not (close_gaps and len(np.unique(face_components(faces, len(points)))) > 1):
        volume = signed_volume(*solid)
    else:
        volume = voxelise(points, faces, bridge=close_gaps).volume
    return ConnectedPart(points, faces, hull_volume, min(1.0, volume / hull_volume))


def _convex_piece(points: Floats) -> ConnectedPart | None:
    try:
        hull, triangles = convex_hull(points)
    except DegenerateShape:
        return None
    return ConnectedPart(hull, triangles, signed_volume(hull, triangles), 1.0)


def thickness(points: Floats) -> float:
    """Extent along the direction of least spread, metres."""
    if len(points) < 4:
        return 0.0
    _, vectors = np.linalg.eigh(np.cov(points.T))
    return float(np.ptp(points @ vectors[:, 0]))


def any_nested(pieces: list[ConnectedPart]) -> bool:
    """A piece lies within the box of a hollow one: the two walls of a double shell, say, which belong together."""
    boxes = [(p.points.min(axis=0), p.points.max(axis=0), p.hull_fill) for p in pieces]
    return any(
        fill < 0.5 and i != j and bool((low <= inner[0]).all() and (inner[1] <= high).all())
        for i, (low, high, fill) in enumerate(boxes)
        for j, inner in enumerate(boxes)
    )
