"""Loft a closed mesh through a sequence of cross-sections."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.families.kit.solids.slab import offset_sides, ring_walls
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.geometry.planar import signed_area
from casa_assets.model.record import Vec2


def loft(rings: Sequence[Floats], crease_deg: float = 40.0) -> Solid:
    """A closed skin over rings of equally many points; the first and last are closed by flat caps.

    Args:
        rings: (N, 3) each, metres, counter-clockwise when looking back along the direction from the first ring to the
            last. The sequence may turn back on itself: up the outside, over the rim and down the inside makes a vessel.
        crease_deg: edges with a larger angle between their faces are shaded as sharp, as in Solid.

    Returns:
        A solid without collision shapes.
    """
    n = len(rings[0])
    faces = [*ring_walls(n, len(rings)), _cap(rings[0])[:, ::-1], _cap(rings[-1]) + (len(rings) - 1) * n]
    return Solid(np.concatenate(list(rings)), np.concatenate(faces).astype(np.int64), crease_deg=crease_deg)


def inset_rings(outline: Floats, steps: Sequence[Vec2]) -> list[Floats]:
    """Copies of an outline, each moved inwards by an inset and raised to a height z.

    Args:
        outline: (N, 2), metres, counter-clockwise.
        steps: (inset, z) of each ring, metres, in order, such as up the outside and down the inside of a basin. A
            negative inset widens the outline.
    """
    loop = np.asarray(outline, dtype=np.float64)
    return [
        np.column_stack([offset_sides(loop, [d] * len(loop)) if d else loop, np.full(len(loop), z)]) for d, z in steps
    ]


def basin(outline: Floats, depth: float, wall: float, fillet: float, lip: float = 0.0) -> Solid:
    """An open basin below z = 0: `outline` is the inside of its mouth.

    Args:
        outline: (N, 2), counter-clockwise, metres. depth: of the inside. wall: thickness.
        fillet: radius between wall and floor. lip: how far a rim of the wall's thickness reaches outwards at the mouth.
    """
    fillet_arc = [(fillet * (1 - np.cos(t)), -depth + fillet * (1 - np.sin(t))) for t in np.linspace(0.0, np.pi / 2, 5)]
    if lip > 0:
        outer = [(-wall, -depth - wall), (-wall, -wall), (-wall - lip, -wall), (-wall - lip, 0.0)]
    else:
        outer = [(-wall, -depth - wall), (-wall, 0.0)]
    inner = [(0.0, 0.0), *[(float(d), float(z)) for d, z in fillet_arc]]
    return loft(inset_rings(outline, [*outer, *inner]), 50.0)


def _cap(ring: Floats) -> Ints:
    """(F, 3) triangles that fill a flat (N, 3) ring; they turn the same way as the ring does."""
    normal = np.cross(np.roll(ring, -1, axis=0) - ring.mean(axis=0), ring - ring.mean(axis=0)).sum(axis=0)
    dropped_axis = int(np.argmax(np.abs(normal)))
    flat = np.delete(ring, dropped_axis, axis=1)
    if signed_area(flat) < 0:
        triangles = np.asarray(manifold3d.triangulate([flat[::-1]]), dtype=np.int64)
        return np.asarray((len(ring) - 1 - triangles)[:, ::-1])
    return np.asarray(manifold3d.triangulate([flat]), dtype=np.int64)
