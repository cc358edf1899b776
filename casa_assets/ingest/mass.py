"""What it weighs and how that is spread: volume times density where that is believable, else the usual mass."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.geometry.hull import convex_hull
from casa_assets.geometry.measure import signed_volume, solid_moments
from casa_assets.geometry.solid import closed_solid, union
from casa_assets.geometry.tessellate import surface
from casa_assets.geometry.topology import weld
from casa_assets.geometry.voxel import voxelise
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.asset import Inertial
from casa_assets.model.category import Build, Category
from casa_assets.model.issue import Issue
from casa_assets.model.material import Substance

Floats = npt.NDArray[np.float64]

# Least over greatest mean square extent of a body whose inertia survives rounding to nine digits.
THINNEST = 1e-7


def mass(draft: Draft, category: Category, substance: Substance, slack: float) -> Draft:
    """Mass, centre and inertia of the whole, asset frame.

    Args:
        draft: metres, with colliders.
        category: mass_kg is the prior, build says what the volume means.
        substance: density of what it is made of.
        slack: how far outside the usual range a measured mass is still believed, ratio > 1.
    """
    vertices, faces = draft.soup()
    volume, center, inertia, spread = _moments(draft, category)
    matter, how = _matter(vertices, faces, volume, category)
    measured = None if matter is None or category.build is Build.HOLLOW else matter * substance.density
    longest = float(np.ptp(vertices, axis=0).max())
    span = category.mass_kg
    usual = float(np.clip(span.typical * (longest / category.longest_m.typical) ** 3, span.low, span.high))
    notes: tuple[Issue, ...] = ()
    if measured is not None and matter is not None and span.low / slack <= measured <= span.high * slack:
        kg, confidence = measured, 0.8
        because = f"{matter * 1e6:.4g} cm^3 ({how}) of {substance.id} at {substance.density:g} kg/m^3"
    else:
        kg, confidence = usual, 0.5
        because = f"usual mass of a {category.id} of this size; {how}"
        if measured is not None and category.id != "object":
            because += f" would give {measured:.3g} kg"
            notes = (warning("MSH021", "mass", because),)
    kg = float(f"{kg:.6g}")
    tensor = _possible(inertia) * (kg / volume)
    inertial = Inertial(
        mass=kg,
        center_of_mass=_vector(center),
        inertia=_six(tensor),
    )
    return draft.replace(
        inertial=inertial,
        guesses=draft.guessed("mass", f"{kg:.6g} kg, spread over {spread}", confidence, because),
        notes=draft.noted(*notes),
    )


def _moments(draft: Draft, category: Category) -> tuple[float, Floats, Floats, str]:
    """Volume, centre, inertia at density 1, and over what they were taken."""
    vertices, faces = draft.soup()
    points, place = weld(vertices)
    surfaces = [surface(p.shape, p.pose) for p in draft.colliders]
    hulls = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    solid = closed_solid(points, place[faces]) if category.build in (Build.SOLID, Build.VESSEL) else None
    if solid is not None and signed_volume(*solid) > 0.02 * signed_volume(*hulls):
        return (*solid_moments(*solid), "the closed mesh")
    return (*solid_moments(*hulls), "the collision shapes")


def _possible(inertia: Floats) -> Floats:
    """The tensor, of a body no thinner than the digits that are kept can tell from none at all."""
    spread, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if spread[0] > THINNEST * spread[2]:
        return inertia
    covariance = (axes * np.maximum(spread, THINNEST * spread[2])) @ axes.T
    fixed: Floats = np.trace(covariance) * np.eye(3) - covariance
    return fixed


def _matter(
    vertices: Floats, faces: npt.NDArray[np.int64], shapes: float, category: Category
) -> tuple[float | None, str]:
    """Volume of matter, m^3, or None where it cannot be known, and how it was measured or why not."""
    points, place = weld(vertices)
    solid = closed_solid(points, place[faces])
    if category.build is Build.VESSEL:
        if solid is not None:
            return min(signed_volume(*solid), shapes * 1.1), "volume of the closed mesh"
        return None, "the mesh is not closed, which leaves its walls without a thickness"
    if solid is not None and category.build is Build.SOLID:
        return min(signed_volume(*solid), shapes * 1.1), "volume of the closed mesh"
    grid = voxelise(points, place[faces], bridge=True)
    return min(grid.volume, shapes * 1.1), "volume within the outline"


def _vector(values: Floats) -> tuple[float, float, float]:
    """Nine digits: what the writers carry, and more than two machines' arithmetic may differ by."""
    x, y, z = (float(f"{v:.9g}") if abs(v) > 1e-9 else 0.0 for v in values)
    return (x, y, z)


def _six(tensor: Floats) -> tuple[float, float, float, float, float, float]:
    size = float(np.trace(tensor))
    picked = (tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2])
    a, b, c, d, e, f = (float(f"{v:.9g}") if abs(v) > 1e-9 * size else 0.0 for v in picked)
    return (a, b, c, d, e, f)
