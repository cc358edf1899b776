"""Exact solids by manifold3d: unions, hulls of few vertices, cuts by planes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import manifold3d
import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.surface import signed_volume

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

Surface = tuple[Floats, Ints]
Solid: TypeAlias = manifold3d.Manifold

# With more pieces than these it is no longer worth the time to unite them.
MOST_PIECES = 1000
# What is so much above the lowest point, as a share of the longest side, is as low.
LEVEL_SHARE = 1e-6
# Where a solid has too many faces still, or a hull too many vertices, coarser tolerances are tried, each this many
# times the one before; for a hull this many of them.
TOLERANCE_GROWTH, TOLERANCE_STEPS = 1.5, 4
# Largest factor by which a hull grows to make up for the vertices that it lacks.
MAX_GROWTH = 1.05


def solid_of(points: Floats, faces: Ints) -> Solid | None:
    """Return welded (P, 3) points and outward (F, 3) faces as a solid, or None: no manifold, or without volume."""
    if len(faces) < 4:
        return None
    # Copies: the binding takes no arrays that may only be read.
    solid = Solid(
        manifold3d.Mesh64(
            vert_properties=np.array(points, dtype=np.float64, order="C"),
            tri_verts=np.array(faces, dtype=np.uint64, order="C"),
        )
    )
    is_sound = solid.status() == manifold3d.Error.NoError and not solid.is_empty() and solid.volume() > 0
    return solid if is_sound else None


def surface_of(solid: Solid) -> Surface:
    """(P, 3) points and (F, 3) outward faces."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3], dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)


def _turned(solid: Solid) -> Solid:
    points, faces = surface_of(solid)
    return Solid(manifold3d.Mesh64(vert_properties=points, tri_verts=np.ascontiguousarray(faces[:, ::-1], np.uint64)))


def closed_solid(points: Floats, faces: Ints) -> Surface | None:
    """Return the surface, (P, 3) welded points and (F, 3) faces, as an outward manifold with volume, or None.

    Overlapping pieces are united, and inner walls cut out: no volume counts twice.
    """
    solid = solid_of(points, faces)
    if solid is None:
        return None
    pieces = solid.decompose()
    if 1 < len(pieces) <= MOST_PIECES:
        walls = [_turned(p) for p in pieces if p.volume() < 0]
        solid = manifold3d.Manifold.batch_boolean([p for p in pieces if p.volume() > 0], manifold3d.OpType.Add)
        if walls:
            solid -= manifold3d.Manifold.batch_boolean(walls, manifold3d.OpType.Add)
    return surface_of(solid) if solid.volume() > 0 else None


def simplified_solid(points: Floats, faces: Ints, target: int) -> Surface | None:
    """Return a manifold of at most about `target` faces, or None if the surface is not a manifold."""
    solid = solid_of(points, faces)
    if solid is None:
        return None
    extent = float(np.ptp(points, axis=0).max())
    tolerance = 2e-4
    while solid.num_tri() > target and tolerance < 0.02:
        solid = solid.simplify(tolerance * extent)
        tolerance *= 1.6
    return surface_of(solid) if solid.volume() > 0 else None


def union(surfaces: Sequence[Surface]) -> Surface | None:
    """Return the union of closed surfaces, or None if none of them is a solid."""
    solids = [s for s in (solid_of(p, f) for p, f in surfaces) if s is not None]
    return surface_of(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)) if solids else None


def intersection_volume(one: Surface, other: Surface) -> float:
    """Volume that two closed surfaces share, 0 where one of them is no solid."""
    a, b = solid_of(*one), solid_of(*other)
    return 0.0 if a is None or b is None else float((a ^ b).volume())


