"""Classify a surface (solid, walled, double walled, sheet) and build the solid that stands for it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.implicit_field import signed_distance_field
from casa_assets.geometry.grid.isosurface import isosurface
from casa_assets.geometry.grid.voxel import Grid, voxelise
from casa_assets.geometry.mesh.hole_filling import fill_holes
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.solid.cutting import (
    Solid,
    simplify_solid,
    solid_of,
    split_by_plane,
    surface_of,
    volume_of_hull,
    without_voids,
)
from casa_assets.ingest.collision.component_solids import AssembledSolid, assemble_solid, covers_surface

# Cubes along the longest side where a broken surface is made solid.
CELLS = 72
# A hole wider than this share of the longest side is an opening.
SMALL_HOLE = 0.05
# The grid can tell what a full thing fills where the thinnest side of the box around it is so many cubes.
TELLING_CELLS = 12
# What is made on a grid is smoothed by this share of a cube: a tenth of the faces is left.
SMOOTH_CELLS = 0.3
# Mean wall over the longest side below which matter is a wall, and the share of its hull that it then fills at most.
# Ref: generated shells measure .011 to .023, a mug .040, a generated solid shaker .19 (filling .11 to .22, and .87).
THIN_WALL_RATIO = 0.06
MAX_WALLED_FILL = 0.5
# A grid of cubes bulges over the ends of what it stands for; of what is cut off there this share has to be left.
MIN_KEPT_SHARE = 0.7
# A surface of which more than this share is lone sheets is one.
MIN_SHEET_SHARE = 0.5
# Matter that grows by more than this share once sealed rooms are filled had two walls.
MIN_SEALED_GROWTH = 0.25


class SurfaceKind(StrEnum):
    """Kind of surface that a solid stands for."""

    SOLID = "solid"
    WALLED = "walled"
    DOUBLE = "double walled"
    SHEET = "open sheet"


@dataclass(frozen=True)
class SolidProxy:
    """Solid that stands for a surface.

    Attributes:
        solid: closed, outward, metres, nothing sealed in it.
        kind: what the surface was. message: how that was seen, and what was done, in words with numbers.
        wall: mean thickness, metres: twice the volume over the surface.
        exact: the surface itself, or with small holes closed; else made on a grid.
    """

    solid: Solid
    kind: SurfaceKind
    message: str
    wall: float
    exact: bool


def solid_proxy(points: Floats, faces: Ints, full: bool) -> SolidProxy | None:
    """Build the solid that a surface stands for; None where there is none.

    Args:
        points: (P, 3) welded, metres. faces: (F, 3).
        full: known to be matter all through, so that openings and rooms within are filled.
    """
    longest = float(np.ptp(points, axis=0).max())
    area = float(face_normals(points, faces)[1].sum())
    grid = voxelise(points, faces, CELLS, bridge=full)
    # The grid tells what a full thing fills only where that is many cubes thick.
    told = not full or float(np.ptp(points, axis=0).min()) * CELLS > TELLING_CELLS * longest
    for made in (_closed, assemble_solid):
        found = made(points, faces, grid)
        solid = None if found is None else without_voids(found.solid)
        if found is not None and solid is not None and covers_surface(solid, points, faces, grid if told else None):
            raw = None if found.lone > MIN_SHEET_SHARE else found.solid
            solid = _within(solid, points[np.unique(faces)]) if found.lone > 0 else solid
            return _classified(solid, raw, area, longest, list(found.done), exact=True)
    gridded = solid_of(*isosurface(signed_distance_field(points, faces, grid), grid.origin, grid.cell))
    if gridded is None:
        return None
    solid = _within(without_voids(simplify_solid(gridded, SMOOTH_CELLS * grid.cell)), points[np.unique(faces)])
    exact = _closed(points, faces, grid)
    done = [f"made solid on a grid of {1000 * grid.cell:.2g} mm"]
    return _classified(solid, None if exact is None else exact.solid, area, longest, done, exact=False)


def _within(solid: Solid, points: Floats) -> Solid:
    """Part of a solid in the box round some points; all of it where that would take most of it, as of a sheet."""
    rest = solid
    for axis in np.eye(3):
        rest = split_by_plane(rest, axis, float((points @ axis).min()))[0]
        rest = split_by_plane(rest, -axis, float((points @ -axis).min()))[0]
    return rest if rest.volume() > MIN_KEPT_SHARE * solid.volume() else solid


def _closed(points: Floats, faces: Ints, grid: Grid) -> AssembledSolid | None:
    """The surface as a solid, small holes closed where there are such."""
    solid = solid_of(points, faces)
    if solid is not None:
        return AssembledSolid(solid, ())
    whole = fill_holes(points, faces, SMALL_HOLE * grid.cell * CELLS)
    solid = None if whole is None else solid_of(*whole)
    return None if solid is None else AssembledSolid(solid, ("small holes were closed",))


def _classified(
    solid: Solid, raw: Solid | None, area: float, longest: float, done: list[str], exact: bool
) -> SolidProxy:
    """Words for what the surface was: how much of its hull it fills, how thick its walls are, what was sealed in."""
    size = float(solid.volume())
    fills = size / max(volume_of_hull([solid]), 1e-30)
    skin = face_normals(*surface_of(solid))[1].sum()
    wall = 2 * size / float(skin)
    before = float(raw.volume()) if raw is not None else 0.0
    thin = 2 * (before if raw is not None else size) / (area * longest)
    sealed = 1 - before / size if raw is not None and size > 0 else 0.0
    if raw is None:
        kind = SurfaceKind.SHEET if thin < THIN_WALL_RATIO else SurfaceKind.SOLID
    elif sealed > MIN_SEALED_GROWTH:
        kind = SurfaceKind.DOUBLE
        done = [*done, f"{sealed:.0%} of it was sealed off and was filled"]
    else:
        kind = SurfaceKind.WALLED if fills < MAX_WALLED_FILL and thin < THIN_WALL_RATIO else SurfaceKind.SOLID
    message = f"{kind}: fills {fills:.0%} of its hull, walls {thin:.3f} of its length"
    return SolidProxy(solid, kind, "; ".join([message, *done]), wall, exact)
