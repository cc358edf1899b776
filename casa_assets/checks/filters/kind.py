"""Find objects of unknown category, or with proportions or an opening unlike their category (FLT)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.built import is_loose_mesh
from casa_assets.checks.check import Measurement, no_fault, not_applicable, required_limit
from casa_assets.checks.filters.welded_surface import NOT_LOOSE, welded_surface, why_no_surface
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Floats
from casa_assets.geometry.grid.fillable_volume import fillable_volume
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose

# The category of what nobody could name.
UNKNOWN = "object"
# Cubes along the longest side in which it is looked for what an opening holds.
CELLS = 64


def category_is_known(package: Package, limit: float | None) -> Measurement:
    """FLT007: the category is known, so that a size and a mass can be expected."""
    if not is_loose_mesh(package.asset):
        return not_applicable(NOT_LOOSE)
    if package.category.id != UNKNOWN:
        return no_fault()
    message = "nobody says what it is, so that no size, pose or mass could be expected; name its category"
    return Measurement(None, (("labels/category", message),))


def proportions_fit_category(package: Package, limit: float | None) -> Measurement:
    """FLT008: least factor by which a side leaves the range of its category, at the best scale."""
    found = welded_surface(package.asset)
    if found is None:
        return why_no_surface(package.asset)
    if package.category.id == UNKNOWN:
        return not_applicable("nobody says what it is, so no proportions are expected (FLT007)")
    size = np.ptp(found.seen.samples, axis=0)
    number = misfit(size, package.category)
    have = " x ".join(f"{v / size.max():.2g}" for v in size)
    message = f"is {have} in proportion; none of the sizes of a {package.category.id} is like that: look at what it is"
    return Measurement(number, (("labels/category", message),) if number > required_limit(limit) else ())


def vessel_is_open(package: Package, limit: float | None) -> Measurement:
    """FLT009: share of its hull in which a vessel, as it stands, holds water."""
    found, category = welded_surface(package.asset), package.category
    if found is None:
        return why_no_surface(package.asset)
    if category.build is not MatterFill.VESSEL or not category.can(Affordance.CONTAINER):
        return not_applicable(f"a {category.id} is no open vessel")
    grid = voxelise(found.points, found.faces, CELLS)
    held = int(fillable_volume(grid.solid).sum()) * grid.cell**3
    share = held / hull_volume(found.points)
    message = f"holds nothing as it stands ({share:.1%} of its hull), though a {category.id} is open"
    problem = (("links/object/visuals", f"{message}; look at its pose, and for a lid"),)
    return Measurement(share, problem if share < required_limit(limit) else ())


def misfit(size: Floats, category: Category) -> float:
    """The least factor by which a side of a thing of (3,) `size`, at its best scale, leaves its range; 1 within all.

    Which of the two level sides is the longer one does not matter, nor, for what has no pose, which side is up.
    """
    spans = category.extents
    low, high = np.array([s.low for s in spans]), np.array([s.high for s in spans])
    rows = slice(0, 3 if category.upright is RestingPose.ANY else 2)
    have, low, high = np.array(size, dtype=np.float64), low.copy(), high.copy()
    for values in (have, low, high):
        values[rows] = np.sort(values[rows])
    have = np.maximum(have, 1e-9)
    return float(np.exp(max(0.0, (np.log(low / have).max() - np.log(high / have).min()) / 2)))
