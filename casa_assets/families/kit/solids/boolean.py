"""Boolean operations on solids: union, difference, intersection (manifold3d)."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from casa_assets.families.kit.solids.solid import Placed, Solid


def union(*solids: Solid) -> Solid:
    """Union of solids; it keeps the colliders of all."""
    body = manifold3d.Manifold.batch_boolean([_manifold(s) for s in solids], manifold3d.OpType.Add)
    return _solid(body, tuple(p for s in solids for p in s.shapes), solids[0].crease_deg)


def subtract(solid: Solid, *tools: Solid, shapes: Sequence[Placed] = ()) -> Solid:
    """Subtract the tools from a solid.

    Args:
        solid, tools: closed surfaces.
        shapes: colliders of the result; none means that the caller adds them elsewhere or wants the hull.
    """
    taken = manifold3d.Manifold.batch_boolean([_manifold(t) for t in tools], manifold3d.OpType.Add)
    return _solid(_manifold(solid) - taken, tuple(shapes), solid.crease_deg)


def intersect(solid: Solid, other: Solid) -> Solid:
    """Intersection of two solids, without collision shapes: unless some are added, its hull is taken."""
    return _solid(_manifold(solid) ^ _manifold(other), (), solid.crease_deg)


def _manifold(solid: Solid) -> manifold3d.Manifold:
    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(solid.points, dtype=np.float64),
        tri_verts=np.ascontiguousarray(solid.faces, dtype=np.uint64),
    )
    mesh.merge()
    body = manifold3d.Manifold(mesh)
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"a solid of {len(solid.faces)} faces is not closed: {body.status()}")
    return body


def _solid(body: manifold3d.Manifold, shapes: tuple[Placed, ...], crease_deg: float) -> Solid:
    if body.is_empty():
        raise ValueError("nothing is left of the solid")
    mesh = body.to_mesh64()
    points = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
    return Solid(points, np.array(mesh.tri_verts, dtype=np.int64), shapes, crease_deg=crease_deg)
