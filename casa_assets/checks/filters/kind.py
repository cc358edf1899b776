"""Find objects of unknown category, or with proportions or an opening unlike their category (FLT)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import is_loose_mesh
from casa_assets.checks.check import Measurement, at_least, at_most, no_fault, not_applicable
from casa_assets.checks.filters.welded_surface import NOT_LOOSE, welded_surface
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Floats
from casa_assets.geometry.grid.fillable_volume import fillable_volume
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose

# The category of what nobody could name.
UNKNOWN = "object"
# Voxels along the longest side of the grid in which the water that a vessel holds is measured.
CELLS = 64


def category_is_known(package: Package) -> Measurement:
    """FLT007: the category is known, so that a size and a mass can be expected."""
    if not is_loose_mesh(package.asset):
        return not_applicable(NOT_LOOSE)
    if package.category.id != UNKNOWN:
        return no_fault()
    message = "nobody says what it is, so that no size, pose or mass could be expected; name its category"
    return Measurement(problems=(("labels/category", message),))


def proportions_fit_category(package: Package, limit: float) -> Measurement:
    """FLT008: least factor by which a side leaves the range of its category, at the best scale."""
    surface, category = welded_surface(package.asset), package.category
    if isinstance(surface, Measurement):
        return surface
    if category.id == UNKNOWN:
        return not_applicable("nobody says what it is, so no proportions are expected (FLT007)")
    size = np.ptp(surface.visibility.samples, axis=0)
    proportions = " x ".join(f"{side / size.max():.2g}" for side in size)
    message = f"is {proportions} in proportion; none of the sizes of a {category.id} is like that: look at what it is"
    return at_most(misfit(size, category), limit, "labels/category", message)


def vessel_is_open(package: Package, limit: float) -> Measurement:
    """FLT009: share of its hull in which a vessel, in its given pose, holds water."""
    surface, category = welded_surface(package.asset), package.category
    if isinstance(surface, Measurement):
        return surface
    if category.build is not MatterFill.VESSEL or not category.can(Affordance.CONTAINER):
        return not_applicable(f"a {category.id} is no open vessel")
    grid = voxelise(surface.points, surface.faces, CELLS)
    share = int(fillable_volume(grid.solid).sum()) * grid.cell**3 / hull_volume(surface.points)
    message = f"holds nothing as it stands ({share:.1%} of its hull), though a {category.id} is open"
    return at_least(share, limit, "links/object/visuals", f"{message}; look at its pose, and for a lid")


def misfit(size: Floats, category: Category) -> float:
    """The least factor by which a side of a thing of (3,) `size`, at its best scale, leaves its range; 1 within all.

    Which of the two level sides is the longer one does not matter, nor, for what has no pose, which side is up.
    """
    # Sides that may be swapped are sorted before they are compared.
    swapped = slice(0, 3 if category.upright is RestingPose.ANY else 2)
    sides = [np.maximum(size, 1e-9), [s.low for s in category.extents], [s.high for s in category.extents]]
    arrays = [np.array(values, dtype=np.float64) for values in sides]
    for array in arrays:
        array[swapped] = np.sort(array[swapped])
    actual, low, high = arrays
    return float(np.exp(max(0.0, (np.log(low / actual).max() - np.log(high / actual).min()) / 2)))
