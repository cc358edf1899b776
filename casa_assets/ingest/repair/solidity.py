"""Measure how solid a surface is (filled, walled, sheet), for the report; `collide` uses the same limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import edge_counts, face_components
from casa_assets.geometry.mesh.visibility import measure_visibility
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.ingest.collision.solid_proxy import MAX_WALLED_FILL, MIN_SEALED_GROWTH, THIN_WALL_RATIO, SurfaceKind

# Share of the area of an open surface, or of a full thing, that must be out of sight for its walls to be double.
HIDDEN_AREA_SHARE = 0.25
# Where that is measured, it is to so many points.
VISIBILITY_SAMPLES = 30_000


@dataclass(frozen=True)
class Solidity:
    """Measured kind of a surface.

    Attributes:
        kind: as `collide` calls it.
        fills: its volume over that of its hull. wall: twice its volume over its area and longest side.
        seen: share of its area that is seen from outside. sealed: share of the matter that sealed rooms would add.
        closed: it bounds a volume, though it may touch itself; else `fills` and `wall` are by a grid.
    """

    kind: SurfaceKind
    fills: float
    wall: float
    seen: float
    sealed: float
    closed: bool

    @property
    def message(self) -> str:
        """The numbers in words."""
        words = f"fills {self.fills:.0%} of its hull, walls {self.wall:.3f} of its length, {self.seen:.0%} is seen"
        sealed = f", sealed rooms would add {self.sealed:.0%}" if self.sealed > 0.005 else ""
        return f"{words}{sealed}" + ("" if self.closed else "; it is open, the volume is that of a grid")

    @property
    def confidence(self) -> float:
        """Confidence, 0..1: less where the surface is open, or a number is near its limit."""
        near = abs(np.log(max(self.wall, 1e-6) / THIN_WALL_RATIO)) < 0.25 and self.kind is not SurfaceKind.DOUBLE
        return (0.9 if self.closed else 0.6) - (0.2 if near else 0.0)


def solidity(points: Floats, faces: Ints, full: bool = False) -> Solidity:
    """Measure a surface.

    Args:
        points: (P, 3) welded, any unit. faces: (F, 3), outward where it is closed.
        full: known to be matter all through, so that a wall inside is none of its own.
    """
    used, local = np.unique(faces, return_inverse=True)
    points, faces = points[used], local.reshape(-1, 3)
    hull = max(hull_volume(points), 1e-300)
    area, longest = float(face_normals(points, faces)[1].sum()), float(np.ptp(points, axis=0).max())
    found = measure_visibility(points, faces, VISIBILITY_SAMPLES)
    seen = float((found.front | found.back).mean())
    outer, rooms = _volumes(points, faces)
    closed = bool((edge_counts(faces)[2] == 0).all()) and outer > rooms
    volume = outer - rooms if closed else voxelise(points, faces).volume
    sealed = rooms / outer if closed else 0.0
    fills, wall = min(1.0, volume / hull), 2 * volume / (area * longest)
    return Solidity(_kind(fills, wall, seen, sealed, closed, full), fills, wall, seen, sealed, closed)


def _volumes(points: Floats, faces: Ints) -> tuple[float, float]:
    """Volume of the pieces that face outwards, and of those that face inwards, the walls of sealed rooms."""
    label = face_components(faces, len(points))
    corners = points[faces] - points.mean(axis=0)
    cones = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes = np.bincount(label, weights=cones)
    return float(volumes[volumes > 0].sum()), float(-volumes[volumes < 0].sum())


def _kind(fills: float, wall: float, seen: float, sealed: float, closed: bool, full: bool) -> SurfaceKind:
    unseen = wall < THIN_WALL_RATIO and seen < 1 - HIDDEN_AREA_SHARE
    # The inner wall of a closed vessel is out of sight, too; that of a thing that is full is a mistake.
    if sealed > MIN_SEALED_GROWTH or (unseen and (full or not closed)):
        return SurfaceKind.DOUBLE
    if not closed:
        return SurfaceKind.SHEET if wall < THIN_WALL_RATIO else SurfaceKind.SOLID
    return SurfaceKind.WALLED if fills < MAX_WALLED_FILL and wall < THIN_WALL_RATIO else SurfaceKind.SOLID
