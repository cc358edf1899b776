"""Find objects of unknown category or unlike it, too wide for a gripper, or slow to load (FLT)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.check import (
    NO_COLLIDERS,
    Measurement,
    at_least,
    at_most,
    is_loose_mesh,
    no_fault,
    not_applicable,
    not_run,
)
from casa_assets.checks.filters.surface import NOT_LOOSE, welded_surface
from casa_assets.checks.package import Package
from casa_assets.core.numeric import Floats
from casa_assets.mesh.grid.voxels import fillable_volume, voxelise
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_volume, union
from casa_assets.mesh.surface import signed_volume, solid_moments
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose

# Cost -----------------------------------------------------------------------------------------------------------------
# Find inertia that no such body has, and meshes or pictures that are slow to load (FLT).

# Milliseconds that MuJoCo takes to load a thousand triangles, and a million pixels, as benchmarks/ingest/filters.py
# measures them on one core. The time is estimated with them and not measured, so that it is the same on any machine.
FACES_MS, PIXELS_MS = 5.0, 25.0
# Part of the greatest moment of inertia that another one may be off without being felt.
SLIGHT_SHARE = 0.05


def inertia_is_plausible(asset: Asset, limit: float) -> Measurement:
    """FLT014: factor between the inertia and that of the evenly filled shapes, on the worst axis."""
    if not is_loose_mesh(asset) or not asset.root.colliders:
        return not_applicable(NO_COLLIDERS if is_loose_mesh(asset) else NOT_LOOSE)
    link = asset.root
    surfaces = [tessellate(c.shape, c.pose) for c in link.colliders]
    solid = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    volume = signed_volume(*solid)
    if volume <= 0:
        return not_run("its collision shapes enclose no volume")
    tensor = solid_moments(*solid)[2]
    expected = np.linalg.eigvalsh(tensor * (link.inertial.mass / volume))
    actual = np.linalg.eigvalsh(link.inertial.tensor)
    # The moment of a knife about its own length hangs on its thickness, which meshes do not say exactly. So moments
    # that are small beside the greatest one count less.
    slight = SLIGHT_SHARE * expected.max()
    ratio = (actual + slight) / (expected + slight)
    factor = float(np.maximum(ratio, 1 / ratio).max())
    message = f"turns {factor:.1f} times harder or easier than its shapes filled evenly; measure the inertia again"
    return at_most(factor, limit, "links/object/inertial", message)


def load_time_is_bounded(asset: Asset, limit: float) -> Measurement:
    """FLT013: estimated loading time in a simulator, from triangles and pixels, milliseconds."""
    if not is_loose_mesh(asset):
        return not_applicable(NOT_LOOSE)
    faces = sum(len(v.mesh.faces) for v in asset.root.visuals)
    # MuJoCo reads the colours alone; the other pictures are read by those who load the USD.
    images = {t.file_name: t.width_px * t.height_px for m in asset.materials for t in m.textures}
    million_pixels = sum(images.values()) / 1e6
    load_ms = FACES_MS * faces / 1e3 + PIXELS_MS * sum(images.values()) / 1e6
    message = f"takes about {load_ms:.0f} ms to load ({faces} triangles, {million_pixels:.1f} million pixels)"
    return at_most(load_ms, limit, "", f"{message}; scale its pictures down")


# Graspable ------------------------------------------------------------------------------------------------------------
# Find graspable objects that are too wide for a gripper and have no rim or handle (FLT).

# Sites that say where a hand takes a thing; their x is what the fingers open to.
GRASP = "grasp_"


def fits_a_gripper(package: Package, limit: float) -> Measurement:
    """FLT018: width of the narrowest grasp of a graspable object, metres; its least side where it has none."""
    asset, category = package.asset, package.category
    if not is_loose_mesh(asset):
        return not_applicable(NOT_LOOSE)
    if asset.base is not Base.FREE or not category.can(Affordance.GRASPABLE):
        return not_applicable(f"a {category.id} is not said to be graspable")
    widths = {s.name: s.size[0] for s in asset.sites if s.name.startswith(GRASP) and s.size is not None}
    if not widths:
        least = float(np.ptp(asset.bounds, axis=0).min())
        message = f"has no body, rim or handle that a gripper of {limit:g} m takes (its least side is {least:.3f} m)"
        return Measurement(least, (("sites", f"{message}; look at its size, or do not call it graspable"),))
    problems = tuple(
        (f"sites/{name}", f"is {width:.3f} m wide; a gripper opens to {limit:g} m")
        for name, width in widths.items()
        if width > limit
    )
    return Measurement(min(widths.values()), problems)


# Kind -----------------------------------------------------------------------------------------------------------------
# Find objects of unknown category, or with proportions or an opening unlike their category (FLT).

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
