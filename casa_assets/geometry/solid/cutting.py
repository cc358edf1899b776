"""Cut and simplify solids: planes, connected parts, contours at a height, hulls of few vertices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import manifold3d
import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.solid.hull import small_hull

Surface = tuple[Floats, Ints]
Solid: TypeAlias = manifold3d.Manifold


# Where a solid has too many faces still, or a hull too many vertices, coarser tolerances are tried, each so many times
# the one before; for a hull so many of them.
TOLERANCE_GROWTH = 1.5
TOLERANCE_STEPS = 4
# Largest factor by which a hull grows to make up for the vertices that it lacks.
MAX_GROWTH = 1.05


def solid_of(points: Floats, faces: Ints) -> Solid | None:
    """Return the surface as a solid, or None if it is not a manifold or has no volume.

    Args:
        points: (P, 3) welded. faces: (F, 3), outward.
    """
    if len(faces) < 4:
        return None
    # Copies: the binding takes no arrays that may only be read.
    solid = Solid(
        manifold3d.Mesh64(
            vert_properties=np.array(points, dtype=np.float64, order="C"),
            tri_verts=np.array(faces, dtype=np.uint64, order="C"),
        )
    )
    ok = solid.status() == manifold3d.Error.NoError and not solid.is_empty() and solid.volume() > 0
    return solid if ok else None


def surface_of(solid: Solid) -> Surface:
    """(P, 3) points and (F, 3) outward faces."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3], dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)


def without_voids(solid: Solid) -> Solid:
    """Fill the sealed voids of a solid: no contact ever gets there."""
    pieces = [p for p in solid.decompose() if p.volume() != 0]
    outer = [p if p.volume() > 0 else _turned(p) for p in pieces]  # one that is inside out may lie beside the others
    return outer[0] if len(outer) == 1 else manifold3d.Manifold.batch_boolean(outer, manifold3d.OpType.Add)


def _turned(solid: Solid) -> Solid:
    points, faces = surface_of(solid)
    return Solid(manifold3d.Mesh64(vert_properties=points, tri_verts=np.ascontiguousarray(faces[:, ::-1], np.uint64)))


def simplify_solid(solid: Solid, tolerance: float, faces: int = 0, most: float = 0.0) -> Solid:
    """Simplify a solid; its surface moves by no more than about a tolerance.

    Args:
        tolerance: metres. faces, most: with more faces than these it grows step by step, as long as it is no more than
            `most`.
    """
    slim = solid.simplify(tolerance)
    while slim.num_tri() > faces and TOLERANCE_GROWTH * tolerance <= most:
        tolerance *= TOLERANCE_GROWTH
        slim = slim.simplify(tolerance)
    return slim if slim.volume() > 0 else solid


def connected_parts(solid: Solid, least: float) -> list[Solid]:
    """Connected parts with more volume than `least`, m^3, the largest first."""
    found = [p for p in solid.decompose() if p.volume() > least]
    return sorted(found, key=lambda p: (-round(p.volume(), 15), p.bounding_box()))


def split_by_plane(solid: Solid, normal: Floats, offset: float) -> tuple[Solid, Solid]:
    """Split a solid by the plane `normal . x = offset`: what lies beyond it, and what lies before it."""
    beyond, before = solid.split_by_plane(tuple(float(v) for v in normal), float(offset))
    return beyond, before


def section_contours(solid: Solid, height: float) -> list[Floats]:
    """(N, 2) closed polygons of the section at a height, outer ones against the clock and holes with it."""
    return [np.asarray(p, dtype=np.float64) for p in solid.slice(float(height)).to_polygons()]


def revolve_profile(profile: Floats, steps: int) -> Solid:
    """Solid of revolution about z of the (N, 2) polygon of radius and height, in `steps` flat sides."""
    return manifold3d.CrossSection([profile]).revolve(steps)


def hull_points(solids: Sequence[Solid]) -> Floats:
    """(N, 3) vertices of the hull around some solids."""
    whole = manifold3d.Manifold.batch_hull(list(solids)) if len(solids) > 1 else solids[0].hull()
    return surface_of(whole)[0]


def volume_of_hull(solids: Sequence[Solid]) -> float:
    """Volume of the hull around some solids, m^3."""
    whole = manifold3d.Manifold.batch_hull(list(solids)) if len(solids) > 1 else solids[0].hull()
    return float(whole.volume())


def hull_within_tolerance(cloud: Floats, limit: int, tolerance: float) -> Floats:
    """(N, 3) vertices, at most `limit`, of a hull that differs from that of the cloud by about `tolerance`, metres.

    Raises:
        DegenerateShape: the cloud spans no volume.
    """
    whole = manifold3d.Manifold.hull_points(np.ascontiguousarray(cloud, dtype=np.float64))
    if whole.is_empty() or whole.volume() <= 0:
        raise DegenerateShape("the points span no volume")
    points = surface_of(whole)[0]
    for step in range(TOLERANCE_STEPS):
        slim = whole.simplify(tolerance * TOLERANCE_GROWTH**step)
        if slim.is_empty() or slim.volume() <= 0:
            break
        points = surface_of(slim.hull())[0]
        if len(points) <= limit:
            break
    return small_hull(points, limit)[0]


def hull_with_volume(cloud: Floats, volume_m3: float, box: Floats) -> Floats:
    """(N, 3) vertices of a hull with few vertices, grown about its middle to a volume, but not beyond a box.

    A hull with few vertices lies inside the shape that it approximates, and a round one loses up to a tenth of its
    volume. Growing it puts its sides as far outside as they were inside.

    Args:
        cloud: vertices. volume_m3: of the approximated shape; a larger hull stays as it is.
        box: (2, 3) lower and upper corner, metres, so that an object on a floor does not sink into it.
    """
    whole = manifold3d.Manifold.hull_points(np.ascontiguousarray(cloud, dtype=np.float64))
    volume = float(whole.volume())
    if not 0 < volume < volume_m3:
        return cloud
    middle = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
    growth = min((volume_m3 / volume) ** (1 / 3), MAX_GROWTH)
    grown: Floats = np.clip(middle + growth * (cloud - middle), *box)
    return grown
