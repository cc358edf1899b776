"""Measure how well collision shapes fit a mesh, the solid that it stands for, and the room in its opening."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from scipy import ndimage

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.fillable_volume import fillable_volume
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.mesh.measure import signed_volume
from casa_assets.geometry.solid.coverage import distances_outside_hulls, surface_samples
from casa_assets.geometry.solid.cutting import Solid, surface_of
from casa_assets.geometry.solid.deviation import Deviation, ReferenceSurface, deviation, reference_surface
from casa_assets.geometry.solid.hull import convex_hull, hull_planes, hull_volume
from casa_assets.geometry.solid.manifold import intersection_volume, union
from casa_assets.ingest.collision.plane_splits import ErrorBound

SAMPLES = 4000
# How far shapes may lie from the surface: 95 % of it, and all of it, as parts of the longest side.
P95_M = 0.002
P95_RATIO = 0.015
WORST_RATIO = 0.05
# How far apart the boxes round both may end, as a part of the longest side: feet stand on it.
BOX_RATIO = 0.02
# Cubes along the longest side where it is looked for what holds water; less than this share of the hull is no opening.
ROOM_CELLS = 64
# A gap narrower than one of so many cubes is closed: as narrow as shapes may be off.
SEEN_CELLS = 66
MIN_ROOM_SHARE = 0.03
MOST_PLACES = 4000
# The share of an opening that shapes may fill.
MAX_FILLED_SHARE = 0.15


@dataclass(frozen=True)
class FitReference:
    """Reference that the collision shapes of a mesh are measured against.

    Attributes:
        solid: that the mesh stands for. of: its surface. samples: (N, 3) points on the mesh itself, metres.
        box: (2, 3) corners of the mesh. room: (M, 3) places in the opening of a vessel, none where it has none.
        bound: how far shapes may be off.
    """

    solid: Solid
    of: ReferenceSurface
    samples: Floats
    box: Floats
    room: Floats
    bound: ErrorBound


@dataclass(frozen=True)
class FitErrors:
    """Errors of collision shapes: deviations, share of the opening left open, and the errors over their bounds.

    Attributes:
        bare: share of the mesh that lies farther outside than a grasp forgives, 0..1.
        kept: share of the opening that is left open, None where there is none.
    """

    off: Deviation
    bare: float
    kept: float | None
    normalized_error: float


def fit_reference(points: Floats, faces: Ints, solid: Solid, is_open: bool) -> FitReference:
    """Measure a mesh once, for all shapes that are held against it.

    Args:
        points: (P, 3) welded, metres, z up. faces: (F, 3). solid: that it stands for.
        is_open: an opening is one, and not damage to a thing that is full.
    """
    of = _touchable(reference_surface(*surface_of(solid)), points, faces, not is_open)
    bound = ErrorBound(max(P95_M, P95_RATIO * of.longest), WORST_RATIO * of.longest)
    room = _room(points, faces) if is_open else np.zeros((0, 3))
    used = points[np.unique(faces)]
    box = np.stack([used.min(axis=0), used.max(axis=0)])
    return FitReference(solid, of, surface_samples(points, faces, SAMPLES), box, room, bound)


def _touchable(of: ReferenceSurface, points: Floats, faces: Ints, full: bool) -> ReferenceSurface:
    """The ruler with probes only where the air around the mesh comes near: nothing enters a slit or a sealed room."""
    grid = voxelise(points, faces, SEEN_CELLS, bridge=full)
    outside = ndimage.binary_dilation(~grid.solid, np.ones((3, 3, 3), dtype=bool))
    at = np.clip(np.round((of.probes - grid.origin) / grid.cell).astype(int), 0, np.array(outside.shape) - 1)
    seen = outside[tuple(at.T)]
    return replace(of, probes=of.probes[seen]) if seen.any() else of


def _room(points: Floats, faces: Ints) -> Floats:
    """(M, 3) places that would hold water, evenly picked; none where they are few."""
    grid = voxelise(points, faces, ROOM_CELLS)
    held = fillable_volume(grid.solid)
    if float(held.sum()) * grid.cell**3 < MIN_ROOM_SHARE * hull_volume(points):
        return np.zeros((0, 3))
    places: Floats = grid.origin + np.argwhere(held) * grid.cell
    return places[:: max(1, len(places) // MOST_PLACES)]


def measure_fit(clouds: Sequence[Floats], by: FitReference, reach: float) -> FitErrors:
    """Measure how well convex shapes stand for a mesh.

    Args:
        clouds: vertices of each. reach: how far outside a grasp forgives, metres.
    Raises:
        DegenerateShape: a cloud spans no volume, or there are none.
    """
    outside = distances_outside_hulls(by.samples, clouds).round(6)
    off = deviation(clouds, by.of, outside)
    kept = None if not len(by.room) else 1 - _inside(by.room, clouds)
    strains = [off.added_p95 / by.bound.p95, off.added_worst / by.bound.worst]
    strains += [off.bare_p95 / by.bound.p95, off.bare_worst / by.bound.worst]
    strains += [off.buried_p95 / by.bound.p95, off.buried_worst / by.bound.worst]
    every = np.concatenate(list(clouds))
    ends = np.abs(np.stack([every.min(axis=0), every.max(axis=0)]) - by.box).max().round(6)
    strains.append(float(ends) / max(reach, BOX_RATIO * by.of.longest))
    if kept is not None:
        strains.append((1 - kept) / MAX_FILLED_SHARE)
    return FitErrors(off, float((outside > reach).mean()), kept, round(max(strains), 6))


def _inside(places: Floats, clouds: Sequence[Floats]) -> float:
    """Share of the places that lie in one of the shapes."""
    within = np.zeros(len(places), dtype=bool)
    for cloud in clouds:
        planes = hull_planes(cloud)
        within |= ((places @ planes[:, :3].T + planes[:, 3]).round(9) < 0).all(axis=1)
    return float(within.mean())


def describe_fit(clouds: Sequence[Floats], by: FitReference, found: FitErrors) -> str:
    """The numbers of shapes that were taken, for the report."""
    whole = union([convex_hull(cloud) for cloud in clouds])
    size, own = (0.0 if whole is None else signed_volume(*whole)), float(by.solid.volume())
    both = 0.0 if whole is None else intersection_volume(whole, surface_of(by.solid))
    mm = [1000 * v for v in astuple(found.off)]
    words = [f"volume {size / own:.2f} of the solid, overlap {both / (size + own - both):.2f}"]
    words.append(f"95 % (all) of the shapes within {mm[0]:.2g} ({mm[1]:.2g}) mm of it")
    words.append(
        f"of the mesh within {mm[2]:.2g} ({mm[3]:.2g}) mm of them, no deeper in them than {mm[4]:.2g} ({mm[5]:.2g}) mm"
    )
    if found.kept is not None:
        words.append(f"{found.kept:.0%} of the opening is open")
    return ", ".join(words)
