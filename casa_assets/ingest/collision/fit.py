"""Measure how well collision shapes fit a mesh, its solid proxy, and the opening of a vessel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from scipy import ndimage

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.fillable_volume import fillable_volume
from casa_assets.geometry.grid.open_room import NO_ROOMS, OpenRooms, closed_shares
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.mesh.measure import signed_volume
from casa_assets.geometry.solid.coverage import distances_outside_hulls, surface_samples
from casa_assets.geometry.solid.cutting import Solid, surface_of
from casa_assets.geometry.solid.deviation import Deviation, ReferenceSurface, deviation, reference_surface
from casa_assets.geometry.solid.hull import convex_hull, hull_planes, hull_volume
from casa_assets.geometry.solid.manifold import intersection_volume, union
from casa_assets.ingest.collision.params import CollideParams
from casa_assets.ingest.collision.plane_splits import ErrorBound

# All numbers below are choices.
# Points sampled on the mesh.
SAMPLES = 4000
# Largest distance of shapes from the surface for 95 % of it (at least P95_M), and for all of it; shares of the longest
# side.
P95_M = 0.002
P95_RATIO = 0.015
WORST_RATIO = 0.05
# Voxels along the longest side of the grid in which the opening of a vessel is found. A smaller share of the hull than
# MIN_OPENING_SHARE is no opening, and at most MAX_OPENING_POINTS voxels of it are tested.
OPENING_CELLS = 64
MIN_OPENING_SHARE = 0.03
MAX_OPENING_POINTS = 4000
# Voxels along the longest side of the grid that tells which parts of the surface can be touched: gaps narrower than a
# voxel count as closed. A voxel is about as wide as P95_RATIO.
REACH_CELLS = 66
# Largest share of an opening that shapes may fill, and of an open room that they may fill or close off. The check of
# the finished asset grants a room more.
MAX_FILLED_SHARE = 0.15
MAX_CLOSED_SHARE = 0.2
# Share of the bounds of the checks on bounding boxes and rooms that is used up at most, since these look at what is
# written.
SOUND_SHARE = 0.9


@dataclass(frozen=True)
class FitReference:
    """Reference that the collision shapes of a mesh are measured against.

    Attributes:
        solid: proxy of the mesh. surface: of that solid. samples: (N, 3) points on the mesh itself, metres.
        box: (2, 3) lower and upper corner of the mesh.
        opening_points: (M, 3) points in the opening of a vessel; empty if it has no opening.
        bound: largest error that shapes may have.
        rooms: open rooms of the mesh. kept_rooms: indices of those that shapes have to leave open.
    """

    solid: Solid
    surface: ReferenceSurface
    samples: Floats
    box: Floats
    opening_points: Floats
    bound: ErrorBound
    rooms: OpenRooms = NO_ROOMS
    kept_rooms: Sequence[int] = ()


@dataclass(frozen=True)
class FitErrors:
    """Errors of collision shapes: deviations, share of the opening left open, and the largest error over its bound.

    Attributes:
        bare_share: share of the mesh that lies farther outside of the shapes than the limit `error_m`, 0..1.
        open_share: share of the opening that is left open; None if the mesh has no opening.
        closed_share: largest share of an open room that is filled or closed off; 0 if the mesh has no open room.
        is_sound: the checks on bounding boxes and on open rooms will accept the shapes.
        normalized_error: largest of all errors, each divided by its bound; 1 or less is good enough.
    """

    deviation: Deviation
    bare_share: float
    open_share: float | None
    closed_share: float
    is_sound: bool
    normalized_error: float


def fit_reference(
    points: Floats,
    faces: Ints,
    solid: Solid,
    is_open: bool,
    rooms: OpenRooms = NO_ROOMS,
    kept_rooms: Sequence[int] = (),
) -> FitReference:
    """Prepare what all candidate shapes of a mesh are measured against.

    Args:
        points: (P, 3) welded, metres, z up. faces: (F, 3). solid: proxy of the mesh.
        is_open: openings of the mesh are meant, and not damage to something solid.
        rooms: open rooms of the mesh. kept_rooms: indices of those that shapes have to leave open.
    """
    surface = _touchable(reference_surface(*surface_of(solid)), points, faces, not is_open)
    bound = ErrorBound(max(P95_M, P95_RATIO * surface.longest), WORST_RATIO * surface.longest)
    opening_points = _opening_points(points, faces) if is_open else np.zeros((0, 3))
    used = points[np.unique(faces)]
    box = np.stack([used.min(axis=0), used.max(axis=0)])
    return FitReference(
        solid, surface, surface_samples(points, faces, SAMPLES), box, opening_points, bound, rooms, kept_rooms
    )


def _touchable(surface: ReferenceSurface, points: Floats, faces: Ints, is_full: bool) -> ReferenceSurface:
    """The surface without probes in slits and sealed cavities, which nothing can touch."""
    grid = voxelise(points, faces, REACH_CELLS, bridge=is_full)
    outside = ndimage.binary_dilation(~grid.solid, np.ones((3, 3, 3), dtype=bool))
    cell = np.clip(np.round((surface.probes - grid.origin) / grid.cell).astype(int), 0, np.array(outside.shape) - 1)
    is_reached = outside[tuple(cell.T)]
    return replace(surface, probes=surface.probes[is_reached]) if is_reached.any() else surface


def _opening_points(points: Floats, faces: Ints) -> Floats:
    """(M, 3) evenly picked points of the volume that would hold water; empty if that volume is small."""
    grid = voxelise(points, faces, OPENING_CELLS)
    is_filled = fillable_volume(grid.solid)
    if float(is_filled.sum()) * grid.cell**3 < MIN_OPENING_SHARE * hull_volume(points):
        return np.zeros((0, 3))
    places: Floats = grid.origin + np.argwhere(is_filled) * grid.cell
    return places[:: max(1, len(places) // MAX_OPENING_POINTS)]


def measure_fit(clouds: Sequence[Floats], reference: FitReference, limits: CollideParams) -> FitErrors:
    """Measure how well convex shapes approximate a mesh.

    Args:
        clouds: vertices of each shape.
    Raises:
        DegenerateShape: a cloud spans no volume, or there are no clouds.
    """
    outside = distances_outside_hulls(reference.samples, clouds).round(6)
    surface_deviation = deviation(clouds, reference.surface, outside)
    open_share = None if not len(reference.opening_points) else 1 - _inside_share(reference.opening_points, clouds)
    ratios = [surface_deviation.added_p95 / reference.bound.p95, surface_deviation.added_worst / reference.bound.worst]
    ratios += [surface_deviation.bare_p95 / reference.bound.p95, surface_deviation.bare_worst / reference.bound.worst]
    ratios += [
        surface_deviation.buried_p95 / reference.bound.p95,
        surface_deviation.buried_worst / reference.bound.worst,
    ]
    all_points = np.concatenate(list(clouds))
    box_share = box_gap(all_points, reference.box) / limits.box_bound(reference.surface.longest)
    closed_share = _closed_share(clouds, reference)
    ratios += [box_share, closed_share / MAX_CLOSED_SHARE]
    if open_share is not None:
        ratios.append((1 - open_share) / MAX_FILLED_SHARE)
    return FitErrors(
        surface_deviation,
        float((outside > limits.error_m).mean()),
        open_share,
        closed_share,
        max(box_share, closed_share / limits.closed_share) <= SOUND_SHARE,
        round(max(ratios), 6),
    )


def box_gap(points: Floats, box: Floats) -> float:
    """Largest distance between a side of the bounding box of (N, 3) points and that of a (2, 3) box, metres."""
    return float(np.abs(np.stack([points.min(axis=0), points.max(axis=0)]) - box).max().round(6))


def _closed_share(clouds: Sequence[Floats], reference: FitReference) -> float:
    """Largest share of a room that is to be kept which shapes fill or close off."""
    if not reference.kept_rooms:
        return 0.0
    hulls = [convex_hull(cloud) for cloud in clouds]
    starts = np.cumsum([0, *(len(points) for points, _ in hulls)])
    faces = np.concatenate([faces + start for (_, faces), start in zip(hulls, starts, strict=False)])
    shares = closed_shares(reference.rooms, np.concatenate([points for points, _ in hulls]), faces)
    return max(shares[k] for k in reference.kept_rooms)


def _inside_share(points: Floats, clouds: Sequence[Floats]) -> float:
    """Share of some points that lie in one of the shapes."""
    is_inside = np.zeros(len(points), dtype=bool)
    for cloud in clouds:
        planes = hull_planes(cloud)
        is_inside |= ((points @ planes[:, :3].T + planes[:, 3]).round(9) < 0).all(axis=1)
    return float(is_inside.mean())


def describe_fit(clouds: Sequence[Floats], reference: FitReference, errors: FitErrors) -> str:
    """The errors of the chosen shapes in words, for the report."""
    united = union([convex_hull(cloud) for cloud in clouds])
    volume, overlap = 0.0, 0.0
    if united is not None:
        volume, overlap = signed_volume(*united), intersection_volume(united, surface_of(reference.solid))
    solid_volume = float(reference.solid.volume())
    mm = [1000 * v for v in astuple(errors.deviation)]
    iou = overlap / (volume + solid_volume - overlap)
    words = [f"volume {volume / solid_volume:.2f} of the solid, overlap {iou:.2f}"]
    words.append(f"95 % (all) of the shapes within {mm[0]:.2g} ({mm[1]:.2g}) mm of it")
    words.append(
        f"of the mesh within {mm[2]:.2g} ({mm[3]:.2g}) mm of them, no deeper in them than {mm[4]:.2g} ({mm[5]:.2g}) mm"
    )
    if errors.open_share is not None:
        words.append(f"{errors.open_share:.0%} of the opening is open")
    if reference.kept_rooms:
        words.append(f"at most {errors.closed_share:.0%} of an open room is closed")
    return ", ".join(words)
