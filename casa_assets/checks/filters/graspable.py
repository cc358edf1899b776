"""Find graspable objects that are too wide for a gripper and have no rim or handle (FLT)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import is_loose_mesh
from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.filters.welded_surface import NOT_LOOSE
from casa_assets.checks.package.package import Package
from casa_assets.model.asset.asset import Base
from casa_assets.model.registry.category import Affordance

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
