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

# Share of the area that must be out of sight for the walls of an open surface, or of something solid, to be double; a
# choice.
HIDDEN_AREA_SHARE = 0.25
# Points of the surface whose visibility is measured.
VISIBILITY_SAMPLES = 30_000


@dataclass(frozen=True)
class Solidity:
    """Measured kind of a surface.

    Attributes:
        kind: as `collide` calls it.
        hull_fill: its volume over that of its hull. wall_ratio: twice its volume over its area and longest side.
        visible_share: share of its area that is seen from outside.
        sealed_share: volume of sealed cavities over the volume with them.
        is_closed: it bounds a volume, though it may touch itself; else its volume is that of a voxel grid.
    """

    kind: SurfaceKind
    hull_fill: float
    wall_ratio: float
    visible_share: float
    sealed_share: float
    is_closed: bool

    @property
    def message(self) -> str:
        """The numbers in words."""
        words = f"fills {self.hull_fill:.0%} of its hull, walls {self.wall_ratio:.3f} of its length"
        words = f"{words}, {self.visible_share:.0%} is seen"
        sealed = f", sealed rooms would add {self.sealed_share:.0%}" if self.sealed_share > 0.005 else ""
        return f"{words}{sealed}" + ("" if self.is_closed else "; it is open, the volume is that of a grid")

    @property
    def confidence(self) -> float:
        """Confidence, 0..1: less where the surface is open, or a number is near its limit."""
        near = abs(np.log(max(self.wall_ratio, 1e-6) / THIN_WALL_RATIO)) < 0.25 and self.kind is not SurfaceKind.DOUBLE
        return (0.9 if self.is_closed else 0.6) - (0.2 if near else 0.0)


def solidity(points: Floats, faces: Ints, is_full: bool = False) -> Solidity:
    """Measure a surface.

    Args:
        points: (P, 3) welded, any unit. faces: (F, 3), outward where it is closed.
        is_full: known to be solid all through, so that walls inside it are faults.
    """
    used, local = np.unique(faces, return_inverse=True)
    points, faces = points[used], local.reshape(-1, 3)
    hull = max(hull_volume(points), 1e-300)
    area, longest = float(face_normals(points, faces)[1].sum()), float(np.ptp(points, axis=0).max())
    visibility = measure_visibility(points, faces, VISIBILITY_SAMPLES)
    visible_share = float((visibility.front | visibility.back).mean())
    outer_volume, cavity_volume = _volumes(points, faces)
    is_closed = bool((edge_counts(faces)[2] == 0).all()) and outer_volume > cavity_volume
    volume = outer_volume - cavity_volume if is_closed else voxelise(points, faces).volume
    sealed_share = cavity_volume / outer_volume if is_closed else 0.0
    hull_fill, wall_ratio = min(1.0, volume / hull), 2 * volume / (area * longest)
    return Solidity(
        _kind(hull_fill, wall_ratio, visible_share, sealed_share, is_closed, is_full),
        hull_fill,
        wall_ratio,
        visible_share,
        sealed_share,
        is_closed,
    )


def _volumes(points: Floats, faces: Ints) -> tuple[float, float]:
    """Volume of the components that face outwards, and of those that face inwards, the walls of sealed cavities."""
    label = face_components(faces, len(points))
    corners = points[faces] - points.mean(axis=0)
    cones = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes = np.bincount(label, weights=cones)
    return float(volumes[volumes > 0].sum()), float(-volumes[volumes < 0].sum())


def _kind(
    hull_fill: float, wall_ratio: float, visible_share: float, sealed_share: float, is_closed: bool, is_full: bool
) -> SurfaceKind:
    has_hidden_walls = wall_ratio < THIN_WALL_RATIO and visible_share < 1 - HIDDEN_AREA_SHARE
    # The inner wall of a closed vessel is out of sight too, but is meant.
    if sealed_share > MIN_SEALED_GROWTH or (has_hidden_walls and (is_full or not is_closed)):
        return SurfaceKind.DOUBLE
    if not is_closed:
        return SurfaceKind.SHEET if wall_ratio < THIN_WALL_RATIO else SurfaceKind.SOLID
    return SurfaceKind.WALLED if hull_fill < MAX_WALLED_FILL and wall_ratio < THIN_WALL_RATIO else SurfaceKind.SOLID