def convex_hull(points: Floats) -> tuple[Floats, Ints]:
    """Hull of (N, 3) points: (M, 3) vertices in order of input and (F, 3) outward triangles.

    Raises DegenerateShape: the points span no volume.
    """
    hull, _, _ = _qhull(points)
    index = np.sort(hull.vertices)
    place = np.full(len(points), -1, dtype=np.int64)
    place[index] = np.arange(len(index))
    faces = place[hull.simplices]
    corners = points[index][faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    # Each triangle starts at its lowest index, and they are sorted: Qhull's own order is not part of its promise.
    start = np.argmin(faces, axis=1)
    faces = np.stack([faces[np.arange(len(faces)), (start + k) % 3] for k in range(3)], axis=1)
    return points[index], faces[np.lexsort(faces.T[::-1])]


def hull_planes(points: Floats) -> Floats:
    """(F, 4) outward unit normals and offsets; normal . x + offset is negative within the hull.

    Raises DegenerateShape: the points span no volume.
    """
    hull, center, scale = _qhull(points)
    planes: Floats = hull.equations.copy()
    planes[:, 3] = planes[:, 3] * scale - planes[:, :3] @ center
    return planes


def _qhull(points: Floats) -> tuple[ConvexHull, Floats, float]:
    """Qhull's hull of the points brought to unit size, and the corner and size that they were brought from."""
    from scipy.spatial import ConvexHull, QhullError

    extent = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    if len(points) < 4 or extent.max() <= 0:
        raise DegenerateShape("fewer than four distinct points span no volume")
    scale, center = float(extent.max()), points.min(axis=0)
    try:
        return ConvexHull((points - center) / scale), center, scale
    except QhullError as error:
        raise DegenerateShape("the points lie in a plane or on a line") from error


def hull_volume(points: Floats) -> float:
    """Volume of the hull of (N, 3) points; zero where they span none."""
    try:
        return signed_volume(*convex_hull(points))
    except DegenerateShape:
        return 0.0


def small_hull(points: Floats, limit: int = 64) -> tuple[Floats, Ints]:
    """Hull of at most `limit` vertices: grown from the outermost points, always by the point that sticks out most.

    If the full hull has a flat bottom to rest level on, so has this one. It lies inside the full hull and touches it in
    every vertex. Returns and raises as `convex_hull`.
    """
    from scipy.spatial import ConvexHull, QhullError

    cloud, faces = convex_hull(points)
    if len(cloud) <= limit:
        return cloud, faces
    # Distances are taken in a frame in which the cloud is as wide in every direction: however thin it is, it spans a
    # volume there. What is equally far but for the last bits, as in every round shape, has to be so on every machine.
    # The symmetric root is used because it does not depend on the choice of axes where these are ambiguous.
    spread, axes = np.linalg.eigh(np.cov(cloud.T))
    stretch: Floats = (axes / np.sqrt(np.maximum(spread, 1e-12 * float(spread[-1])))) @ axes.T
    even = ((cloud - cloud.mean(axis=0)) @ stretch).round(9)
    reach = float(np.ptp(cloud, axis=0).max())
    chosen = list(dict.fromkeys([*_outermost(cloud), *_standing(cloud, reach)]))[:limit]
    while len(chosen) < limit:
        try:
            planes = ConvexHull(even[chosen]).equations
        except QhullError:  # what is outermost in a thin cloud may lie in one plane
            chosen = sorted({*chosen, *_outermost(even)})[:limit]
            planes = ConvexHull(even[chosen]).equations
        true = np.linalg.norm(planes[:, :3] @ stretch, axis=1)
        outside = (((even @ planes[:, :3].T + planes[:, 3]) / true).max(axis=1) / reach).round(9)
        farthest = int(np.argmax(outside))
        if outside[farthest] <= 1e-6:
            break
        chosen.append(farthest)
    return convex_hull(cloud[sorted(chosen)])


def _outermost(cloud: Floats) -> list[int]:
    """Indices of the extreme points in 26 directions, those of a cube's faces, edges and corners; ascending."""
    half = np.array(list(np.ndindex(3, 3, 3))[14:], dtype=np.float64) - 1
    return sorted({int(i) for d in half for s in [(cloud @ d).round(9)] for i in (s.argmax(), s.argmin())})


def _standing(cloud: Floats, reach: float) -> list[int]:
    """Indices of the corners of what is lowest, by the eight directions of a compass; ascending."""
    lowest = np.flatnonzero(cloud[:, 2] <= cloud[:, 2].min() + LEVEL_SHARE * reach)
    compass = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)], dtype=np.float64)
    return sorted({int(lowest[(cloud[lowest, :2] @ d).round(9).argmax()]) for d in compass})


def without_voids(solid: Solid) -> Solid:
    """Fill the sealed voids of a solid: no contact ever gets there."""
    pieces = [p for p in solid.decompose() if p.volume() != 0]
    outer = [p if p.volume() > 0 else _turned(p) for p in pieces]  # one that is inside out may lie beside the others
    return outer[0] if len(outer) == 1 else manifold3d.Manifold.batch_boolean(outer, manifold3d.OpType.Add)


def simplify_solid(solid: Solid, tolerance: float, faces: int = 0, most: float = 0.0) -> Solid:
    """Simplify a solid; its surface moves by no more than about a tolerance, metres.

    With more than `faces` faces the tolerance grows step by step, as long as it is no more than `most`.
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

    Raises DegenerateShape: the cloud spans no volume.
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
    """(N, 3) vertices of a hull of few vertices, grown about its middle to a volume, but not out of a (2, 3) box, m.

    A hull with few vertices lies inside the shape that it approximates, and a round one loses up to a tenth of its
    volume. Growing it puts its sides as far outside as they were inside, but no object on a floor sinks into it.
    """
    whole = manifold3d.Manifold.hull_points(np.ascontiguousarray(cloud, dtype=np.float64))
    volume = float(whole.volume())
    if not 0 < volume < volume_m3:
        return cloud
    middle = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
    growth = min((volume_m3 / volume) ** (1 / 3), MAX_GROWTH)
    return np.asarray(np.clip(middle + growth * (cloud - middle), *box))
