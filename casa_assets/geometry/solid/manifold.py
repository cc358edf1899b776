"""Exact solids: closed surfaces as manifold3d sees them, their unions and simplifications."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats, Ints

Surface = tuple[Floats, Ints]

# With more pieces than these it is no longer worth the time to unite them.
MOST_PIECES = 1000


def closed_solid(points: Floats, faces: Ints) -> Surface | None:
    """Return the surface as a valid outward manifold, or None if it is not one.

    Overlapping pieces are united, and inner walls cut out: no volume counts twice.

    Args:
        points: (P, 3) welded. faces: (F, 3).
    Returns:
        (Q, 3) points and (G, 3) faces of a manifold with positive volume.
    """
    solid = _solid(points, faces)
    if solid is None:
        return None
    pieces = solid.decompose()
    if 1 < len(pieces) <= MOST_PIECES:
        walls = [_reversed(p) for p in pieces if p.volume() < 0]
        solid = manifold3d.Manifold.batch_boolean([p for p in pieces if p.volume() > 0], manifold3d.OpType.Add)
        if walls:
            solid -= manifold3d.Manifold.batch_boolean(walls, manifold3d.OpType.Add)
    return _surface(solid) if solid.volume() > 0 else None


def simplified_solid(points: Floats, faces: Ints, target: int) -> Surface | None:
    """Return a manifold of at most about `target` faces, or None if the surface is not a manifold."""
    solid = _solid(points, faces)
    if solid is None:
        return None
    extent = float(np.ptp(points, axis=0).max())
    tolerance = 2e-4
    while solid.num_tri() > target and tolerance < 0.02:
        solid = solid.simplify(tolerance * extent)
        tolerance *= 1.6
    return _surface(solid) if solid.volume() > 0 else None


def union(surfaces: Sequence[Surface]) -> Surface | None:
    """Return the union of closed surfaces, or None if none of them is a solid."""
    solids = [s for s in (_solid(p, f) for p, f in surfaces) if s is not None]
    return _surface(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)) if solids else None


def intersection_volume(one: Surface, other: Surface) -> float:
    """Volume that two closed surfaces share, 0 where one of them is no solid."""
    a, b = _solid(*one), _solid(*other)
    return 0.0 if a is None or b is None else float((a ^ b).volume())


def _solid(points: Floats, faces: Ints) -> manifold3d.Manifold | None:
    if len(faces) < 4:
        return None
    mesh = manifold3d.Mesh64(
        vert_properties=np.array(points, dtype=np.float64, order="C"),  # a copy: read-only arrays are refused
        tri_verts=np.ascontiguousarray(faces, dtype=np.uint64),
    )
    solid = manifold3d.Manifold(mesh)
    ok = solid.status() == manifold3d.Error.NoError and not solid.is_empty() and solid.volume() > 0
    return solid if ok else None


def _reversed(solid: manifold3d.Manifold) -> manifold3d.Manifold:
    points, faces = _surface(solid)
    mesh = manifold3d.Mesh64(vert_properties=points, tri_verts=np.ascontiguousarray(faces[:, ::-1], dtype=np.uint64))
    return manifold3d.Manifold(mesh)


def _surface(solid: manifold3d.Manifold) -> Surface:
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3], dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)
